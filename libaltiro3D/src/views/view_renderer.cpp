#include "views/view_renderer.hpp"

#include <opencv2/core.hpp>

namespace altiro3D {

float halfParallaxOf(const ViewOptions& options, int width) {
    return static_cast<float>(options.strengthPercent / 100 * width / 2);
}

double shiftOf(const ViewOptions& options, int width, double position) {
    constexpr double kLargest = 1e30; // representable as float, also multiplied by any S/2
    const auto bounded = static_cast<float>(std::clamp(position, -kLargest, kLargest));
    return static_cast<double>(bounded * halfParallaxOf(options, width));
}

void forRows(int rows, const std::function<void(const cv::Range&)>& body) {
    constexpr int kPartsPerThread = 8;
    cv::parallel_for_(cv::Range(0, rows), body, kPartsPerThread * cv::getNumThreads());
}

void renderShown(const ViewRenderer& renderer, cv::Size photo, cv::Range shown, double shiftPixels,
                 cv::Mat& view) {
    if (shown.size() == photo.width) {
        renderWhole(renderer, shiftPixels, view);
        return;
    }
    cv::Mat whole(photo, CV_8UC3);
    renderWhole(renderer, shiftPixels, whole);
    whole.colRange(shown).copyTo(view);
}

void renderWhole(const ViewRenderer& renderer, double shiftPixels, cv::Mat& view) {
    if (!renderer.makesRows()) {
        renderer.render(shiftPixels, view);
        return;
    }
    forRows(view.rows, [&](const cv::Range& rows) {
        const std::unique_ptr<RowRenderer> rowRenderer = renderer.rowRenderer();
        const std::vector<double> shifts = {shiftPixels};
        for (int y = rows.start; y < rows.end; ++y)
            rowRenderer->render(y, shifts, {view.ptr<std::uint8_t>(y)});
    });
}

} // namespace altiro3D
