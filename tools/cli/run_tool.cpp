#include "cli/run_tool.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/version.hpp"
#include "cli/json_text.hpp"

#include <QCoreApplication>
#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <clocale>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <limits>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <system_error>
#include <unistd.h>

namespace altiro3D::tools {

using Json = nlohmann::ordered_json;

namespace {

struct Console {
    std::mutex mutex;
    bool showsStatus = false;
} console;

void put(std::FILE* stream, const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stream);
    std::fflush(stream);
}

// The caller holds the mutex.
void takeStatusAway() {
    if (console.showsStatus) put(stderr, "\r\033[K");
    console.showsStatus = false;
}

std::atomic<int> stopSignal{0}; // the signal that the user has sent

// The first signal ends the video with a complete file; a second one ends the process.
extern "C" void stopOnce(int signal) {
    stopSignal.store(signal);
    std::signal(signal, SIG_DFL);
}

// Standard output may be a full disk or a closed pipe: then the user has not got the answer.
int finish(const Messages& messages, int status) {
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0)
        return status == kExitStopped ? 128 + stopSignal.load() : status; // as in shells
    messages.fail("standard output cannot be written");
    return kExitFailed;
}

// Prints a text such as the help. Its reader may close the pipe early, as head(1) does.
int answer(const Messages& messages, const std::string& text) {
    errno = 0;
    const bool written = std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0;
    return errno == EPIPE && !written ? kExitDone : finish(messages, kExitDone);
}

// Standard error belongs to the process: the first object turns it off, the last one on again.
struct Quiet {
    std::mutex mutex;
    int users = 0;
    int saved = -1;
} quiet;

} // namespace

void catchStop() {
    std::signal(SIGINT, stopOnce);
    std::signal(SIGTERM, stopOnce);
}

bool isStopWanted() {
    return stopSignal.load() != 0;
}

void endIfStopWanted() {
    if (isStopWanted()) throw Stopped();
}

const char* stateName(int exitStatus) {
    return exitStatus == kExitDone ? "done" : exitStatus == kExitStopped ? "stopped" : "failed";
}

void writeLine(std::FILE* stream, const std::string& line) {
    const std::lock_guard<std::mutex> lock(console.mutex);
    if (isatty(fileno(stream)) != 0) takeStatusAway();
    put(stream, line + '\n');
}

bool hasStatusLine() {
    return isatty(STDERR_FILENO) != 0;
}

void showStatus(const std::string& text) {
    if (!hasStatusLine()) return;
    const std::lock_guard<std::mutex> lock(console.mutex);
    // Line wrap is off, because only the last row of a wrapped line could be erased.
    put(stderr, "\r\033[K\033[?7l" + text + "\033[?7h");
    console.showsStatus = true;
}

void clearStatus() {
    const std::lock_guard<std::mutex> lock(console.mutex);
    takeStatusAway();
}

std::string sizeText(cv::Size size) {
    return std::to_string(size.width) + " x " + std::to_string(size.height) + " px";
}

std::string oneLine(std::string text) {
    return withoutControls(std::move(text));
}

void Messages::say(const std::string& line) const {
    if (text_ != nullptr && (!quiet_ || verbose_)) writeLine(text_, oneLine(ofSubject(line)));
}

void Messages::warn(const std::string& line) {
    const std::string text = oneLine(line);
    if (std::find(all_.begin(), all_.end(), text) != all_.end()) return;
    all_.push_back(text);
    waiting_.push_back(text);
}

void Messages::warn(const std::vector<std::string>& lines) {
    for (const std::string& line : lines)
        warn(line);
}

void Messages::warn(const Notes& notes) {
    for (const Note& note : notes)
        warn(note.text);
}

void Messages::flushWarnings() {
    for (const std::string& line : waiting_)
        writeLine(stderr, tool_ + ": warning: " + line);
    waiting_.clear();
}

void Messages::dropWarnings() {
    all_.resize(all_.size() - waiting_.size()); // those that wait are the newest
    waiting_.clear();
}

void Messages::fail(const std::string& line) const {
    writeLine(stderr, tool_ + ": error: " + oneLine(line));
}

void StageTimes::end(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    stages_.emplace_back(stage, std::chrono::duration<double, std::milli>(now - last_).count());
    last_ = now;
}

double fastestMilliseconds(const std::function<void()>& work, double enough) {
    double fastest = std::numeric_limits<double>::infinity();
    double total = 0;
    for (int i = 0; i < 3 && total < enough; ++i) {
        StageTimes times;
        work();
        times.end("work");
        const double taken = times.milliseconds().front().second;
        fastest = std::min(fastest, taken);
        total += taken;
    }
    return fastest;
}

std::string StageTimes::text() const {
    std::string text;
    for (const auto& [stage, milliseconds] : stages_)
        text += (text.empty() ? "" : ", ") + stage + " " + fixed(milliseconds, 1) + " ms";
    return text;
}

double peakMegabytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.compare(0, 6, "VmHWM:") == 0) return std::atof(line.c_str() + 6) / 1024;
    }
    return 0;
}

void resetPeakMemory() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

Progress::Progress(std::size_t steps, std::string unit) : steps_(steps), unit_(std::move(unit)) {}

Progress::~Progress() {
    clear();
}

double Progress::secondsLeft() const {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
    return spent.count() / static_cast<double>(done_) * static_cast<double>(steps_ - done_);
}

void Progress::step(const std::string& what, const std::filesystem::path& input) {
    if (!unit_.empty()) {
        Json line = {{"state", "running"},
                     {unit_ + "s", done_},
                     {unit_ + "sInAll", steps_},
                     {"share", static_cast<double>(done_) / static_cast<double>(steps_)}};
        if (done_ > 0) line["secondsLeft"] = secondsLeft();
        line["input"] = input.string();
        writeProgress(line);
    } else if (steps_ > 1) {
        std::string text = "[" + std::to_string(done_ + 1) + "/" + std::to_string(steps_) + "] ";
        if (done_ > 0) text += "(" + fixed(secondsLeft(), 0) + " s left) ";
        showStatus(text + oneLine(what));
    }
    ++done_;
}

void Progress::end(int exitStatus, std::size_t ended) {
    clear();
    if (!unit_.empty()) writeProgress({{"state", stateName(exitStatus)}, {unit_ + "s", ended}});
}

QuietStandardError::QuietStandardError() {
    const std::lock_guard<std::mutex> lock(quiet.mutex);
    if (quiet.users++ > 0) return;
    std::fflush(stderr);
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (null < 0) return;
    quiet.saved = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    if (quiet.saved >= 0) dup2(null, STDERR_FILENO);
    close(null);
}

QuietStandardError::~QuietStandardError() {
    const std::lock_guard<std::mutex> lock(quiet.mutex);
    if (--quiet.users > 0 || quiet.saved < 0) return;
    std::fflush(stderr);
    dup2(quiet.saved, STDERR_FILENO);
    close(quiet.saved);
    quiet.saved = -1;
}

std::string fixed(double value, int decimals) {
    char text[512]; // of any double
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    return text;
}

std::optional<std::string> environment(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0' ? std::optional<std::string>(value) : std::nullopt;
}

std::filesystem::path cacheDirectory() {
    const auto cache = environment("XDG_CACHE_HOME");
    if (cache && std::filesystem::path(*cache).is_absolute())
        return std::filesystem::path(*cache) / "altiro3D";
    if (const auto home = environment("HOME"))
        return std::filesystem::path(*home) / ".cache" / "altiro3D";
    return {};
}

bool isThere(const std::filesystem::path& name) {
    std::error_code error;
    return std::filesystem::exists(name, error);
}

bool isFile(const std::filesystem::path& name) {
    std::error_code error;
    return std::filesystem::is_regular_file(name, error);
}

bool isDirectory(const std::filesystem::path& name) {
    std::error_code error;
    return std::filesystem::is_directory(name, error);
}

std::string lowerCase(std::string text) {
    for (char& c : text)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

std::string sentenceOf(const std::exception& error) {
    if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
        return "out of memory, expected more free memory or smaller pictures";
    }
    const auto* const fromSystem = dynamic_cast<const std::system_error*>(&error);
    if (fromSystem != nullptr &&
        fromSystem->code() == std::errc::resource_unavailable_try_again) { // of std::thread
        return "no thread can be started, expected more memory or processes to be allowed";
    }
    std::string text = error.what();
    if (const auto* fromOpenCv = dynamic_cast<const cv::Exception*>(&error)) {
        text = fromOpenCv->code == cv::Error::StsNoMem
                   ? "out of memory, expected more free memory or smaller pictures"
                   : "OpenCV: " + fromOpenCv->err;
    }
    return oneLine(text);
}

std::string codeOf(const std::exception& error) {
    if (const auto* known = dynamic_cast<const Error*>(&error)) return errorCodeName(known->code());
    if (dynamic_cast<const UsageError*>(&error) != nullptr) return "Usage";
    const auto* const fromOpenCv = dynamic_cast<const cv::Exception*>(&error);
    const bool isMemory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                          (fromOpenCv != nullptr && fromOpenCv->code == cv::Error::StsNoMem);
    return isMemory ? errorCodeName(ErrorCode::OutOfMemory) : "Unknown";
}

int runTool(int argc, char** argv, CommandLine& commandLine,
            const std::function<int(const CommandLine&, Messages&)>& body) {
    const QCoreApplication application(argc, argv);
    std::setlocale(LC_NUMERIC, "C"); // Qt takes the user's; numbers in files have a point
    return runToolWithoutApplication(argc, argv, commandLine, body);
}

int runToolWithoutApplication(int argc, char** argv, CommandLine& commandLine,
                              const std::function<int(const CommandLine&, Messages&)>& body) {
    std::signal(SIGPIPE, SIG_IGN); // a closed pipe is a failed write, not the end of the process
    std::signal(SIGXFSZ, SIG_IGN); // and so is a file beyond the user's limit
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });

    commandLine.addSection("General");
    commandLine.addAdvanced({"j"}, "Use N threads (default: all processors).", "N");
    commandLine.add({"v", "verbose"}, "Print what is done and how long each stage takes.");
    commandLine.add({"h", "help"}, "Show this help.");
    commandLine.add({"version"}, "Show the version.");
    if (commandLine.hasMore()) {
        commandLine.add({"help-all"}, "Show all options.");
    } else {
        commandLine.addHidden("help-all"); // the same
    }
    commandLine.addHidden("help-man");
    commandLine.addHidden("help-completion", "SHELL");
    Messages messages(commandLine.name(), false);
    try {
        commandLine.parse(argc, argv);
        if (commandLine.has("help-all")) return answer(messages, commandLine.help(true));
        if (commandLine.has("help")) return answer(messages, commandLine.help(false));
        if (commandLine.has("help-man")) return answer(messages, commandLine.manPage(version()));
        if (const auto shell = commandLine.choice("help-completion", {"bash", "zsh"})) {
            return answer(messages,
                          *shell == 0 ? commandLine.bashCompletion() : commandLine.zshCompletion());
        }
        if (commandLine.has("version"))
            return answer(messages, commandLine.name() + " (altiro3D) " + version() + "\n");
        if (const auto threads = commandLine.wholeNumber("j", 1, 1024)) {
            // more than there are processors gain nothing, and TBB would complain of them
            cv::setNumThreads(std::min(*threads, cv::getNumberOfCPUs()));
        }
        messages = Messages(commandLine.name(), commandLine.has("verbose"));
        messages.warn(commandLine.warnings());
        const int status = body(commandLine, messages);
        messages.flushWarnings();
        return finish(messages, status);
    } catch (const UsageError& error) {
        messages.fail(sentenceOf(error));
        return kExitUsage;
    } catch (const Stopped&) {
        messages.dropWarnings();
        messages.warn("stopped; the output was not made");
        messages.flushWarnings();
        return finish(messages, kExitStopped);
    } catch (const std::exception& error) {
        messages.fail(sentenceOf(error));
        tellEarlyFailure(commandLine, error);
        return kExitFailed;
    } catch (...) {
        messages.fail("unknown failure");
        return kExitFailed;
    }
}

} // namespace altiro3D::tools
