#pragma once

#include "altiro3D/video_io.hpp"
#include "video/ffmpeg.hpp"
#include "video/frame_times.hpp"
#include "video/video_packets.hpp"

#include <cstdint>
#include <set>

namespace altiro3D {

/// A decoded frame and its time, in the stream's unit.
struct DecodedFrame {
    FramePtr frame = newFrame();
    std::int64_t pts = 0;
};

/// Decodes the pictures of a video, without the damaged ones.
class FrameDecoder {
  public:
    /// @param decoder open
    /// @param packets those of the pictures are decoded, others kept; must outlive this
    /// @param times that frames get
    /// @param counts damaged packets and frames are counted there; must outlive this
    FrameDecoder(CodecPtr decoder, VideoPackets& packets, FrameTimes times,
                 VideoReadCounts& counts);

    /// The next undamaged frame.
    /// @return false at the end; the frame's time is then as before
    /// @throws Error ReadFailed, OutOfMemory
    bool decode(DecodedFrame& decoded);
    /// To be called when the packets go on elsewhere: what came before does not count.
    void restart();

    const FrameTimes& times() const { return times_; }
    /// A frame was interlaced.
    bool hasInterlaced() const { return interlaced_; }

  private:
    bool feed();
    bool isDamaged(const AVFrame& frame);

    CodecPtr decoder_;
    VideoPackets& packets_;
    FrameTimes times_;
    VideoReadCounts& counts_;
    std::set<std::int64_t> corruptPts_; // of packets the container calls damaged
    bool sentEnd_ = false;
    bool interlaced_ = false;
};

} // namespace altiro3D
