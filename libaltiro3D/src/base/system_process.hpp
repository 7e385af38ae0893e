#pragma once

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// What the system does with processes, and what it knows of them. hostName() is in file_io.hpp.
namespace altiro3D {

/// The number of this process.
std::int64_t processNumber();
/// Whether a process of this computer runs; true also for a number that no process can have.
bool isRunning(std::int64_t process);

/// How work in a process of its own has ended.
struct ApartEnd {
    int error = 0;         ///< errno: the process could not be started.
    bool isInTime = false; ///< It ended within the time limit; otherwise it was killed.
    bool isWhole = false;  ///< The work has returned; otherwise the process crashed.
    std::string how;       ///< What ended it: " (Segmentation fault)"; empty if unknown.
};
/// Does work in a process of its own, so that a crash does no harm. The process prints nothing, and
/// ends with this one.
/// @param work must not throw
/// @param program arguments with which this program does the same work, for systems that cannot
///        copy a process; if there are none, those do the work in this process
/// @param seconds time limit
ApartEnd runApart(const std::function<void()>& work, const std::vector<std::string>& program,
                  double seconds);

/// A variable of the environment in UTF-8. @return empty if it is not set
std::string environmentOf(const char* name);
/// What separates the entries of a list of directories in the environment.
extern const char kListSeparator;

/// The quote around a word of the shell that has other characters than letters, and what stands for
/// that quote inside the word.
extern const char kShellQuote;
extern const char* const kQuoteInShellQuotes;
/// Where programs keep their data for this user. @return empty if it is not known
std::filesystem::path userDataDirectory();

/// The local date and time.
std::tm localTime(std::time_t time);

/// Asks for large pages for memory that is not written yet. The system may refuse.
void requestLargePages(const void* begin, const void* end);

} // namespace altiro3D
