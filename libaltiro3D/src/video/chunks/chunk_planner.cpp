#include "altiro3D/error.hpp"
#include "altiro3D/video_conversion.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "media/run_settings.hpp"
#include "media/video_segments.hpp"
#include "video/chunks/chunk_division.hpp"
#include "video/chunks/chunk_plan.hpp"
#include "video/conversion/conversion_run.hpp"

#include <chrono>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <system_error>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

VideoChunkPlan planVideoChunks(VideoConversion conversion, const fs::path& directory,
                               const VideoChunkOptions& options,
                               const VideoProgressFunction& goOn) {
    checkNumber(options.seconds >= 1 && options.seconds <= 86400, "seconds", options.seconds,
                "1..86400");
    requireFileInput(conversion);
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
        if (!other.empty()) {
            throw Error(ErrorCode::Mismatch, directory.string(),
                        "holds a plan with other settings (" + other + "), expected a new folder");
        }
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
    if (survey.frames == 0) {
        throw Error(ErrorCode::BadFormat, run.conversion.input.string(),
                    "holds no frames in this part, expected at least one");
    }
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
}

VideoChunkPlan readVideoChunks(const fs::path& directory) {
    return readChunkPlan(directory).shown;
}

} // namespace altiro3D
