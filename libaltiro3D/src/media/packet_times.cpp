#include "media/packet_times.hpp"

#include <algorithm>
#include <cstdlib>

namespace altiro3D {

namespace {

constexpr AVRational kMicroseconds{1, AV_TIME_BASE};
constexpr std::int64_t kFarBack = AV_TIME_BASE / 10;
constexpr std::int64_t kFarAhead = 10 * std::int64_t{AV_TIME_BASE};
constexpr std::int64_t kLatest = kFarthestTime / 1000000; // no sum or difference overflows

} // namespace

PacketTimes::PacketTimes(const AVFormatContext& format)
    : mayJump_((format.iformat->flags & AVFMT_TS_DISCONT) != 0), pieces_(1) {
    for (unsigned i = 0; mayJump_ && i < format.nb_streams; ++i) {
        const AVStream& stream = *format.streams[i];
        const AVMediaType type = stream.codecpar->codec_type;
        Stream& known = streams_.emplace_back();
        known.unit = stream.time_base;
        known.lasts = (type == AVMEDIA_TYPE_VIDEO || type == AVMEDIA_TYPE_AUDIO) &&
                      (stream.disposition & AV_DISPOSITION_ATTACHED_PIC) == 0;
    }
}

void PacketTimes::restart() {
    for (Stream& stream : streams_) {
        stream.begun = false;
        stream.piece = 0;
    }
    pieces_.assign(1, {});
}

// Whether the time of a key frame, or of sound, is neither the next one of its stream nor near
// those of the others.
bool PacketTimes::beginsPiece(const Stream& stream, std::int64_t time) const {
    if (time <= stream.last && time + kFarBack < stream.end) return true;
    if (time - stream.end <= kFarAhead) return false;
    return std::none_of(streams_.begin(), streams_.end(), [&](const Stream& other) {
        return other.begun && other.lasts && other.piece == stream.piece &&
               std::abs(time - other.last) <= kFarAhead;
    });
}

bool PacketTimes::join(AVPacket& packet) {
    const auto index = static_cast<std::size_t>(packet.stream_index);
    if (index >= streams_.size()) return false;
    Stream& stream = streams_[index];
    const std::size_t newest = pieces_.size() - 1;
    const std::size_t before = stream.piece;
    const bool wasBegun = stream.begun;
    std::int64_t time = AV_NOPTS_VALUE;
    if (isNear(packet.dts)) time = av_rescale_q(packet.dts, stream.unit, kMicroseconds);
    const bool isKnown = time >= -kLatest && time <= kLatest;
    if (!stream.lasts || !stream.begun) {
        stream.piece = newest;
    } else if (isKnown && stream.piece < newest) { // it follows the stream that passed the joint
        if (std::abs(time - pieces_[newest].last) < std::abs(time - stream.end))
            stream.piece = newest;
    } else if (isKnown && (packet.flags & AV_PKT_FLAG_KEY) != 0 && beginsPiece(stream, time)) {
        std::int64_t end = stream.end;
        for (const Stream& other : streams_) {
            if (other.begun && other.lasts && other.piece == stream.piece)
                end = std::max(end, other.end);
        }
        const std::int64_t shift = pieces_[newest].shift + end - time;
        if (std::abs(shift) <= kLatest) {
            pieces_.push_back({shift, time});
            stream.piece = pieces_.size() - 1;
        }
    }
    if (stream.lasts && isKnown) {
        stream.begun = true;
        stream.last = time;
        stream.end = time;
        if (packet.duration > 0 && isNear(packet.duration))
            stream.end += std::clamp<std::int64_t>(
                av_rescale_q(packet.duration, stream.unit, kMicroseconds), 0, kFarAhead);
        pieces_[stream.piece].last = time;
    }
    const std::int64_t shift =
        av_rescale_q(pieces_[stream.piece].shift, kMicroseconds, stream.unit);
    for (std::int64_t* const one : {&packet.pts, &packet.dts}) {
        if (isNear(*one) && isNear(*one + shift)) *one += shift;
    }
    return wasBegun && stream.piece != before;
}

} // namespace altiro3D
