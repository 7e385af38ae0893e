#include "video/conversion/frame_renderer.hpp"

#include "altiro3D/error.hpp"
#include "base/state_bytes.hpp"
#include "native/quilt_shape.hpp"
#include "video/motion/picture_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

namespace altiro3D {

namespace {

const DepthRefineOptions kAsItIs{DepthFlaws()};

// Numbers of saved states, and their range: the fields of DepthFlaws,
using FlawValues = std::array<double, 7>;
constexpr FlawValues kMinFlaws = {0, -7, -7, -7, 0, 0, 0};
constexpr FlawValues kMaxFlaws = {64, 7, 7, 7, 1, 1, 7};
// and the position of the part that is shown, focus and strength.
using ChoiceValues = std::array<double, 4>;
constexpr ChoiceValues kMinChoices = {0, 0, 0, 0};
constexpr ChoiceValues kMaxChoices = {1, 1, 1, 10000};

FlawValues valuesOf(const DepthFlaws& flaws) {
    return std::apply([](auto... fields) { return FlawValues{static_cast<double>(fields)...}; },
                      DepthFlaws::fields(flaws));
}

DepthFlaws flawsOf(const FlawValues& values) {
    DepthFlaws flaws;
    std::apply(
        [value = values.begin()](auto&... fields) mutable {
            ((fields = static_cast<std::remove_reference_t<decltype(fields)>>(*value++)), ...);
        },
        DepthFlaws::fields(flaws));
    return flaws;
}

// Appends whether numbers are known, and the numbers.
template <typename Values>
void keepNumbers(SavedState& state, bool areKnown, const Values& values) {
    append(state.bytes, areKnown ? 1 : 0);
    for (const double value : values) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        append(state.bytes, bits);
    }
}

// Removes what keepNumbers() appended last. @return whether they are known
// @throws Error BadFormat if a number is outside of its range
template <typename Values>
bool takeNumbers(SavedState& state, const Values& least, const Values& most, Values& values) {
    constexpr std::size_t kBytes = (1 + std::tuple_size_v<Values>)*sizeof(std::uint64_t);
    if (state.bytes.size() < kBytes) throw damagedState();
    const std::string kept = state.bytes.substr(state.bytes.size() - kBytes);
    state.bytes.resize(state.bytes.size() - kBytes);
    std::string_view rest = kept;
    std::uint64_t isKnown = 0;
    take(rest, isKnown);
    for (std::size_t i = 0; i < values.size(); ++i) {
        std::uint64_t bits = 0;
        take(rest, bits);
        std::memcpy(&values[i], &bits, sizeof bits);
        if (!(values[i] >= least[i] && values[i] <= most[i])) throw damagedState(); // also NaN
    }
    return isKnown != 0;
}

// Natives and quilts of photos with depth.
class ViewsRenderer : public FrameRenderer {
  public:
    ViewsRenderer(const VideoConversion& conversion, const VideoTarget& target, DepthEdges edges)
        : options_(conversion.native), target_(target), edges_(edges),
          isGiven_(conversion.given.has_value()), isMeasuring_(!options_.refine.flaws),
          wanted_(conversion.choices) {
        wanted_.isVideo = true;
        if (conversion.product == VideoProduct::Quilt) {
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

    cv::Size size() const override { return maker_ ? target_.panelSize : target_.layout.size(); }

    void work(PipelineFrame& frame) override {
        cv::Mat& result = frame.result.picture;
        const double pixelAspect = frame.source.sampleAspect.value();
        const bool isRepeated = frame.step.repeated && pixelAspect == lastPixelAspect_;
        if (isRepeated && !last_.empty() && !isMeasured(frame)) {
            result = last_;
            return;
        }
        lastPixelAspect_ = pixelAspect;
        const Scene fitted = placed(frame);
        if (quilter_) {
            quilter_->render(fitted, result);
        } else {
            if (maker_->path() == NativePath::OverQuilt) maker_->makeQuilt(fitted, quilt_);
            maker_->makeNative(fitted, quilt_, result);
        }
        last_ = result;
    }

    void pass(PipelineFrame& frame) override {
        if (isChosenBy(frame) || isMeasured(frame)) static_cast<void>(placed(frame));
    }

    std::vector<SceneChoice> choices() const override { return choices_; }

    void keepState(SavedState& state) const override {
        const std::optional<DepthFlaws>& flaws = options_.refine.flaws;
        keepNumbers(state, isMeasuring_ && flaws, valuesOf(flaws.value_or(DepthFlaws())));
        if (wanted_.any()) keepNumbers(state, isChosen_, chosenValues());
    }

    void takeState(SavedState& state) override {
        if (wanted_.any()) {
            ChoiceValues values{};
            isChosen_ = takeNumbers(state, kMinChoices, kMaxChoices, values);
            if (isChosen_) {
                options_.framing.centre = {values[0], values[1]};
                options_.views.focus = values[2];
                options_.views.strengthPercent = values[3];
                useChosen();
            }
        }
        FlawValues values{};
        const bool areKnown = takeNumbers(state, kMinFlaws, kMaxFlaws, values);
        if (!isMeasuring_) return;
        options_.refine.flaws.reset();
        if (areKnown) options_.refine.flaws = flawsOf(values);
    }

  private:
    ChoiceValues chosenValues() const {
        return {options_.framing.centre.x, options_.framing.centre.y, options_.views.focus,
                options_.views.strengthPercent};
    }

    void useChosen() {
        if (maker_) maker_ = maker_->withViews(options_.views);
        if (quilter_) quilter_.emplace(target_.layout, options_.views);
    }

    // Makes the choices for a new scene and places the frame.
    Scene placed(const PipelineFrame& frame) {
        Scene scene{frame.source.picture, frame.depth};
        scene.edges = edges_;
        // the shape as displayed, because px of the frame need not be square
        const double aspect = target_.aspect() / frame.source.sampleAspect.value();
        PlacementOptions& options = options_;
        if (isChosenBy(frame)) {
            options = chooseFromScene(scene, aspect, target_.layout, options, wanted_).options;
            useChosen();
            isChosen_ = true;
            choices_.push_back({static_cast<double>(frame.source.pts), options.framing,
                                options.views.focus, options.views.strengthPercent});
        }
        if (isMeasured(frame)) options.refine.flaws.reset();
        const Placement result = placeScene(scene, aspect, workSize_, options);
        options.refine.flaws = result.flaws;
        return result.scene;
    }

    bool isChosenBy(const PipelineFrame& frame) const {
        return wanted_.any() && (!isChosen_ || frame.step.cut);
    }

    // What is wrong with the depth belongs to its source. It is measured at the start of a scene,
    // so edges do not waver from frame to frame; as given depth has no scenes, now and then.
    bool isMeasured(const PipelineFrame& frame) const {
        const bool isDue = isGiven_ && frame.number % kFramesPerMeasurement == 0;
        return isMeasuring_ && (!options_.refine.flaws || frame.step.cut || isDue);
    }

    NativeOptions options_; // with the choices for the scene, and its flaws
    VideoTarget target_;
    DepthEdges edges_;
    bool isGiven_;
    bool isMeasuring_; // the flaws of the depth were not given
    AutoChoices wanted_;
    bool isChosen_ = false; // options_ hold the choices for the scene
    std::vector<SceneChoice> choices_;
    cv::Size workSize_;
    std::optional<NativeMaker> maker_;
    std::optional<Depth2Quilt> quilter_; // used instead of the maker
    cv::Mat quilt_;
    cv::Mat last_;
    double lastPixelAspect_ = 0; // of the frame of last_
};

// Photo and depth side by side.
class RgbdRenderer : public FrameRenderer {
  public:
    RgbdRenderer(double focus, cv::Size photo, double seenAspect)
        : focus_(focus), // square px, even sides
          half_(std::max(2, static_cast<int>(std::lround(photo.height * seenAspect / 2)) * 2),
                std::max(2, photo.height / 2 * 2)) {}

    cv::Size size() const override { return {2 * half_.width, half_.height}; }

    void work(PipelineFrame& frame) override {
        cv::Mat& result = frame.result.picture;
        const double pixelAspect = frame.source.sampleAspect.value();
        if (frame.step.repeated && !last_.empty() && pixelAspect == lastPixelAspect_) {
            result = last_;
            return;
        }
        lastPixelAspect_ = pixelAspect;
        const Scene scene{frame.source.picture, frame.depth};
        // Frames of the first one's shape fill the half, although its sides are rounded.
        const double aspect = static_cast<double>(half_.width) / half_.height / pixelAspect;
        const double own = static_cast<double>(scene.photo.cols) / scene.photo.rows;
        const bool fills = std::abs(aspect / own - 1) < kSameShape;
        const PhotoFit fit = fitPhoto(scene.photo.size(), fills ? own : aspect, half_,
                                      fills ? FitMode::Stretch : FitMode::Contain);
        fitScene(scene, fit, focus_, fitted_,
                 kAsItIs); // as the depth that photo2native saves
        joinRgbd(fitted_.photo, fitted_.depth, DepthSide::Right, result);
        last_ = result;
    }

  private:
    static constexpr double kSameShape = 0.02;

    double focus_;
    cv::Size half_;
    Scene fitted_;
    cv::Mat last_;
    double lastPixelAspect_ = 0; // of the frame of last_
};

// Natives of quilts.
class QuiltRenderer : public FrameRenderer {
  public:
    QuiltRenderer(const VideoConversion& conversion, const VideoTarget& target)
        : fit_(conversion.viewAspect > 0 ? conversion.native.fit : FitMode::Stretch),
          viewAspect_(conversion.viewAspect), hasMap_(conversion.map.has_value()), target_(target),
          maker_(makerFor(conversion, target)) {}

    cv::Size size() const override { return target_.panelSize; }

    void work(PipelineFrame& frame) override {
        if (!last_.empty() && areEqual(frame.source.picture, lastQuilt_)) {
            frame.step.repeated = true;
            frame.result.picture = last_;
            return;
        }
        const cv::Mat& picture = frame.source.picture;
        cv::Mat quilt = hasMap_
                            ? cropQuilt(picture, target_.layout, last_.empty() ? &notes_ : nullptr)
                            : fitQuilt(picture, target_.layout);
        if (fit_ != FitMode::Stretch)
            applyFitToViews(quilt, target_.layout, viewAspect_, target_.aspect(), fit_, quilt);
        maker_.render(quilt, frame.result.picture);
        last_ = frame.result.picture;
        lastQuilt_ = frame.source.picture;
    }

    Notes notes() const override { return notes_; }

  private:
    static Quilt2Native makerFor(const VideoConversion& conversion, const VideoTarget& target) {
        if (conversion.map) return Quilt2Native(*conversion.map);
        const Display& display = *conversion.display;
        const QuiltSampling& sampling = conversion.native.sampling;
        if (sampling.views != ViewFilter::Nearest || sampling.inTile != TileSampling::Nearest)
            return {display.calibration, target.layout, sampling, display.invert};
        return Quilt2Native(NativeLut(display.calibration, target.layout, display.invert));
    }

    FitMode fit_;
    double viewAspect_;
    bool hasMap_;
    VideoTarget target_;
    Quilt2Native maker_;
    Notes notes_;
    cv::Mat last_;
    cv::Mat lastQuilt_;
};

} // namespace

std::unique_ptr<FrameRenderer> makePhotoRenderer(const VideoConversion& conversion,
                                                 const VideoTarget& target, cv::Size photo,
                                                 double seenAspect, DepthEdges edges) {
    if (conversion.product == VideoProduct::Rgbd) {
        return std::make_unique<RgbdRenderer>(conversion.native.views.focus, photo, seenAspect);
    }
    return std::make_unique<ViewsRenderer>(conversion, target, edges);
}

std::unique_ptr<FrameRenderer> makeQuiltRenderer(const VideoConversion& conversion,
                                                 const VideoTarget& target) {
    return std::make_unique<QuiltRenderer>(conversion, target);
}

} // namespace altiro3D
