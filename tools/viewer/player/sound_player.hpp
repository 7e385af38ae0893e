#pragma once

#include "altiro3D/video_io.hpp"
#include "viewer/player/sound_device.hpp"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace altiro3D::viewer {

/// Plays the sound of a file and tells the time that is being heard, which pictures follow. Silence
/// follows the end of the sound, so the time goes on. Thread-safe.
class SoundPlayer {
  public:
    /// @param problem receives why there is no sound output
    /// @return null where there is none
    static std::unique_ptr<SoundPlayer> open(const std::filesystem::path& file,
                                             std::string& problem);
    ~SoundPlayer();
    SoundPlayer(const SoundPlayer&) = delete;
    SoundPlayer& operator=(const SoundPlayer&) = delete;

    /// Plays from a time on, s from the start of the file.
    /// @param stream index of the sound stream, -1 = the default one
    /// @param speed 0.25..4; the pitch changes with it
    void start(double from, int stream, double speed);
    void setPaused(bool paused);
    /// @param volume 0..1, a factor
    void setVolume(double volume);

    /// Time of the file that is being heard, s. Until the first sample is heard it is less than the
    /// start.
    double time() const;
    /// Whether all sound of the file has been heard, or none can be read.
    bool isOver() const;
    /// Whether the output takes no more samples, as after the loss of a device.
    bool isStuck() const;

  private:
    using Clock = std::chrono::steady_clock;
    struct Wish {
        double from = 0;
        int stream = -1;
        double speed = 1;
    };

    explicit SoundPlayer(std::filesystem::path file) : file_(std::move(file)) {}
    void fill(float* samples, int count); // by the device's thread
    void feed();                          // runs in thread_
    void prepare(const Wish& wish);
    double timeLocked() const;

    std::filesystem::path file_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    std::optional<Wish> wish_;
    Wish playing_;
    bool started_ = false;
    bool ending_ = false;
    bool paused_ = false;
    double pausedAt_ = 0;
    double volume_ = 1;
    int delay_ = 0; // SoundDevice::delay()
    // The samples that wait, as a ring, and what was taken of them since the start.
    std::vector<float> ring_;
    std::size_t first_ = 0;
    std::size_t waiting_ = 0;
    std::int64_t taken_ = 0;
    // The block that the device took last: where it begins, how many samples, and when.
    std::int64_t blockBegin_ = 0;
    std::int64_t blockLength_ = 0;
    Clock::time_point blockTime_;
    Clock::time_point lastCall_ = Clock::now();
    std::optional<double> end_;           // of the sound, s
    std::unique_ptr<AudioReader> reader_; // of thread_, as the next two
    Wish reading_;
    std::thread thread_;
    std::unique_ptr<SoundDevice> device_; // last: it uses the others
};

} // namespace altiro3D::viewer
