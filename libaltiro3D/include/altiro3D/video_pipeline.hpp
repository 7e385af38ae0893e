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

/// A frame on its way through a pipeline. Frames are used again with their memory: whoever keeps a
/// picture beyond its stage makes others take new memory by holding a reference, see ownMemory().
struct PipelineFrame {
    std::int64_t number = 0; ///< From 0, in the order of display.
    VideoFrame source;       ///< As it was read.
    cv::Mat depth;           ///< [any size, CV_32FC1, 0..1, 1 = nearest]
    VideoDepthStep step;     ///< How the depth was made.
    VideoFrame result;       ///< What is written.
    std::string state;       ///< What a later run needs to go on after this frame; mostly empty.
};

/// One step of the work on every frame.
struct PipelineStage {
    std::string name; ///< For reports: "decode", "depth", "render", "encode".
    /// Works on a frame. Called for one frame after the other, in order, in one thread. False ends
    /// the run: the frame is dropped, stages before make no more, those behind finish theirs.
    std::function<bool(PipelineFrame&)> work;
};

/// How a pipeline runs.
struct PipelineOptions {
    int queueFrames = 3; ///< Frames that may wait between two stages, 1..64.
    bool threads = true; ///< Each stage has a thread; false: one after the other, for comparison.
    /// Live: the first stage never waits. Where queueFrames wait behind it already, the oldest of
    /// them is dropped; with queueFrames = 1 the second stage always gets the newest.
    bool dropLate = false;
};

/// What a stage did.
struct StageReport {
    std::string name;        ///< The stage's.
    std::int64_t frames = 0; ///< Frames it worked on.
    double seconds = 0;      ///< Time it worked, all frames together.
    double longest = 0;      ///< Time of the slowest frame, s.
};

/// What a pipeline did.
struct PipelineReport {
    std::vector<StageReport> stages; ///< In order.
    double seconds = 0;              ///< From begin to end, all stages together.
    std::int64_t dropped = 0;        ///< Frames left out by PipelineOptions::dropLate.
};

/// Gives the picture memory of its own to be written to: what others hold, too, is let go, and
/// `create()` then takes new memory.
///
/// @param picture [any size and type]; empty afterwards if anybody else holds its memory, else as
///        it was
ALTIRO3D_EXPORT void ownMemory(cv::Mat& picture);

/// Takes frames through stages, each in its own thread, with short queues between them: memory does
/// not grow with the length, and results do not depend on who is fast.
///
/// Returns when the last frame has passed the last stage. If a stage throws, all stop and the
/// exception is thrown here.
///
/// @param stages at least one, in the order of the work
/// @param options see PipelineOptions
/// @return what each stage did
/// @throws Error InvalidArgument (no stage, queueFrames), and what the stages throw
ALTIRO3D_EXPORT PipelineReport runPipeline(const std::vector<PipelineStage>& stages,
                                           const PipelineOptions& options = {});

} // namespace altiro3D
