#include "altiro3D/native_maker.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "native/lens_filter.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace altiro3D {

namespace {

// px per lens period that hold what LensFilter passes (docs/lab/views.md)
constexpr double kPixelsPerLens = 3;

// Half of an 8K panel. More, for the finest lenses of such panels, is worth .16 dB of 2.5.
constexpr int kMostLensPixels = 3840 * 2160;

// Limit for prints, whose memory must not grow with their size.
constexpr double kMostPrintPixels = 1.2e7;

// Rows per inch of prints whose lenses stand; those show all detail down.
constexpr double kPrintDetail = 300;

// @param dpiDown of a print; else 0
cv::Size lensDetail(const LensGeometry& lens, double dpiDown) {
    const double across = lens.lensPeriodSubpixels / 3; // px
    const double down = lens.panelHeight / (std::abs(lens.tilt) * lens.periodsPerWidth);
    const double period = lens.isLying() ? down : across;
    const int times = std::max(1, static_cast<int>(std::lround(period / kPixelsPerLens)));
    const cv::Size panel(lens.panelWidth, lens.panelHeight);
    cv::Size size((panel.width + times - 1) / times, (panel.height + times - 1) / times);
    if (dpiDown > 0 && !lens.isLying()) {
        const double rows = panel.height * std::min(1.0, kPrintDetail / dpiDown);
        size.height =
            std::max(size.height, static_cast<int>(std::min(rows, kMostPrintPixels / size.width)));
    }
    if (times == 1 && 1.0 * size.width * size.height > kMostLensPixels)
        size = {(panel.width + 1) / 2, (panel.height + 1) / 2};
    const double scale = std::sqrt(std::min(1.0, kMostPrintPixels / size.width / size.height));
    return {static_cast<int>(size.width * scale), static_cast<int>(size.height * scale)};
}

} // namespace

struct NativeMaker::Impl {
    NativeOptions options;
    QuiltLayout layout;
    cv::Size panelSize;
    Depth2Quilt quilter;
    std::optional<NativeRenderer> direct;
    std::optional<Quilt2Native> overQuilt;
    std::optional<Display> display; // for the direct way and for the filter
    cv::Size workSize;
    cv::Size quiltSize;
    std::shared_ptr<const LensFilter> filter; // for photos of the work size

    // In a quilt, Detail::Lens is Detail::View. On the direct way, the constructor from a display
    // replaces workSize by what the lenses can show.
    Impl(const NativeOptions& o, const QuiltLayout& l, cv::Size panel)
        : options(o), layout(l), panelSize(panel), quilter(l, o.views),
          workSize(o.detail == Detail::Panel ? panel : l.tileSize),
          quiltSize(o.lensFilter ? l.tileSize : workSize) {}

    LensGeometry lens() const { return lensGeometry(display->calibration, display->invert); }

    Scene filtered(const Scene& fitted) const {
        if (!options.lensFilter) return fitted;
        const cv::Size size(shownColumns(fitted).size(), fitted.photo.rows);
        const auto use =
            size == workSize ? filter : std::make_shared<const LensFilter>(lens(), size);
        Scene scene = fitted;
        scene.photo.release();
        use->apply(fitted.photo, scene.photo);
        if (!fitted.hidden.photo.empty()) {
            // what is unknown counts as the photo, so that it does not darken its surroundings
            cv::Mat known;
            cv::compare(fitted.hidden.depth, fitted.hidden.depth, known, cv::CMP_EQ);
            cv::Mat whole = fitted.photo.clone();
            fitted.hidden.photo.copyTo(whole, known);
            scene.hidden.photo.release();
            use->apply(whole, scene.hidden.photo);
        }
        return scene;
    }

    void startDirect() {
        direct.emplace(display->calibration, layout.viewCount, options.views, options.positions,
                       display->invert);
    }
};

namespace {

void checkFitted(const Scene& fitted, cv::Size expected) {
    const cv::Size photo(shownColumns(fitted).size(), fitted.photo.rows);
    if (photo == expected) return;
    throw Error(ErrorCode::Mismatch, "fitted photo",
                "has " + sizeText(photo) + ", expected " + sizeText(expected) +
                    ", workSize() or quiltSize() for placeScene()");
}

void requireDirect(const NativeOptions& options, const std::string& obstacle) {
    check(options.positions == ViewPositions::Discrete || obstacle.empty(), "positions",
          "are continuous, but " + obstacle + ", expected discrete positions");
}

} // namespace

std::string NativeMaker::obstacle(const QuiltLayout& layout, const NativeOptions& options) {
    if (options.sampling.blends()) return "views are blended";
    if (options.views.method == ViewMethod::Real) return "method real makes whole views";
    if (layout.viewCount > NativeRenderer::kMaxViews) {
        return "there are more than " + std::to_string(NativeRenderer::kMaxViews) + " views";
    }
    return {};
}

NativeMaker::NativeMaker(const Display& display, const NativeOptions& options)
    : NativeMaker(display, display.quilt, options) {}

NativeMaker::NativeMaker(const Display& display, const QuiltLayout& layout,
                         const NativeOptions& options) try {
    const std::string why = obstacle(layout, options);
    requireDirect(options, why);
    const auto impl = std::make_shared<Impl>(options, layout, display.panelSize());
    impl->display = display;
    if (why.empty()) {
        if (options.detail == Detail::Lens) {
            const bool isPrint = display.calibration.sheet && display.calibration.sheet->isPrint;
            impl->workSize =
                lensDetail(impl->lens(), isPrint ? display.calibration.sheet->dpiDown : 0);
        }
        impl->startDirect();
    } else {
        impl->overQuilt.emplace(display.calibration, layout, options.sampling, display.invert);
    }
    if (impl->lens().isLying()) impl->options.lensFilter = false; // it is for vertical lenses
    if (impl->options.lensFilter)
        impl->filter = std::make_shared<const LensFilter>(impl->lens(), impl->workSize);
    impl_ = impl;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

NativeMaker::NativeMaker(NativeLut map, const NativeOptions& options) {
    check(!options.sampling.blends(), "sampling",
          "is linear, but a look-up table holds single px, expected nearest");
    requireDirect(options, "a look-up table holds whole views");
    check(!options.lensFilter, "lensFilter",
          "is on, but a look-up table does not hold the lenses, expected a display");
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
    return impl_->workSize;
}

cv::Size NativeMaker::quiltSize() const {
    return impl_->quiltSize;
}

void NativeMaker::makeQuilt(const Scene& fitted, cv::Mat& quilt) const {
    makeQuilt(fitted, quilt, {});
}

bool NativeMaker::makeQuilt(const Scene& fitted, cv::Mat& quilt,
                            const QuiltProgressFunction& goOn) const try {
    checkFitted(fitted, quiltSize());
    return impl_->quilter.render(impl_->filtered(fitted), quilt, goOn);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void NativeMaker::makeNative(const Scene& fitted, const cv::Mat& quilt, cv::Mat& native,
                             ChannelOrder order) const try {
    if (impl_->direct) {
        checkFitted(fitted, workSize());
        impl_->direct->render(impl_->filtered(fitted), native, order);
    } else {
        impl_->overQuilt->render(quilt, native);
        if (order == ChannelOrder::Rgb) cv::cvtColor(native, native, cv::COLOR_BGR2RGB);
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void NativeMaker::makeNative(const Scene& fitted, const cv::Mat& quilt, const RowSink& sink) const
    try {
    if (impl_->direct) {
        checkFitted(fitted, workSize());
        impl_->direct->render(impl_->filtered(fitted), sink);
    } else {
        impl_->overQuilt->render(quilt, sink);
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void NativeMaker::makeNative(const Scene& scene, cv::Mat& native, ChannelOrder order) const {
    const double aspect = impl_->display
                              ? impl_->display->aspect()
                              : static_cast<double>(panelSize().width) / panelSize().height;
    const cv::Size size = impl_->direct ? workSize() : quiltSize();
    makeNative(placeScene(scene, aspect, size, options()), native, order);
}

void NativeMaker::makeNative(const Placement& placed, cv::Mat& native, ChannelOrder order) const {
    cv::Mat quilt;
    if (!impl_->direct) makeQuilt(placed.scene, quilt);
    makeNative(placed.scene, quilt, native, order);
}

} // namespace altiro3D
