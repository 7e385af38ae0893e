#include "video/video_run.hpp"

#include "altiro3D/file_io.hpp"
#include "cli/inputs.hpp"
#include "cli/json_text.hpp"
#include "cluster/chunk_folder.hpp"
#include "video/video_progress.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr const char* kLength = "chunk-seconds";
constexpr const char* kJoined = "joined"; // size and time of the output that was written

// Does work that shows its progress and that Ctrl-C stops.
// @param work takes the receiver of progress and returns a result with `cancelled`
template <typename Work>
auto withProgress(bool json, const Work& work) {
    catchStop();
    VideoProgressLine progress(json, {});
    auto result = work([&](const VideoProgress& now) {
        progress.update(now);
        return !isStopWanted();
    });
    progress.end(result.cancelled ? "stopped" : "done");
    return result;
}

// Says why there is only one chunk, and when many machines do not pay.
void tellGain(const VideoChunkPlan& made, const VideoChunkOptions& options, Messages& messages) {
    const std::string plainly = "; a run without --plan makes the same file";
    if (made.chunks.size() == 1)
        return messages.say(std::string("it does not pay: there is one chunk, because ") +
                            (options.seconds < made.end
                                 ? "a chunk consists of whole segments of the "
                                   "output, of about 6 s each"
                                 : "the video is not longer than a chunk") +
                            plainly);
    // The time with a machine for each chunk, in frames: that of the longest chunk of depth alone,
    // and then that of the longest other chunk.
    constexpr double kDepth = 0.5; // of the time of a frame, by the default network
    double depthAlone = 0;
    double longest = 0;
    for (const VideoChunk& chunk : made.chunks) {
        const double depth = kDepth * static_cast<double>(chunk.first - chunk.begin);
        double& most = chunk.frames == 0 ? depthAlone : longest;
        most = std::max(most, depth + static_cast<double>(chunk.frames));
    }
    constexpr double kGains = 0.8;       // of the time of one run
    constexpr double kShortSeconds = 10; // a chunk takes one or two seconds to start
    const double share = (depthAlone + longest) / static_cast<double>(made.frames);
    const double seconds = made.end / static_cast<double>(made.chunks.size());
    if (share > kGains) {
        messages.say("it does not pay: even with a machine for each chunk it takes about " +
                     fixed(100 * share, 0) +
                     " % of the time of one run, because depth is carried "
                     "through long scenes" +
                     plainly);
    } else if (seconds < kShortSeconds) {
        messages.say("it hardly pays: chunks of " + fixed(seconds, 1) +
                     " s take as long to start as to make" + plainly);
    }
}

int plan(const VideoJob& job, const VideoChunkOptions& options,
         const std::vector<std::string>& arguments, const fs::path& folder, Messages& messages) {
    if (!job.canReadAgain) requireFile(job.input);
    VideoRun run(job, messages);
    VideoConversion conversion = openVideo(run, messages);
    const VideoChunkPlan made = withProgress(job.jsonProgress, [&](const auto& progress) {
        return planVideoChunks(std::move(conversion), folder, options, progress);
    });
    if (made.cancelled) {
        messages.warn("stopped; no plan was made");
        return kExitStopped;
    }
    messages.warn(made.notes);
    keepCommandLine(folder, arguments, job.display, run.display);
    const auto depthOnly = std::count_if(made.chunks.begin(), made.chunks.end(),
                                         [](const VideoChunk& chunk) { return chunk.frames == 0; });
    const double repeated =
        100 * static_cast<double>(made.repeatedFrames) / static_cast<double>(made.frames);
    messages.say(folder.string() + ": " + counted(made.chunks.size(), "chunk") +
                 (depthOnly > 0 ? ", the first " + std::to_string(depthOnly) + " of depth alone"
                                : std::string()) +
                 ", " + counted(made.frames, "frame") + ", " + clockText(made.end) +
                 "; depth that is made twice: " + fixed(repeated, 1) + " %; planned in " +
                 fixed(made.seconds, 1) + " s");
    tellGain(made, options, messages);
    const double most = run.job.encoding.maxRate;
    if (most > 0) {
        messages.say("the pictures take at most about " + bytesText(1e6 / 8 * most * made.end) +
                     " (--max-rate " + fixed(most, 0) + ")");
        tellDecoding(run, most, messages);
    }
    return kExitDone;
}

int makeChunk(const ChunkCall& call, const VideoRun& run, VideoConversion conversion, bool json,
              Messages& messages) {
    repeatEncoder(run.job.encoding);
    const std::string task = std::to_string(call.number);
    const std::string name = call.folder.string() + ": chunk " + task;
    logLine(call, "begins chunk " + task);
    const VideoConversionResult result = withProgress(json, [&](const auto& progress) {
        return makeVideoChunk(std::move(conversion), call.folder, call.number, progress);
    });
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

int join(const ChunkCall& call, const VideoRun& run, VideoConversion conversion, bool json,
         Messages& messages) {
    const fs::path output = conversion.output;
    const fs::path mark = call.folder / kJoined;
    const std::string there = fileStamp(output);
    if (!there.empty() && isThere(mark) && readFile(mark, 1000) == there) {
        messages.say(output.string() + " is made already");
        return kExitDone;
    }
    Outputs outputs(run.job.replace);
    outputs.addInputs({run.job.input});
    outputs.addOutputs({output});
    outputs.check();
    const VideoConversionResult result = withProgress(json, [&](const auto& progress) {
        return joinVideoChunks(std::move(conversion), call.folder, progress);
    });
    if (result.cancelled) {
        messages.warn("stopped; " + output.string() + " was not made");
        return kExitStopped;
    }
    messages.warn(result.notes);
    writeFile(mark, fileStamp(output));
    const std::string line =
        output.string() + ": " + counted(result.frames, "frame") + ", " + clockText(result.end) +
        ", " + bytesAndRateText(static_cast<double>(fs::file_size(output)), result.end) +
        "; joined in " + fixed(result.finishSeconds, 1) + " s";
    logLine(call, line);
    messages.say(line);
    return kExitDone;
}

} // namespace

void addVideoChunkOptions(CommandLine& commandLine) {
    addChunkOptions(commandLine, kLength, "Length of a chunk of --plan in seconds (default 60).",
                    "SECONDS", "Check the chunks of the plan in this folder, and write OUT.");
}

std::optional<int> runVideoChunks(const CommandLine& commandLine,
                                  const std::vector<std::string>& arguments,
                                  const std::function<void(CommandLine&)>& addOptions,
                                  Messages& messages) {
    const std::optional<ChunkCall> called = chunkCall(commandLine, kLength);
    if (!called) return std::nullopt;
    const ChunkCall& call = *called;
    const bool json = wantsJsonProgress(commandLine);
    if (json) messages.leaveStandardOutput();
    if (call.task == ChunkCall::Task::Plan) {
        commandLine.exclude("plan", {"show", "resume", "report", "recursive"});
        const VideoJob job = videoJob(commandLine);
        if (job.isFolder)
            throw UsageError(
                "--plan applies to one video, expected a single video instead of a folder");
        VideoChunkOptions options;
        commandLine.take({{kLength, options.seconds, 1, 86400}});
        return plan(job, options, arguments, call.folder, messages);
    }
    return runLogged(call, [&] {
        std::optional<VideoRun> run;
        VideoConversion conversion;
        messages.setQuiet(true); // the plan has said this
        openCommandLine(call.folder, commandLine.name(), readVideoChunks(call.folder).threads,
                        addOptions, [&](const CommandLine& planned) {
                            VideoJob job = videoJob(planned);
                            job.isChecked = true; // the plan has checked the names
                            conversion = openVideo(run.emplace(job, messages), messages);
                        });
        messages.setQuiet(false);
        commandLine.take({{"y", run->job.replace}});
        const auto work = call.task == ChunkCall::Task::Chunk ? makeChunk : join;
        return work(call, *run, std::move(conversion), json, messages);
    });
}

} // namespace altiro3D::tools
