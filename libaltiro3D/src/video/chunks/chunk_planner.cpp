#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "media/resumable_video.hpp"
#include "media/video_segments.hpp"
#include "video/chunks/chunk_files.hpp"
#include "video/conversion/conversion_run.hpp"
#include "video/conversion/frame_renderer.hpp"
#include "video/motion/motion.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// If this many chunks or more begin inside one scene, a further chunk makes its depth for them.
constexpr int kManyInScene = 3;
// Depth alone takes about this share of the time of depth and picture.
constexpr double kDepthShare = 0.3;

// What a chunk's first frame depends on.
struct ChunkDependence {
    bool onScene = false;           // Depth, its flaws and choices, which begin anew at a cut.
    std::optional<RgbdLayout> rgbd; // Layout of RGB-D frames.
    std::optional<StereoVideo> stereo;
};

// A frame and its time.
struct FramePlace {
    std::int64_t frame = 0;
    std::int64_t pts = 0;
};

// The frames of the input, read once.
struct VideoSurvey {
    std::vector<VideoSegment> segments;
    std::vector<FramePlace> firsts; // First frames of the segments.
    std::vector<FramePlace> cuts;
    std::int64_t frames = 0;
    bool cancelled = false;
};

// The frame from which depth must be made so that the one at `first` is right.
FramePlace beginOf(const VideoSurvey& survey, const ChunkDependence& on, const FramePlace& first) {
    if (!on.onScene) return first;
    const auto after = std::upper_bound(
        survey.cuts.begin(), survey.cuts.end(), first.frame,
        [](std::int64_t value, const FramePlace& place) { return value < place.frame; });
    return after == survey.cuts.begin() ? FramePlace() : *(after - 1);
}

// The segments that begin chunks. A border costs the frames whose depth is made twice, plus the
// frames by which the chunk differs from its wanted length.
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

ChunkDependence dependenceOf(const VideoConversion& conversion) {
    ChunkDependence on;
    if (conversion.fromQuilt || conversion.eyes.filmed) return on;
    on.onScene = true;
    on.stereo = conversion.stereo;
    if (conversion.given) on.rgbd = conversion.given->rgbd;
    return on;
}

// Reads all frames and finds the cuts.
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
    stages.push_back(
        {"cuts", [&](PipelineFrame& frame) {
             const VideoFrame& source = frame.source;
             const FramePlace place{survey.frames, source.pts};
             if (survey.frames % segmentFrames == 0) {
                 survey.segments.emplace_back().pts = source.pts;
                 survey.firsts.push_back(place);
             }
             VideoSegment& segment = survey.segments.back();
             ++segment.frames;
             segment.end = source.pts + std::max<std::int64_t>(source.duration, 1);
             segment.times = mixTime(segment.times, source);
             if (on.onScene) {
                 cv::Mat photo = source.picture;
                 cv::Mat depth;
                 if (on.rgbd) splitRgbd(source.picture, *on.rgbd, photo, depth);
                 if (on.stereo)
                     photo = splitStereoPair(photo, on.stereo->layout, on.stereo->halves).left;
                 if (tracker.next(photo).cut) survey.cuts.push_back(place);
             }
             ++survey.frames;
             return true;
         }});
    runPipeline(stages);
    return survey;
}

// Adds the chunks to a plan, which has its segments.
// @param seconds desired length of a chunk @param videoSeconds length of the video
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

void makePlanFolders(const fs::path& directory) {
    static const std::set<std::string> kOurs = {kChunkPlanFile, "arguments", "visual.json", kChunks,
                                                kStates,        "logs",      "joined"};
    std::error_code error;
    if (fs::exists(directory, error) && !fs::is_directory(directory, error))
        throw Error(ErrorCode::WriteFailed, directory.string(), "is a file, expected a new folder");
    for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (kOurs.count(name) == 0 && name.rfind(".altiro3D-", 0) != 0)
            throw Error(ErrorCode::WriteFailed, directory.string(),
                        "holds other files (" + name + "), expected a new folder");
    }
    for (const char* name : {"", kChunks, kStates, "logs"}) {
        fs::create_directories(directory / name, error);
        if (error)
            throw Error(ErrorCode::WriteFailed, (directory / name).string(),
                        "cannot be made: " + error.message() + ", expected a folder to write to");
    }
}

void removePlan(const fs::path& directory) {
    std::error_code error;
    for (const char* name : {kChunkPlanFile, kChunks, kStates, "logs", "joined"}) {
        fs::remove_all(directory / name, error);
        if (error)
            throw Error(ErrorCode::WriteFailed, (directory / name).string(),
                        "cannot be removed: " + error.message());
    }
}

} // namespace

VideoChunkPlan planVideoChunks(VideoConversion conversion, const fs::path& directory,
                               const VideoChunkOptions& options,
                               const VideoProgressFunction& goOn) try {
    checkNumber(options.seconds >= 1 && options.seconds <= 86400, "seconds", options.seconds,
                "1..86400");
    const auto start = std::chrono::steady_clock::now();
    const UnfinishedRun unfinished = conversion.unfinished;
    const ChunkDependence on = dependenceOf(conversion);
    const fs::path output = conversion.output;
    ConversionRun run(std::move(conversion), ChunkRange());
    ChunkPlan plan;
    {
        // Outputs that cannot be written must fail now, not after all chunks are made.
        VideoReader source(run.conversion.input, run.conversion.part);
        plan.shown.notes = VideoWriter(output, run.encoding, &source).notes();
    }
    plan.settings = settingsJson(run.stamp);
    plan.settings["length of chunks"] = numberText(options.seconds);
    std::error_code error;
    if (unfinished == UnfinishedRun::Discard) removePlan(directory);
    if (fs::exists(directory / kChunkPlanFile, error)) {
        const ChunkPlan there = readChunkPlan(directory);
        const std::string other = differenceOf(there.settings, plan.settings);
        if (!other.empty())
            throw Error(ErrorCode::Mismatch, directory.string(),
                        "holds a plan with other settings (" + other + "), expected a new folder");
        makePlanFolders(directory);
        return there.shown;
    }
    makePlanFolders(directory);
    plan.segmentFrames = segmentFramesFor(run.encoding.frameRate);
    plan.shown.threads = cv::getNumThreads();
    VideoProgress progress;
    progress.framesInAll = run.reader->facts().frameCount;
    const VideoSurvey survey = surveyVideo(*run.reader, plan.segmentFrames, on, goOn, progress);
    if (survey.cancelled) {
        plan.shown.cancelled = true;
        return plan.shown;
    }
    if (survey.frames == 0)
        throw Error(ErrorCode::BadFormat, run.conversion.input.string(),
                    "holds no frames in this part, expected at least one");
    const Notes notes = run.reader->notes();
    plan.shown.notes.insert(plan.shown.notes.end(), notes.begin(), notes.end());
    const Fraction timeBase = run.reader->facts().timeBase;
    plan.segments = survey.segments;
    divideVideo(plan, survey, on, options.seconds,
                static_cast<double>(survey.segments.back().end) * timeBase.value());
    setTimes(plan, timeBase);
    plan.shown.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    writeChunkPlan(plan, timeBase, directory);
    return plan.shown;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

VideoChunkPlan readVideoChunks(const fs::path& directory) {
    return readChunkPlan(directory).shown;
}

} // namespace altiro3D
