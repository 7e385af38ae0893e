#pragma once

#include "altiro3D/video_io.hpp"
#include "media/ffmpeg.hpp"

#include <cstdint>

namespace altiro3D {

/// Assigns rising times to the frames of a video, in the stream's unit: the times of the file, or
/// repaired ones.
///
/// A few frames in disorder are placed one tick apart until the next valid time. If times start
/// again, as in concatenated files, all following times are shifted.
class FrameTimes {
  public:
    /// @param facts properties of the video
    /// @param unit unit of times
    /// @param start start of the file in that unit
    /// @param counts receives the number of repaired times; must outlive this
    FrameTimes(const VideoFacts& facts, AVRational unit, std::int64_t start,
               VideoReadCounts& counts);

    /// The time of the next frame.
    std::int64_t next(const AVFrame& frame);
    /// Resets the state; the next frame is treated as the first.
    void restart();

    /// Whether a frame has a time.
    bool hasBegun() const { return hasLast_; }
    /// Times of the file do.
    bool beginsAgain() const { return beginsAgain_; }
    /// Nominal duration of a frame; 0 = unknown.
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
