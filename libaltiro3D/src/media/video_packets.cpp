#include "media/video_packets.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <chrono>
#include <set>
#include <thread>

namespace altiro3D {

namespace {

constexpr double kMissingSeconds = 0.5; // a file that ends this much too early is cut off
constexpr double kInterleavedSeconds = 10;

} // namespace

VideoPackets::VideoPackets(VideoInput& input, const VideoReaderOptions& options,
                           VideoReadCounts& counts)
    : subject_(input.subject), kind_(input.kind), hasFixedTimes_(input.hasFixedTimes()),
      stream_(input.stream), startPts_(input.startPts), fileEnd_(input.end), counts_(counts),
      times_(*input.format) {
    otherIndex_ = describeOthers(input, options, *others_);
    format_ = std::move(input.format);
}

bool VideoPackets::read() {
    if (ahead_.empty()) {
        Read next;
        if (!fetch(next)) return false;
        ahead_.push_back(std::move(next));
        if (ahead_.front().packet->stream_index == stream_->index) trustAtJoint();
    }
    packet_ = std::move(ahead_.front().packet);
    ahead_.pop_front();
    return true;
}

// A container counts the packets of each piece anew, and marks the last picture before a joint as
// damaged, although it is whole; or the one before, where pictures are divided anew.
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
    const int result = av_read_frame(format_.get(), &packet);
    if (result == AVERROR(EAGAIN)) { // a device without a picture yet
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return true;
    }
    if (result < 0) {
        drained_ = true;
        noteEnd(result);
        return false;
    }
    const AVStream& stream = *format_->streams[packet.stream_index];
    const std::int64_t shown = packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts;
    if (shown != AV_NOPTS_VALUE) {
        const double end = (static_cast<double>(shown) +
                            static_cast<double>(std::max<std::int64_t>(packet.duration, 0))) *
                               av_q2d(stream.time_base) -
                           static_cast<double>(startPts_) * av_q2d(stream_->time_base);
        lastEnd_ = std::max(lastEnd_, end);
    }
    read.begins = times_.join(packet);
    return true;
}

// Decides, after the last packet, whether the file is complete or cut off.
void VideoPackets::noteEnd(int result) {
    if (kind_ == VideoInput::Kind::Device) {
        if (result != AVERROR_EOF) {
            throw Error(ErrorCode::ReadFailed, subject_, "cannot be read: " + ffmpegText(result));
        }
        return;
    }
    if (format_->pb != nullptr && format_->pb->error < 0 && format_->pb->error != AVERROR_EOF &&
        format_->pb->error != AVERROR_INVALIDDATA) {
        throw Error(ErrorCode::ReadFailed, subject_,
                    "cannot be read any further: " + ffmpegText(format_->pb->error));
    }
    counts_.truncated =
        result != AVERROR_EOF || (fileEnd_ > 0 && lastEnd_ < fileEnd_ - kMissingSeconds);
}

std::optional<std::string> VideoPackets::truncation() const {
    if (!counts_.truncated) return std::nullopt;
    const std::string text = "is cut off: it ends after " + numberText(lastEnd_, 4) + " s";
    return fileEnd_ > 0 ? text + " of " + numberText(fileEnd_, 4) + " s" : text;
}

void VideoPackets::keep() {
    const auto index = static_cast<std::size_t>(packet_->stream_index);
    if (!wanted_ || index >= otherIndex_.size()) return; // a stream that appeared later
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
        const AVRational unit = format_->streams[index]->time_base;
        if (isOfPictures()) {
            const double past = static_cast<double>(time() - until) * av_q2d(unit);
            if (past > kInterleavedSeconds) break;
            continue;
        }
        if (av_compare_ts(time(), unit, until, stream_->time_base) >= 0) {
            behind.erase(static_cast<int>(index));
            continue;
        }
        keep();
    }
}

bool VideoPackets::seek(std::int64_t target) {
    if (av_seek_frame(format_.get(), stream_->index, target, AVSEEK_FLAG_BACKWARD) < 0) {
        return false;
    }
    restart();
    return true;
}

bool VideoPackets::seekToStart() {
    if (avformat_seek_file(format_.get(), -1, INT64_MIN, INT64_MIN, INT64_MAX, 0) < 0) {
        return seek(startPts_);
    }
    restart();
    return true;
}

// Resets the state after a seek.
void VideoPackets::restart() {
    others_->clear();
    ahead_.clear();
    times_.restart();
    drained_ = false;
    lastEnd_ = 0;
}

} // namespace altiro3D
