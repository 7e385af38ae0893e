#pragma once

#include "cli/command_line.hpp"
#include "cli/messages.hpp"

#include <chrono>
#include <exception>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

/// JSON that the tools write for programs. docs/report.schema.json describes reports and progress.
namespace altiro3D::tools {

/// The text of a JSON value. Numbers have six significant digits, and at least three decimals if
/// they are not whole: 0.208, not 0.20800000000000002. Bytes that are not UTF-8 are replaced.
/// @param indent as for json::dump(); -1: one line
std::string jsonText(nlohmann::ordered_json value, int indent = -1);

/// --progress
void addProgressOption(CommandLine& commandLine);
/// True for `--progress json`. @throws UsageError
bool wantsJsonProgress(const CommandLine& commandLine);
/// Writes a line of `--progress json` to standard output.
void writeProgress(const nlohmann::ordered_json& line);
/// Writes a line about a failure that came before all others, if `--progress json` is given.
void tellEarlyFailure(const CommandLine& commandLine, const std::exception& error);

/// Replaces the report of an earlier run, or one of this run that says "done", by one that says
/// that this run has failed or was stopped. Other files, a report of this run that says so itself,
/// and what may not be replaced stay as they are.
/// @param before fileStamp() of the report before the run @param error why; null: not known
void outdateReport(const CommandLine& commandLine, const std::string& before, int exitStatus,
                   const std::exception* error);

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

} // namespace altiro3D::tools
