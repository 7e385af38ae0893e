#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <string>
#include <thread>
#include <vector>

namespace altiro3D::viewer {

/// Plays a video at its own rate, once or in a loop. It delivers each picture at its time and drops
/// late ones, but delivers at least one in 0.25 s if it can.
class VideoPlayer {
  public:
    /// Numbers of pictures so far.
    struct Counts {
        std::int64_t shown = 0;
        std::int64_t dropped = 0;
    };

    /// The player's own thread calls both functions.
    /// @param file a file or a capture device
    /// @param show receives a picture [CV_8UC3]; returns false to drop it
    /// @param done receives the reason if the video cannot be read (further), an empty text at the
    /// end
    ///        of a video that does not loop; it is the last call
    VideoPlayer(std::filesystem::path file, std::function<bool(const cv::Mat&)> show,
                std::function<void(const std::string&)> done, bool loops = true);
    /// Calls end().
    ~VideoPlayer();
    VideoPlayer(const VideoPlayer&) = delete;
    VideoPlayer& operator=(const VideoPlayer&) = delete;

    /// Stops the player. Waits for a running call of `show`; no further call follows.
    void end();
    void setPaused(bool paused);
    Counts counts() const;

  private:
    using Clock = std::chrono::steady_clock;

    void run();
    void playOnce();                // returns when the time of the last picture is over
    bool waitUntil(double seconds); // false: the player is being stopped

    std::filesystem::path file_;
    std::function<bool(const cv::Mat&)> show_;
    std::function<void(const std::string&)> done_;
    bool loops_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    bool ending_ = false;
    bool paused_ = false;
    Clock::time_point start_; // clock time of the video's time 0
    Counts counts_;
    std::thread thread_; // last: it uses the others
};

/// Players that must end; another thread can wait for them later. Thread-safe.
class EndingPlayers {
  public:
    /// @param player may be null
    void add(std::shared_ptr<VideoPlayer> player);
    /// Ends all that have been added and waits for them.
    void endAll();

  private:
    std::mutex mutex_;
    std::vector<std::shared_ptr<VideoPlayer>> players_;
};

} // namespace altiro3D::viewer
