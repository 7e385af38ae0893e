#include "views/view_methods.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "views/view_renderer.hpp"

#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

std::unique_ptr<ViewRenderer> rendererOf(const Scene& scene, const ViewOptions& options,
                                         double outermost) {
    const cv::Mat& photo = scene.photo;
    const cv::Mat& depth = scene.depth;
    const double largestShift = shiftOf(options, shownColumns(scene).size(), outermost);
    switch (options.method) {
    case ViewMethod::Fast:
        return makeFastRenderer(photo, depth, options, largestShift);
    case ViewMethod::Real:
        return makeRealRenderer(photo, depth, options.focus, options.real);
    case ViewMethod::Layered:
        break;
    }
    LayeredSettings settings{options.layered};
    settings.reachPixels = largestShift;
    settings.hidden = scene.hidden;
    settings.mixedPixels = scene.mixedPixels;
    return makeLayeredRenderer(photo, depth, options.focus, settings);
}

} // namespace

void checkScene(const Scene& scene) {
    checkPhotoAndDepth(scene.photo, scene.depth, "depth", "CV_32FC1 of 0..1");
    const HiddenLayer& hidden = scene.hidden;
    if (!hidden.photo.empty() || !hidden.depth.empty()) {
        checkPhotoAndDepth(hidden.photo, hidden.depth, "hidden depth", "CV_32FC1 of 0..1");
        checkSize(hidden.photo.size(), scene.photo.size(), "hidden layer", "the photo's ");
    }
    checkRange("mixed px", scene.mixedPixels, 0, 7, " px");
    const cv::Range shown = shownColumns(scene);
    check(shown.start >= 0 && shown.start < shown.end && shown.end <= scene.photo.cols,
          "shown columns",
          "are " + std::to_string(shown.start) + ".." + std::to_string(shown.end - 1) +
              ", expected columns of the photo, 0.." + std::to_string(scene.photo.cols - 1));
}

void checkApart(const cv::Mat& result, const Scene& scene, const char* subject) {
    checkApart(result, scene.photo, subject, "photo");
    checkApart(result, scene.depth, subject, "depth");
    checkApart(result, scene.hidden.photo, subject, "hidden layer");
    checkApart(result, scene.hidden.depth, subject, "hidden layer");
}

std::unique_ptr<ViewRenderer> makeRenderer(const Scene& scene, const ViewOptions& options,
                                           double outermost) {
    checkScene(scene);
    return orOutOfMemory("photo",
                         "no memory for views of " + sizeText(scene.photo.size()) +
                             ", expected a smaller photo",
                         [&] { return rendererOf(scene, options, outermost); });
}

float halfParallaxOf(const ViewOptions& options, int width) {
    return static_cast<float>(options.strengthPercent / 100 * width / 2);
}

double shiftOf(const ViewOptions& options, int width, double position) {
    constexpr double kLargest = 1e30; // representable as float, also multiplied by any S/2
    const auto bounded = static_cast<float>(std::clamp(position, -kLargest, kLargest));
    return static_cast<double>(bounded * halfParallaxOf(options, width));
}

void renderShown(const ViewRenderer& renderer, cv::Size photo, cv::Range shown, double shiftPixels,
                 cv::Mat& view) {
    if (shown.size() == photo.width) return renderWhole(renderer, shiftPixels, view);
    cv::Mat whole(photo, CV_8UC3);
    renderWhole(renderer, shiftPixels, whole);
    whole.colRange(shown).copyTo(view);
}

void renderWhole(const ViewRenderer& renderer, double shiftPixels, cv::Mat& view) {
    if (!renderer.makesRows()) return renderer.render(shiftPixels, view);
    forRows(view.rows, [&](const cv::Range& rows) {
        const std::unique_ptr<RowRenderer> rowRenderer = renderer.rowRenderer();
        const std::vector<double> shifts = {shiftPixels};
        for (int y = rows.start; y < rows.end; ++y)
            rowRenderer->render(y, shifts, {view.ptr<std::uint8_t>(y)});
    });
}

} // namespace altiro3D
