#pragma once

#include "altiro3D/video_io.hpp"
#include "viewer/player/sound_player.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace altiro3D::viewer {

/// What a player does at the end of its video.
enum class AtEnd {
    Loop,  ///< It begins again.
    Stop,  ///< It pauses at the end; when it is set to play, it begins again.
    Finish ///< It calls `done` and ends.
};

/// How a video is played.
struct PlaySettings {
    int volume = 100; ///< 0..100, % of the amplitude in the file.
    bool muted = false;
    double speed = 1; ///< 0.25..4
    AtEnd atEnd = AtEnd::Loop;
    int track = -1; ///< Index of the sound stream in the file; -1 = the default one.
};

constexpr int kVolumeStep = 10; ///< % of one key press.
constexpr double kSeekStep = 5; ///< s of one key press.

/// Plays a video with its sound, at its own rate or faster or slower. The pictures follow the clock
/// of the sound, or the computer's clock where there is none. It delivers each picture at its time
/// and drops those that are over 30 ms late, but delivers at least one in 0.25 s if it can.
class VideoPlayer {
  public:
    struct Counts {
        std::int64_t shown = 0;
        std::int64_t dropped = 0;
    };
    /// What a window shows about the video.
    struct State {
        double position = 0; ///< s from the start of the file.
        double duration = 0; ///< s; 0 = unknown.
        bool paused = false;
        bool sounds = false;                  ///< Its sound is played.
        std::vector<VideoStreamFacts> tracks; ///< Its sound tracks.
    };

    /// The player's own thread calls both functions.
    /// @param file a file or a capture device
    /// @param reading how it is read, of its whole length
    /// @param show receives a picture [CV_8UC3] and its time, s; returns false to drop it
    /// @param done receives the reason if the video cannot be read (further), an empty text after
    ///        AtEnd::Finish; it is the last call
    VideoPlayer(std::filesystem::path file, std::function<bool(const cv::Mat&, double)> show,
                std::function<void(const std::string&)> done, const PlaySettings& settings = {},
                const VideoReaderOptions& reading = {});
    ~VideoPlayer() { end(); }
    VideoPlayer(const VideoPlayer&) = delete;
    VideoPlayer& operator=(const VideoPlayer&) = delete;

    /// Stops the player. Waits for a running call of `show`; no further call follows.
    void end();
    void setPaused(bool paused);
    void set(const PlaySettings& settings);
    /// Goes to a time, s; a paused player shows the picture there. Times outside the video become
    /// its start or its end. A capture device ignores it.
    void seek(double seconds);
    /// Delivers pictures earlier, by the time from `show` to the screen.
    /// @param seconds the time that the last picture took; the player smooths it
    void noteDelay(double seconds);
    Counts counts() const;
    State state() const;

  private:
    using Clock = std::chrono::steady_clock;

    void run();
    /// Plays from a time to the end, the sound included. @return false if it was interrupted
    bool playFrom(double from);
    /// @param leads earlier by lead_ @return false if it was interrupted
    bool waitUntil(double seconds, bool leads = false);
    bool waitForEnd(double seconds);
    bool isInterrupted() const { return ending_ || wanted_; }
    void startClock(double from);
    double now();
    void openSound(const VideoFacts& facts);
    void rest(std::unique_lock<std::mutex>& lock);

    std::filesystem::path file_;
    VideoReaderOptions reading_;
    std::function<bool(const cv::Mat&, double)> show_;
    std::function<void(const std::string&)> done_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    PlaySettings settings_;
    bool ending_ = false;
    bool paused_ = false;
    std::optional<double> wanted_; // a time to seek, s
    State state_;
    double lead_ = 0; // s, by which pictures are delivered earlier
    // The clock where there is no sound: the video's time `base_` was at `since_`.
    double base_ = 0;
    Clock::time_point since_;
    Counts counts_;
    std::unique_ptr<SoundPlayer> sound_;
    bool isSilent_ = false; // there is no sound, or no output for it
    std::thread thread_;    // last: it uses the others
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
