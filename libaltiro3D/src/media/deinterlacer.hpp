#pragma once

#include "media/ffmpeg.hpp"

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

extern "C" {
#include <libavfilter/avfilter.h>
}

namespace altiro3D {

/// A decoded frame and its time, in the stream's unit.
struct DecodedFrame {
    FramePtr frame = newFrame();
    std::int64_t pts = 0;
};

struct FreeGraph {
    void operator()(AVFilterGraph* graph) const;
};

/// Interpolates the lines that interlaced frames lack, by FFmpeg's filter bwdif, and keeps other
/// frames as they are. A frame depends on those before and after it. Up to the first interlaced
/// frame nothing is filtered and nothing is held back.
class Deinterlacer {
  public:
    /// @param unit of the frames' times
    /// @param subject name of the video, for errors
    Deinterlacer(AVRational unit, int threads, std::string subject);

    /// Takes a frame. @throws Error Unsupported, OutOfMemory
    void give(DecodedFrame& decoded);
    /// Says that no frame follows.
    void end();
    /// Delivers the next frame. @return false if another one must be given first
    bool take(DecodedFrame& decoded);
    /// Forgets all frames, for a seek.
    void restart();

  private:
    void open(const AVFrame& frame);
    void push(const DecodedFrame* decoded);

    AVRational unit_;
    int threads_;
    std::string subject_;
    std::unique_ptr<AVFilterGraph, FreeGraph> graph_;
    AVFilterContext* source_ = nullptr; // `graph_` owns both
    AVFilterContext* sink_ = nullptr;
    DecodedFrame last_; // given last, while nothing is filtered
    bool hasLast_ = false;
    bool skips_ = false; // the next frame of the graph was delivered before
    std::deque<DecodedFrame> ready_;
};

/// Whether a frame is interlaced.
bool isInterlaced(const AVFrame& frame);

} // namespace altiro3D
