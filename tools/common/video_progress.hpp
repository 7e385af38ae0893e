#pragma once

#include "altiro3D/video_conversion.hpp"
#include "common/run_tool.hpp"

#include <chrono>
#include <string>

namespace altiro3D::tools {

/// Shows how far a video is: a line on a terminal, JSON lines for programs, nothing elsewhere.
class VideoProgressLine {
  public:
    /// --progress
    static void add(CommandLine& commandLine);
    /// True for `--progress json`. @throws UsageError
    static bool json(const CommandLine& commandLine);

    /// @param json one JSON object a line on standard output instead of a bar
    /// @param start how far it is before the first frame
    VideoProgressLine(bool json, const VideoProgress& start);
    ~VideoProgressLine();
    VideoProgressLine(const VideoProgressLine&) = delete;
    VideoProgressLine& operator=(const VideoProgressLine&) = delete;

    /// A frame is made, or the file is being closed.
    void update(const VideoProgress& now);
    /// All are done: the last JSON line; takes the bar away.
    /// @param state "done", "stopped" or "truncated"
    void end(const std::string& state);
    /// Takes the bar away.
    void clear();

  private:
    double rate() const; // frames a second of this run
    void show();
    void putLine(const std::string& state) const;

    bool json_;
    VideoProgress now_;
    double firstTime_ = -1;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point shown_{};
};

} // namespace altiro3D::tools
