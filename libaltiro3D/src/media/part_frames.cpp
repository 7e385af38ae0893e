#include "media/part_frames.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace altiro3D {

namespace {

using Kind = VideoInput::Kind;

constexpr double kStepsBackSeconds[] = {0, 2, 10};
constexpr double kFarSeconds = 2; // nearer frames are decoded, further ones sought
constexpr std::int64_t kToTheEnd = std::numeric_limits<std::int64_t>::max();

std::int64_t durationOf(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(57, 30, 100)
    return frame.duration;
#else
    return frame.pkt_duration;
#endif
}

} // namespace

PartFrames::PartFrames(const VideoInput& input, const VideoReaderOptions& options,
                       VideoPackets& packets, FrameDecoder& decoder, VideoReadCounts& counts)
    : subject_(input.subject), codec_(input.facts.codec), kind_(input.kind),
      isLive_(input.facts.isLive), unit_(av_q2d(input.stream->time_base)), packets_(packets),
      decoder_(decoder), counts_(counts), startPts_(input.startPts),
      fromPts_(startPts_ + std::llround(options.from / unit_)),
      toPts_(options.to < 1e9 ? startPts_ + std::llround(options.to / unit_) : kToTheEnd),
      originPts_(options.from > 0 ? fromPts_ : startPts_), from_(options.from) {}

// Resets the state after a seek.
void PartFrames::restart() {
    decoder_.restart();
    counts_ = {};
}

bool PartFrames::seek(std::int64_t target) {
    if (!packets_.seek(target)) return false;
    restart();
    return true;
}

bool PartFrames::seekToStart() {
    if (!packets_.seekToStart()) return false;
    restart();
    return true;
}

void PartFrames::begin(bool maySeek) {
    begun_ = true;
    packets_.begin();
    // A bare stream has no times, so seeking in it is not possible.
    const bool seeks = maySeek && kind_ == Kind::File && packets_.hasStart();
    bool found = fromPts_ > startPts_ && seeks && seekToPart();
    while (found && ahead_.pts < fromPts_)
        found = decoder_.decode(ahead_);
    if (!found) found = decodeUpToPart();
    if (found && ahead_.pts >= toPts_) {
        pastEnd_ = true;
        found = false;
    }
    if (found) originPts_ = std::min(originPts_, ahead_.pts);
    packets_.others()->setRange(
        originPts_, toPts_ == kToTheEnd ? std::nullopt : std::optional<std::int64_t>(toPts_),
        packets_.stream().time_base, from_ > 0);
    hasCurrent_ = found;
    if (found) std::swap(current_, ahead_);
}

// Decodes a frame (ahead_) at the beginning of the part or before it. False: decode everything from
// the current position.
bool PartFrames::seekToPart() {
    bool found = false;
    // A container may seek past the requested frame; then the search starts further back.
    for (const double back : kStepsBackSeconds) {
        const auto ticks = static_cast<std::int64_t>(std::ceil(back / unit_));
        if (!seek(std::max(startPts_, fromPts_ - ticks))) break;
        found = decoder_.decode(ahead_);
        if (found && ahead_.pts <= fromPts_) return true;
        if (seconds(fromPts_ - startPts_) <= back) break; // from the start
    }
    // The last resort: decode everything from the start.
    if (seekToStart()) return false;
    if (found) {
        throw Error(ErrorCode::ReadFailed, subject_,
                    "cannot seek to " + numberText(from_) + " s, expected a file with an index");
    }
    return false;
}

// Decodes from the current position up to the first frame of the part (ahead_).
bool PartFrames::decodeUpToPart() {
    for (;; ++passedFrames_) {
        if (!decoder_.decode(ahead_)) return false;
        if (from_ <= 0 || ahead_.pts >= fromPts_) return true;
    }
}

std::int64_t PartFrames::countBefore() {
    begin(false);
    return passedFrames_;
}

bool PartFrames::next(Frame& frame) {
    if (!begun_) {
        begin(true);
    } else if (isLive_ && !ended_ && !hasCurrent_) { // waits for the next picture only now
        hasCurrent_ = decoder_.decode(current_) && current_.pts < toPts_;
    }
    if (!hasCurrent_) {
        if (ended_) return false;
        if (!decoder_.times().hasBegun() && counts_.corrupt > 0 && !pastEnd_) {
            ended_ = true;
            throw Error(ErrorCode::BadFormat, subject_,
                        "holds " + codec_ + " video of which not one frame can be decoded");
        }
        end();
        return false;
    }
    frame.pts = current_.pts - originPts_;
    const std::int64_t stated = durationOf(*current_.frame);
    frame.duration = isNear(stated) ? stated : 0;
    bool hasNext = false;
    if (!isLive_) { // the time of the next frame is the end of this one
        hasNext = decoder_.decode(ahead_);
        if (hasNext) {
            frame.duration = ahead_.pts - current_.pts;
        } else if (frame.duration <= 0) {
            frame.duration = decoder_.times().frameDuration();
        }
        if (hasNext && ahead_.pts >= toPts_) {
            pastEnd_ = true;
            hasNext = false;
        }
    }
    std::swap(current_, ahead_);
    hasCurrent_ = hasNext;
    frame.picture = ahead_.frame.get();
    return true;
}

void PartFrames::end() {
    ended_ = true;
    if (pastEnd_) packets_.drainOthers(toPts_);
    packets_.others()->end();
}

void PartFrames::skipTo(std::int64_t pts) {
    if (!begun_) begin(true);
    const std::int64_t goal = originPts_ + std::clamp(pts, -kFarthestTime, kFarthestTime);
    if (hasCurrent_) goTo(goal);
    if (hasCurrent_ && current_.pts >= toPts_) {
        pastEnd_ = true;
        hasCurrent_ = false;
    }
}

// Decodes up to the first frame at or after that time, in the part or after it. Distant frames are
// reached by seeking.
void PartFrames::goTo(std::int64_t goal) {
    const auto far = static_cast<std::int64_t>(kFarSeconds / unit_);
    const bool needsBefore = decoder_.deinterlaces(); // the frame depends on the one before
    if (packets_.hasFixedTimes() && goal - current_.pts > far &&
        seek(needsBefore ? goal - far : goal)) {
        // Repaired times are not the same after a seek, so everything is read.
        bool before = false;
        while ((hasCurrent_ = decoder_.decode(current_)) && current_.pts < goal)
            before = true;
        if (hasCurrent_ && current_.pts == goal && (before || !needsBefore)) return;
        if (!hasCurrent_ && before && counts_.repairedTimes == 0) return; // the video ends earlier
        hasCurrent_ = seekToStart() && decoder_.decode(current_);
    }
    while (hasCurrent_ && current_.pts < goal)
        hasCurrent_ = decoder_.decode(current_);
}

bool PartFrames::pass(std::int64_t until) {
    if (!begun_) begin(true);
    if (ended_) return false;
    bool more = !pastEnd_;
    while (more && packets_.read()) {
        if (!packets_.isOfPictures()) {
            packets_.keep();
            continue;
        }
        const std::int64_t time = packets_.time();
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

} // namespace altiro3D
