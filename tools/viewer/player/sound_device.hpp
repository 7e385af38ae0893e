#pragma once

#include <functional>
#include <memory>
#include <string>

namespace altiro3D::viewer {

/// The computer's sound output, through SDL. SDL chooses the driver, or $SDL_AUDIODRIVER does.
class SoundDevice {
  public:
    static constexpr int kRate = 48000;  ///< Samples per second.
    static constexpr int kPeriod = 1024; ///< Samples that the device takes at a time.

    /// Opens the output and starts it.
    ///
    /// @param fill a thread of the device's calls it for the next samples: left and right in turn,
    ///        32-bit floating point, `count` of each
    /// @param problem receives the reason where there is no output
    /// @return null where there is no output
    static std::unique_ptr<SoundDevice> open(std::function<void(float* samples, int count)> fill,
                                             std::string& problem);
    /// Closes the output; `fill` is not called any more.
    ~SoundDevice();
    /// Samples that are still to be heard when `fill` is called: those of the call before. SDL's
    /// drivers `disk` and `dummy` have no buffer, so there are none.
    int delay() const { return delay_; }
    SoundDevice(const SoundDevice&) = delete;
    SoundDevice& operator=(const SoundDevice&) = delete;

  private:
    SoundDevice() = default;

    std::function<void(float*, int)> fill_;
    int delay_ = 0;
    [[maybe_unused]] unsigned number_ = 0; // SDL's
};

/// Why there is no sound output; empty if there is one.
std::string soundProblem();

} // namespace altiro3D::viewer
