#include "altiro3D/video_reader.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/mat_memory.hpp"
#include "base/text.hpp"
#include "video/ffmpeg.hpp"
#include "video/other_streams.hpp"
#include "video/video_input.hpp"
#include "video/video_picture.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <thread>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using Kind = VideoInput::Kind;

constexpr int kMostThreads = 64;
constexpr int kMostThreadsByItself = 16; // more only take memory
constexpr double kStepsBackSeconds[] = {0, 2, 10};
constexpr double kMissingSeconds = 0.5; // a file that ends so much too early is cut off
constexpr double kInterleavedSeconds = 10;
constexpr double kFarSeconds = 2;   // nearer frames are decoded, further ones sought
constexpr int kMostInDisorder = 16; // frames; more, or further back, and times have jumped
constexpr double kFarBackSeconds = 1;

[[noreturn]] void fail(ErrorCode code, const std::string& subject, const std::string& problem) {
    throw Error(code, subject, problem);
}

std::int64_t durationOf(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(57, 30, 100)
    return frame.duration;
#else
    return frame.pkt_duration;
#endif
}

bool isInterlaced(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 7, 100)
    return (frame.flags & AV_FRAME_FLAG_INTERLACED) != 0;
#else
    return frame.interlaced_frame != 0;
#endif
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
    if (options.threads < 0 || options.threads > kMostThreads) {
        fail(ErrorCode::InvalidArgument, "threads",
             "is " + std::to_string(options.threads) + ", expected 0.." +
                 std::to_string(kMostThreads));
    }
}

struct VideoReader::Impl {
    Impl(const fs::path& path, const VideoReaderOptions& given);

    std::int64_t framesBefore();
    bool read(VideoFrame& frame);
    void skipTo(std::int64_t pts);
    bool pass(std::int64_t until);

    std::string subject;
    VideoReaderOptions options;
    VideoFacts facts;
    VideoReadCounts counts;
    std::shared_ptr<OtherStreams> others = std::make_shared<OtherStreams>();
    double lastEnd = 0; // s: end of the last packet of any stream, from the start of the file
    double fileEnd = 0; // s: where the file says it ends; 0 = it does not
    bool interlaced = false;
    bool resized = false;
    bool beginsAgain = false; // times of the file do

  private:
    void setRange();
    void begin();
    void goTo(std::int64_t goal);
    void restart();
    bool seek(std::int64_t target);
    bool seekToStart();
    bool readPacket();
    void keepOther();
    std::int64_t risingTime(const AVFrame& frame);
    bool decode(AVFrame& frame);
    bool decodeInRange(AVFrame& frame);
    void drainOthers();
    void noteEnd(int result);
    std::int64_t frameDuration() const;

    fs::path path_;
    Kind kind_ = Kind::File;
    bool hasFixedTimes_ = false;
    bool hasCurrent_ = false;
    InputPtr format_;
    AVStream* stream_ = nullptr;
    CodecPtr decoder_;
    std::unique_ptr<PictureMaker> pictures_;
    PacketPtr packet_ = newPacket();
    FramePtr current_ = newFrame();
    FramePtr ahead_ = newFrame();
    std::int64_t currentPts_ = 0; // file time
    std::int64_t aheadPts_ = 0;
    std::int64_t passedFrames_ = 0; // decoded from the start of the file, before the part
    std::optional<std::int64_t> framesBefore_;

    std::vector<std::int64_t> otherIndex_; // by stream of the file, -1 = the delivered one
    std::set<std::int64_t> corruptPts_;    // of packets the container calls damaged
    std::int64_t startPts_ = 0;            // of the file, in the stream's unit
    std::int64_t fromPts_ = 0;
    std::int64_t toPts_ = 0;
    std::int64_t originPts_ = 0;
    std::int64_t lastPts_ = 0;   // of the frame decoded last
    std::int64_t timeShift_ = 0; // see risingTime()
    int inDisorder_ = 0;         // frames in a row
    bool hasLast_ = false;
    bool countsBefore_ = false; // while it begins
    bool begun_ = false;
    bool wanted_ = false; // a writer wants the other streams
    bool drained_ = false;
    bool sentEnd_ = false;
    bool ended_ = false;
    bool pastEnd_ = false; // ended by options.to
};

VideoReader::Impl::Impl(const fs::path& path, const VideoReaderOptions& given)
    : options(given), path_(path) {
    validate(options);
    quietFfmpeg();
    const auto processors = static_cast<int>(std::thread::hardware_concurrency());
    if (options.threads == 0) options.threads = std::clamp(processors, 1, kMostThreadsByItself);
    VideoInput input = openVideoInput(path, options);
    otherIndex_ = describeOthers(input, options, *others);
    const AVCodecParameters& parameters = *input.stream->codecpar;
    pictures_ = std::make_unique<PictureMaker>(cv::Size(parameters.width, parameters.height),
                                               input.orientation, options.threads, input.subject);
    subject = input.subject;
    facts = std::move(input.facts);
    fileEnd = input.end;
    kind_ = input.kind;
    hasFixedTimes_ = input.hasFixedTimes();
    format_ = std::move(input.format);
    stream_ = input.stream;
    decoder_ = std::move(input.decoder);
    startPts_ = input.startPts;
    setRange();
}

// Where the wanted part begins and ends, in the time of the file.
void VideoReader::Impl::setRange() {
    const double unit = av_q2d(stream_->time_base);
    fromPts_ = startPts_ + std::llround(options.from / unit);
    toPts_ = options.to < 1e9 ? startPts_ + std::llround(options.to / unit)
                              : std::numeric_limits<std::int64_t>::max();
    originPts_ = options.from > 0 ? fromPts_ : startPts_;
}

// After a seek: what came before does not count.
void VideoReader::Impl::restart() {
    avcodec_flush_buffers(decoder_.get());
    others->clear();
    corruptPts_.clear();
    sentEnd_ = false;
    drained_ = false;
    hasLast_ = false;
    timeShift_ = 0;
    inDisorder_ = 0;
    beginsAgain = false;
    lastEnd = 0;
    counts = {};
}

// Goes to the last key frame before a time of the file; false if the file cannot.
bool VideoReader::Impl::seek(std::int64_t target) {
    if (av_seek_frame(format_.get(), stream_->index, target, AVSEEK_FLAG_BACKWARD) < 0) {
        return false;
    }
    restart();
    return true;
}

// Goes to the very beginning of the file; false if the file cannot.
bool VideoReader::Impl::seekToStart() {
    if (avformat_seek_file(format_.get(), -1, INT64_MIN, INT64_MIN, INT64_MAX, 0) < 0) {
        return seek(startPts_);
    }
    restart();
    return true;
}

void VideoReader::Impl::begin() {
    begun_ = true;
    wanted_ = others->begin();
    bool found = false;
    // A bare stream has no times, so a place in it cannot be found again.
    const bool seekable =
        kind_ == Kind::File && format_->start_time != AV_NOPTS_VALUE && !countsBefore_;
    if (fromPts_ > startPts_ && seekable) {
        // A container may lead behind the wanted frame: then from further back.
        for (const double back : kStepsBackSeconds) {
            const auto ticks =
                static_cast<std::int64_t>(std::ceil(back / av_q2d(stream_->time_base)));
            if (!seek(std::max(startPts_, fromPts_ - ticks))) break;
            found = decode(*ahead_);
            if (found && aheadPts_ <= fromPts_) break;
            const bool fromStart =
                static_cast<double>(fromPts_ - startPts_) * av_q2d(stream_->time_base) <= back;
            if (fromStart) break;
        }
        if (!found || aheadPts_ > fromPts_) {
            // The last way: everything from the start.
            if (seekToStart()) {
                found = false;
            } else if (found) {
                fail(ErrorCode::ReadFailed, subject,
                     "cannot seek to " + numberText(options.from) +
                         " s, expected a file with an index");
            }
        }
    }
    while (found && aheadPts_ < fromPts_) {
        found = decode(*ahead_);
    }
    if (!found) found = decodeInRange(*ahead_);
    if (found && aheadPts_ >= toPts_) {
        pastEnd_ = true;
        found = false;
    }
    if (found && aheadPts_ < originPts_) originPts_ = aheadPts_;
    others->setRange(originPts_,
                     toPts_ == std::numeric_limits<std::int64_t>::max()
                         ? std::nullopt
                         : std::optional<std::int64_t>(toPts_),
                     stream_->time_base, options.from > 0);
    hasCurrent_ = found;
    if (found) {
        std::swap(current_, ahead_);
        currentPts_ = aheadPts_;
    }
}

// Takes one packet from the container; false at its end.
bool VideoReader::Impl::readPacket() {
    if (drained_) return false;
    const int result = av_read_frame(format_.get(), packet_.get());
    if (result == AVERROR(EAGAIN)) { // a device without a picture yet
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return true;
    }
    if (result < 0) {
        drained_ = true;
        noteEnd(result);
        return false;
    }
    const AVStream& stream = *format_->streams[packet_->stream_index];
    const std::int64_t time = packet_->pts != AV_NOPTS_VALUE ? packet_->pts : packet_->dts;
    if (time != AV_NOPTS_VALUE) {
        const double end = (static_cast<double>(time) +
                            static_cast<double>(std::max<std::int64_t>(packet_->duration, 0))) *
                               av_q2d(stream.time_base) -
                           static_cast<double>(startPts_) * av_q2d(stream_->time_base);
        lastEnd = std::max(lastEnd, end);
    }
    return true;
}

// The container has no more packets: at its end or before it?
void VideoReader::Impl::noteEnd(int result) {
    if (kind_ == Kind::Device) {
        if (result != AVERROR_EOF) {
            fail(ErrorCode::ReadFailed, subject, "cannot be read: " + ffmpegText(result));
        }
        return;
    }
    if (format_->pb != nullptr && format_->pb->error < 0 && format_->pb->error != AVERROR_EOF &&
        format_->pb->error != AVERROR_INVALIDDATA) {
        fail(ErrorCode::ReadFailed, subject,
             "cannot be read any further: " + ffmpegText(format_->pb->error));
    }
    counts.truncated =
        result != AVERROR_EOF || (fileEnd > 0 && lastEnd < fileEnd - kMissingSeconds);
}

// Hands a packet that is not of the pictures over to the writer.
void VideoReader::Impl::keepOther() {
    const auto index = static_cast<std::size_t>(packet_->stream_index);
    if (!wanted_ || index >= otherIndex_.size()) return; // a stream that appeared later
    PacketPtr kept = newPacket();
    av_packet_move_ref(kept.get(), packet_.get());
    others->push(static_cast<std::size_t>(otherIndex_[index]), std::move(kept));
}

// The time of the frame after that of lastPts_: as the file states it if that is later, else
// repaired.
//
// A few frames in disorder are put one tick apart, so that the next good time counts again. Where
// times begin again, as in files put together, what follows is shifted as a whole.
std::int64_t VideoReader::Impl::risingTime(const AVFrame& frame) {
    std::optional<std::int64_t> stated; // AV_NOPTS_VALUE is far outside
    if (isNear(frame.best_effort_timestamp)) stated = frame.best_effort_timestamp;
    if (stated && (!hasLast_ || *stated > lastPts_)) timeShift_ = 0;
    const std::int64_t latest = kFarthestTime;
    if (stated && (!hasLast_ || *stated + timeShift_ > lastPts_)) {
        inDisorder_ = 0;
        return std::min(*stated + timeShift_, latest);
    }
    if (hasLast_ || !facts.averageRate.isKnown() || facts.frameCount.value_or(0) > 1)
        ++counts.repairedTimes;
    if (!hasLast_) return startPts_;
    const std::int64_t step = std::max<std::int64_t>(frameDuration(), 1);
    const std::int64_t next = std::min(lastPts_ + step, latest);
    if (!stated) return next;
    // A piece begins with a picture that needs no other.
    const std::int64_t back = lastPts_ - *stated - timeShift_;
    const bool isPiece = frame.pict_type == AV_PICTURE_TYPE_I && back >= 2 * step;
    const double seconds = static_cast<double>(back) * av_q2d(stream_->time_base);
    const bool isFar = seconds >= kFarBackSeconds && back >= kMostInDisorder * step;
    if (++inDisorder_ <= kMostInDisorder && !isPiece && !isFar)
        return std::min(lastPts_ + 1, latest);
    beginsAgain = beginsAgain || isPiece || isFar;
    timeShift_ = next - *stated;
    return next;
}

// The next undamaged frame and its time (aheadPts_); false at the end.
bool VideoReader::Impl::decode(AVFrame& frame) {
    for (;;) {
        const int result = avcodec_receive_frame(decoder_.get(), &frame);
        if (result == AVERROR_EOF) return false;
        if (result == AVERROR(EAGAIN)) {
            if (sentEnd_) return false;
            av_packet_unref(packet_.get());
            if (!readPacket()) {
                sentEnd_ = true;
                avcodec_send_packet(decoder_.get(), nullptr);
                continue;
            }
            if (packet_->data == nullptr && packet_->size == 0) continue;
            if (packet_->stream_index != stream_->index) {
                keepOther();
                continue;
            }
            if ((packet_->flags & AV_PKT_FLAG_CORRUPT) != 0) {
                if (packet_->pts != AV_NOPTS_VALUE) corruptPts_.insert(packet_->pts);
            }
            const int sent = avcodec_send_packet(decoder_.get(), packet_.get());
            if (sent == AVERROR(ENOMEM)) checkMemory(nullptr);
            if (sent < 0 && sent != AVERROR(EAGAIN)) ++counts.corrupt;
            continue;
        }
        if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
        if (result < 0) {
            ++counts.corrupt;
            continue;
        }
        if ((frame.flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame.decode_error_flags != 0 ||
            corruptPts_.erase(frame.pts) != 0) {
            ++counts.corrupt;
            continue;
        }
        interlaced = interlaced || isInterlaced(frame);
        aheadPts_ = risingTime(frame);
        lastPts_ = aheadPts_;
        hasLast_ = true;
        return true;
    }
}

// decode() without the frames before the beginning.
bool VideoReader::Impl::decodeInRange(AVFrame& frame) {
    for (;; ++passedFrames_) {
        if (!decode(frame)) return false;
        if (options.from <= 0 || aheadPts_ >= fromPts_) return true;
    }
}

// By packets where they tell, as that takes no time to speak of; else by decoding from the start.
std::int64_t VideoReader::Impl::framesBefore() {
    if (framesBefore_) return *framesBefore_;
    check(!begun_, "framesBefore", "comes after the first frame");
    std::error_code error;
    if (options.from <= 0) {
        framesBefore_ = 0;
    } else if (kind_ == Kind::File && fs::is_regular_file(path_, error)) {
        framesBefore_ = countPackets(path_, options, options.from);
    }
    if (!framesBefore_) {
        countsBefore_ = true;
        begin();
        framesBefore_ = passedFrames_;
    }
    return *framesBefore_;
}

// Reads on until the sound has come to the end of the part, too.
void VideoReader::Impl::drainOthers() {
    if (!wanted_ || !pastEnd_) return;
    std::set<int> behind;
    for (std::size_t i = 0; i < others->streams.size(); ++i) {
        const OtherStream& other = others->streams[i];
        if (other.parameters->codec_type == AVMEDIA_TYPE_AUDIO && others->isTaken(i))
            behind.insert(other.index);
    }
    while (!behind.empty()) {
        av_packet_unref(packet_.get());
        if (!readPacket()) break;
        const auto index = static_cast<std::size_t>(packet_->stream_index);
        const std::int64_t time = packet_->dts != AV_NOPTS_VALUE ? packet_->dts : packet_->pts;
        if (index >= otherIndex_.size() || !isNear(time)) continue;
        const AVRational unit = format_->streams[index]->time_base;
        if (packet_->stream_index == stream_->index) {
            const double past = static_cast<double>(time - toPts_) * av_q2d(unit);
            if (past > kInterleavedSeconds) break;
            continue;
        }
        if (av_compare_ts(time, unit, toPts_, stream_->time_base) >= 0) {
            behind.erase(static_cast<int>(index));
            continue;
        }
        keepOther();
    }
}

// Goes on with the frame of that time, as read() gives it; the frames before are left out.
void VideoReader::Impl::skipTo(std::int64_t pts) {
    if (!begun_) begin();
    const std::int64_t goal = originPts_ + std::clamp(pts, -kFarthestTime, kFarthestTime);
    if (hasCurrent_) goTo(goal);
    if (hasCurrent_ && currentPts_ >= toPts_) {
        pastEnd_ = true;
        hasCurrent_ = false;
    }
}

// Decodes up to the first frame of that time or later, in or behind the part; far ones are sought.
void VideoReader::Impl::goTo(std::int64_t goal) {
    const auto far = static_cast<std::int64_t>(kFarSeconds / av_q2d(stream_->time_base));
    if (hasFixedTimes_ && goal - currentPts_ > far && seek(goal)) {
        // Where times were missing they are not the same after a seek: then all is read.
        bool before = false;
        while ((hasCurrent_ = decode(*current_)) && aheadPts_ < goal)
            before = true;
        currentPts_ = aheadPts_;
        if (hasCurrent_ && aheadPts_ == goal) return;
        if (!hasCurrent_ && before && counts.repairedTimes == 0) return; // the video ends earlier
        hasCurrent_ = seekToStart() && decode(*current_);
        currentPts_ = aheadPts_;
    }
    while (hasCurrent_ && currentPts_ < goal) {
        hasCurrent_ = decode(*current_);
        currentPts_ = aheadPts_;
    }
}

// Reads on without decoding, up to the pictures of a time; false at the end.
bool VideoReader::Impl::pass(std::int64_t until) {
    if (!begun_) begin();
    if (ended_) return false;
    bool more = !pastEnd_;
    while (more) {
        av_packet_unref(packet_.get());
        more = readPacket();
        if (!more) break;
        if (packet_->stream_index != stream_->index) {
            keepOther();
            continue;
        }
        const std::int64_t time = packet_->dts != AV_NOPTS_VALUE ? packet_->dts : packet_->pts;
        if (!isNear(time)) continue;
        if (time >= toPts_) {
            pastEnd_ = true;
            more = false;
        } else if (time - originPts_ > until) {
            return true;
        }
    }
    ended_ = true;
    drainOthers();
    others->end();
    return false;
}

// Nominal time a frame stays, in the stream's unit; 0 = not known.
std::int64_t VideoReader::Impl::frameDuration() const {
    const Fraction& rate = facts.averageRate.isKnown() ? facts.averageRate : facts.nominalRate;
    if (!rate.isKnown()) return 0;
    const std::int64_t duration =
        av_rescale_q(1, AVRational{rate.denominator, rate.numerator}, stream_->time_base);
    return std::clamp<std::int64_t>(duration, 0, kFarthestTime);
}

bool VideoReader::Impl::read(VideoFrame& frame) {
    if (!begun_) {
        begin();
    } else if (kind_ == Kind::Device && !ended_ &&
               !hasCurrent_) { // its next picture is waited for only now
        hasCurrent_ = decode(*current_) && aheadPts_ < toPts_;
        currentPts_ = aheadPts_;
    }
    if (!hasCurrent_) {
        if (!ended_) {
            ended_ = true;
            if (!hasLast_ && counts.corrupt > 0 && !pastEnd_) {
                fail(ErrorCode::BadFormat, subject,
                     "holds " + facts.codec + " video of which not one frame can be decoded");
            }
            drainOthers();
            others->end();
        }
        return false;
    }
    std::int64_t duration = isNear(durationOf(*current_)) ? durationOf(*current_) : 0;
    bool hasNext = false;
    if (kind_ != Kind::Device) {
        hasNext = decode(*ahead_);
        if (hasNext) {
            duration = aheadPts_ - currentPts_;
        } else if (duration <= 0) {
            duration = frameDuration();
        }
        if (hasNext && aheadPts_ >= toPts_) {
            pastEnd_ = true;
            hasNext = false;
        }
    }
    releaseIfShared(frame.picture);
    resized = resized || cv::Size(current_->width, current_->height) !=
                             cv::Size(stream_->codecpar->width, stream_->codecpar->height);
    pictures_->make(*current_, frame.picture);
    frame.pts = currentPts_ - originPts_;
    frame.duration = duration;
    ++counts.frames;
    av_frame_unref(current_.get());
    hasCurrent_ = hasNext;
    std::swap(current_, ahead_);
    currentPts_ = aheadPts_;
    return true;
}

VideoReader::VideoReader(const fs::path& path, const VideoReaderOptions& options)
    : impl_(std::make_unique<Impl>(path, options)) {}
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
    impl_->skipTo(pts);
}

bool VideoReader::pass(std::int64_t until) {
    return impl_->pass(until);
}

Notes VideoReader::notes() const {
    const Impl& impl = *impl_;
    Notes notes;
    const auto note = [&](const std::string& text) { notes.push_back(impl.subject + ": " + text); };
    if (impl.counts.truncated) {
        note(impl.fileEnd > 0 ? "is cut off: it ends after " + numberText(impl.lastEnd, 4) +
                                    " s of " + numberText(impl.fileEnd, 4) + " s"
                              : "is cut off: it ends after " + numberText(impl.lastEnd, 4) + " s");
    }
    if (impl.counts.corrupt > 0) {
        note(std::to_string(impl.counts.corrupt) + (impl.counts.corrupt == 1
                                                        ? " damaged frame was left out"
                                                        : " damaged frames were left out"));
    }
    if (impl.counts.repairedTimes > 0) {
        note("the times of " + std::to_string(impl.counts.repairedTimes) +
             " frames were missing or ran backwards and were replaced");
    }
    if (impl.beginsAgain) {
        note("times begin again in it, as where files were put together; sound is out of step from "
             "there on (ffmpeg -f concat puts files together properly)");
    }
    if (impl.interlaced) note("holds interlaced pictures, which are used as they are");
    if (impl.resized) note("changes the size of its pictures; all are brought to the first one's");
    const int transfer = impl.facts.colour.transfer;
    if (transfer == AVCOL_TRC_SMPTE2084 || transfer == AVCOL_TRC_ARIB_STD_B67) {
        note("is HDR video, which is not tone-mapped");
    }
    return notes;
}

std::shared_ptr<OtherStreams> VideoReader::otherStreams() const {
    return impl_->others;
}

} // namespace altiro3D
