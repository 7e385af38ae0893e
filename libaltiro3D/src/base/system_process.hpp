#pragma once

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <functional>
#include <string>

/// What the system does with processes, and what it knows of them. hostName() is in file_io.hpp.
namespace altiro3D {

/// The number of this process.
std::int64_t processNumber();
/// Whether a process of this computer runs; true also for a number that no process can have.
bool isRunning(std::int64_t process);

/// How work in a process of its own has ended.
struct ApartEnd {
    int error = 0;         ///< errno: the process could not be started.
    bool isInTime = false; ///< It ended within the time limit; otherwise it was ended.
    bool isWhole = false;  ///< The work has returned; otherwise the process crashed.
    std::string how;       ///< What ended it: " (Segmentation fault)"; empty if unknown.
};
/// Does work in a process of its own, so that a crash does no harm. The process prints nothing, and
/// ends with this one.
/// @param work must not throw @param seconds time limit
ApartEnd runApart(const std::function<void()>& work, double seconds);

/// The local date and time.
std::tm localTime(std::time_t time);

/// Asks for large pages for memory that is not written yet. The system may refuse.
void requestLargePages(const void* begin, const void* end);

} // namespace altiro3D
