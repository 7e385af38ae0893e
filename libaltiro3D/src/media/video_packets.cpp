#include "media/video_packets.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"
#include "media/video_picture.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <set>
#include <thread>

namespace altiro3D {

namespace {

constexpr AVRational kMicroseconds{1, AV_TIME_BASE};
constexpr std::int64_t kFarBack = AV_TIME_BASE / 10;
constexpr std::int64_t kFarAhead = 10 * std::int64_t{AV_TIME_BASE};
constexpr std::int64_t kLatest = kFarthestTime / 1000000; // no sum or difference overflows

constexpr double kMissingSeconds = 0.5; // a file that ends this much too early is cut off
constexpr double kInterleavedSeconds = 10;
constexpr double kLatestSeconds = 1e9; // later contents of a file are ignored

} // namespace

std::vector<std::int64_t> describeOthers(const VideoInput& input, const VideoReaderOptions& options,
                                         OtherStreams& others) {
    std::vector<std::int64_t> indices;
    others.subject = input.subject;
    others.tags = input.facts.tags;
    others.colour = shownColour(input.facts.colour);
    for (const VideoChapter& chapter : input.facts.chapters) {
        const double start = std::max(chapter.start, options.from) - options.from;
        const double end = std::min({chapter.end, options.to, kLatestSeconds}) - options.from;
        if (end > start) others.chapters.push_back({start, end, chapter.title});
    }
    for (unsigned i = 0; i < input.format->nb_streams; ++i) {
        const AVStream& stream = *input.format->streams[i];
        if (&stream == input.stream || &stream == input.twin) {
            indices.push_back(-1);
            continue;
        }
        indices.push_back(static_cast<std::int64_t>(others.streams.size()));
        OtherStream& other = others.streams.emplace_back();
        other.index = static_cast<int>(i);
        other.parameters = copyOf(*stream.codecpar);
        other.timeBase = stream.time_base;
        other.tags = tagsOf(stream.metadata);
        other.disposition = stream.disposition;
        other.isCover = isCover(stream);
        other.isEncrypted = input.encrypted.count(other.index) > 0;
    }
    return indices;
}

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

// Whether a key frame's or sound's time is neither next in its stream nor near the others.
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

VideoPackets::VideoPackets(VideoInput& input, const VideoReaderOptions& options,
                           VideoReadCounts& counts)
    : input_(input), counts_(counts), times_(*input.format),
      otherIndex_(describeOthers(input, options, *others_)) {}

bool VideoPackets::read() {
    if (ahead_.empty()) {
        Read next;
        if (!fetch(next)) return false;
        ahead_.push_back(std::move(next));
        if (ahead_.front().packet->stream_index == input_.stream->index) trustAtJoint();
    }
    packet_ = std::move(ahead_.front().packet);
    ahead_.pop_front();
    return true;
}

// A container counts the packets of each piece anew, and so marks the last picture before a joint
// as damaged, although it is whole; or the picture before that, if a parser divides the pictures.
void VideoPackets::trustAtJoint() {
    constexpr std::size_t kMost = 1000; // packets of other streams between pictures
    AVPacket& first = *ahead_.front().packet;
    if ((first.flags & AV_PKT_FLAG_CORRUPT) == 0) return;
    for (int pictures = 0; pictures < 2 && ahead_.size() < kMost;) {
        Read next;
        if (!fetch(next)) return;
        const bool isOfPictures = next.packet->stream_index == first.stream_index;
        if (isOfPictures && next.begins) first.flags &= ~AV_PKT_FLAG_CORRUPT;
        if (isOfPictures) ++pictures;
        ahead_.push_back(std::move(next));
    }
}

// Reads a packet from the file; it is empty if a device has none yet.
bool VideoPackets::fetch(Read& read) {
    if (drained_) return false;
    read.packet = newPacket();
    AVPacket& packet = *read.packet;
    const int result = input_.readPacket(packet);
    if (result == AVERROR(EAGAIN)) { // a device without a picture yet
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return true;
    }
    if (result < 0) {
        drained_ = true;
        noteEnd(result);
        return false;
    }
    const AVStream& stream = *input_.format->streams[packet.stream_index];
    const std::int64_t shown = packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts;
    if (shown != AV_NOPTS_VALUE) {
        const double end = (static_cast<double>(shown) +
                            static_cast<double>(std::max<std::int64_t>(packet.duration, 0))) *
                               av_q2d(stream.time_base) -
                           static_cast<double>(input_.startPts) * av_q2d(input_.stream->time_base);
        lastEnd_ = std::max(lastEnd_, end);
    }
    read.begins = times_.join(packet);
    return true;
}

// Decides, after the last packet, whether the file is complete or cut off.
void VideoPackets::noteEnd(int result) {
    if (input_.kind == VideoInput::Kind::Device) {
        if (result == AVERROR_EOF) return;
        throw Error(ErrorCode::ReadFailed, input_.subject, "cannot be read: " + ffmpegText(result));
    }
    if (input_.format->pb != nullptr && input_.format->pb->error < 0 &&
        input_.format->pb->error != AVERROR_EOF &&
        input_.format->pb->error != AVERROR_INVALIDDATA) {
        throw Error(ErrorCode::ReadFailed, input_.subject,
                    "cannot be read any further: " + ffmpegText(input_.format->pb->error));
    }
    counts_.truncated =
        result != AVERROR_EOF || (input_.end > 0 && lastEnd_ < input_.end - kMissingSeconds);
}

std::optional<std::string> VideoPackets::truncation() const {
    if (!counts_.truncated) return std::nullopt;
    const std::string text = "is cut off: it ends after " + numberText(lastEnd_, 4) + " s";
    return input_.end > 0 ? text + " of " + numberText(input_.end, 4) + " s" : text;
}

void VideoPackets::keep() {
    const auto index = static_cast<std::size_t>(packet_->stream_index);
    // a stream that appeared later, or the other eye's
    if (!wanted_ || index >= otherIndex_.size() || otherIndex_[index] < 0) return;
    PacketPtr kept = newPacket();
    av_packet_move_ref(kept.get(), packet_.get());
    others_->push(static_cast<std::size_t>(otherIndex_[index]), std::move(kept));
}

void VideoPackets::drainOthers(std::int64_t until) {
    if (!wanted_) return;
    std::set<int> behind;
    for (std::size_t i = 0; i < others_->streams.size(); ++i) {
        const OtherStream& other = others_->streams[i];
        if (other.parameters->codec_type == AVMEDIA_TYPE_AUDIO && others_->isTaken(i))
            behind.insert(other.index);
    }
    while (!behind.empty() && read()) {
        const auto index = static_cast<std::size_t>(packet_->stream_index);
        if (index >= otherIndex_.size() || !isNear(time())) continue;
        const AVRational unit = input_.format->streams[index]->time_base;
        if (isOfPictures()) {
            const double past = static_cast<double>(time() - until) * av_q2d(unit);
            if (past > kInterleavedSeconds) break;
            continue;
        }
        if (av_compare_ts(time(), unit, until, input_.stream->time_base) >= 0) {
            behind.erase(static_cast<int>(index));
            continue;
        }
        keep();
    }
}

bool VideoPackets::seek(std::int64_t target) {
    if (av_seek_frame(input_.format.get(), input_.stream->index, target, AVSEEK_FLAG_BACKWARD) < 0)
        return false;
    restart();
    return true;
}

bool VideoPackets::seekToStart() {
    if (avformat_seek_file(input_.format.get(), -1, INT64_MIN, INT64_MIN, INT64_MAX, 0) < 0)
        return seek(input_.startPts);
    restart();
    return true;
}

// Resets the state after a seek.
void VideoPackets::restart() {
    others_->clear();
    input_.ahead.clear();
    ahead_.clear();
    times_.restart();
    drained_ = false;
    lastEnd_ = 0;
}

} // namespace altiro3D
