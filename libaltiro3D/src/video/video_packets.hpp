#pragma once

#include "altiro3D/video_io.hpp"
#include "video/ffmpeg.hpp"
#include "video/other_streams.hpp"
#include "video/video_input.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// The packets of an open video: those of the pictures, and the others, which a writer may want.
class VideoPackets {
  public:
    /// @param input its container is taken; the decoder stays
    /// @param options the part that is read
    /// @param counts says in the end whether the file is cut off; must outlive this
    VideoPackets(VideoInput& input, const VideoReaderOptions& options, VideoReadCounts& counts);

    /// The stream of the pictures.
    const AVStream& stream() const { return *stream_; }
    /// The file says when it begins: a bare stream does not.
    bool hasStart() const { return format_->start_time != AV_NOPTS_VALUE; }
    /// See VideoInput::hasFixedTimes().
    bool hasFixedTimes() const { return hasFixedTimes_; }
    /// What a writer takes.
    const std::shared_ptr<OtherStreams>& others() const { return others_; }

    /// To be called before the first packet is read: other streams are kept if a writer wants them.
    void begin() { wanted_ = others_->begin(); }
    /// Reads a packet, which may be empty where a device has none yet.
    /// @return false at the end
    /// @throws Error ReadFailed
    bool read();
    /// The packet that was read.
    const AVPacket& packet() const { return *packet_; }
    bool isOfPictures() const { return packet_->stream_index == stream_->index; }
    /// When it is decoded, or else shown, in its stream's unit; may be any number.
    std::int64_t time() const {
        return packet_->dts != AV_NOPTS_VALUE ? packet_->dts : packet_->pts;
    }
    /// Hands a packet that is not of the pictures over to the writer.
    void keep();
    /// Reads on until the sound has come to a time of the pictures.
    void drainOthers(std::int64_t until);

    /// Goes to the last key frame before a time. @return false if the file cannot
    bool seek(std::int64_t target);
    /// Goes to the very beginning. @return false if the file cannot
    bool seekToStart();

    /// That the file is cut off, for people; nothing if it is not.
    std::optional<std::string> truncation() const;

  private:
    void restart();
    void noteEnd(int result);

    std::string subject_;
    VideoInput::Kind kind_;
    bool hasFixedTimes_;
    InputPtr format_;
    AVStream* stream_;      // `format_` owns it
    std::int64_t startPts_; // of the file
    double fileEnd_;        // s: where the file says it ends; 0 = it does not
    double lastEnd_ = 0;    // s: end of the last packet of any stream, from the start of the file
    VideoReadCounts& counts_;
    PacketPtr packet_ = newPacket();
    bool drained_ = false;
    std::shared_ptr<OtherStreams> others_ = std::make_shared<OtherStreams>();
    std::vector<std::int64_t> otherIndex_; // by stream of the file, -1 = the pictures
    bool wanted_ = false;                  // a writer wants the other streams
};

} // namespace altiro3D
