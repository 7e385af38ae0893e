#pragma once

#include "altiro3D/video_conversion.hpp"

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace altiro3D {

/// A frame in a pipeline. Each has its own memory.
struct PipelineFrame {
    std::int64_t number = 0; ///< Number of the frame, from 0, in the order of display.
    VideoFrame source;       ///< The frame as read.
    cv::Mat depth;           ///< Depth of `source` [any size, CV_32FC1, 0..1, 1 = nearest]
    HiddenLayer hidden;      ///< What is known about what `source` hides; usually nothing.
    VideoDepthStep step;     ///< How the depth was made.
    VideoFrame result;       ///< The frame to write.
    SavedState state;        ///< State to resume after this frame in a later run; usually empty.
};

/// One processing step, applied to every frame.
struct PipelineStage {
    std::string name; ///< For reports: "decode", "depth", "render", "encode".
    /// Processes a frame. It is called for all frames in order, in one thread. Returning false ends
    /// the run: the frame is dropped, earlier stages stop, and later stages finish their frames.
    std::function<bool(PipelineFrame&)> work;
};

struct PipelineOptions {
    int queueFrames = 3; ///< Frames that may wait between two stages, 1 or more.
    /// For live input: the first stage never waits. If queueFrames frames already wait behind it,
    /// the oldest one is dropped. With queueFrames = 1 the second stage gets the newest frame.
    bool dropLate = false;
};

/// Runs frames through stages, each in its own thread, with short queues between them. Memory does
/// not grow with the length of the video, and results do not depend on the speed of the stages.
///
/// The last stage runs in the calling thread. The function returns when the last frame has passed
/// the last stage. If a stage throws, all stages stop and the exception is rethrown here.
/// @param stages one or more, in processing order
/// @return statistics of each stage
/// @throws what the stages throw
PipelineReport runPipeline(const std::vector<PipelineStage>& stages,
                           const PipelineOptions& options = {});

} // namespace altiro3D
