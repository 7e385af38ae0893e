#pragma once

#include "altiro3D/video_conversion.hpp"
#include "cli/run_tool.hpp"

#include <chrono>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// How fast a video is made, and how much is left, for people and programs.
class VideoPace {
  public:
    /// @param start progress before the first frame
    explicit VideoPace(const VideoProgress& start) : now_(start) {}

    /// Takes new progress. @return true if another frame was made
    bool update(const VideoProgress& now);
    const VideoProgress& now() const { return now_; }
    double rate() const;                 ///< Frames per second of this run.
    std::optional<double> share() const; ///< The part done, 0..1; nothing if the length is unknown.
    std::optional<double> secondsLeft() const; ///< Nothing before the second frame.

  private:
    double spent() const; // s

    VideoProgress now_;
    double firstTime_ = -1;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Shows the progress of a video: a bar on a terminal, JSON lines for programs, else nothing.
class VideoProgressLine {
  public:
    /// @param json write JSON objects, one per line, to standard output instead of a bar
    /// @param start progress before the first frame
    /// @param input name of the video for JSON; empty: not written
    /// @param place what a bar begins with
    VideoProgressLine(bool json, const VideoProgress& start, std::string input = {},
                      std::string place = {});
    ~VideoProgressLine();
    VideoProgressLine(const VideoProgressLine&) = delete;
    VideoProgressLine& operator=(const VideoProgressLine&) = delete;

    /// Shows new progress: a frame was made, or the file is being closed.
    void update(const VideoProgress& now);
    /// Writes the last JSON line and erases the bar.
    /// @param state "done", "stopped", "truncated" or "failed"
    void end(const std::string& state);
    /// Erases the bar.
    void clear() { clearStatus(); }

  private:
    void show();
    nlohmann::ordered_json stateLine(const std::string& state) const;
    void putLine(nlohmann::ordered_json line) const;

    bool json_;
    std::string input_;
    std::string place_;
    VideoPace pace_;
    std::chrono::steady_clock::time_point shown_{};
};

} // namespace altiro3D::tools
