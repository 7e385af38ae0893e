#pragma once

#include "video/conversion/frame_depth.hpp"
#include "video/conversion/frame_renderer.hpp"
#include "video/conversion/video_pipeline.hpp"
#include "video/conversion/video_sink.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace altiro3D {

/// The conversion of a video, or of a range of its frames.
class ConversionRun {
  public:
    /// See VideoConverter::VideoConverter(). Only the frames of `range` are made, if it is given.
    explicit ConversionRun(VideoConversion given, std::optional<ChunkRange> range = {});
    ConversionRun(const ConversionRun&) = delete;
    ConversionRun& operator=(const ConversionRun&) = delete;

    /// See VideoConverter::run(). With a range, nothing is joined.
    VideoConversionResult run(const VideoProgressFunction& goOn);

    VideoConversion conversion;
    RunSettings stamp; ///< See conversionStamp(); empty if the input cannot be read again.
    std::unique_ptr<VideoReader> reader;
    std::unique_ptr<FrameRenderer> renderer;
    VideoWriterOptions encoding;   ///< of the output, complete
    std::optional<VideoSink> sink; ///< nothing if the pictures are shown
    VideoProgress progress;

  private:
    using Clock = std::chrono::steady_clock;

    std::vector<PipelineStage> stages();
    bool mayGoOn();
    bool read(PipelineFrame& frame);
    void waitUntilDue(const VideoFrame& frame);
    void count(const PipelineFrame& frame);
    [[noreturn]] void failEmpty() const;
    void finish(VideoConversionResult& result);
    void finishRange(const VideoConversionResult& result);
    // Whether a frame is passed for the depth of later ones only.
    bool isBefore(const PipelineFrame& frame) const {
        return range_ && frame.number < range_->first;
    }
    double seconds(std::int64_t pts) const { return static_cast<double>(pts) * unit_; }

    double unit_ = 1;                   // of times, s
    std::unique_ptr<FrameDepth> depth_; // null: frames are quilts
    std::optional<ChunkRange> range_;
    std::mutex mutex_; // of what follows, and progress
    VideoProgressFunction goOn_;
    VideoConversionResult result_;
    std::atomic<bool> cancelled_{false};
    std::optional<Clock::time_point> start_; // of the first picture that is shown
    bool begun_ = false;
};

} // namespace altiro3D
