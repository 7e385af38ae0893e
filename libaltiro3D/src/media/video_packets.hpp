#pragma once

#include "altiro3D/video_io.hpp"
#include "media/ffmpeg.hpp"
#include "media/other_streams.hpp"
#include "media/packet_times.hpp"
#include "media/video_input.hpp"

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// The packets of an open video: those of the pictures, and the others for a writer.
class VideoPackets {
  public:
    /// @param input its container is moved here; the decoder stays
    /// @param options the part that is read
    /// @param counts receives at the end whether the file is cut off; must outlive this
    VideoPackets(VideoInput& input, const VideoReaderOptions& options, VideoReadCounts& counts);

    /// The stream of the pictures.
    const AVStream& stream() const { return *stream_; }
    /// Whether the file states its start time; a bare stream does not.
    bool hasStart() const { return format_->start_time != AV_NOPTS_VALUE; }
    /// See VideoInput::hasFixedTimes().
    bool hasFixedTimes() const { return hasFixedTimes_; }
    /// The other streams, for a writer.
    const std::shared_ptr<OtherStreams>& others() const { return others_; }

    /// Call it before the first packet is read. Other streams are kept if a writer requested them.
    void begin() { wanted_ = others_->begin(); }
    /// Reads a packet; it is empty if a device has none yet.
    /// @return false at the end
    /// @throws Error ReadFailed
    bool read();
    /// The packet that was read.
    const AVPacket& packet() const { return *packet_; }
    bool isOfPictures() const { return packet_->stream_index == stream_->index; }
    /// Its decoding time, else its display time, in its stream's unit; may be any number.
    std::int64_t time() const {
        return packet_->dts != AV_NOPTS_VALUE ? packet_->dts : packet_->pts;
    }
    /// Passes a packet of another stream to the writer.
    void keep();
    /// Reads until the sound reaches a time of the pictures.
    void drainOthers(std::int64_t until);

    /// Seeks to the last key frame before a time. @return false if that is not possible
    bool seek(std::int64_t target);
    /// Seeks to the beginning. @return false if that is not possible
    bool seekToStart();

    /// A remark that the file is cut off; nothing if it is not.
    std::optional<std::string> truncation() const;

  private:
    struct Read {
        PacketPtr packet;
        bool begins = false; // the first one of its stream after a joint
    };

    bool fetch(Read& read);
    void trustAtJoint();
    void restart();
    void noteEnd(int result);

    std::string subject_;
    VideoInput::Kind kind_;
    bool hasFixedTimes_;
    InputPtr format_;
    AVStream* stream_;      // `format_` owns it
    std::int64_t startPts_; // of the file
    double fileEnd_;        // s: stated end of the file; 0 = not stated
    double lastEnd_ = 0;    // s: end of the last packet of any stream, from the start of the file
    VideoReadCounts& counts_;
    PacketPtr packet_ = newPacket();
    PacketTimes times_;
    std::deque<Read> ahead_; // read, but not delivered
    bool drained_ = false;
    std::shared_ptr<OtherStreams> others_ = std::make_shared<OtherStreams>();
    std::vector<std::int64_t> otherIndex_; // by stream of the file, -1 = the pictures
    bool wanted_ = false;                  // a writer has requested other streams
};

} // namespace altiro3D
