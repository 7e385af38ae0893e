#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_types.hpp"

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace altiro3D {

/// A frame in a pipeline. Frames and their memory are reused. A stage that keeps a reference to a
/// picture forces later writers to allocate new memory, see ownMemory().
struct PipelineFrame {
    std::int64_t number = 0; ///< From 0, in the order of display.
    VideoFrame source;       ///< The frame as read.
    cv::Mat depth;           ///< [any size, CV_32FC1, 0..1, 1 = nearest]
    VideoDepthStep step;     ///< How the depth was made.
    VideoFrame result;       ///< The frame to write.
    std::string state;       ///< What a later run needs to resume after this frame; usually empty.
};

/// One processing step, applied to every frame.
struct PipelineStage {
    std::string name; ///< For reports: "decode", "depth", "render", "encode".
    /// Processes a frame. It is called for all frames in order, in one thread. Returning false ends
    /// the run: the frame is dropped, earlier stages stop, and later stages finish their frames.
    std::function<bool(PipelineFrame&)> work;
};

/// Options of a pipeline.
struct PipelineOptions {
    int queueFrames = 3; ///< Frames that may wait between two stages, 1..64.
    bool threads = true; ///< One thread per stage; false: all stages in one thread, for comparison.
    /// For live input: the first stage never waits. If queueFrames frames already wait behind it,
    /// the oldest one is dropped. With queueFrames = 1 the second stage always gets the newest
    /// frame.
    bool dropLate = false;
};

/// Statistics of a stage.
struct StageReport {
    std::string name;        ///< Name of the stage.
    std::int64_t frames = 0; ///< Frames it processed.
    double seconds = 0;      ///< Processing time of all frames, s.
    double longest = 0;      ///< Processing time of the slowest frame, s.
};

/// Statistics of a pipeline run.
struct PipelineReport {
    std::vector<StageReport> stages; ///< In order.
    double seconds = 0;              ///< Wall time of the run, s.
    std::int64_t dropped = 0;        ///< Frames dropped by PipelineOptions::dropLate.
};

/// Prepares a picture for writing: if its memory is shared, the reference is released, and
/// `create()` then allocates new memory.
///
/// @param picture [any size and type]; empty afterwards if its memory is shared, else unchanged
ALTIRO3D_EXPORT void ownMemory(cv::Mat& picture);

/// Runs frames through stages, each in its own thread, with short queues between them. Memory does
/// not grow with the length of the video, and results do not depend on the speed of the stages.
///
/// Returns when the last frame has passed the last stage. If a stage throws, all stages stop and
/// the exception is rethrown here.
///
/// @param stages one or more, in processing order
/// @param options queue length, threads and live input
/// @return statistics of each stage
/// @throws Error InvalidArgument (no stage, queueFrames); exceptions of the stages pass through
ALTIRO3D_EXPORT PipelineReport runPipeline(const std::vector<PipelineStage>& stages,
                                           const PipelineOptions& options = {});

} // namespace altiro3D
