#include "video/conversion/frame_renderer.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/products.hpp"
#include "base/state_bytes.hpp"
#include "native/quilt_shape.hpp"
#include "video/conversion/frame_depth.hpp"
#include "video/motion/motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

namespace altiro3D {

namespace {

// The range of the numbers of a saved state: whether flaws are known, and the fields of DepthFlaws;
// whether choices are made, the position of the part that is shown, focus and strength.
using StateNumbers = std::array<double, 13>;
constexpr StateNumbers kLeast = {0, 0, -7, -7, -7, 0, 0, 0, 0, 0, 0, 0, 0};
constexpr StateNumbers kMost = {1, 64, 7, 7, 7, 1, 1, 7, 1, 1, 1, 1, 10000};
constexpr std::size_t kChoices = 8; // index of the second part

// The size of whole frames with square px and even sides.
cv::Size evenSize(cv::Size photo, double seenAspect) {
    return {std::max(2, static_cast<int>(std::lround(photo.height * seenAspect / 2)) * 2),
            std::max(2, photo.height / 2 * 2)};
}

// The same for one eye. A half that is squeezed has even sides as well, for colours of 4:2:0.
cv::Size eyeSize(cv::Size photo, double seenAspect, EyesPicture picture) {
    cv::Size size = evenSize(photo, seenAspect);
    if (picture == EyesPicture::SideBySideHalf) size.width = std::max(4, size.width / 4 * 4);
    if (picture == EyesPicture::TopBottomHalf) size.height = std::max(4, size.height / 4 * 4);
    return size;
}

// Fit of whole frames. Those of the first one's shape fill the result despite its rounded sides.
PhotoFit wholeFit(cv::Size photo, double pixelAspect, cv::Size result) {
    // sides of small ones are rounded by more
    const double sameShape = std::max(0.02, 4.0 / std::min(result.width, result.height));
    const double aspect = static_cast<double>(result.width) / result.height / pixelAspect;
    const double own = static_cast<double>(photo.width) / photo.height;
    const bool fills = std::abs(aspect / own - 1) < sameShape;
    return fitPhoto(photo, fills ? own : aspect, result,
                    fills ? FitMode::Stretch : FitMode::Contain);
}

// Natives, quilts and pictures for two eyes of photos with depth.
class ViewsRenderer : public FrameRenderer {
  public:
    ViewsRenderer(const VideoConversion& conversion, const VideoTarget& target, DepthEdges edges)
        : options_(static_cast<const NativeOptions&>(conversion.recipe)), target_(target),
          edges_(edges), isMeasuring_(!options_.refine.flaws), wanted_(conversion.recipe.choices) {
        wanted_.isVideo = true;
        if (conversion.product == VideoProduct::Stereo) {
            eyes_ = conversion.eyes;
            options_.detail = Detail::View;
            validate(options_.views);
        } else if (conversion.product == VideoProduct::Quilt) {
            quilter_.emplace(target.layout, options_.views);
        } else if (conversion.map) {
            maker_.emplace(*conversion.map, options_);
        } else {
            maker_.emplace(*conversion.display, target.layout, options_);
        }
        if (maker_) {
            const bool isDirect = maker_->path() == NativePath::Direct;
            workSize_ = isDirect ? maker_->workSize() : maker_->quiltSize();
        } else {
            workSize_ =
                options_.detail == Detail::Panel ? target.panelSize : target.layout.tileSize;
        }
    }

    cv::Size size() const override {
        if (eyes_) return eyesSize(workSize_, eyes_->picture);
        return maker_ ? target_.panelSize : target_.layout.size();
    }

    void make(const PipelineFrame& frame, cv::Mat& result) override {
        const Scene fitted = placed(frame);
        if (eyes_) {
            StereoPair pair = renderEyes(fitted, options_.views, eyes_->from);
            if (eyes_->swapped) cv::swap(pair.left, pair.right);
            joinEyes(pair.left, pair.right, eyes_->picture, result);
        } else if (quilter_) {
            quilter_->render(fitted, result);
        } else {
            if (maker_->path() == NativePath::OverQuilt) maker_->makeQuilt(fitted, quilt_);
            maker_->makeNative(fitted, quilt_, result);
        }
    }

    bool isRepeated(PipelineFrame& frame) override {
        return frame.step.repeated && !isMeasured(frame);
    }

    void pass(PipelineFrame& frame) override {
        if (isChosenBy(frame) || isMeasured(frame)) static_cast<void>(placed(frame));
    }

    std::vector<SceneChoice> choices() const override { return choices_; }

    void keepState(SavedState& state) const override {
        const bool areKnown = isMeasuring_ && flaws_;
        const DepthFlaws flaws = areKnown ? *flaws_ : DepthFlaws();
        std::vector<double> numbers = {areKnown ? 1.0 : 0.0};
        std::apply([&](auto... fields) { (numbers.push_back(static_cast<double>(fields)), ...); },
                   DepthFlaws::fields(flaws));
        const ViewOptions& views = options_.views;
        const cv::Point2d centre = options_.framing.centre;
        if (isChosen_)
            numbers.insert(numbers.end(),
                           {1, centre.x, centre.y, views.focus, views.strengthPercent});
        numbers.resize(kLeast.size());
        std::string bytes;
        append(bytes, cv::Mat(numbers));
        state.bytes = bytes + state.bytes;
    }

    void takeState(SavedState& state) override {
        std::string_view rest(state.bytes);
        cv::Mat taken;
        if (!take(rest, CV_64FC1, taken) || taken.total() != kLeast.size()) throw damagedState();
        const auto* numbers = taken.ptr<double>();
        for (std::size_t i = 0; i < kLeast.size(); ++i) {
            if (!(numbers[i] >= kLeast[i] && numbers[i] <= kMost[i])) throw damagedState();
        }
        state.bytes = std::string(rest);
        isChosen_ = wanted_.any() && numbers[kChoices] != 0;
        if (isChosen_) {
            options_.framing.centre = {numbers[kChoices + 1], numbers[kChoices + 2]};
            options_.views.focus = numbers[kChoices + 3];
            options_.views.strengthPercent = numbers[kChoices + 4];
            useChosen();
        }
        if (!isMeasuring_) return;
        flaws_.reset();
        if (*numbers++ == 0) return;
        std::apply(
            [&](auto&... fields) {
                ((fields = static_cast<std::remove_reference_t<decltype(fields)>>(*numbers++)),
                 ...);
            },
            DepthFlaws::fields(flaws_.emplace()));
    }

  private:
    void useChosen() {
        if (maker_) maker_ = maker_->withViews(options_.views);
        if (quilter_) quilter_.emplace(target_.layout, options_.views);
    }

    // Makes the choices for a new scene and places the frame.
    Scene placed(const PipelineFrame& frame) {
        Scene scene{frame.source.picture, frame.depth, frame.hidden};
        scene.edges = edges_;
        // the shape as displayed, because px of the frame need not be square
        double aspect = target_.aspect() / frame.source.sampleAspect.value();
        PlacementOptions& options = options_;
        if (eyes_) { // whole frames
            const PhotoFit fit =
                wholeFit(scene.photo.size(), frame.source.sampleAspect.value(), workSize_);
            const bool fills = fit.target.size() == workSize_;
            options.fit = fills ? FitMode::Stretch : FitMode::Contain;
            if (fills) aspect = static_cast<double>(scene.photo.cols) / scene.photo.rows;
        }
        if (isChosenBy(frame)) {
            options = chooseFromScene(scene, aspect, target_.layout, options, wanted_).options;
            useChosen();
            isChosen_ = true;
            choices_.push_back({static_cast<double>(frame.source.pts), options.framing,
                                options.views.focus, options.views.strengthPercent});
        }
        if (isMeasured(frame)) flaws_.reset();
        return placeFrame(scene, aspect, workSize_, options, flaws_).scene;
    }

    bool isChosenBy(const PipelineFrame& frame) const {
        return wanted_.any() && (!isChosen_ || frame.step.cut);
    }

    // Flaws belong to the source of depth. They are measured once per scene, so edges are steady.
    bool isMeasured(const PipelineFrame& frame) const {
        return isMeasuring_ && (!flaws_ || frame.step.cut);
    }

    NativeOptions options_;           // with the choices for the scene
    std::optional<DepthFlaws> flaws_; // of the scene
    VideoTarget target_;
    DepthEdges edges_;
    bool isMeasuring_; // the flaws of the depth were not given
    AutoChoices wanted_;
    bool isChosen_ = false; // options_ hold the choices for the scene
    std::vector<SceneChoice> choices_;
    cv::Size workSize_;
    std::optional<NativeMaker> maker_;
    std::optional<Depth2Quilt> quilter_; // used instead of the maker
    std::optional<VideoEyes> eyes_;      // likewise
    cv::Mat quilt_;
};

// Photo and depth side by side.
class RgbdRenderer : public FrameRenderer {
  public:
    RgbdRenderer(double focus, StereoHalves shape, cv::Size photo, double seenAspect)
        : focus_(focus), layout_(DepthSide::Right, shape), half_(evenSize(photo, seenAspect)) {}

    cv::Size size() const override {
        const bool isSqueezed = layout_.halves == StereoHalves::Squeezed;
        return {(isSqueezed ? 1 : 2) * half_.width, half_.height};
    }

    void make(const PipelineFrame& frame, cv::Mat& result) override {
        const double pixelAspect = frame.source.sampleAspect.value();
        const Scene scene{frame.source.picture, frame.depth};
        const PhotoFit fit = wholeFit(scene.photo.size(), pixelAspect, half_);
        // As the depth that photo2native saves.
        fitScene(scene, fit, focus_, fitted_, DepthRefineOptions{DepthFlaws()});
        joinRgbd(fitted_.photo, fitted_.depth, layout_, result);
    }

  private:
    double focus_;
    RgbdLayout layout_;
    cv::Size half_;
    Scene fitted_;
};

// Both eyes' pictures as they were filmed.
class EyesRenderer : public FrameRenderer {
  public:
    EyesRenderer(const VideoConversion& conversion, const VideoFacts& facts)
        : video_(*conversion.stereo), eyes_(conversion.eyes) {
        const cv::Size half = halvesOf(video_).photoSize(facts.size);
        const double pixelAspect = facts.sampleAspect.value();
        eye_ = eyeSize(half, pixelAspect * half.width / half.height, eyes_.picture);
    }

    cv::Size size() const override { return eyesSize(eye_, eyes_.picture); }

    void make(const PipelineFrame& frame, cv::Mat& result) override {
        StereoPair pair = splitStereoPair(frame.source.picture, video_.layout, video_.halves);
        if (eyes_.swapped) cv::swap(pair.left, pair.right);
        for (cv::Mat* picture : {&pair.left, &pair.right}) {
            if (picture->size() == eye_) continue;
            cv::Mat fitted;
            applyFit(*picture, wholeFit(picture->size(), frame.source.sampleAspect.value(), eye_),
                     fitted);
            *picture = fitted;
        }
        joinEyes(pair.left, pair.right, eyes_.picture, result);
    }

  private:
    StereoVideo video_;
    VideoEyes eyes_;
    cv::Size eye_;
};

// Natives of quilts.
class QuiltRenderer : public FrameRenderer {
  public:
    QuiltRenderer(const VideoConversion& conversion, const VideoTarget& target)
        : fit_(conversion.viewAspect > 0 ? conversion.recipe.fit : FitMode::Stretch),
          viewAspect_(conversion.viewAspect), hasMap_(conversion.map.has_value()), target_(target),
          maker_(makerFor(conversion, target)) {}

    cv::Size size() const override { return target_.panelSize; }

    bool isRepeated(PipelineFrame& frame) override {
        frame.step.repeated = areEqual(frame.source.picture, lastQuilt_);
        return frame.step.repeated;
    }

    void make(const PipelineFrame& frame, cv::Mat& result) override {
        const cv::Mat& picture = frame.source.picture;
        Notes* const notes = lastQuilt_.empty() ? &notes_ : nullptr;
        cv::Mat quilt =
            hasMap_ ? cropQuilt(picture, target_.layout, notes) : fitQuilt(picture, target_.layout);
        if (fit_ != FitMode::Stretch)
            applyFitToViews(quilt, target_.layout, viewAspect_, target_.aspect(), fit_, quilt);
        maker_.render(quilt, result);
        lastQuilt_ = picture;
    }

    Notes notes() const override { return notes_; }

  private:
    static Quilt2Native makerFor(const VideoConversion& conversion, const VideoTarget& target) {
        if (conversion.map) return Quilt2Native(*conversion.map);
        const Display& display = *conversion.display;
        return {display.calibration, target.layout, conversion.recipe.sampling, display.invert};
    }

    FitMode fit_;
    double viewAspect_;
    bool hasMap_;
    VideoTarget target_;
    Quilt2Native maker_;
    Notes notes_;
    cv::Mat lastQuilt_;
};

} // namespace

void FrameRenderer::work(PipelineFrame& frame) {
    const double pixelAspect = frame.source.sampleAspect.value();
    if (!last_.empty() && pixelAspect == lastPixelAspect_ && isRepeated(frame)) {
        frame.result.picture = last_;
        return;
    }
    lastPixelAspect_ = pixelAspect;
    make(frame, frame.result.picture);
    last_ = frame.result.picture;
}

std::unique_ptr<FrameRenderer> makePhotoRenderer(const VideoConversion& conversion,
                                                 const VideoTarget& target, cv::Size photo,
                                                 double seenAspect, DepthEdges edges) {
    if (conversion.product == VideoProduct::Rgbd)
        return std::make_unique<RgbdRenderer>(conversion.recipe.views.focus, conversion.rgbdHalves,
                                              photo, seenAspect);
    if (conversion.product == VideoProduct::Stereo) {
        const cv::Size eye = eyeSize(photo, seenAspect, conversion.eyes.picture);
        return std::make_unique<ViewsRenderer>(conversion, VideoTarget{{2, 1, eye, 2}, eye}, edges);
    }
    return std::make_unique<ViewsRenderer>(conversion, target, edges);
}

std::unique_ptr<FrameRenderer> makeEyesRenderer(const VideoConversion& conversion,
                                                const VideoFacts& facts) {
    return std::make_unique<EyesRenderer>(conversion, facts);
}

std::unique_ptr<FrameRenderer> makeQuiltRenderer(const VideoConversion& conversion,
                                                 const VideoTarget& target) {
    return std::make_unique<QuiltRenderer>(conversion, target);
}

} // namespace altiro3D
