#include "cli/run_tool.hpp"

#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "cli/json_text.hpp"

#include <QCoreApplication>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <clocale>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>

namespace altiro3D::tools {

namespace {

std::atomic<int> stopSignal{0}; // the signal that the user has sent

// The first signal asks the tool to stop (catchStop()); a second one ends the process.
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

} // namespace

void catchStop() {
    onStop(stopOnce);
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

std::string nameOf(const std::filesystem::path& file, const char* stream) {
    return isStandardStream(file) ? stream : file.string();
}

std::filesystem::path cacheDirectory() {
    const std::filesystem::path caches = userCacheDirectory();
    return caches.empty() ? caches : caches / "altiro3D";
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

int runTool(int argc, char** argv, CommandLine& commandLine,
            const std::function<int(const CommandLine&, Messages&)>& body) {
    const QCoreApplication application(argc, argv);
    std::setlocale(LC_NUMERIC, "C"); // Qt takes the user's; numbers in files have a point
    return runBody(argc, argv, commandLine, body);
}

int runBody(int argc, char** argv, CommandLine& commandLine,
            const std::function<int(const CommandLine&, Messages&)>& body) {
    prepareProcess();
    const std::vector<std::string> arguments = argumentsOf(argc, argv);
    if (answerProbe({arguments.begin() + 1, arguments.end()})) return kExitDone;
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
    std::string report; // as it is before the run
    const auto end = [&](int status, const std::exception* error = nullptr) {
        if (status != kExitDone) outdateReport(commandLine, report, status, error);
        return status;
    };
    try {
        commandLine.parse(arguments);
        commandLine.take({{"report", report}});
        report = fileStamp(report);
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
        const int status = end(body(commandLine, messages));
        messages.flushWarnings();
        return finish(messages, status);
    } catch (const UsageError& error) {
        messages.fail(sentenceOf(error));
        return end(kExitUsage, &error);
    } catch (const Stopped&) {
        messages.dropWarnings();
        messages.warn("stopped; the output was not made");
        messages.flushWarnings();
        return finish(messages, end(kExitStopped));
    } catch (const std::exception& error) {
        messages.fail(sentenceOf(error));
        tellEarlyFailure(commandLine, error);
        return end(kExitFailed, &error);
    } catch (...) {
        messages.fail("unknown failure");
        return end(kExitFailed);
    }
}

} // namespace altiro3D::tools
