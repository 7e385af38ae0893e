// Method Fast: view(x, y) = photo(x + shift (depth(x, y) - focus), y), linear, borders repeated;
// with refinement depth is read again where the px was found to come from.

#include "view_renderer.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

// Few enough rows that map and pixels stay in the second-level cache.
constexpr int kRowsAtATime = 16;

float clamped(float depth) {
    return depth > 0 ? (depth < 1 ? depth : 1) : 0; // NaN compares false: 0
}

// Depth between two px, linear.
double depthAt(const float* depth, int width, double place) {
    const int left = static_cast<int>(place);
    const int right = std::min(left + 1, width - 1);
    const double nearer = clamped(depth[left]);
    return nearer + (place - left) * (clamped(depth[right]) - nearer);
}

// Reads one row of depth, writes one row of map; bound by arithmetic.
void mapRow(const float* depth, int width, double shiftPixels, double focus, float* mapX) {
    const double right = width - 1;
    for (int x = 0; x < width; ++x) {
        const double place = x + shiftPixels * (clamped(depth[x]) - focus);
        mapX[x] = static_cast<float>(std::min(std::max(place, 0.0), right));
    }
}

// Moves each place to x + shift (depth(place) - focus): one fixed-point step towards the place that
// the px really comes from. Bound by the scattered reads of depth.
void refineRow(const float* depth, int width, double shiftPixels, double focus, float* mapX) {
    const double right = width - 1;
    for (int x = 0; x < width; ++x) {
        const double d = depthAt(depth, width, static_cast<double>(mapX[x]));
        const double place = x + shiftPixels * (d - focus);
        mapX[x] = static_cast<float>(std::min(std::max(place, 0.0), right));
    }
}

class FastRenderer : public ViewRenderer {
  public:
    FastRenderer(const cv::Mat& photo, const cv::Mat& depth, const ViewOptions& options)
        : photo_(photo), depth_(depth), focus_(options.focus), refinement_(options.refinement) {}

    void render(double shiftPixels, cv::Mat& view) const override {
        const int rowsAtATime = std::min(kRowsAtATime, photo_.rows);
        cv::Mat mapX(rowsAtATime, photo_.cols, CV_32FC1);
        cv::Mat mapY(rowsAtATime, photo_.cols, CV_32FC1);
        for (int y0 = 0; y0 < photo_.rows; y0 += rowsAtATime) {
            const int rows = std::min(rowsAtATime, photo_.rows - y0);
            for (int i = 0; i < rows; ++i) {
                const float* depthRow = depth_.ptr<float>(y0 + i);
                float* mapXRow = mapX.ptr<float>(i);
                mapRow(depthRow, photo_.cols, shiftPixels, focus_, mapXRow);
                for (int step = 0; step < refinement_; ++step) {
                    refineRow(depthRow, photo_.cols, shiftPixels, focus_, mapXRow);
                }
                std::fill_n(mapY.ptr<float>(i), photo_.cols, static_cast<float>(y0 + i));
            }
            cv::Mat target = view.rowRange(y0, y0 + rows);
            cv::remap(photo_, target, mapX.rowRange(0, rows), mapY.rowRange(0, rows),
                      cv::INTER_LINEAR, cv::BORDER_REPLICATE);
        }
    }

  private:
    cv::Mat photo_;
    cv::Mat depth_;
    double focus_;
    int refinement_;
};

} // namespace

std::unique_ptr<ViewRenderer> makeFastRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               const ViewOptions& options) {
    return std::make_unique<FastRenderer>(photo, depth, options);
}

} // namespace altiro3D
