#include "viewer/show/slide_maker.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/run_tool.hpp"
#include "viewer/model/depth_maker.hpp"
#include "viewer/model/played_depth.hpp"

#include <utility>

namespace altiro3D::viewer {

namespace {

// The picture of a file that needs no calibration.
cv::Mat plainPicture(const Source& source) {
    if (!isVideoName(source.file)) return readPhoto(source.file);
    if (auto first = VideoReader(source.file).next()) return first->picture;
    throw Error(ErrorCode::BadFormat, source.file.string(), "holds no pictures, expected a video");
}

// Makes Natives of the pictures of a flat or RGB-D video, with the window's settings; one thread at
// a time.
std::function<cv::Mat(const cv::Mat&)> sceneConverter(const Document& first, const Display& display,
                                                      const std::shared_ptr<DepthMaker>& maker) {
    const Knobs knobs;
    NativeOptions options;
    options.views = knobs.views;
    options.fit = knobs.fit;
    const NativeMaker toNative(display, layoutOf(knobs, display), options);
    const auto depth = std::make_shared<PlayedDepth>(maker);
    const DepthEdges edges = first.rawDepth.empty() ? DepthEdges::Decided : DepthEdges::Unknown;
    Source source = first.source;
    if (first.rawDepth.empty()) source.reading = Reading::Photo; // no search for a quilt in each
    return [=, aspect = display.aspect(), scene = 0](const cv::Mat& frame) mutable {
        Document document = documentOf(source, frame, display);
        depth->next(document, knobs.depth);
        if (document.depth.empty()) normalizeDepth(document.rawDepth, document.depth);
        if (document.scene != scene) options.refine.flaws.reset();
        scene = document.scene;
        const Placement placed = placeScene({document.picture, document.depth, {}, {}, edges},
                                            aspect, toNative.workSize(), options);
        options.refine.flaws = placed.flaws; // until the next scene
        cv::Mat native;
        toNative.makeNative(placed, native);
        return native;
    };
}

} // namespace

SlideMaker::SlideMaker(std::shared_ptr<const Display> display, cv::Size screen)
    : display_(std::move(display)), screen_(screen), depthMaker_(std::make_shared<DepthMaker>()),
      studio_(depthMaker_) {}

Slide SlideMaker::make(const Source& source) {
    Slide slide;
    slide.source = source;
    const bool isVideo = isVideoName(source.file);
    try {
        if (!display_) {
            slide.native = plainPicture(source);
            if (slide.native.size() != screen_) {
                throw Error(ErrorCode::Mismatch, source.file.string(),
                            "has " + tools::sizeText(slide.native.size()) +
                                ", but the screen shows " + tools::sizeText(screen_) +
                                "; expected a Native made for it, or -c with the display's "
                                "calibration");
            }
            if (isVideo) slide.nativeOfFrame = [](const cv::Mat& frame) { return frame; };
            return slide;
        }
        const auto document = std::make_shared<const Document>(readDocument(source, *display_));
        slide.native = nativeOf(document);
        if (isVideo && document->kind == Kind::Native)
            slide.nativeOfFrame = [](const cv::Mat& frame) { return frame; };
        if (isVideo && document->kind == Kind::Quilt)
            slide.nativeOfFrame = quiltConverter(source.file, document->layout, *display_, true);
        if (isVideo && document->kind == Kind::Scene)
            slide.nativeOfFrame = sceneConverter(*document, *display_, depthMaker_);
    } catch (const std::exception& error) {
        slide.native.release();
        slide.nativeOfFrame = nullptr;
        slide.problem = tools::sentenceOf(error);
    }
    return slide;
}

cv::Mat SlideMaker::nativeOf(const std::shared_ptr<const Document>& document) {
    Request request;
    request.document = document;
    if (document->video) request.knobs = ofVideo(request.knobs);
    request.display = display_;
    request.mode = Mode::Native;
    request.area = display_->panelSize();
    return studio_.render(request).picture.clone(); // without the studio's copies of the document
}

} // namespace altiro3D::viewer
