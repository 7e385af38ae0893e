#pragma once

#include "altiro3D/quilt.hpp"
#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"
#include "base/json_reader.hpp"
#include "media/resumable_video.hpp"
#include "media/video_segments.hpp"
#include "video/conversion/frame_depth.hpp"
#include "video/conversion/frame_renderer.hpp"
#include "video/conversion/video_pipeline.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

namespace altiro3D {

/// The frames of a conversion that a chunk makes; they count from 0 in the part of the video.
struct ChunkRange {
    std::int64_t begin = 0;          ///< From here on depth is made, from `first` on also pictures.
    std::int64_t beginPts = 0;       ///< time of that frame
    SavedState state;                ///< State before that frame; empty: a scene begins there.
    std::int64_t first = 0;          ///< first frame to write; it begins a segment
    std::int64_t frames = 0;         ///< frames to write
    int segmentFrames = 1;           ///< frames of a segment
    std::filesystem::path directory; ///< receives the segments
    std::set<std::int64_t> borders;  ///< Frames before which `keep` receives the state.
    std::function<void(std::int64_t frame, const SavedState& state)> keep;

    std::int64_t end() const { return first + frames; }
};

/// Frames of a segment of a conversion's output.
int segmentFramesFor(const Fraction& rate);

/// Whether the input of a conversion can be read again.
bool canReadAgain(const std::filesystem::path& input);

/// The conversion of a video, or of a range of its frames. Its frames are written to segments, from
/// which a later run can continue, or directly to the file if the input cannot be read again.
class ConversionRun {
  public:
    /// See VideoConverter::VideoConverter(). Only the frames of `range` are made, if it is given.
    explicit ConversionRun(VideoConversion given, std::optional<ChunkRange> range = {});
    ConversionRun(const ConversionRun&) = delete;
    ConversionRun& operator=(const ConversionRun&) = delete;

    /// See VideoConverter::run(). With a range, nothing is joined.
    VideoConversionResult run(const VideoProgressFunction& goOn);
    /// Remarks about the output.
    const Notes& notes() const;
    /// Whether a later run can continue.
    bool keepsWork() const { return segments_ && segments_->keepsWork(); }
    /// The segments of the range, after run().
    const std::vector<VideoSegment>& chunk() const { return chunkSegments_; }

    VideoConversion conversion;
    RunSettings stamp; ///< See conversionStamp(); empty if the input cannot be read again.
    std::shared_ptr<VideoReader> reader;
    std::unique_ptr<FrameRenderer> renderer;
    VideoWriterOptions encoding; ///< complete options of the output
    VideoProgress progress;

  private:
    using Clock = std::chrono::steady_clock;

    void openOutput();
    std::vector<PipelineStage> stages();
    bool mayGoOn();
    bool read(PipelineFrame& frame);
    void waitUntilDue(const VideoFrame& frame);
    bool wantsState(std::int64_t frame) const;
    void write(const PipelineFrame& frame);
    void count(const PipelineFrame& frame);
    [[noreturn]] void failEmpty() const;
    void finish(VideoConversionResult& result);
    void finishRange(const VideoConversionResult& result);
    void finishFile(bool complete);
    // Whether a frame is needed only for the depth of later ones, and no picture is made of it.
    bool isBefore(const PipelineFrame& frame) const {
        return range_ && frame.number < range_->first;
    }
    double seconds(std::int64_t pts) const { return static_cast<double>(pts) * unit_; }

    double unit_ = 1;                   // unit of times, s
    std::unique_ptr<FrameDepth> depth_; // null: frames are quilts
    std::optional<ChunkRange> range_;
    // One of these receives the pictures, unless they are shown.
    std::optional<VideoWriter> plain_;
    std::optional<ResumableVideoWriter> segments_;
    std::optional<SegmentWriter> chunk_;
    std::vector<VideoSegment> chunkSegments_;
    KeptVideo kept_;   // kept by an earlier run, or made before the range
    std::mutex mutex_; // guards what follows, and progress
    VideoProgressFunction goOn_;
    VideoConversionResult result_;
    std::atomic<bool> cancelled_{false};
    std::optional<Clock::time_point> start_; // time of the first picture that is shown
    bool begun_ = false;
};

/// Takes the range of given depth that an earlier run or a plan has measured, unless one is set.
/// @param settings of the run or the plan
void takeDepthRange(VideoConversion& conversion, const Json& settings);

/// Everything that determines the frames and the file of a conversion, for
/// ResumableVideoOptions::settings: size and time of all input files, the contents of tables and
/// networks, and all options. The caller's settings come first.
/// @param conversion complete, with its depth source @param layout of the quilts
RunSettings conversionStamp(const VideoConversion& conversion, const QuiltLayout& layout);

} // namespace altiro3D
