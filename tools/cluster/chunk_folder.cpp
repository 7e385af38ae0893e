#include "cluster/chunk_folder.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"

#include <QDateTime>
#include <fstream>
#include <opencv2/core.hpp>
#include <system_error>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr const char* kArguments = "arguments";
constexpr const char* kCalibration = "visual.json";
constexpr std::uintmax_t kMaxWords = std::uintmax_t{256} << 20;
constexpr std::uintmax_t kMaxCalibration = std::uintmax_t{1} << 24;

// An error of a task names the machine, because others make other chunks.
Error onThisHost(const Error& error) {
    const std::string text = error.what(); // "subject: problem"
    const std::size_t end = text.find(": ");
    if (end == std::string::npos) return error;
    return {error.code(), text.substr(0, end), text.substr(end + 2) + " (on " + hostName() + ")"};
}

// Networks and encoders give other bits with another number of threads, so a machine with fewer
// processors takes the plan's number as well. TBB's warning about that is not of use.
void useThreads(int threads) {
    cv::setNumThreads(threads);
    if (threads <= cv::getNumberOfCPUs()) return;
    const QuietStandardError quiet;
    cv::parallel_for_(cv::Range(0, threads), [](const cv::Range&) {});
}

// Refuses options that are not of this call, as the plan states them. @param option "chunk", "join"
void requireNoOthers(const CommandLine& commandLine, const std::string& option) {
    for (const auto& [given, value] : commandLine.given()) {
        const bool isOurs = given == option || given == "v" || given == "progress" ||
                            (given == "y" && option == "join");
        if (isOurs) continue;
        throw UsageError("--" + option + " takes its settings from the plan, expected no " +
                         (given.size() > 1 ? "--" : "-") + given);
    }
}

} // namespace

void failDamaged(const fs::path& file) {
    throw Error(ErrorCode::BadFormat, file.string(),
                "is damaged, expected the file as it was written; make the plan again");
}

void writeWords(const fs::path& file, const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += word + '\0';
    writeFile(file, text);
}

std::vector<std::string> readWords(const fs::path& file) {
    const std::string text = readFile(file, kMaxWords);
    std::vector<std::string> words;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\0', at);
        if (end == std::string::npos) failDamaged(file);
        words.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return words;
}

void addChunkOptions(CommandLine& commandLine, const std::string& length,
                     const std::string& lengthHelp, const std::string& lengthValue,
                     const std::string& joinHelp) {
    commandLine.addSection("Many machines");
    commandLine.addAdvanced({"plan"},
                            "Divide the run into chunks, and write the plan to this folder, which "
                            "all machines must see.",
                            "DIR");
    commandLine.addAdvanced({length}, lengthHelp, lengthValue);
    commandLine.addAdvanced({"chunk"}, "Make chunk K of the plan in the folder PLAN.", "K");
    commandLine.addAdvanced({"join"}, joinHelp, "DIR");
}

std::optional<ChunkCall> chunkCall(const CommandLine& commandLine, const std::string& length) {
    commandLine.refuseWithout("plan", {length.c_str()},
                              " is a setting of --plan, expected --plan DIR");
    commandLine.exclude("plan", {"chunk", "join"});
    commandLine.exclude("chunk", "join");
    using Task = ChunkCall::Task;
    std::optional<Task> task;
    ChunkCall call;
    commandLine.take({{"plan", task, Task::Plan},
                      {"plan", call.folder},
                      {"join", task, Task::Join},
                      {"join", call.folder},
                      {"chunk", task, Task::Chunk}});
    if (!task) return std::nullopt;
    call.task = *task;
    if (call.task != Task::Plan) {
        const bool isChunk = call.task == Task::Chunk;
        requireNoOthers(commandLine, isChunk ? "chunk" : "join");
        if (commandLine.files().size() != (isChunk ? 1 : 0))
            throw UsageError(isChunk
                                 ? "--chunk takes the folder of a plan, expected --chunk K PLAN"
                                 : "--join takes all names from the plan, expected --join PLAN");
        if (isChunk) call.folder = commandLine.files().front();
    }
    commandLine.take({{"chunk", call.number, 1, 1000000}});
    call.folder = fs::absolute(call.folder);
    return call;
}

void keepCommandLine(const fs::path& folder, std::vector<std::string> words,
                     const DisplayOptions& options, const ChosenDisplay& display) {
    const bool isNamed = !options.calibration.empty() || !options.map.empty();
    if (!isNamed && !display.files.empty()) {
        const fs::path copy = folder / kCalibration;
        writeFile(copy, readFile(display.files.front(), kMaxCalibration));
        words.insert(words.begin() + 1, {"-c", copy.string()});
    }
    words.insert(words.begin(), fs::current_path().string());
    writeWords(folder / kArguments, words);
}

void openCommandLine(const fs::path& folder, const std::string& tool, int threads,
                     const std::function<void(CommandLine&)>& addOptions,
                     const std::function<void(const CommandLine&)>& open) {
    std::vector<std::string> words = readWords(folder / kArguments);
    if (words.size() < 2) failDamaged(folder / kArguments);
    const std::string place = words.front();
    std::error_code error;
    fs::current_path(place, error);
    if (error) {
        throw Error(ErrorCode::NotFound, place,
                    "cannot be entered: " + error.message() +
                        ", expected the folder in which the plan was made, shared by all machines");
    }
    CommandLine commandLine(tool, "");
    addOptions(commandLine);
    commandLine.add({"v", "verbose"}, "");
    commandLine.add({"j"}, "", "N");
    try {
        commandLine.parse({words.begin() + 1, words.end()});
        useThreads(threads);
        open(commandLine);
    } catch (const UsageError& problem) {
        throw Error(ErrorCode::BadFormat, (folder / kArguments).string(),
                    std::string("is of another version: ") + problem.what());
    }
}

void logLine(const ChunkCall& call, const std::string& line) {
    std::ofstream log(call.folder / "logs" / (call.logName() + ".log"), std::ios::app);
    const std::string time = QDateTime::currentDateTimeUtc().toString(Qt::ISODate).toStdString();
    log << time + " " + hostName() + " " + oneLine(line) + "\n";
}

int runLogged(const ChunkCall& call, const std::function<int()>& work) {
    try {
        return work();
    } catch (const Error& error) {
        logLine(call, std::string("failed: ") + onThisHost(error).what());
        throw onThisHost(error);
    }
}

std::string rangesText(const std::vector<int>& numbers) {
    std::string text;
    for (std::size_t i = 0; i < numbers.size();) {
        std::size_t end = i + 1;
        while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1)
            ++end;
        if (!text.empty()) text += ",";
        text += std::to_string(numbers[i]);
        if (end > i + 1) text += "-" + std::to_string(numbers[end - 1]);
        i = end;
    }
    return text;
}

} // namespace altiro3D::tools
