#pragma once

#include "altiro3D/error.hpp"
#include "cli/command_line.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <opencv2/core/types.hpp>
#include <optional>
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

// All writing to standard output and standard error: whole lines in order and, on a terminal, one
// status line, which is erased before each line.

/// Writes a line, given without its end, and flushes it.
void writeLine(std::FILE* stream, const std::string& line);

/// Whether a status line is visible, i.e. standard error is a terminal.
bool hasStatusLine();
/// Replaces the status line; the text is cut off at the terminal's edge. Does nothing if
/// hasStatusLine() is false.
void showStatus(const std::string& text);
void clearStatus();

/// The messages of a tool.
///
/// Results go to standard output, warnings and errors to standard error, each on one line. Warnings
/// are held back until their work is done, so that a run that fails shows its error only.
class Messages {
  public:
    Messages(std::string tool, bool verbose) : tool_(std::move(tool)), verbose_(verbose) {}

    bool verbose() const { return verbose_; }
    /// Reserves standard output for programs: say() and detail() have no effect from now on.
    void leaveStandardOutput() { text_ = nullptr; }
    /// Reserves standard output for a picture or video: say() and detail() write to standard error.
    void useStandardError() { text_ = stderr; }
    /// say() has no effect, except with `-v`.
    void setQuiet(bool quiet) { quiet_ = quiet; }
    void say(const std::string& line) const;
    /// Writes a text for programs, such as JSON, unchanged.
    void print(const std::string& text) const { writeLine(stdout, text); }
    /// Sets the item that the following messages of say() and detail() begin with, if a run has
    /// several items; empty: none.
    void setSubject(const std::string& subject) { subject_ = subject; }
    bool hasSubject() const { return !subject_.empty(); }
    /// Writes a line if `-v` was given.
    void detail(const std::string& line) const {
        if (verbose_) say(line);
    }
    /// Adds a warning; flushWarnings() shows it. The same text is shown only once.
    void warn(const std::string& line);
    void warn(const std::vector<std::string>& lines);
    void warn(const Notes& notes);
    void warnOfSubject(const std::string& line) { warn(ofSubject(line)); }
    void flushWarnings();
    void dropWarnings();
    /// All warnings so far, shown or pending.
    const std::vector<std::string>& warnings() const { return all_; }
    void fail(const std::string& line) const;

  private:
    std::string ofSubject(const std::string& line) const {
        return subject_.empty() ? line : subject_ + ": " + line;
    }

    std::string tool_;
    bool verbose_;
    bool quiet_ = false;
    std::FILE* text_ = stdout; // null: silent
    std::string subject_;
    std::vector<std::string> waiting_;
    std::vector<std::string> all_;
};

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

/// Peak memory of this process since its start or the last resetPeakMemory(), in MB of 2^20 bytes;
/// 0 if the system does not report it.
double peakMegabytes();
void resetPeakMemory();

/// "1536 x 2048 px"
std::string sizeText(cv::Size size);
/// The text as one line without terminal escape sequences, which file names may contain.
std::string oneLine(std::string text);

/// The progress of work of several steps: a line on a terminal, or JSON lines for programs.
class Progress {
  public:
    /// @param unit "photo": writes JSON lines that count photos, see `--progress json`; empty:
    ///        shows a line if there are several steps
    explicit Progress(std::size_t steps, std::string unit = {});
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    /// Begins a step. @param what for people @param input its file, for JSON
    void step(const std::string& what, const std::filesystem::path& input = {});
    /// Ends the work. @param exitStatus says how @param ended number of steps that ended well
    void end(int exitStatus, std::size_t ended);
    void clear() { clearStatus(); }

  private:
    double secondsLeft() const; // done_ is not 0

    std::size_t steps_;
    std::string unit_;
    std::size_t done_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Discards standard error, to which decoders print by themselves, while an object of this class
/// exists. Messages of other threads are lost as well.
class QuietStandardError {
  public:
    QuietStandardError();
    ~QuietStandardError();
    QuietStandardError(const QuietStandardError&) = delete;
    QuietStandardError& operator=(const QuietStandardError&) = delete;
};

/// Runs a tool: adds the options of all tools (--help, --version, -v, -j), reads the command line,
/// calls the body and turns every failure into one line and an exit status.
int runTool(int argc, char** argv, CommandLine& commandLine,
            const std::function<int(const CommandLine&, Messages&)>& body);

/// runTool() for a tool whose body makes its own Qt application: one with windows ends the process
/// if there is no desktop, but --help must work there.
int runToolWithoutApplication(int argc, char** argv, CommandLine& commandLine,
                              const std::function<int(const CommandLine&, Messages&)>& body);

std::string fixed(double value, int decimals);

// What a name stands for. False for names that cannot be looked up: opening them says why.
bool isThere(const std::filesystem::path& name);
bool isFile(const std::filesystem::path& name); ///< A regular one.
bool isDirectory(const std::filesystem::path& name);

/// ASCII letters in lower case, all else as it is.
std::string lowerCase(std::string text);

/// The value of an environment variable; nothing if it is not set or empty.
std::optional<std::string> environment(const char* name);

/// The user's directory for cached look-up tables and measured costs. It need not exist. Empty if
/// the environment does not define one.
std::filesystem::path cacheDirectory();

std::string sentenceOf(const std::exception& error);
/// The code of an error for reports: errorCodeName(), or "Usage" or "Unknown".
std::string codeOf(const std::exception& error);

} // namespace altiro3D::tools
