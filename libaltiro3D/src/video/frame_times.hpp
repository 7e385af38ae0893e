#pragma once

#include "altiro3D/video_io.hpp"
#include "video/ffmpeg.hpp"

#include <cstdint>

namespace altiro3D {

/// Gives the frames of a video times that rise, in the stream's unit: as the file states them,
/// else repaired.
///
/// A few frames in disorder are put one tick apart, so that the next good time counts again. Where
/// times begin again, as in files put together, what follows is shifted as a whole.
class FrameTimes {
  public:
    /// @param facts of the video
    /// @param unit of times
    /// @param start where the file begins, in that unit
    /// @param counts repaired times are counted there; must outlive this
    FrameTimes(const VideoFacts& facts, AVRational unit, std::int64_t start,
               VideoReadCounts& counts);

    /// The time of the next frame.
    std::int64_t next(const AVFrame& frame);
    /// Forgets what came before.
    void restart();

    /// A frame has got a time.
    bool hasBegun() const { return hasLast_; }
    /// Times of the file do.
    bool beginsAgain() const { return beginsAgain_; }
    /// Nominal time that a frame stays; 0 = not known.
    std::int64_t frameDuration() const { return frameDuration_; }

  private:
    std::int64_t risingTime(const AVFrame& frame);

    AVRational unit_;
    std::int64_t start_;
    std::int64_t frameDuration_;
    bool countsFirst_; // that the time of the first frame is missing
    VideoReadCounts& counts_;
    std::int64_t last_ = 0;
    bool hasLast_ = false;
    std::int64_t shift_ = 0;
    int inDisorder_ = 0; // frames in a row
    bool beginsAgain_ = false;
};

} // namespace altiro3D
