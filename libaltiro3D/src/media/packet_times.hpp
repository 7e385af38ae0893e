#pragma once

#include "media/ffmpeg.hpp"

#include <cstdint>
#include <vector>

namespace altiro3D {

/// Joins the pieces of a file whose times jump or begin again, as of broadcasts and of recordings
/// that were appended to each other. Each piece begins where the one before ends. All streams keep
/// in step, although they pass the joint one after the other.
///
/// As in FFmpeg's tools, this holds for containers whose times may be discontinuous (MPEG transport
/// streams and others). A jump is a step back, to 0.1 s or more before the expected time, or
/// forward by more than 10 s.
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
        bool lasts = false; ///< Of pictures or sound.
        bool begun = false;
        std::size_t piece = 0;
        std::int64_t last = 0; ///< Decoding time of its last packet, as stored, in µs.
        std::int64_t end = 0;  ///< Its end.
    };
    struct Piece {
        std::int64_t shift = 0; ///< In µs.
        std::int64_t last = 0;  ///< The last time in it, as stored.
    };

    bool beginsPiece(const Stream& stream, std::int64_t time) const;

    bool mayJump_;
    std::vector<Stream> streams_;
    std::vector<Piece> pieces_;
};

} // namespace altiro3D
