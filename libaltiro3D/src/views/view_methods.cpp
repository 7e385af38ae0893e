#include "views/view_methods.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"

#include <new>

namespace altiro3D {

namespace {

std::unique_ptr<ViewRenderer> rendererOf(const cv::Mat& photo, const cv::Mat& depth,
                                         const ViewOptions& options, double reach) {
    const double largestShift = shiftOf(options, photo.cols, reach);
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
    return makeLayeredRenderer(photo, depth, options.focus, settings);
}

[[noreturn]] void failForMemory(cv::Size size) {
    throw Error(ErrorCode::OutOfMemory, "photo",
                "no memory for views of " + sizeText(size) + " px, expected a smaller photo");
}

} // namespace

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
