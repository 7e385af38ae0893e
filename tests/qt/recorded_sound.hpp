#pragma once

#include "support/files.hpp"
#include "support/video.hpp"

#include <QByteArray>
#include <QTest>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace altiro3D::test {

/// How far a picture may be from its sound, s: 0.04 if nothing else runs ($ALTIRO3D_CLICK_SECONDS
/// is set, as by scripts/soak.sh). Beside other tests on a slow machine only gross faults are
/// found, such as another rate or sound that starts elsewhere.
inline double inStep() {
    return qEnvironmentVariableIsSet("ALTIRO3D_CLICK_SECONDS") ? 0.04 : 0.4;
}

/// An environment variable with another value, while it lives.
class Environment {
  public:
    Environment(const char* name, const QByteArray& value) : name_(name), before_(qgetenv(name)) {
        qputenv(name, value);
    }
    ~Environment() {
        if (before_.isNull())
            qunsetenv(name_);
        else
            qputenv(name_, before_);
    }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

  private:
    const char* name_;
    QByteArray before_;
};

/// Records what is played while it lives, by SDL's driver `disk`, and when: the file grows by a
/// block when the block begins to sound.
class Recording {
  public:
    using Clock = std::chrono::steady_clock;
    static constexpr double kRate = 48000;

    explicit Recording(const std::filesystem::path& file)
        : file_(file), driver_("SDL_AUDIODRIVER", "disk"), name_("SDL_DISKAUDIOFILE", file.c_str()),
          thread_([this] { watch(); }) {}
    ~Recording() { stop(); }
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;

    void stop() {
        ending_ = true;
        if (thread_.joinable()) thread_.join();
    }
    /// Waits until so many seconds of sound, also silence, have been recorded from now on.
    bool goesOnFor(double seconds) const {
        const auto samples = [this] {
            std::error_code none;
            const auto bytes = std::filesystem::file_size(file_, none);
            return none ? 0.0 : static_cast<double>(bytes) / 8;
        };
        const double end = samples() + seconds * kRate;
        return QTest::qWaitFor([&] { return samples() >= end; }, 120000);
    }
    /// The recorded samples of the left channel. Call stop() before.
    std::vector<float> samples() const {
        const std::string bytes = slurp(file_);
        std::vector<float> left(bytes.size() / 8);
        for (std::size_t i = 0; i < left.size(); ++i)
            std::memcpy(&left[i], bytes.data() + 8 * i, 4);
        return left;
    }
    /// The number of the sample that sounded at a time, from the growth of the file alone.
    double sampleAt(Clock::time_point time) const {
        double at = 0;
        for (std::size_t i = 1; i < growth_.size() && growth_[i].first <= time; ++i) {
            const double begin = growth_[i - 1].second;
            const double since =
                std::chrono::duration<double>(time - growth_[i].first).count() * kRate;
            at = begin + std::min(since, growth_[i].second - begin);
        }
        return at;
    }

  private:
    void watch() {
        growth_.emplace_back(Clock::now(), 0.0);
        for (; !ending_; std::this_thread::sleep_for(std::chrono::microseconds(500))) {
            std::error_code none;
            const auto size = std::filesystem::file_size(file_, none);
            const double samples = none ? 0 : static_cast<double>(size) / 8;
            if (samples > growth_.back().second) growth_.emplace_back(Clock::now(), samples);
        }
    }

    std::filesystem::path file_;
    Environment driver_;
    Environment name_;
    std::vector<std::pair<Clock::time_point, double>> growth_;
    std::atomic<bool> ending_{false};
    std::thread thread_;
};

/// A video with a white picture and a click at the beginning of each second, else black and silent.
/// @param more options of ffmpeg before the file's name
inline std::filesystem::path makeClicks(const std::filesystem::path& file, int seconds,
                                        const std::string& more = "") {
    const std::string length = std::to_string(seconds);
    ffmpeg("-f lavfi -i \"color=black:size=64x48:rate=25:duration=" + length +
           ",drawbox=color=white:t=fill:enable='lt(mod(n,25),1)'\" -f lavfi -i "
           "\"aevalsrc=if(lt(mod(t\\,1)\\,0.004)\\,0.8\\,0):s=48000:d=" +
           length + "\" -c:v libx264 -preset ultrafast -g 50 -c:a pcm_s16le " + more + " " +
           arg(file));
    return file;
}

/// Where clicks begin in samples.
inline std::vector<double> clicksOf(const std::vector<float>& samples, float threshold = 0.05F) {
    std::vector<double> clicks;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (std::abs(samples[i]) < threshold) continue;
        clicks.push_back(static_cast<double>(i));
        i += 4800; // past this one
    }
    return clicks;
}

} // namespace altiro3D::test
