#pragma once

#include "common/run_tool.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// Shows how far a video is: a line on a terminal, JSON lines for programs, nothing elsewhere.
class VideoProgress {
  public:
    /// --progress
    static void add(CommandLine& commandLine);
    /// True for `--progress json`. @throws UsageError
    static bool json(const CommandLine& commandLine);

    /// @param json one JSON object a line on standard output instead of a bar
    /// @param frames how many there are in all, as far as known
    /// @param seconds how long the video is, as far as known
    /// @param done frames that an earlier run has made
    /// @param doneTime where they end, s of the video
    VideoProgress(bool json, std::optional<std::int64_t> frames, std::optional<double> seconds,
                  std::int64_t done, double doneTime);
    ~VideoProgress();
    VideoProgress(const VideoProgress&) = delete;
    VideoProgress& operator=(const VideoProgress&) = delete;

    /// A frame is done that ends at a time of the video, s.
    void frame(double end);
    /// All frames are given to the encoder, which still holds some; the file is being closed.
    void finishing();
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
    std::optional<std::int64_t> frames_;
    std::optional<double> seconds_;
    std::int64_t before_;
    std::int64_t done_ = 0;
    double time_;
    double firstTime_ = -1;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point shown_{};
};

} // namespace altiro3D::tools
