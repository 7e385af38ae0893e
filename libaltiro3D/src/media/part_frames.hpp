#pragma once

#include "altiro3D/video_io.hpp"
#include "media/ffmpeg.hpp"
#include "media/frame_decoder.hpp"
#include "media/video_input.hpp"
#include "media/video_packets.hpp"

#include <cstdint>
#include <string>

namespace altiro3D {

/// The frames of the requested part of a video: finds its beginning, skips, and stops at its end.
class PartFrames {
  public:
    /// A frame of the part.
    struct Frame {
        const AVFrame* picture = nullptr;
        std::int64_t pts = 0;      ///< from the part's beginning, in the stream's unit
        std::int64_t duration = 0; ///< in the stream's unit; 0 = unknown
    };

    /// @param input the open video @param options the part
    /// @param packets, decoder, counts must outlive this
    PartFrames(const VideoInput& input, const VideoReaderOptions& options, VideoPackets& packets,
               FrameDecoder& decoder, VideoReadCounts& counts);

    /// The next frame; it is valid until the next call.
    /// @return false at the end
    /// @throws Error as VideoReader::next()
    bool next(Frame& frame);
    /// Releases the memory of the frame from next().
    void release() { av_frame_unref(ahead_.frame.get()); }

    /// Whether a frame was read or the first one was searched for.
    bool hasBegun() const { return begun_; }
    /// Begins by decoding from the start of the file. @return number of frames before the part
    std::int64_t countBefore();
    /// See VideoReader::skipTo().
    void skipTo(std::int64_t pts);
    /// Reads without decoding up to the pictures of a time. @return false at the end
    bool pass(std::int64_t until);

  private:
    void begin(bool maySeek);
    bool seekToPart();
    bool decodeUpToPart();
    void goTo(std::int64_t goal);
    bool seek(std::int64_t target);
    bool seekToStart();
    void restart();
    void end();
    double seconds(std::int64_t ticks) const { return static_cast<double>(ticks) * unit_; }

    std::string subject_;
    std::string codec_;
    VideoInput::Kind kind_;
    bool isLive_; // frames are delivered as they arrive
    double unit_; // s
    VideoPackets& packets_;
    FrameDecoder& decoder_;
    VideoReadCounts& counts_;

    // position of the part, in the time of the file
    std::int64_t startPts_; // of the file
    std::int64_t fromPts_;
    std::int64_t toPts_;
    std::int64_t originPts_; // the time that counts as 0
    double from_;            // VideoReaderOptions::from, s

    DecodedFrame current_; // the next one to return
    DecodedFrame ahead_;
    bool hasCurrent_ = false;
    bool begun_ = false;
    bool ended_ = false;
    bool pastEnd_ = false;          // at the end of the part
    std::int64_t passedFrames_ = 0; // decoded before the part
};

} // namespace altiro3D
