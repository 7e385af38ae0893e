#pragma once

#include "altiro3D/error.hpp"
#include "base/text.hpp" // IWYU pragma: export

#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

/// What a tool says: lines and warnings.
namespace altiro3D::tools {

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

/// The text as one line without terminal escape sequences, which file names may contain.
std::string oneLine(std::string text);

std::string sentenceOf(const std::exception& error);
/// The code of an error for reports: errorCodeName(), or "Usage" or "Unknown".
std::string codeOf(const std::exception& error);

/// Discards standard error, to which decoders print by themselves, while an object of this class
/// exists. Messages of other threads are lost as well.
class QuietStandardError {
  public:
    QuietStandardError();
    ~QuietStandardError();
    QuietStandardError(const QuietStandardError&) = delete;
    QuietStandardError& operator=(const QuietStandardError&) = delete;
};

} // namespace altiro3D::tools
