#pragma once

#include "altiro3D/video_io.hpp"
#include "media/ffmpeg.hpp"
#include "media/other_streams.hpp"
#include "media/video_input.hpp"

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// Describes a video's contents other than pictures for a writer, clipped to the part that is read.
/// @return for each stream of the file, its index in `others.streams`; -1 = the pictures
std::vector<std::int64_t> describeOthers(const VideoInput& input, const VideoReaderOptions& options,
                                         OtherStreams& others);

/// Joins the pieces of a file whose times jump or begin again, such as broadcasts and recordings
/// that were appended to each other. Each piece begins where the one before ends. All streams keep
/// in step, although they pass the joint one after the other.
///
/// As in FFmpeg's tools, this is for containers with discontinuous times (MPEG transport streams,
/// ...). A jump goes back, to 0.1 s or more before the expected time, or forward by more than 10 s.
class PacketTimes {
  public:
    explicit PacketTimes(const AVFormatContext& format);

    /// Shifts the times of a packet to those of the joined pieces.
    /// @return whether it is the first one of its stream after a joint
    bool join(AVPacket& packet);
    /// Resets the state after a seek.
    void restart();

  private:
    struct Stream {
        AVRational unit{0, 1};
        bool lasts = false; ///< Its packets have a duration: pictures or sound.
        bool begun = false;
        std::size_t piece = 0;
        std::int64_t last = 0; ///< Decoding time of its last packet, as stored, in µs.
        std::int64_t end = 0;  ///< Its end.
    };
    struct Piece {
        std::int64_t shift = 0; ///< Shift in µs.
        std::int64_t last = 0;  ///< The last time in it, as stored.
    };

    bool beginsPiece(const Stream& stream, std::int64_t time) const;

    bool mayJump_;
    std::vector<Stream> streams_;
    std::vector<Piece> pieces_;
};

/// The packets of an open video: those of the pictures, and the others for a writer.
class VideoPackets {
  public:
    /// @param counts receives whether the file is cut off; it and `input` must outlive this
    VideoPackets(VideoInput& input, const VideoReaderOptions& options, VideoReadCounts& counts);

    /// The other streams, for a writer.
    const std::shared_ptr<OtherStreams>& others() const { return others_; }

    /// Call it before the first packet is read. Other streams are kept if a writer requested them.
    void begin() { wanted_ = others_->begin(); }
    /// Reads a packet; it is empty if a device has none yet.
    /// @return false at the end
    /// @throws Error ReadFailed
    bool read();
    const AVPacket& packet() const { return *packet_; }
    bool isOfPictures() const { return packet_->stream_index == input_.stream->index; }
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

    VideoInput& input_;
    double lastEnd_ = 0; // s: end of the last packet of any stream, from the start of the file
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
