// Method Fast: view(x, y) = photo(x + shift (depth(x, y) - focus), y), linear, borders repeated.

#include "view_renderer.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

// Few enough rows that map and pixels stay in the second-level cache.
constexpr int kRowsAtATime = 16;

// Reads one row of depth, writes one row of map; bound by arithmetic.
void mapRow(const float* depth, int width, double shiftPixels, double focus, float* mapX) {
    const double right = width - 1;
    for (int x = 0; x < width; ++x) {
        double d = depth[x];
        d = d > 0 ? (d < 1 ? d : 1) : 0; // NaN compares false: 0
        const double place = x + shiftPixels * (d - focus);
        mapX[x] = static_cast<float>(std::min(std::max(place, 0.0), right));
    }
}

class FastRenderer : public ViewRenderer {
  public:
    FastRenderer(const cv::Mat& photo, const cv::Mat& depth, const ViewOptions& options)
        : photo_(photo), depth_(depth), focus_(options.focus) {}

    void render(double shiftPixels, cv::Mat& view) const override {
        const int rowsAtATime = std::min(kRowsAtATime, photo_.rows);
        cv::Mat mapX(rowsAtATime, photo_.cols, CV_32FC1);
        cv::Mat mapY(rowsAtATime, photo_.cols, CV_32FC1);
        for (int y0 = 0; y0 < photo_.rows; y0 += rowsAtATime) {
            const int rows = std::min(rowsAtATime, photo_.rows - y0);
            for (int i = 0; i < rows; ++i) {
                mapRow(depth_.ptr<float>(y0 + i), photo_.cols, shiftPixels, focus_,
                       mapX.ptr<float>(i));
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
};

} // namespace

std::unique_ptr<ViewRenderer> makeFastRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               const ViewOptions& options) {
    return std::make_unique<FastRenderer>(photo, depth, options);
}

} // namespace altiro3D
