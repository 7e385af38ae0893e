#include "media/frame_times.hpp"

#include <algorithm>
#include <optional>

namespace altiro3D {

namespace {

constexpr int kMaxInDisorder = 16; // frames; beyond this the times have jumped
constexpr double kFarBackSeconds = 1;

std::int64_t nominalDuration(const VideoFacts& facts, AVRational unit) {
    const Fraction& rate = facts.averageRate.isKnown() ? facts.averageRate : facts.nominalRate;
    if (!rate.isKnown()) return 0;
    const std::int64_t duration =
        av_rescale_q(1, AVRational{rate.denominator, rate.numerator}, unit);
    return std::clamp<std::int64_t>(duration, 0, kFarthestTime);
}

} // namespace

FrameTimes::FrameTimes(const VideoFacts& facts, AVRational unit, std::int64_t start,
                       VideoReadCounts& counts)
    : unit_(unit), start_(start), frameDuration_(nominalDuration(facts, unit)),
      countsFirst_(!facts.averageRate.isKnown() || facts.frameCount.value_or(0) > 1),
      counts_(counts) {}

void FrameTimes::restart() {
    hasLast_ = false;
    shift_ = 0;
    inDisorder_ = 0;
    beginsAgain_ = false;
}

std::int64_t FrameTimes::next(const AVFrame& frame) {
    last_ = risingTime(frame);
    hasLast_ = true;
    return last_;
}

std::int64_t FrameTimes::risingTime(const AVFrame& frame) {
    std::optional<std::int64_t> stated; // AV_NOPTS_VALUE is far outside
    if (isNear(frame.best_effort_timestamp)) stated = frame.best_effort_timestamp;
    if (stated && (!hasLast_ || *stated > last_)) shift_ = 0;
    const std::int64_t latest = kFarthestTime;
    if (stated && (!hasLast_ || *stated + shift_ > last_)) {
        inDisorder_ = 0;
        return std::min(*stated + shift_, latest);
    }
    if (hasLast_ || countsFirst_) ++counts_.repairedTimes;
    if (!hasLast_) return start_;
    const std::int64_t step = std::max<std::int64_t>(frameDuration_, 1);
    const std::int64_t next = std::min(last_ + step, latest);
    if (!stated) return next;
    // A piece begins with a key frame.
    const std::int64_t back = last_ - *stated - shift_;
    const bool isPiece = frame.pict_type == AV_PICTURE_TYPE_I && back >= 2 * step;
    const double seconds = static_cast<double>(back) * av_q2d(unit_);
    const bool isFar = seconds >= kFarBackSeconds && back >= kMaxInDisorder * step;
    if (++inDisorder_ <= kMaxInDisorder && !isPiece && !isFar) return std::min(last_ + 1, latest);
    beginsAgain_ = beginsAgain_ || isPiece || isFar;
    shift_ = next - *stated;
    return next;
}

} // namespace altiro3D
