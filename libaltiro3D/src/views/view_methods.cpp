#include "views/view_methods.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"

#include <new>

namespace altiro3D {

namespace {

std::unique_ptr<ViewRenderer> rendererOf(const Scene& scene, const ViewOptions& options,
                                         double reach) {
    const cv::Mat& photo = scene.photo;
    const cv::Mat& depth = scene.depth;
    const double largestShift = shiftOf(options, shownColumns(scene).size(), reach);
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

[[noreturn]] void failForMemory(cv::Size size) {
    throw Error(ErrorCode::OutOfMemory, "photo",
                "no memory for views of " + sizeText(size) + " px, expected a smaller photo");
}

} // namespace

std::unique_ptr<ViewRenderer> makeRenderer(const Scene& scene, const ViewOptions& options,
                                           double reach) {
    checkPhotoAndDepth(scene.photo, scene.depth, "depth", "CV_32FC1 of 0..1");
    const HiddenLayer& hidden = scene.hidden;
    if (!hidden.photo.empty() || !hidden.depth.empty()) {
        checkPhotoAndDepth(hidden.photo, hidden.depth, "hidden depth", "CV_32FC1 of 0..1");
        if (hidden.photo.size() != scene.photo.size()) {
            throw Error(ErrorCode::Mismatch, "hidden layer",
                        "has " + sizeText(hidden.photo.size()) +
                            " px, expected those of the photo, " + sizeText(scene.photo.size()));
        }
    }
    const cv::Range shown = shownColumns(scene);
    check(shown.start >= 0 && shown.end <= scene.photo.cols, "shown columns",
          "are " + std::to_string(shown.start) + ".." + std::to_string(shown.end - 1) +
              ", expected columns of the photo, 0.." + std::to_string(scene.photo.cols - 1));
    checkNumber(scene.mixedPixels >= 0 && scene.mixedPixels <= 7, "mixed px", scene.mixedPixels,
                "0..7 px");
    try {
        return rendererOf(scene, options, reach);
    } catch (const std::bad_alloc&) {
        failForMemory(scene.photo.size());
    } catch (const cv::Exception& exception) {
        if (exception.code != cv::Error::StsNoMem) throw;
        failForMemory(scene.photo.size());
    }
}

} // namespace altiro3D
