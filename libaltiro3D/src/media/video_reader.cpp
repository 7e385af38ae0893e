#include "altiro3D/error.hpp"
#include "altiro3D/video_io.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "media/ffmpeg.hpp"
#include "media/frame_decoder.hpp"
#include "media/video_input.hpp"
#include "media/video_packets.hpp"
#include "media/video_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using Kind = VideoInput::Kind;

constexpr double kStepsBackSeconds[] = {0, 2, 10};
constexpr double kFarSeconds = 2; // nearer frames are decoded, further ones sought
constexpr std::int64_t kToTheEnd = std::numeric_limits<std::int64_t>::max();
constexpr int kMaxThreads = 64;
constexpr int kMaxThreadsByItself = 16; // default limit; more threads only need memory

std::int64_t durationOf(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(57, 30, 100)
    return frame.duration;
#else
    return frame.pkt_duration;
#endif
}

VideoReaderOptions complete(VideoReaderOptions options) {
    validate(options);
    const auto processors = static_cast<int>(std::thread::hardware_concurrency());
    if (options.threads == 0) options.threads = std::clamp(processors, 1, kMaxThreadsByItself);
    return options;
}

} // namespace

void validate(const VideoReaderOptions& options) {
    check(options.from >= 0 && options.from < 1e9, "from",
          "is " + numberText(options.from) + " s, expected 0 or more, less than 1e9 s");
    check(options.to > options.from, "to",
          "is " + numberText(options.to) + " s, expected more than from, " +
              numberText(options.from) + " s");
    check(options.threads >= 0 && options.threads <= kMaxThreads, "threads",
          "is " + std::to_string(options.threads) + ", expected 0.." + std::to_string(kMaxThreads));
}

// Packets are decoded to frames; those of the part are converted to pictures. Finds the beginning
// of the part, skips, and stops at its end.
struct VideoReader::Impl {
    Impl(const fs::path& givenPath, const VideoReaderOptions& complete);

    std::int64_t framesBefore();
    bool read(VideoFrame& frame);
    void skipTo(std::int64_t pts);
    bool pass(std::int64_t until);

    fs::path path;
    VideoReaderOptions options;
    VideoInput input;
    VideoReadCounts counts;
    VideoPackets packets;
    FrameDecoder decoder;
    PictureMaker pictures;
    bool isReshaped = false; // a frame has another size or shape of px than the first

  private:
    bool next(VideoFrame& frame);
    void begin(bool maySeek);
    bool seekToPart();
    bool decodeUpToPart();
    void goTo(std::int64_t goal);
    bool seek(std::optional<std::int64_t> target);
    void end();
    Fraction aspectOf(const AVFrame& picture) const;

    // unit of the stream's times, s; then, in this unit, the range of the part in the file's time
    double unit_;
    std::int64_t fromPts_;
    std::int64_t toPts_;
    std::int64_t originPts_; // the time that counts as 0

    DecodedFrame current_; // the next one to return
    DecodedFrame ahead_;   // after next(): the one that it returned
    bool hasCurrent_ = false;
    bool begun_ = false;
    bool ended_ = false;
    bool pastEnd_ = false;          // at the end of the part
    std::int64_t passedFrames_ = 0; // decoded before the part
    std::optional<std::int64_t> framesBefore_;
};

VideoReader::Impl::Impl(const fs::path& givenPath, const VideoReaderOptions& complete)
    : path(givenPath), options(complete), input(openVideoInput(path, options)),
      packets(input, options, counts), decoder(input, options, packets, counts),
      pictures(orientationOf(input.facts), options.isDepth, options.threads, input.subject),
      unit_(av_q2d(input.stream->time_base)),
      fromPts_(input.startPts + std::llround(options.from / unit_)),
      toPts_(options.to < 1e9 ? input.startPts + std::llround(options.to / unit_) : kToTheEnd),
      originPts_(options.from > 0 ? fromPts_ : input.startPts) {}

// Seeks to the last key frame before a time, or to the beginning.
bool VideoReader::Impl::seek(std::optional<std::int64_t> target) {
    if (!(target ? packets.seek(*target) : packets.seekToStart())) return false;
    decoder.restart();
    counts = {};
    return true;
}

void VideoReader::Impl::begin(bool maySeek) {
    begun_ = true;
    packets.begin();
    const bool seeks = maySeek && input.canSeek();
    bool found = fromPts_ > input.startPts && seeks && seekToPart();
    while (found && ahead_.pts < fromPts_)
        found = decoder.decode(ahead_);
    if (!found) found = decodeUpToPart();
    if (found && ahead_.pts >= toPts_) {
        pastEnd_ = true;
        found = false;
    }
    if (found) originPts_ = std::min(originPts_, ahead_.pts);
    packets.others()->setRange(
        originPts_, toPts_ == kToTheEnd ? std::nullopt : std::optional<std::int64_t>(toPts_),
        input.stream->time_base, options.from > 0);
    hasCurrent_ = found;
    if (found) std::swap(current_, ahead_);
}

// Decodes a frame (ahead_) at or before the beginning of the part. False: decode on from here.
bool VideoReader::Impl::seekToPart() {
    bool found = false;
    // A container may seek past the requested frame; then the search starts further back.
    for (const double back : kStepsBackSeconds) {
        const auto ticks = static_cast<std::int64_t>(std::ceil(back / unit_));
        if (!seek(std::max(input.startPts, fromPts_ - ticks))) break;
        found = decoder.decode(ahead_);
        if (found && ahead_.pts <= fromPts_) return true;
        if (static_cast<double>(fromPts_ - input.startPts) * unit_ <= back) break; // from the start
    }
    // The last resort: decode everything from the start.
    if (seek(std::nullopt)) return false;
    if (found) {
        throw Error(ErrorCode::ReadFailed, input.subject,
                    "cannot seek to " + numberText(options.from) +
                        " s, expected a file with an index");
    }
    return false;
}

// Decodes from the current position up to the first frame of the part (ahead_).
bool VideoReader::Impl::decodeUpToPart() {
    for (;; ++passedFrames_) {
        if (!decoder.decode(ahead_)) return false;
        if (options.from <= 0 || ahead_.pts >= fromPts_) return true;
    }
}

// Counts packets if each holds one frame, which is fast; else decodes from the start.
std::int64_t VideoReader::Impl::framesBefore() {
    if (framesBefore_) return *framesBefore_;
    check(!begun_, "framesBefore", "comes after the first frame");
    std::error_code error;
    if (options.from <= 0) {
        framesBefore_ = 0;
    } else if (input.kind == Kind::File && fs::is_regular_file(path, error)) {
        framesBefore_ = countPackets(path, options, options.from);
    }
    if (!framesBefore_) {
        begin(false);
        framesBefore_ = passedFrames_;
    }
    return *framesBefore_;
}

// The next frame of the part without its picture, which is in `ahead_`. False at the end.
bool VideoReader::Impl::next(VideoFrame& frame) {
    if (!begun_) {
        begin(true);
    } else if (input.facts.isLive && !ended_ &&
               !hasCurrent_) { // waits for the next picture only now
        hasCurrent_ = decoder.decode(current_) && current_.pts < toPts_;
    }
    if (!hasCurrent_) {
        if (ended_) return false;
        if (!decoder.times().hasBegun() && counts.corrupt > 0 && !pastEnd_) {
            ended_ = true;
            throw Error(ErrorCode::BadFormat, input.subject,
                        "holds " + input.facts.codec +
                            " video of which not one frame can be decoded");
        }
        end();
        return false;
    }
    frame.pts = current_.pts - originPts_;
    const std::int64_t stated = durationOf(*current_.frame);
    frame.duration = isNear(stated) ? stated : 0;
    bool hasNext = false;
    if (!input.facts.isLive) { // the time of the next frame is the end of this one
        hasNext = decoder.decode(ahead_);
        if (hasNext) {
            frame.duration = ahead_.pts - current_.pts;
        } else if (frame.duration <= 0) {
            frame.duration = decoder.times().frameDuration();
        }
        if (hasNext && ahead_.pts >= toPts_) {
            pastEnd_ = true;
            hasNext = false;
        }
    }
    std::swap(current_, ahead_);
    hasCurrent_ = hasNext;
    return true;
}

void VideoReader::Impl::end() {
    ended_ = true;
    if (pastEnd_) packets.drainOthers(toPts_);
    packets.others()->end();
}

void VideoReader::Impl::skipTo(std::int64_t pts) {
    if (!begun_) begin(true);
    const std::int64_t goal = originPts_ + std::clamp(pts, -kFarthestTime, kFarthestTime);
    if (hasCurrent_) goTo(goal);
    if (hasCurrent_ && current_.pts >= toPts_) {
        pastEnd_ = true;
        hasCurrent_ = false;
    }
}

// Decodes up to the first frame at or after that time, in the part or after it. Seeks if it is far.
void VideoReader::Impl::goTo(std::int64_t goal) {
    const auto far = static_cast<std::int64_t>(kFarSeconds / unit_);
    const bool needsBefore = decoder.deinterlaces(); // the frame depends on the one before
    if (input.hasFixedTimes() && goal - current_.pts > far &&
        seek(needsBefore ? goal - far : goal)) {
        // Repaired times may differ after a seek. Unless the goal is met exactly, all is read.
        bool before = false;
        while ((hasCurrent_ = decoder.decode(current_)) && current_.pts < goal)
            before = true;
        if (hasCurrent_ && current_.pts == goal && (before || !needsBefore)) return;
        if (!hasCurrent_ && before && counts.repairedTimes == 0) return; // the video ends earlier
        hasCurrent_ = seek(std::nullopt) && decoder.decode(current_);
    }
    while (hasCurrent_ && current_.pts < goal)
        hasCurrent_ = decoder.decode(current_);
}

bool VideoReader::Impl::pass(std::int64_t until) {
    if (!begun_) begin(true);
    if (ended_) return false;
    bool more = !pastEnd_;
    while (more && packets.read()) {
        if (!packets.isOfPictures()) {
            packets.keep();
            continue;
        }
        const std::int64_t time = packets.time();
        if (!isNear(time)) continue;
        if (time >= toPts_) {
            pastEnd_ = true;
            more = false;
        } else if (time - originPts_ > until) {
            return true;
        }
    }
    end();
    return false;
}

Fraction VideoReader::Impl::aspectOf(const AVFrame& picture) const {
    // A container's statement goes first, as in FFmpeg's tools.
    const AVRational stated = input.stream->sample_aspect_ratio;
    const Fraction aspect = fraction(stated.num > 0 ? stated : picture.sample_aspect_ratio);
    constexpr double kMost = 16; // other values are damage
    if (!aspect.isKnown() || aspect.value() > kMost || aspect.value() * kMost < 1)
        return input.facts.sampleAspect;
    return input.facts.rotationDegrees % 180 != 0 ? Fraction{aspect.denominator, aspect.numerator}
                                                  : aspect;
}

bool VideoReader::Impl::read(VideoFrame& frame) {
    if (!next(frame)) return false;
    AVFrame& decoded = *ahead_.frame;
    frame.picture.release();
    const AVFrameSideData* const stereo = av_frame_get_side_data(&decoded, AV_FRAME_DATA_STEREO3D);
    if (counts.frames == 0 && input.facts.eyes.empty() && stereo != nullptr)
        setEyes(reinterpret_cast<const AVStereo3D*>(stereo->data), input.facts);
    pictures.make(decoded, frame.picture);
    frame.sampleAspect = aspectOf(decoded);
    isReshaped = isReshaped || frame.picture.size() != input.facts.size ||
                 std::abs(frame.sampleAspect.value() / input.facts.sampleAspect.value() - 1) > 1e-3;
    av_frame_unref(&decoded);
    ++counts.frames;
    return true;
}

VideoReader::VideoReader(const fs::path& path, const VideoReaderOptions& options)
    : impl_(std::make_unique<Impl>(path, complete(options))) {}
VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;

const VideoFacts& VideoReader::facts() const {
    return impl_->input.facts;
}

const VideoReadCounts& VideoReader::counts() const {
    return impl_->counts;
}

std::optional<VideoFrame> VideoReader::next() {
    VideoFrame frame;
    return read(frame) ? std::optional(std::move(frame)) : std::nullopt;
}

bool VideoReader::read(VideoFrame& frame) try {
    return impl_->read(frame);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

std::int64_t VideoReader::framesBefore() {
    return impl_->framesBefore();
}

void VideoReader::skipTo(std::int64_t pts) {
    impl_->skipTo(pts);
}

bool VideoReader::pass(std::int64_t until) {
    return impl_->pass(until);
}

Notes VideoReader::notes() const {
    const Impl& impl = *impl_;
    Notes notes;
    const auto note = [&](NoteCode code, const std::string& text) {
        notes.push_back({code, impl.input.subject + ": " + text});
    };
    if (const auto truncation = impl.packets.truncation()) note(NoteCode::CutOff, *truncation);
    if (impl.counts.corrupt > 0) {
        note(NoteCode::Repaired,
             std::to_string(impl.counts.corrupt) +
                 (impl.counts.corrupt == 1 ? " damaged frame was" : " damaged frames were") +
                 " left out" +
                 (impl.input.twin != nullptr ? ", counting those without the other eye's" : ""));
    }
    if (impl.counts.repairedTimes > 0) {
        note(NoteCode::Repaired, "the times of " + std::to_string(impl.counts.repairedTimes) +
                                     " frames were missing or ran backwards and were replaced");
    }
    if (impl.decoder.times().beginsAgain()) {
        note(NoteCode::Doubtful, "its times begin again, as in files that were simply appended to "
                                 "each other; from there "
                                 "on the sound is out of step");
    }
    if (impl.decoder.hasInterlaced() && !impl.options.deinterlace)
        note(NoteCode::AsItIs, "holds interlaced frames, which are not deinterlaced");
    if (impl.isReshaped)
        note(NoteCode::Converted,
             "the shape of its frames changes; each is fitted in its own shape");
    if (impl.input.facts.eyes == kAlternateFrames && !impl.input.alternates)
        note(NoteCode::AsItIs, "shows the eyes by turns, as its frames are read");
    notes.insert(notes.end(), impl.input.notes.begin(), impl.input.notes.end());
    if (const int transfer = impl.pictures.hdrTransfer(); transfer != 0) {
        note(NoteCode::Converted, std::string("is HDR (") +
                                      (transfer == AVCOL_TRC_SMPTE2084 ? "PQ" : "HLG") +
                                      "): its bright parts are compressed");
    }
    return notes;
}

std::shared_ptr<OtherStreams> VideoReader::otherStreams() const {
    return impl_->packets.others();
}

} // namespace altiro3D
