#include "altiro3D/native_maker.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"

#include <optional>

namespace altiro3D {

struct NativeMaker::Impl {
    NativeOptions options;
    QuiltLayout layout;
    cv::Size panelSize;
    Depth2Quilt quilter;
    std::optional<NativeRenderer> direct;
    std::optional<Quilt2Native> overQuilt;
    std::optional<Display> display; // of the direct way

    Impl(const NativeOptions& o, const QuiltLayout& l, cv::Size panel)
        : options(o), layout(l), panelSize(panel), quilter(l, o.views) {}

    void startDirect() {
        direct.emplace(display->calibration, layout.viewCount, options.views, options.positions,
                       display->invert);
    }
};

namespace {

bool blends(const QuiltSampling& sampling) {
    return sampling.views != ViewFilter::Nearest || sampling.inTile != TileSampling::Nearest;
}

void checkFitted(const Scene& fitted, cv::Size expected) {
    const cv::Size photo(shownColumns(fitted).size(), fitted.photo.rows);
    if (photo == expected) return;
    throw Error(ErrorCode::Mismatch, "fitted photo",
                "has " + sizeText(photo) + " px, expected " + sizeText(expected) +
                    " px, the size that fitScene() with fit() gives it");
}

void requireDirect(const NativeOptions& options, const std::string& obstacle) {
    check(options.positions == ViewPositions::Discrete || obstacle.empty(), "positions",
          "are continuous, but " + obstacle + ", expected discrete positions");
}

} // namespace

std::string NativeMaker::obstacle(const QuiltLayout& layout, const NativeOptions& options) {
    if (blends(options.sampling)) return "views are blended";
    if (options.views.method == ViewMethod::Real) return "method real makes whole views";
    if (layout.viewCount > NativeRenderer::kMaxViews) {
        return "there are more than " + std::to_string(NativeRenderer::kMaxViews) + " views";
    }
    return {};
}

NativeMaker::NativeMaker(const Display& display, const NativeOptions& options)
    : NativeMaker(display, display.quilt, options) {}

NativeMaker::NativeMaker(const Display& display, const QuiltLayout& layout,
                         const NativeOptions& options) {
    const std::string why = obstacle(layout, options);
    requireDirect(options, why);
    const auto impl = std::make_shared<Impl>(options, layout, display.panelSize());
    if (why.empty()) {
        impl->display = display;
        impl->startDirect();
    } else if (blends(options.sampling)) {
        impl->overQuilt.emplace(display.calibration, layout, options.sampling, display.invert);
    } else {
        impl->overQuilt.emplace(NativeLut(display.calibration, layout, display.invert));
    }
    impl_ = impl;
}

NativeMaker::NativeMaker(NativeLut map, const NativeOptions& options) {
    check(!blends(options.sampling), "sampling",
          "is linear, but a look-up table holds single px, expected nearest");
    requireDirect(options, "a look-up table holds whole views");
    const auto impl = std::make_shared<Impl>(options, map.quilt(), map.panelSize());
    impl->overQuilt.emplace(std::move(map));
    impl_ = impl;
}

NativeMaker::NativeMaker(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

NativeMaker NativeMaker::withViews(const ViewOptions& views) const {
    const auto impl = std::make_shared<Impl>(*impl_);
    impl->options.views = views;
    impl->quilter = Depth2Quilt(impl->layout, views);
    if (impl->direct) impl->startDirect();
    return NativeMaker(impl);
}

NativePath NativeMaker::path() const {
    return impl_->direct ? NativePath::Direct : NativePath::OverQuilt;
}

const NativeOptions& NativeMaker::options() const {
    return impl_->options;
}

const QuiltLayout& NativeMaker::layout() const {
    return impl_->layout;
}

cv::Size NativeMaker::panelSize() const {
    return impl_->panelSize;
}

cv::Size NativeMaker::workSize() const {
    return impl_->options.keepResolution ? impl_->panelSize : impl_->layout.tileSize;
}

PhotoFit NativeMaker::fit(cv::Size photo, double aspect) const {
    const cv::Size panel = impl_->panelSize;
    const double shown = aspect == 0 ? static_cast<double>(panel.width) / panel.height : aspect;
    return withMargins(
        fitPhoto(photo, shown, workSize(), impl_->options.fit, impl_->options.framing), photo,
        impl_->options.views);
}

void NativeMaker::makeQuilt(const Scene& fitted, cv::Mat& quilt) const {
    checkFitted(fitted, workSize());
    impl_->quilter.render(fitted, quilt);
}

void NativeMaker::makeNative(const Scene& fitted, const cv::Mat& quilt, cv::Mat& native) const {
    if (impl_->direct) {
        checkFitted(fitted, workSize());
        impl_->direct->render(fitted, native);
    } else {
        impl_->overQuilt->render(quilt, native);
    }
}

void NativeMaker::makeNative(const Scene& scene, cv::Mat& native) const {
    Scene fitted;
    const NativeOptions& options = impl_->options;
    fitScene(scene, fit(scene.photo.size()), options.views.focus, fitted, options.refine);
    cv::Mat quilt;
    if (!impl_->direct) makeQuilt(fitted, quilt);
    makeNative(fitted, quilt, native);
}

} // namespace altiro3D
