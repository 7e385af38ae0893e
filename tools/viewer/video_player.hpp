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

/// Plays a video at its own rate, again and again: hands out each picture when its time has come,
/// and drops those that come too late.
class VideoPlayer {
  public:
    /// How it goes.
    struct Counts {
        std::int64_t shown = 0;
        std::int64_t dropped = 0;
    };

    /// Both functions are called by a thread of the player's own.
    /// @param file a file or a capture device
    /// @param show takes a picture [CV_8UC3]; false if it could not be used, which drops it
    /// @param fail is told why the video cannot be read (further); nothing comes after that
    VideoPlayer(std::filesystem::path file, std::function<bool(const cv::Mat&)> show,
                std::function<void(const std::string&)> fail);
    /// Does what end() does.
    ~VideoPlayer();
    VideoPlayer(const VideoPlayer&) = delete;
    VideoPlayer& operator=(const VideoPlayer&) = delete;

    /// Waits for the picture that is being handed out; none comes after it.
    void end();
    void setPaused(bool paused);
    Counts counts() const;

  private:
    using Clock = std::chrono::steady_clock;

    void run();
    void playOnce();                // until its last picture has had its time
    bool waitUntil(double seconds); // false: it ends

    std::filesystem::path file_;
    std::function<bool(const cv::Mat&)> show_;
    std::function<void(const std::string&)> fail_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    bool ending_ = false;
    bool paused_ = false;
    Clock::time_point start_; // when time 0 of the video was
    Counts counts_;
    std::thread thread_; // last: it uses the others
};

/// Players that are to end, until somebody has the time to wait for them. For any thread.
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
