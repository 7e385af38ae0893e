#include "common/video_chunk_run.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/video_chunks.hpp"
#include "common/folder_run.hpp"
#include "common/outputs.hpp"
#include "common/video_job.hpp"
#include "common/video_plan.hpp"
#include "common/video_progress.hpp"
#include "common/video_run.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <optional>
#include <system_error>
#include <unistd.h>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr const char* kArguments = "arguments";
constexpr const char* kCalibration = "visual.json";
constexpr const char* kJoined = "joined"; // size and time of the output that was written
constexpr std::uintmax_t kMaxArguments = std::uintmax_t{1} << 22;
constexpr std::uintmax_t kMaxCalibration = std::uintmax_t{1} << 24;

std::string hostName() {
    std::array<char, 256> name{};
    if (gethostname(name.data(), name.size() - 1) != 0) return "an unknown host";
    return name.data();
}

// An error of a task names the machine, because others make other chunks.
Error onThisHost(const Error& error) {
    const std::string text = error.what(); // "subject: problem"
    const std::size_t end = text.find(": ");
    if (end == std::string::npos) return error;
    return {error.code(), text.substr(0, end), text.substr(end + 2) + " (on " + hostName() + ")"};
}

std::string timeText() {
    const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    std::tm parts{};
    gmtime_r(&now, &parts);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text.data();
}

// Adds a line to the log of a task. A log that cannot be written does not stop the work.
void logLine(const fs::path& folder, const std::string& task, const std::string& line) {
    std::ofstream log(folder / "logs" / (task + ".log"), std::ios::app);
    log << timeText() + " " + hostName() + " " + oneLine(line) + "\n";
}

// The part of a run that its plan states.
struct PlannedRun {
    std::optional<CommandLine> commandLine;
    VideoJob job;
    VideoConversion conversion;
};

void prepare(PlannedRun& run, Messages& messages) {
    run.job.plan = planVideo(*run.commandLine);
    run.job.plan.isChecked = true; // the plan has checked the names
    prepareVideo(*run.commandLine, run.job, messages);
    run.conversion = openVideo(*run.commandLine, run.job, messages);
}

// Networks and encoders give other bits with another number of threads, so a machine with fewer
// processors takes the plan's number as well. TBB's warning about that is not of use.
void useThreads(int threads) {
    cv::setNumThreads(threads);
    if (threads <= cv::getNumberOfCPUs()) return;
    const QuietStandardError quiet;
    cv::parallel_for_(cv::Range(0, threads), [](const cv::Range&) {});
}

// Opens the run of a plan as the plan's command line did, in its working directory.
// @param folder absolute
void openPlanned(const fs::path& folder, const std::string& tool,
                 const std::function<void(CommandLine&)>& addOptions, PlannedRun& run,
                 Messages& messages) {
    const VideoChunkPlan plan = readVideoChunks(folder);
    const fs::path file = folder / kArguments;
    const std::string text = readFile(file, kMaxArguments);
    std::vector<std::string> words;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\0', at);
        if (end == std::string::npos) break;
        words.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    if (words.size() < 2 || text.back() != '\0') {
        throw Error(ErrorCode::BadFormat, file.string(),
                    "is damaged, expected the command line of the plan; make the plan again");
    }
    const std::string place = words.front();
    std::error_code error;
    fs::current_path(place, error);
    if (error) {
        throw Error(ErrorCode::NotFound, place,
                    "cannot be entered: " + error.message() +
                        ", expected the folder in which the plan was made, shared by all machines");
    }
    std::vector<char*> pointers;
    for (std::size_t i = 1; i < words.size(); ++i)
        pointers.push_back(words[i].data());
    run.commandLine.emplace(tool, "");
    addOptions(*run.commandLine);
    run.commandLine->add({"v", "verbose"}, "");
    run.commandLine->add({"j"}, "", "N");
    try {
        run.commandLine->parse(static_cast<int>(pointers.size()), pointers.data());
        useThreads(plan.threads);
        prepare(run, messages);
    } catch (const UsageError& problem) {
        throw Error(ErrorCode::BadFormat, file.string(),
                    std::string("is of another version: ") + problem.what());
    }
}

// Keeps the words of the command line, with the calibration that was found.
void keepArguments(const fs::path& folder, std::vector<std::string> words,
                   const CommandLine& commandLine, const VideoJob& job) {
    const bool isNamed = commandLine.has("c") || commandLine.has("m");
    if (!isNamed && !job.display.files.empty()) {
        const fs::path copy = folder / kCalibration;
        writeFile(copy, readFile(job.display.files.front(), kMaxCalibration));
        words.insert(words.begin() + 1, {"-c", copy.string()});
    }
    std::string text = fs::current_path().string() + '\0';
    for (const std::string& word : words)
        text += word + '\0';
    writeFile(folder / kArguments, text);
}

std::string shareText(std::int64_t part, std::int64_t whole) {
    return fixed(100 * static_cast<double>(part) / static_cast<double>(whole), 1) + " %";
}

int plan(const CommandLine& commandLine, const std::vector<std::string>& arguments,
         const fs::path& folder, Messages& messages) {
    for (const char* option : {"chunk", "join", "show", "resume", "report", "recursive"})
        commandLine.exclude("plan", option);
    if (takesFolder(commandLine)) {
        throw UsageError(
            "--plan applies to one video, expected a single video instead of a folder");
    }
    VideoChunkOptions options;
    options.seconds = commandLine.number("chunk-seconds", 1, 86400).value_or(options.seconds);
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
    keepArguments(folder, arguments, commandLine, job);
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

// Only the options of this call; all others are those of the plan.
void requireNoOthers(const CommandLine& commandLine, const std::string& option) {
    for (const auto& [given, value] : commandLine.given()) {
        const bool isOurs = given == option || given == "v" || given == "progress" ||
                            (given == "y" && option == "join");
        if (isOurs) continue;
        throw UsageError("--" + option + " takes its settings from the plan, expected no " +
                         (given.size() > 1 ? "--" : "-") + given);
    }
}

int makeChunk(const fs::path& folder, int number, PlannedRun& run, bool json, Messages& messages) {
    catchStop();
    repeatEncoder(run.job.encoding);
    const std::string task = std::to_string(number);
    const std::string name = folder.string() + ": chunk " + task;
    VideoProgressLine progress(json, {});
    logLine(folder, task, "begins chunk " + task);
    const VideoConversionResult result =
        makeVideoChunk(std::move(run.conversion), folder, number, [&](const VideoProgress& now) {
            progress.update(now);
            return !isStopWanted();
        });
    progress.end(result.cancelled ? "stopped" : "done");
    messages.warn(result.notes);
    if (result.cancelled) {
        logLine(folder, task, "was stopped");
        messages.warn("chunk " + task + " was stopped; the same command makes it");
        return kExitStopped;
    }
    if (result.keptFrames > 0 || (result.frames == 0 && result.pipeline.stages.empty())) {
        logLine(folder, task, "chunk " + task + " is made already");
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
    logLine(folder, task, line);
    messages.say(name + ": " + line);
    return kExitDone;
}

// The size and the time of a file as text; empty if there is none.
std::string stampOf(const fs::path& file) {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    const auto time = fs::last_write_time(file, error).time_since_epoch().count();
    return error ? std::string() : std::to_string(bytes) + " " + std::to_string(time);
}

int join(const fs::path& folder, PlannedRun& run, bool replace, bool json, Messages& messages) {
    const fs::path output = run.conversion.output;
    std::error_code error;
    const fs::path mark = folder / kJoined;
    const std::string there = stampOf(output);
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
        joinVideoChunks(std::move(run.conversion), folder, [&](const VideoProgress& now) {
            progress.update(now);
            return !isStopWanted();
        });
    progress.end(result.cancelled ? "stopped" : "done");
    if (result.cancelled) {
        messages.warn("stopped; " + output.string() + " was not made");
        return kExitStopped;
    }
    messages.warn(result.notes);
    writeFile(mark, stampOf(output));
    const std::string line = output.string() + ": " + counted(result.frames, "frame") + ", " +
                             clockText(result.end) + "; joined in " +
                             fixed(result.finishSeconds, 1) + " s";
    logLine(folder, "join", line);
    messages.say(line);
    return kExitDone;
}

} // namespace

void addChunkOptions(CommandLine& commandLine) {
    commandLine.addSection("Many machines");
    commandLine.addAdvanced({"plan"},
                            "Divide the run into chunks, and write the plan to the folder PLAN, "
                            "which all machines must see.",
                            "DIR");
    commandLine.addAdvanced({"chunk-seconds"},
                            "Length of a chunk of --plan in seconds (default 60).", "SECONDS");
    commandLine.addAdvanced({"chunk"}, "Make chunk K of the plan in the folder PLAN.", "K");
    commandLine.addAdvanced({"join"}, "Check the chunks of the plan in this folder, and write OUT.",
                            "DIR");
}

bool isForChunks(const CommandLine& commandLine) {
    if (commandLine.has("chunk-seconds") && !commandLine.has("plan"))
        throw UsageError("--chunk-seconds is a setting of --plan, expected --plan DIR");
    return commandLine.has("plan") || commandLine.has("chunk") || commandLine.has("join");
}

int runChunks(const CommandLine& commandLine, const std::vector<std::string>& arguments,
              const std::function<void(CommandLine&)>& addOptions, Messages& messages) {
    const bool json = VideoProgressLine::json(commandLine);
    if (json) messages.leaveStandardOutput();
    if (const auto folder = commandLine.value("plan"))
        return plan(commandLine, arguments, fs::absolute(*folder), messages);
    commandLine.exclude("chunk", "join");
    const bool isChunk = commandLine.has("chunk");
    requireNoOthers(commandLine, isChunk ? "chunk" : "join");
    const std::size_t names = isChunk ? 1 : 0;
    if (commandLine.files().size() != names) {
        throw UsageError(isChunk ? "--chunk takes the folder of a plan, expected --chunk K PLAN"
                                 : "--join takes all names from the plan, expected --join PLAN");
    }
    const fs::path folder =
        fs::absolute(isChunk ? commandLine.files().front() : fs::path(*commandLine.value("join")));
    const int number = isChunk ? *commandLine.wholeNumber("chunk", 1, 1000000) : 0;
    try {
        PlannedRun run;
        openPlanned(folder, commandLine.name(), addOptions, run, messages);
        return isChunk ? makeChunk(folder, number, run, json, messages)
                       : join(folder, run, commandLine.has("y"), json, messages);
    } catch (const Error& error) {
        logLine(folder, isChunk ? std::to_string(number) : "join",
                std::string("failed: ") + onThisHost(error).what());
        throw onThisHost(error);
    }
}

} // namespace altiro3D::tools
