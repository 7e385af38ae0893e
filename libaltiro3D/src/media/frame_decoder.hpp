#pragma once

#include "altiro3D/video_io.hpp"
#include "media/deinterlacer.hpp"
#include "media/ffmpeg.hpp"
#include "media/frame_times.hpp"
#include "media/video_packets.hpp"

#include <cstdint>
#include <optional>
#include <set>

namespace altiro3D {

/// Decodes the pictures of a video, drops damaged ones and deinterlaces.
class FrameDecoder {
  public:
    /// @param decoder open
    /// @param packets packets of the pictures are decoded, others are kept; must outlive this
    /// @param times assigns the times of frames
    /// @param deinterlacer nothing: interlaced frames stay as they are
    /// @param counts receives the numbers of damaged packets and frames; must outlive this
    FrameDecoder(CodecPtr decoder, VideoPackets& packets, FrameTimes times,
                 std::optional<Deinterlacer> deinterlacer, VideoReadCounts& counts);

    /// The next undamaged frame.
    /// @return false at the end; the frame's time is then unchanged
    /// @throws Error ReadFailed, OutOfMemory
    bool decode(DecodedFrame& decoded);
    /// Resets the decoder; call it after a seek.
    void restart();

    const FrameTimes& times() const { return times_; }
    /// Whether a frame was interlaced.
    bool hasInterlaced() const { return interlaced_; }
    /// Whether frames may depend on those before them.
    bool deinterlaces() const;

  private:
    bool decodeNext(DecodedFrame& decoded);
    bool feed();
    bool isDamaged(const AVFrame& frame);

    CodecPtr decoder_;
    VideoPackets& packets_;
    FrameTimes times_;
    std::optional<Deinterlacer> deinterlacer_;
    DecodedFrame given_; // to the deinterlacer
    VideoReadCounts& counts_;
    std::set<std::int64_t> corruptPts_; // times of packets that the container marks as damaged
    bool sentEnd_ = false;
    bool interlaced_ = false;
};

} // namespace altiro3D
