#include "views/view_renderer.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "views/views_layered.hpp"
#include "views/views_real.hpp"

#include <new>

namespace altiro3D {

float halfParallaxOf(const ViewOptions& options, int width) {
    return static_cast<float>(options.strengthPercent / 100 * width / 2);
}

double shiftOf(const ViewOptions& options, int width, double position) {
    constexpr double kLargest = 1e30; // a float holds it, and its product with any S/2
    const auto bounded = static_cast<float>(std::clamp(position, -kLargest, kLargest));
    return static_cast<double>(bounded * halfParallaxOf(options, width));
}

namespace {

std::unique_ptr<ViewRenderer> rendererOf(const cv::Mat& photo, const cv::Mat& depth,
                                         const ViewOptions& options, double reach) {
    switch (options.method) {
    case ViewMethod::Fast:
        return makeFastRenderer(photo, depth, options);
    case ViewMethod::Real:
        return makeRealRenderer(photo, depth, options.focus, options.real);
    case ViewMethod::Layered:
        break;
    }
    LayeredSettings settings{options.layered};
    settings.reachPixels = shiftOf(options, photo.cols, reach);
    return makeLayeredRenderer(photo, depth, options.focus, settings);
}

[[noreturn]] void failForMemory(cv::Size size) {
    throw Error(ErrorCode::OutOfMemory, "photo",
                "no memory for views of " + sizeText(size) + " px, expected a smaller photo");
}

} // namespace

void renderWhole(const ViewRenderer& renderer, double shiftPixels, cv::Mat& view) {
    if (!renderer.makesRows()) {
        renderer.render(shiftPixels, view);
        return;
    }
    cv::parallel_for_(cv::Range(0, view.rows), [&](const cv::Range& rows) {
        const std::unique_ptr<RowRenderer> rowRenderer = renderer.rowRenderer();
        const std::vector<double> shifts = {shiftPixels};
        for (int y = rows.start; y < rows.end; ++y)
            rowRenderer->render(y, shifts, {view.ptr<std::uint8_t>(y)});
    });
}

std::unique_ptr<ViewRenderer> makeRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                           const ViewOptions& options, double reach) {
    checkPhotoAndDepth(photo, depth, "depth", "CV_32FC1 of 0..1");
    try {
        return rendererOf(photo, depth, options, reach);
    } catch (const std::bad_alloc&) {
        failForMemory(photo.size());
    } catch (const cv::Exception& exception) {
        if (exception.code != cv::Error::StsNoMem) throw;
        failForMemory(photo.size());
    }
}

} // namespace altiro3D
