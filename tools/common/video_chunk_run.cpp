#include "common/video_chunk_run.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/video_chunks.hpp"
#include "common/chunk_folder.hpp"
#include "common/folder_run.hpp"
#include "common/outputs.hpp"
#include "common/video_job.hpp"
#include "common/video_plan.hpp"
#include "common/video_progress.hpp"
#include "common/video_run.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr const char* kLength = "chunk-seconds";
constexpr const char* kJoined = "joined"; // size and time of the output that was written

// The part of a run that its plan states.
struct PlannedRun {
    std::unique_ptr<CommandLine> commandLine;
    VideoJob job;
    VideoConversion conversion;
};

// Opens the run of a plan as the plan's command line did, in its working directory.
void openPlanned(const fs::path& folder, const std::string& tool,
                 const std::function<void(CommandLine&)>& addOptions, PlannedRun& run,
                 Messages& messages) {
    const int threads = readVideoChunks(folder).threads;
    run.commandLine =
        openCommandLine(folder, tool, threads, addOptions, [&](const CommandLine& commandLine) {
            run.job.plan = planVideo(commandLine);
            run.job.plan.isChecked = true; // the plan has checked the names
            prepareVideo(commandLine, run.job, messages);
            run.conversion = openVideo(commandLine, run.job, messages);
        });
}

std::string shareText(std::int64_t part, std::int64_t whole) {
    return fixed(100 * static_cast<double>(part) / static_cast<double>(whole), 1) + " %";
}

int plan(const CommandLine& commandLine, const std::vector<std::string>& arguments,
         const fs::path& folder, Messages& messages) {
    for (const char* option : {"show", "resume", "report", "recursive"})
        commandLine.exclude("plan", option);
    if (takesFolder(commandLine)) {
        throw UsageError(
            "--plan applies to one video, expected a single video instead of a folder");
    }
    VideoChunkOptions options;
    options.seconds = commandLine.number(kLength, 1, 86400).value_or(options.seconds);
    VideoJob job;
    job.plan = planVideo(commandLine);
    if (!job.plan.isFile) requireFile(job.plan.input);
    prepareVideo(commandLine, job, messages);
    VideoConversion conversion = openVideo(commandLine, job, messages);
    catchStop();
    VideoProgressLine progress(VideoProgressLine::json(commandLine), {});
    const VideoChunkPlan made =
        planVideoChunks(std::move(conversion), folder, options, [&](const VideoProgress& now) {
            progress.update(now);
            return !isStopWanted();
        });
    progress.end(made.cancelled ? "stopped" : "done");
    if (made.cancelled) {
        messages.warn("stopped; no plan was made");
        return kExitStopped;
    }
    messages.warn(made.notes);
    keepCommandLine(folder, arguments, commandLine, job.display);
    const auto depthOnly = std::count_if(made.chunks.begin(), made.chunks.end(),
                                         [](const VideoChunk& chunk) { return chunk.frames == 0; });
    messages.say(folder.string() + ": " + counted(made.chunks.size(), "chunk") +
                 (depthOnly > 0 ? ", the first " + std::to_string(depthOnly) + " of depth alone"
                                : std::string()) +
                 ", " + counted(made.frames, "frame") + ", " + clockText(made.end) +
                 "; depth that is made twice: " + shareText(made.repeatedFrames, made.frames) +
                 "; planned in " + fixed(made.seconds, 1) + " s");
    return kExitDone;
}

int makeChunk(const ChunkCall& call, PlannedRun& run, bool json, Messages& messages) {
    catchStop();
    repeatEncoder(run.job.encoding);
    const std::string task = std::to_string(call.number);
    const std::string name = call.folder.string() + ": chunk " + task;
    VideoProgressLine progress(json, {});
    logLine(call, "begins chunk " + task);
    const VideoConversionResult result = makeVideoChunk(std::move(run.conversion), call.folder,
                                                        call.number, [&](const VideoProgress& now) {
                                                            progress.update(now);
                                                            return !isStopWanted();
                                                        });
    progress.end(result.cancelled ? "stopped" : "done");
    messages.warn(result.notes);
    if (result.cancelled) {
        logLine(call, "was stopped");
        messages.warn("chunk " + task + " was stopped; the same command makes it");
        return kExitStopped;
    }
    if (result.keptFrames > 0 || (result.frames == 0 && result.pipeline.stages.empty())) {
        logLine(call, "chunk " + task + " is made already");
        messages.say(name + " is made already");
        return kExitDone;
    }
    const double seconds = result.seconds();
    const bool isDepthAlone = result.frames == 0;
    const std::int64_t made = isDepthAlone ? result.pipeline.stages.front().frames : result.frames;
    const std::string line = std::string("made ") + (isDepthAlone ? "the depth of " : "") +
                             counted(made, "frame") + " in " + fixed(seconds, 1) + " s, " +
                             fixed(seconds > 0 ? static_cast<double>(made) / seconds : 0, 1) +
                             " fps on " + hostName();
    logLine(call, line);
    messages.say(name + ": " + line);
    return kExitDone;
}

int join(const ChunkCall& call, PlannedRun& run, bool replace, bool json, Messages& messages) {
    const fs::path output = run.conversion.output;
    std::error_code error;
    const fs::path mark = call.folder / kJoined;
    const std::string there = fileStamp(output);
    if (!there.empty() && fs::exists(mark, error) && readFile(mark, 1000) == there) {
        messages.say(output.string() + " is made already");
        return kExitDone;
    }
    Outputs outputs(replace || run.commandLine->has("y"));
    outputs.addInput(run.job.plan.input);
    outputs.addOutput(output);
    outputs.check();
    catchStop();
    VideoProgressLine progress(json, {});
    const VideoConversionResult result =
        joinVideoChunks(std::move(run.conversion), call.folder, [&](const VideoProgress& now) {
            progress.update(now);
            return !isStopWanted();
        });
    progress.end(result.cancelled ? "stopped" : "done");
    if (result.cancelled) {
        messages.warn("stopped; " + output.string() + " was not made");
        return kExitStopped;
    }
    messages.warn(result.notes);
    writeFile(mark, fileStamp(output));
    const std::string line = output.string() + ": " + counted(result.frames, "frame") + ", " +
                             clockText(result.end) + "; joined in " +
                             fixed(result.finishSeconds, 1) + " s";
    logLine(call, line);
    messages.say(line);
    return kExitDone;
}

} // namespace

void addVideoChunkOptions(CommandLine& commandLine) {
    addChunkOptions(commandLine, kLength, "Length of a chunk of --plan in seconds (default 60).",
                    "SECONDS", "Check the chunks of the plan in this folder, and write OUT.");
}

bool isForVideoChunks(const CommandLine& commandLine) {
    return isForChunks(commandLine, kLength);
}

int runVideoChunks(const CommandLine& commandLine, const std::vector<std::string>& arguments,
                   const std::function<void(CommandLine&)>& addOptions, Messages& messages) {
    const bool json = VideoProgressLine::json(commandLine);
    if (json) messages.leaveStandardOutput();
    const ChunkCall call = chunkCall(commandLine);
    if (call.task == ChunkCall::Task::Plan)
        return plan(commandLine, arguments, call.folder, messages);
    return runLogged(call, [&] {
        PlannedRun run;
        openPlanned(call.folder, commandLine.name(), addOptions, run, messages);
        return call.task == ChunkCall::Task::Chunk
                   ? makeChunk(call, run, json, messages)
                   : join(call, run, commandLine.has("y"), json, messages);
    });
}

} // namespace altiro3D::tools
