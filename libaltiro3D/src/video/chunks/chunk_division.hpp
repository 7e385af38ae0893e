#pragma once

#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"
#include "video/chunks/chunk_plan.hpp"

#include <cstdint>
#include <optional>
#include <vector>

/// Where the chunks of a video begin.
namespace altiro3D {

/// What a chunk's first frame depends on.
struct ChunkDependence {
    bool onScene = false; ///< Depth or choices, which begin anew at a cut.
    bool onFlaws = false; ///< Flaws of given depth, measured every kFramesPerMeasurement frames.
    std::optional<RgbdLayout> rgbd; ///< Of RGB-D frames.
};
/// The dependence of a conversion.
ChunkDependence dependenceOf(const VideoConversion& conversion);

/// A frame and its time.
struct FramePlace {
    std::int64_t frame = 0;
    std::int64_t pts = 0;
};

/// The frames of the input, read once.
struct VideoSurvey {
    std::vector<SegmentPlan> segments;
    std::vector<FramePlace> firsts; ///< Of the segments.
    std::vector<FramePlace> cuts;
    std::vector<FramePlace> measured; ///< At these, flaws of given depth are measured.
    std::int64_t frames = 0;
    bool cancelled = false;
};

/// Reads all frames and finds the cuts.
/// @param goOn receives `progress` before each frame; may be empty
VideoSurvey surveyVideo(VideoReader& reader, int segmentFrames, const ChunkDependence& on,
                        const VideoProgressFunction& goOn, VideoProgress progress);

/// Adds the chunks to a plan, which has its segments.
/// @param seconds desired length of a chunk @param videoSeconds length of the video
void divideVideo(ChunkPlan& plan, const VideoSurvey& survey, const ChunkDependence& on,
                 double seconds, double videoSeconds);

} // namespace altiro3D
