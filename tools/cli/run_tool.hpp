#pragma once

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "cli/system.hpp"

#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::tools {

// The exit statuses of all tools; kExitStatuses explains them.
constexpr int kExitDone = 0;
constexpr int kExitFailed = 1;
constexpr int kExitUsage = 2;
constexpr int kExitStopped = 130; ///< By the user; runTool() makes it 143 for SIGTERM.

/// The exit statuses and their meaning, for the manual.
constexpr std::pair<const char*, const char*> kExitStatuses[] = {
    {"0", "Done."},
    {"1", "Failed, or some of several files failed: each error is one line on standard error."},
    {"2", "Wrong usage: nothing was done."},
    {"130", "Stopped by Ctrl-C (SIGINT). A second Ctrl-C ends a tool that is still finishing."},
    {"143", "Stopped by SIGTERM."}};

/// How a run ended, for reports and `--progress json`: "done", "failed" or "stopped".
const char* stateName(int exitStatus);

/// Lets the first Ctrl-C or SIGTERM set isStopWanted(), and a second one end the process.
void catchStop();
bool isStopWanted();
/// Thrown where work ends because the user has stopped it.
struct Stopped {};
/// @throws Stopped if isStopWanted()
void endIfStopWanted();

/// The stages of the work and their times.
class StageTimes {
  public:
    /// Ends the stage that began with the last call or the construction.
    void end(const std::string& stage);
    /// Adds a stage that was timed elsewhere.
    void add(const std::string& stage, double milliseconds) {
        stages_.emplace_back(stage, milliseconds);
    }
    const std::vector<std::pair<std::string, double>>& milliseconds() const { return stages_; }
    /// "read 12.3 ms, depth 40.1 ms, ..."
    std::string text() const;

  private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
    std::vector<std::pair<std::string, double>> stages_;
};

/// The time that some work takes, in ms: the fastest of three times, because the machine may be
/// busy.
/// @param enough ms, after which the work is not done again
double fastestMilliseconds(const std::function<void()>& work,
                           double enough = std::numeric_limits<double>::infinity());

/// Runs a tool: adds the options of all tools (--help, --version, -v, -j), reads the command line,
/// calls the body and turns every failure into one line and an exit status.
int runTool(int argc, char** argv, CommandLine& commandLine,
            const std::function<int(const CommandLine&, Messages&)>& body);

/// runTool() for a tool whose body makes its own Qt application: one with windows ends the process
/// if there is no desktop, but --help must work there.
int runBody(int argc, char** argv, CommandLine& commandLine,
            const std::function<int(const CommandLine&, Messages&)>& body);

/// Whether a name stands for standard input or standard output: "-".
inline bool isStandardStream(const std::filesystem::path& file) {
    return file == "-";
}
/// A name for people. @param stream "standard input" or "standard output"
std::string nameOf(const std::filesystem::path& file, const char* stream);

// What a name stands for. False for names that cannot be looked up: opening them says why.
bool isThere(const std::filesystem::path& name);
bool isFile(const std::filesystem::path& name); ///< A regular one.
bool isDirectory(const std::filesystem::path& name);

/// The user's directory for what was measured, such as the costs of methods. It need not exist.
/// Empty if the environment does not define one.
std::filesystem::path cacheDirectory();

} // namespace altiro3D::tools
