#include "media/other_streams.hpp"

#include <algorithm>

namespace altiro3D {

bool OtherStreams::want() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (begun_) return false;
    wanted_ = true;
    return true;
}

bool OtherStreams::begin() {
    const std::lock_guard<std::mutex> lock(mutex_);
    begun_ = true;
    packets_.resize(streams.size());
    return wanted_;
}

void OtherStreams::take(std::size_t index) {
    const std::lock_guard<std::mutex> lock(mutex_);
    taken_.insert(index);
}

bool OtherStreams::isTaken(std::size_t index) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return taken_.count(index) != 0;
}

void OtherStreams::push(std::size_t index, PacketPtr packet) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (taken_.count(index) != 0) packets_[index].push_back(std::move(packet));
}

void OtherStreams::clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (auto& queue : packets_)
        queue.clear();
}

void OtherStreams::setRange(std::int64_t origin, std::optional<std::int64_t> end, AVRational unit,
                            bool clip) {
    const std::lock_guard<std::mutex> lock(mutex_);
    origin_ = origin;
    end_ = end;
    unit_ = unit;
    clip_ = clip;
}

void OtherStreams::end() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
}

bool OtherStreams::hasEnded() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return ended_;
}

PacketPtr OtherStreams::pop(std::size_t index, std::optional<std::int64_t> before,
                            AVRational unit) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (index >= packets_.size()) return nullptr;
    std::deque<PacketPtr>& queue = packets_[index];
    const AVRational timeBase = streams[index].timeBase;
    const bool isSubtitle = streams[index].parameters->codec_type == AVMEDIA_TYPE_SUBTITLE;
    const std::int64_t shift = av_rescale_q(origin_, unit_, timeBase);
    while (!queue.empty()) {
        AVPacket& packet = *queue.front();
        const auto isTime = [](std::int64_t one) { return one == AV_NOPTS_VALUE || isNear(one); };
        if (!isNear(shift) || !isTime(packet.pts) || !isTime(packet.dts)) { // without a usable time
            queue.pop_front();
            continue;
        }
        const std::int64_t time = packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts;
        if (time != AV_NOPTS_VALUE) {
            const std::int64_t begin = time - shift;
            if (before && av_compare_ts(begin, timeBase, *before, unit) >= 0) return nullptr;
            const std::int64_t after =
                begin + std::clamp<std::int64_t>(packet.duration, 0, kFarthestTime);
            const bool early = clip_ && begin < 0 && (!isSubtitle || after <= 0);
            if (early || (end_ && av_compare_ts(begin, timeBase, *end_ - origin_, unit_) >= 0)) {
                queue.pop_front();
                continue;
            }
            if (clip_ && begin < 0) { // a subtitle visible at the start of the part
                packet.duration = after;
                packet.pts = shift;
                packet.dts = shift;
            }
        }
        PacketPtr taken = std::move(queue.front());
        queue.pop_front();
        if (taken->pts != AV_NOPTS_VALUE) taken->pts -= shift;
        if (taken->dts != AV_NOPTS_VALUE) taken->dts -= shift;
        return taken;
    }
    return nullptr;
}

} // namespace altiro3D
