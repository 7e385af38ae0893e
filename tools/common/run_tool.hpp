#pragma once

#include "altiro3D/error.hpp"
#include "common/command_line.hpp"

#include <chrono>
#include <functional>
#include <opencv2/core/types.hpp>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::tools {

constexpr int kExitDone = 0;
constexpr int kExitFailed = 1;
constexpr int kExitUsage = 2;

/// What a tool says while it works.
///
/// Results go to standard output, warnings and errors to standard error, each on one line. Warnings
/// wait until the work they belong to is done: a run that fails says one thing, its error.
class Messages {
  public:
    Messages(std::string tool, bool verbose) : tool_(std::move(tool)), verbose_(verbose) {}

    bool verbose() const { return verbose_; }
    /// Standard output is for programs from now on: say() and detail() say nothing.
    void leaveStandardOutput() { silent_ = true; }
    /// A line about the result.
    void say(const std::string& line) const;
    /// A text for programs, such as JSON, as it is.
    void print(const std::string& text) const;
    /// What say() and detail() talk about from now on, where there are several; empty: no word.
    void setSubject(const std::string& subject) { subject_ = subject; }
    bool hasSubject() const { return !subject_.empty(); }
    /// A line that only `-v` shows.
    void detail(const std::string& line) const;
    /// A warning; shown by flushWarnings(), the same text once only.
    void warn(const std::string& line);
    void warn(const std::vector<std::string>& lines);
    void warn(const Notes& notes);
    /// A warning that holds for the subject only, which it names.
    void warnOfSubject(const std::string& line) { warn(ofSubject(line)); }
    /// Shows the warnings that wait.
    void flushWarnings();
    /// Forgets the warnings that wait.
    void dropWarnings();
    /// The warnings so far, shown or waiting.
    const std::vector<std::string>& warnings() const { return all_; }
    /// An error line.
    void fail(const std::string& line) const;

  private:
    std::string ofSubject(const std::string& line) const {
        return subject_.empty() ? line : subject_ + ": " + line;
    }

    std::string tool_;
    bool verbose_;
    bool silent_ = false;
    std::string subject_;
    std::vector<std::string> waiting_;
    std::vector<std::string> all_;
};

/// Stage names with the milliseconds they took.
class StageTimes {
  public:
    /// Ends the stage that began with the last call (or the construction).
    void end(const std::string& stage);
    /// A stage that was timed elsewhere, in milliseconds.
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

/// Peak memory of this process since its start or the last resetPeakMemory(), in MB of 2^20 bytes;
/// 0 where the system does not tell.
double peakMegabytes();
void resetPeakMemory();

/// "1536 x 2048 px"
std::string sizeText(cv::Size size);
/// The text as one line without orders to a terminal, such as file names may hold.
std::string oneLine(std::string text);

/// A progress line on a terminal, for work of several steps; nothing elsewhere.
class Progress {
  public:
    explicit Progress(std::size_t steps);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    /// Shows that a step begins.
    void step(const std::string& what);
    /// Takes the line away, so that other lines can be written.
    void clear();

  private:
    std::size_t steps_;
    std::size_t done_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Keeps what decoders print by themselves off standard error while any of these lives; messages of
/// other threads are lost with it.
class QuietStandardError {
  public:
    QuietStandardError();
    ~QuietStandardError();
    QuietStandardError(const QuietStandardError&) = delete;
    QuietStandardError& operator=(const QuietStandardError&) = delete;
};

/// Runs a tool: adds the options that all tools have (--help, --version, -v, -j), reads the command
/// line, calls the body and turns every failure into one line and an exit status.
int runTool(int argc, char** argv, CommandLine& commandLine,
            const std::function<int(const CommandLine&, Messages&)>& body);

/// runTool() for a tool whose body makes a Qt application of its own: one with windows ends the
/// process where there is no desktop, which --help must not.
int runToolWithoutApplication(int argc, char** argv, CommandLine& commandLine,
                              const std::function<int(const CommandLine&, Messages&)>& body);

/// A number with so many decimals.
std::string fixed(double value, int decimals);

/// The sentence of any exception, on one line.
std::string sentenceOf(const std::exception& error);

} // namespace altiro3D::tools
