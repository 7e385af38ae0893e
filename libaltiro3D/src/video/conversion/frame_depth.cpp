#include "video/conversion/frame_depth.hpp"

#include "altiro3D/error.hpp"
#include "base/state_bytes.hpp"
#include "video/motion/picture_tracker.hpp"

#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

constexpr std::size_t kDigestBytes = sizeof(std::uint64_t);

std::string digest(const cv::Mat& picture) {
    std::uint64_t sum = pictureHash(picture);
    for (const int part : {picture.rows, picture.cols, picture.type()})
        sum = mixIn(sum, static_cast<std::uint64_t>(part));
    std::string bytes;
    append(bytes, sum);
    return bytes;
}

// Frames mostly give the same remark.
void addNew(const Note& note, Notes& notes) {
    for (const Note& known : notes)
        if (known.text == note.text) return;
    notes.push_back(note);
}

} // namespace

FrameDepth::FrameDepth(VideoConversion& conversion, const VideoFacts& facts)
    : flatDepth_(conversion.native.views.focus), options_(conversion.depthOptions),
      unit_(facts.timeBase.value()) {
    if (conversion.given) {
        const GivenVideoDepth& given = *conversion.given;
        rgbd_ = given.rgbd;
        kind_ = given.kind;
        range_ = given.range.value_or(DepthRange());
        options_.every = 1;
        if (conversion.choices.any()) cuts_.emplace();
        if (!rgbd_) given_.emplace(given, conversion.part, facts);
    } else {
        source_ = std::move(conversion.depth);
        kind_ = source_->kind();
    }
    start();
}

void FrameDepth::start() {
    const auto estimate = [this](const cv::Mat& picture, cv::Mat& raw) {
        if (source_) {
            cv::Mat photo;
            source_->readFrame(picture, photo, raw);
        } else {
            raw_.copyTo(raw);
        }
    };
    depth_.emplace(estimate, kind_, options_);
}

void FrameDepth::begin(VideoReader& video) {
    if (given_) given_->begin(video);
}

cv::Size FrameDepth::photoSize(cv::Size frame) const {
    return rgbd_ ? rgbd_->photoSize(frame) : frame;
}

double FrameDepth::photoAspect(cv::Size frame, double frameAspect) const {
    const cv::Size photo = photoSize(frame);
    const auto aspect = [](cv::Size size) { return static_cast<double>(size.width) / size.height; };
    return frameAspect * aspect(photo) / aspect(frame);
}

SavedState FrameDepth::state() const {
    std::string cuts;
    if (cuts_) cuts_->save(cuts);
    return {digest(lastPhoto_) + digest(lastRaw_) + cuts + depth_->state().bytes};
}

void FrameDepth::setState(const SavedState& state) {
    if (state.bytes.size() < 2 * kDigestBytes) throw damagedState();
    std::string_view rest(state.bytes);
    rest.remove_prefix(2 * kDigestBytes);
    if (cuts_ && !cuts_->load(rest)) throw damagedState();
    depth_->setState({std::string(rest)});
    kept_ = state.bytes.substr(0, 2 * kDigestBytes);
}

void FrameDepth::work(PipelineFrame& frame) {
    if (source_) {
        frame.step = depth_->next(frame.source.picture, frame.depth);
        return;
    }
    if (given_) {
        given_->read(static_cast<double>(frame.source.pts) * unit_, frame.number, raw_);
    } else {
        cv::Mat photo;
        Notes notes;
        splitRgbd(frame.source.picture, *rgbd_, photo, raw_, &notes);
        if (photo.size() != photoSize(frame.source.picture.size())) {
            throw Error(ErrorCode::Unsupported, "RGB-D frame",
                        "has a white gap between photo and depth, expected halves without a gap");
        }
        for (const Note& note : notes)
            addNew({note.code, "RGB-D frames: " + note.text}, notes_);
        raw_.convertTo(raw_, CV_8U); // a grey value of a frame
        frame.source.picture = photo;
    }
    useGiven(frame);
}

// Grey values have one range for the whole video, so that the depth does not waver. Distances and
// floats have no fixed range; they get one that follows them slowly.
void FrameDepth::useGiven(PipelineFrame& frame) {
    bool samePhoto = areEqual(frame.source.picture, lastPhoto_);
    bool sameDepth = areEqual(raw_, lastRaw_);
    if (!kept_.empty()) {
        samePhoto = kept_.compare(0, kDigestBytes, digest(frame.source.picture)) == 0;
        sameDepth = kept_.compare(kDigestBytes, kDigestBytes, digest(raw_)) == 0;
        kept_.clear();
    }
    lastPhoto_ = frame.source.picture;
    lastRaw_ = raw_.clone();
    const bool isCut = cuts_ && cuts_->next(frame.source.picture).cut;
    const bool grey = raw_.depth() == CV_8U || raw_.depth() == CV_16U;
    if (grey && kind_ != DepthKind::Metric) {
        frame.step.repeated = samePhoto && sameDepth;
        frame.step.cut = isCut;
        const DepthRange range = raw_.depth() == CV_8U ? DepthRange{0, 255} : range_;
        if (range.high <= range.low) {
            frame.depth.create(raw_.size(), CV_32FC1);
            frame.depth.setTo(flatDepth_);
            return;
        }
        const double scale = (kind_ == DepthKind::FarWhite ? -1 : 1) / (range.high - range.low);
        raw_.convertTo(frame.depth, CV_32F, scale,
                       -scale * (kind_ == DepthKind::FarWhite ? range.high : range.low));
        if (raw_.depth() != CV_8U) frame.depth = cv::min(cv::max(frame.depth, 0), 1);
        return;
    }
    if (samePhoto && !sameDepth) start(); // the picture does not show what moves
    frame.step = depth_->next(frame.source.picture, frame.depth);
    frame.step.inferred = false;
}

} // namespace altiro3D
