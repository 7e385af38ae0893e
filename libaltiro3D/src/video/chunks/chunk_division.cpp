#include "video/chunks/chunk_division.hpp"

#include "altiro3D/depth_map.hpp"
#include "media/video_segments.hpp"
#include "video/conversion/frame_renderer.hpp"
#include "video/motion/picture_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <system_error>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// Chunks that begin inside the same scene get a chunk that makes its depth, if they are as many.
constexpr int kManyInScene = 3;
// Depth alone takes about this share of the time of depth and picture.
constexpr double kDepthShare = 0.3;

// The last place at or before a frame.
FramePlace lastBefore(const std::vector<FramePlace>& places, std::int64_t frame) {
    const auto after = std::upper_bound(
        places.begin(), places.end(), frame,
        [](std::int64_t value, const FramePlace& place) { return value < place.frame; });
    return after == places.begin() ? FramePlace() : *(after - 1);
}

// The frame from which depth must be made so that the one at `first` is right.
FramePlace beginOf(const VideoSurvey& survey, const ChunkDependence& on, const FramePlace& first) {
    FramePlace begin = first;
    for (const auto& [isNeeded, places] :
         {std::pair(on.onScene, &survey.cuts), std::pair(on.onFlaws, &survey.measured)}) {
        if (!isNeeded) continue;
        const FramePlace place = lastBefore(*places, first.frame);
        if (place.frame < begin.frame) begin = place;
    }
    return begin;
}

// The segments that begin chunks. Frames whose depth is repeated count as much as frames by which a
// chunk differs from its length.
std::vector<std::size_t> bordersOf(const VideoSurvey& survey, const ChunkDependence& on,
                                   int segmentFrames, std::size_t wanted) {
    std::vector<std::size_t> borders = {0};
    const std::size_t count = survey.segments.size();
    while (count - borders.back() > wanted + wanted / 2) {
        const std::size_t at = borders.back();
        std::size_t best = at + wanted;
        auto least = std::numeric_limits<std::int64_t>::max();
        for (std::size_t s = at + (wanted + 1) / 2; s <= at + wanted + wanted / 2; ++s) {
            const FramePlace& first = survey.firsts[s];
            const auto length = static_cast<std::int64_t>(wanted) * segmentFrames;
            const std::int64_t repeated =
                std::min(first.frame - beginOf(survey, on, first).frame, length);
            const std::size_t off = std::max(s, at + wanted) - std::min(s, at + wanted);
            const std::int64_t cost = repeated + static_cast<std::int64_t>(off) * segmentFrames;
            if (cost > least || (cost == least && s > at + wanted)) continue;
            least = cost;
            best = s;
        }
        borders.push_back(best);
    }
    return borders;
}

} // namespace

ChunkDependence dependenceOf(const VideoConversion& conversion) {
    ChunkDependence on;
    if (conversion.fromQuilt) return on;
    on.onScene = true;
    if (!conversion.given) return on;
    const GivenVideoDepth& given = *conversion.given;
    std::error_code error;
    on.rgbd = given.rgbd;
    on.onFlaws = true;
    // Pictures of a directory may be distances or floats, which get a range that follows them.
    on.onScene = conversion.choices.any() || given.kind == DepthKind::Metric ||
                 (!given.rgbd && fs::is_directory(given.source, error));
    return on;
}

VideoSurvey surveyVideo(VideoReader& reader, int segmentFrames, const ChunkDependence& on,
                        const VideoProgressFunction& goOn, VideoProgress progress) {
    VideoSurvey survey;
    PictureTracker tracker;
    const double unit = reader.facts().timeBase.value();
    std::vector<PipelineStage> stages;
    stages.push_back({"decode", [&](PipelineFrame& frame) {
                          if (goOn && !goOn(progress)) {
                              survey.cancelled = true;
                              return false;
                          }
                          if (!reader.read(frame.source)) return false;
                          ++progress.frames;
                          progress.end = static_cast<double>(frame.source.pts) * unit;
                          return true;
                      }});
    stages.push_back({"cuts", [&](PipelineFrame& frame) {
                          const VideoFrame& source = frame.source;
                          const FramePlace place{survey.frames, source.pts};
                          if (survey.frames % segmentFrames == 0) {
                              survey.segments.push_back({0, source.pts, 0, 0});
                              survey.firsts.push_back(place);
                          }
                          SegmentPlan& segment = survey.segments.back();
                          ++segment.frames;
                          segment.end = source.pts + std::max<std::int64_t>(source.duration, 1);
                          segment.times = mixTime(segment.times, source);
                          if (survey.frames % kFramesPerMeasurement == 0)
                              survey.measured.push_back(place);
                          if (on.onScene) {
                              cv::Mat photo = source.picture;
                              cv::Mat depth;
                              if (on.rgbd) splitRgbd(source.picture, *on.rgbd, photo, depth);
                              if (tracker.next(photo).cut) survey.cuts.push_back(place);
                          }
                          ++survey.frames;
                          return true;
                      }});
    runPipeline(stages);
    return survey;
}

void divideVideo(ChunkPlan& plan, const VideoSurvey& survey, const ChunkDependence& on,
                 double seconds, double videoSeconds) {
    const double segmentSeconds =
        videoSeconds * plan.segmentFrames / static_cast<double>(survey.frames);
    const double most = static_cast<double>(survey.segments.size());
    const auto wanted = static_cast<std::size_t>(
        std::clamp(std::round(seconds / std::max(segmentSeconds, 1e-9)), 1.0, most));
    const std::vector<std::size_t> borders = bordersOf(survey, on, plan.segmentFrames, wanted);
    struct Made {
        VideoChunk chunk;
        std::int64_t beginPts;
    };
    std::vector<Made> all;
    std::map<std::int64_t, std::vector<std::size_t>> inScene; // by first frame of the scene
    for (std::size_t i = 0; i < borders.size(); ++i) {
        const FramePlace& first = survey.firsts[borders[i]];
        const std::int64_t end =
            i + 1 < borders.size() ? survey.firsts[borders[i + 1]].frame : survey.frames;
        const FramePlace begin = beginOf(survey, on, first);
        VideoChunk chunk;
        chunk.begin = begin.frame;
        chunk.first = first.frame;
        chunk.frames = end - first.frame;
        if (chunk.begin < chunk.first) inScene[chunk.begin].push_back(all.size());
        all.push_back({chunk, begin.pts});
    }
    for (const auto& [begin, members] : inScene) {
        if (members.size() < static_cast<std::size_t>(kManyInScene)) continue;
        Made depth = all[members.back()];
        depth.chunk.frames = 0;
        all.push_back(depth);
    }
    const auto work = [](const Made& made) {
        return static_cast<double>(made.chunk.frames) +
               kDepthShare * static_cast<double>(made.chunk.first - made.chunk.begin);
    };
    std::stable_sort(all.begin(), all.end(), [&](const Made& a, const Made& b) {
        if ((a.chunk.frames == 0) != (b.chunk.frames == 0)) return a.chunk.frames == 0;
        return work(a) > work(b);
    });
    for (const Made& made : all) {
        plan.shown.chunks.push_back(made.chunk);
        plan.beginPts.push_back(made.beginPts);
    }
}

} // namespace altiro3D
