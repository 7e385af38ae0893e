#include "altiro3D/video_io.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "media/ffmpeg.hpp"
#include "media/frame_decoder.hpp"
#include "media/part_frames.hpp"
#include "media/video_input.hpp"
#include "media/video_packets.hpp"
#include "media/video_picture.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxThreads = 64;
constexpr int kMaxThreadsByItself = 16; // default limit; more threads only need memory

[[noreturn]] void fail(ErrorCode code, const std::string& subject, const std::string& problem) {
    throw Error(code, subject, problem);
}

VideoReaderOptions complete(VideoReaderOptions options) {
    validate(options);
    const auto processors = static_cast<int>(std::thread::hardware_concurrency());
    if (options.threads == 0) options.threads = std::clamp(processors, 1, kMaxThreadsByItself);
    return options;
}

VideoInput openQuietly(const fs::path& path, const VideoReaderOptions& options) {
    quietFfmpeg();
    return openVideoInput(path, options);
}

std::optional<Deinterlacer> deinterlacerOf(const VideoInput& input,
                                           const VideoReaderOptions& options) {
    if (!options.deinterlace) return std::nullopt;
    return Deinterlacer(input.stream->time_base, options.threads, input.subject);
}

} // namespace

void validate(const VideoReaderOptions& options) {
    if (!(options.from >= 0) || !(options.from < 1e9)) {
        fail(ErrorCode::InvalidArgument, "from",
             "is " + numberText(options.from) + " s, expected 0 or more, less than 1e9 s");
    }
    if (!(options.to > options.from)) {
        fail(ErrorCode::InvalidArgument, "to",
             "is " + numberText(options.to) + " s, expected more than from, " +
                 numberText(options.from) + " s");
    }
    if (options.threads < 0 || options.threads > kMaxThreads) {
        fail(ErrorCode::InvalidArgument, "threads",
             "is " + std::to_string(options.threads) + ", expected 0.." +
                 std::to_string(kMaxThreads));
    }
}

// Packets are decoded to frames; the frames of the part are converted to pictures.
struct VideoReader::Impl {
    Impl(const fs::path& givenPath, const VideoReaderOptions& complete)
        : Impl(givenPath, complete, openQuietly(givenPath, complete)) {}
    Impl(const fs::path& givenPath, const VideoReaderOptions& complete, VideoInput input);

    std::int64_t framesBefore();
    bool read(VideoFrame& frame);
    Fraction aspectOf(const AVFrame& picture) const;

    fs::path path;
    VideoReaderOptions options;
    std::string subject; // its name, for errors
    VideoInput::Kind kind;
    VideoFacts facts;
    Notes remarks;    // of opening it
    std::string eyes; // see eyesText()
    VideoReadCounts counts;
    VideoPackets packets;
    FrameDecoder decoder;
    PartFrames part;
    PictureMaker pictures;
    bool isReshaped = false; // a frame has another size or shape of px than the first

  private:
    std::optional<std::int64_t> framesBefore_;
};

VideoReader::Impl::Impl(const fs::path& givenPath, const VideoReaderOptions& complete,
                        VideoInput input)
    : path(givenPath), options(complete), subject(input.subject), kind(input.kind),
      facts(input.facts), remarks(input.notes), eyes(input.eyes), packets(input, options, counts),
      decoder(std::move(input.decoder), packets,
              FrameTimes(facts, input.stream->time_base, input.startPts, counts),
              deinterlacerOf(input, options), counts),
      part(input, options, packets, decoder, counts),
      pictures(input.orientation, options.isDepth, options.threads, subject) {}

// Counts packets if each holds one frame, which is fast; else decodes from the start.
std::int64_t VideoReader::Impl::framesBefore() {
    if (framesBefore_) return *framesBefore_;
    check(!part.hasBegun(), "framesBefore", "comes after the first frame");
    std::error_code error;
    if (options.from <= 0) {
        framesBefore_ = 0;
    } else if (kind == VideoInput::Kind::File && fs::is_regular_file(path, error)) {
        framesBefore_ = countPackets(path, options, options.from);
    }
    if (!framesBefore_) framesBefore_ = part.countBefore();
    return *framesBefore_;
}

Fraction VideoReader::Impl::aspectOf(const AVFrame& picture) const {
    // A container's statement goes first, as in FFmpeg's tools.
    const AVRational stated = packets.stream().sample_aspect_ratio;
    const Fraction aspect = fraction(stated.num > 0 ? stated : picture.sample_aspect_ratio);
    constexpr double kMost = 16; // other values are damage
    if (!aspect.isKnown() || aspect.value() > kMost || aspect.value() * kMost < 1)
        return facts.sampleAspect;
    return facts.rotationDegrees % 180 != 0 ? Fraction{aspect.denominator, aspect.numerator}
                                            : aspect;
}

bool VideoReader::Impl::read(VideoFrame& frame) {
    PartFrames::Frame next;
    if (!part.next(next)) return false;
    frame.picture.release();
    const AVFrameSideData* const stereo =
        av_frame_get_side_data(next.picture, AV_FRAME_DATA_STEREO3D);
    if (eyes.empty() && stereo != nullptr)
        eyes = eyesText(reinterpret_cast<const AVStereo3D*>(stereo->data));
    pictures.make(*next.picture, frame.picture);
    frame.sampleAspect = aspectOf(*next.picture);
    isReshaped = isReshaped || frame.picture.size() != facts.size ||
                 std::abs(frame.sampleAspect.value() / facts.sampleAspect.value() - 1) > 1e-3;
    part.release();
    frame.pts = next.pts;
    frame.duration = next.duration;
    ++counts.frames;
    return true;
}

VideoReader::VideoReader(const fs::path& path, const VideoReaderOptions& options)
    : impl_(std::make_unique<Impl>(path, complete(options))) {}
VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;

const VideoFacts& VideoReader::facts() const {
    return impl_->facts;
}

const VideoReadCounts& VideoReader::counts() const {
    return impl_->counts;
}

std::optional<VideoFrame> VideoReader::next() {
    VideoFrame frame;
    if (!read(frame)) return std::nullopt;
    return frame;
}

bool VideoReader::read(VideoFrame& frame) {
    return impl_->read(frame);
}

std::int64_t VideoReader::framesBefore() {
    return impl_->framesBefore();
}

void VideoReader::skipTo(std::int64_t pts) {
    impl_->part.skipTo(pts);
}

bool VideoReader::pass(std::int64_t until) {
    return impl_->part.pass(until);
}

Notes VideoReader::notes() const {
    const Impl& impl = *impl_;
    Notes notes;
    const auto note = [&](NoteCode code, const std::string& text) {
        notes.push_back({code, impl.subject + ": " + text});
    };
    if (const auto truncation = impl.packets.truncation()) note(NoteCode::CutOff, *truncation);
    if (impl.counts.corrupt > 0) {
        note(NoteCode::Repaired, std::to_string(impl.counts.corrupt) +
                                     (impl.counts.corrupt == 1 ? " damaged frame was left out"
                                                               : " damaged frames were left out"));
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
    if (!impl.eyes.empty()) {
        note(NoteCode::Doubtful, "holds the pictures of both eyes (" + impl.eyes +
                                     "), which become one flat scene; expected those of one eye");
    }
    notes.insert(notes.end(), impl.remarks.begin(), impl.remarks.end());
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
