// Method Layered: each row of a view shows, at each pixel, the front-most surface there; behind
// near things lies a background that is painted once.

#include "views_layered.hpp"

#include "views_layered_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Beyond this nothing of the photo is left in any view; it keeps all places finite.
constexpr double kLargestShift = 1e9;

void mirrorRow(std::uint8_t* bgr, int width) {
    for (std::uint8_t *left = bgr, *right = bgr + 3 * (static_cast<std::ptrdiff_t>(width) - 1);
         left < right; left += 3, right -= 3)
        std::swap_ranges(left, left + 3, right);
}

class LayeredRenderer : public ViewRenderer {
  public:
    LayeredRenderer(const cv::Mat& photo, const cv::Mat& depth, double focus,
                    const LayeredSettings& options)
        : photo_(photo) {
        cv::parallel_for_(cv::Range(0, 2), [&](const cv::Range& sides) {
            for (int side = sides.start; side < sides.end; ++side) {
                if (side == 0) {
                    toTheRight_ = layeredScene(photo, depth, focus, options);
                    continue;
                }
                cv::Mat mirroredPhoto;
                cv::Mat mirroredDepth;
                cv::flip(photo, mirroredPhoto, 1);
                cv::flip(depth, mirroredDepth, 1);
                toTheLeft_ = layeredScene(mirroredPhoto, mirroredDepth, focus, options);
            }
        });
    }

    void render(double shiftPixels, cv::Mat& view) const override {
        const bool mirrored = shiftPixels < 0;
        const std::vector<LayeredRowData>& rows = mirrored ? toTheLeft_ : toTheRight_;
        const double shift = std::min(std::abs(shiftPixels), kLargestShift);
        const std::size_t rowBytes = 3 * static_cast<std::size_t>(photo_.cols);
        LayeredTrace trace;
        for (int y = 0; y < photo_.rows; ++y) {
            const LayeredRowData& data = rows[static_cast<std::size_t>(y)];
            auto* pixels = view.ptr<std::uint8_t>(y);
            if (shift == 0 || data.still) {
                std::memcpy(pixels, photo_.ptr<std::uint8_t>(y), rowBytes);
                continue;
            }
            const LayeredRow row = data.tables();
            traceRow(row, shift, photo_.cols, trace);
            sampleRow(row, trace, photo_.cols, pixels);
            if (mirrored) mirrorRow(pixels, photo_.cols);
        }
    }

  private:
    cv::Mat photo_;
    std::vector<LayeredRowData> toTheRight_; // for shifts > 0
    std::vector<LayeredRowData> toTheLeft_;  // for shifts < 0, mirrored
};

} // namespace

std::unique_ptr<ViewRenderer> makeLayeredRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                                  double focus, const LayeredSettings& options) {
    return std::make_unique<LayeredRenderer>(photo, depth, focus, options);
}

} // namespace altiro3D
