#pragma once

#include "altiro3D/video_io.hpp"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace altiro3D::viewer {

/// The computer's sound output, through SDL. SDL chooses the driver, or $SDL_AUDIODRIVER does.
class SoundDevice {
  public:
    static constexpr int kRate = 48000;  ///< Samples per second.
    static constexpr int kPeriod = 1024; ///< Samples that the device takes at a time.

    /// Opens the output and starts it.
    /// @param fill a thread of the device's calls it for the next samples: left and right in turn,
    ///        32-bit floating point, `count` of each
    /// @throws std::runtime_error there is no output
    explicit SoundDevice(std::function<void(float* samples, int count)> fill);
    /// Closes the output; `fill` is not called any more.
    ~SoundDevice();
    /// Samples that are still to be heard when `fill` is called: those of the call before. SDL's
    /// drivers `disk` and `dummy` have no buffer, so there are none.
    int delay() const { return delay_; }
    SoundDevice(const SoundDevice&) = delete;
    SoundDevice& operator=(const SoundDevice&) = delete;

  private:
    std::function<void(float*, int)> fill_;
    int delay_ = 0;
    [[maybe_unused]] unsigned number_ = 0; // SDL's
};

/// Why there is no sound output; empty if there is one.
std::string soundProblem();

/// Plays the sound of a file and tells the time that is being heard, which pictures follow. Silence
/// follows the end of the sound, so the time goes on. Thread-safe.
class SoundPlayer {
  public:
    /// @throws std::runtime_error there is no sound output
    explicit SoundPlayer(std::filesystem::path file);
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
