// Videos with sound: what is recorded of the sound, and when pictures are shown.

#include "recorded_sound.hpp"
#include "support/slow.hpp"
#include "viewer/player/video_player.hpp"
#include "viewer_scenes.hpp"

#include <QTest>
#include <algorithm>
#include <functional>
#include <gtest/gtest.h>
#include <mutex>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using viewer::AtEnd;
using viewer::PlaySettings;
using viewer::VideoPlayer;
using Clock = Recording::Clock;

// A player, and when it showed white pictures.
class Played {
  public:
    explicit Played(const fs::path& file, const PlaySettings& settings = {})
        : player(
              file,
              [this](const cv::Mat& picture, double) {
                  const std::lock_guard<std::mutex> lock(mutex_);
                  if (picture.at<cv::Vec3b>(20, 20)[1] > 128) whites_.push_back(Clock::now());
                  return true;
              },
              [this](const std::string& text) {
                  const std::lock_guard<std::mutex> lock(mutex_);
                  problem_ = text;
                  isDone_ = true;
              },
              settings) {}

    std::vector<Clock::time_point> whites() const {
        const std::lock_guard<std::mutex> lock(mutex_);
        return whites_;
    }
    bool isDone() const {
        const std::lock_guard<std::mutex> lock(mutex_);
        return isDone_;
    }
    std::string problem() const {
        const std::lock_guard<std::mutex> lock(mutex_);
        return problem_;
    }

  private:
    mutable std::mutex mutex_;
    std::vector<Clock::time_point> whites_;
    std::string problem_;
    bool isDone_ = false;

  public:
    VideoPlayer player; // last: it uses the others
};

PlaySettings once() {
    PlaySettings settings;
    settings.atEnd = AtEnd::Finish;
    return settings;
}

// Offset of each white picture from the nearest click, s; later pictures are positive.
std::vector<double> offsets(const Recording& recording, const std::vector<double>& clicks,
                            const std::vector<Clock::time_point>& whites) {
    std::vector<double> all;
    for (const Clock::time_point white : whites) {
        const double at = recording.sampleAt(white);
        double nearest = 1e9;
        for (const double click : clicks)
            if (std::abs(at - click) < std::abs(nearest)) nearest = at - click;
        all.push_back(nearest / Recording::kRate);
    }
    return all;
}

double largest(const std::vector<double>& values) {
    double most = 0;
    for (const double value : values)
        most = std::max(most, std::abs(value));
    return most;
}

class VideoSound : public ::testing::Test {
  protected:
    void SetUp() override {
        ALTIRO3D_REQUIRE_FFMPEG();
        const Environment driver("SDL_AUDIODRIVER", "dummy");
        if (!viewer::soundProblem().empty()) GTEST_SKIP() << viewer::soundProblem();
    }

    struct Heard {
        std::vector<float> samples;
        std::vector<double> clicks;
        std::vector<double> apart; // of each white picture and its click, s
        VideoPlayer::Counts counts;
    };
    // Plays and records a video to its end, or while somebody does something.
    Heard play(const fs::path& file, const PlaySettings& settings = once(),
               const std::function<void(Played&, Recording&)>& act = {}) const {
        Heard heard;
        Recording recording(folder_ / "played.raw");
        std::vector<Clock::time_point> whites;
        {
            Played played(file, settings);
            if (act) {
                act(played, recording);
            } else {
                EXPECT_TRUE(waitFor([&] { return played.isDone(); }));
                EXPECT_EQ(played.problem(), "");
            }
            whites = played.whites();
            heard.counts = played.player.counts();
            if (!played.isDone()) {
                EXPECT_TRUE(recording.goesOnFor(0.1)); // with the last click
            }
        }
        recording.stop();
        heard.samples = recording.samples();
        heard.clicks = clicksOf(heard.samples);
        heard.apart = offsets(recording, heard.clicks, whites);
        fs::remove(folder_ / "played.raw");
        return heard;
    }

    TemporaryDirectory folder_;
};

// $ALTIRO3D_CLICK_SECONDS: the length, for long runs.
TEST_F(VideoSound, PicturesStayInStepAndEverySampleIsPlayed) {
    const int seconds = std::max(5, qEnvironmentVariableIntValue("ALTIRO3D_CLICK_SECONDS"));
    const fs::path file = makeClicks(folder_ / "c.mkv", seconds);
    const auto [samples, clicks, apart, counts] = play(file, once(), [&](Played& played, auto&) {
        EXPECT_TRUE(QTest::qWaitFor([&] { return played.isDone(); }, 1000 * (2 * seconds + 120)));
        EXPECT_EQ(played.problem(), "");
    });
    ASSERT_EQ(clicks.size(), static_cast<std::size_t>(seconds));
    for (std::size_t i = 1; i < clicks.size(); ++i)
        EXPECT_EQ(clicks[i] - clicks[i - 1], 48000) << i; // no sample was lost or repeated
    EXPECT_GE(apart.size(), clicks.size() * 9 / 10);
    EXPECT_LT(largest(apart), inStep());
    const auto [least, most] = std::minmax_element(apart.begin(), apart.end());
    std::printf("%d s: pictures %.1f..%.1f ms after their clicks, %lld shown, %lld dropped\n",
                seconds, *least * 1000, *most * 1000, static_cast<long long>(counts.shown),
                static_cast<long long>(counts.dropped));
}

TEST_F(VideoSound, LoopsStayInStep) {
    const Heard heard = play(makeClicks(folder_ / "c.mkv", 1), {}, [](Played& played, Recording&) {
        EXPECT_TRUE(waitFor([&] { return played.whites().size() >= 4; }));
    });
    EXPECT_GE(heard.clicks.size(), 4U);
    EXPECT_LT(largest(heard.apart), inStep());
}

TEST_F(VideoSound, SeeksPausesAndGoesOnInStep) {
    ALTIRO3D_TAKES(7);
    const auto act = [](Played& played, Recording& recording) {
        const auto position = [&] { return played.player.state().position; };
        ASSERT_TRUE(waitFor([&] { return !played.whites().empty(); }));
        played.player.seek(10.5);
        ASSERT_TRUE(waitFor([&] { return position() > 11.2; }));
        EXPECT_LT(position(), 13);
        EXPECT_NEAR(played.player.state().duration, 20, 0.1);
        played.player.setPaused(true);
        const double at = position();
        const std::size_t before = played.whites().size();
        EXPECT_TRUE(recording.goesOnFor(1.5)); // with silence
        EXPECT_NEAR(position(), at, 0.1);
        EXPECT_EQ(played.whites().size(), before);
        played.player.setPaused(false);
        ASSERT_TRUE(waitFor([&] { return played.whites().size() >= before + 2; }));
        played.player.seek(1.6); // backwards
        ASSERT_TRUE(waitFor([&] { return position() < 3; }));
        ASSERT_TRUE(waitFor([&] { return played.whites().size() >= before + 4; }));
    };
    EXPECT_LT(largest(play(makeClicks(folder_ / "c.mkv", 20), {}, act).apart), inStep());
}

TEST_F(VideoSound, APausedPlayerShowsWhereItWasSent) {
    const fs::path file = makeClicks(folder_ / "c.mkv", 5);
    const Environment driver("SDL_AUDIODRIVER", "dummy");
    Played played(file);
    ASSERT_TRUE(waitFor([&] { return played.whites().size() == 1; }));
    played.player.setPaused(true);
    for (const double at : {3.0, 2.0}) {
        const std::size_t before = played.whites().size();
        played.player.seek(at);
        ASSERT_TRUE(waitFor([&] { return played.whites().size() > before; }));
        EXPECT_TRUE(waitFor([&] { return std::abs(played.player.state().position - at) < 0.001; }));
    }
    EXPECT_TRUE(played.player.state().paused);
    EXPECT_EQ(played.whites().size(), 3U);
}

TEST_F(VideoSound, OtherSpeedsStayInStep) {
    ALTIRO3D_TAKES(16);
    const fs::path file = makeClicks(folder_ / "c.mkv", 6);
    for (const double speed : {0.5, 2.0}) {
        PlaySettings settings = once();
        settings.speed = speed;
        const auto [samples, clicks, apart, counts] = play(file, settings);
        ASSERT_EQ(clicks.size(), 6U) << speed;
        for (std::size_t i = 1; i < clicks.size(); ++i)
            EXPECT_NEAR(clicks[i] - clicks[i - 1], 48000 / speed, 3);
        EXPECT_GE(apart.size(), 5U);
        EXPECT_LT(largest(apart), inStep()) << speed;
    }
}

TEST_F(VideoSound, VolumeAndMuteChangeTheAmplitude) {
    ALTIRO3D_TAKES(7);
    const fs::path file = makeClicks(folder_ / "c.mkv", 2);
    const auto loudest = [&](int volume, bool muted) {
        PlaySettings settings = once();
        settings.volume = volume;
        settings.muted = muted;
        const std::vector<float> samples = play(file, settings).samples;
        return *std::max_element(samples.begin(), samples.end());
    };
    const float full = loudest(100, false);
    EXPECT_NEAR(full, 0.8 * std::sqrt(0.5), 0.01); // mono in both channels
    EXPECT_NEAR(loudest(25, false), full / 4, 0.001);
    EXPECT_EQ(loudest(100, true), 0.F);
}

TEST_F(VideoSound, TheChosenTrackIsPlayed) {
    const fs::path file = folder_ / "two.mkv";
    ffmpeg("-f lavfi -i color=black:size=64x48:rate=25:duration=2 -f lavfi -i "
           "sine=frequency=440:duration=2 -f lavfi -i anullsrc=r=48000:d=2 -map 0 -map 1 -map 2 "
           "-c:v libx264 -preset ultrafast -c:a pcm_s16le -metadata:s:a:1 language=fra " +
           arg(file));
    const auto act = [](Played& played, Recording&) {
        PlaySettings settings = once();
        ASSERT_TRUE(waitFor([&] { return played.player.state().position > 0.5; }));
        const std::vector<VideoStreamFacts> tracks = played.player.state().tracks;
        ASSERT_EQ(tracks.size(), 2U);
        EXPECT_EQ(tracks[1].language, "fra");
        EXPECT_TRUE(played.player.state().sounds);
        settings.track = tracks[1].index;
        played.player.set(settings);
        ASSERT_TRUE(waitFor([&] { return played.isDone(); }));
    };
    const std::vector<float> samples = play(file, once(), act).samples;
    ASSERT_GT(samples.size(), 2U * 40000);
    const auto loudest = [&](std::size_t from, std::size_t to) {
        return *std::max_element(samples.begin() + std::ptrdiff_t(from),
                                 samples.begin() + std::ptrdiff_t(to));
    };
    EXPECT_GT(loudest(0, 24000), 0.05F);
    EXPECT_EQ(loudest(samples.size() - 30000, samples.size()), 0.F);
}

// The picture outlasts the sound, and the reverse.
TEST_F(VideoSound, TheLongerOfPictureAndSoundIsPlayedToItsEnd) {
    const auto lengths = [&](const char* picture, const char* sound) {
        const fs::path file = folder_ / "l.mkv";
        ffmpeg(std::string("-f lavfi -i color=white:size=64x48:rate=25:duration=") + picture +
               " -f lavfi -i sine=frequency=440:duration=" + sound +
               " -c:v libx264 -preset ultrafast -c:a pcm_s16le " + arg(file));
        const Heard heard = play(file);
        fs::remove(file);
        const auto loud = std::count_if(heard.samples.begin(), heard.samples.end(),
                                        [](float sample) { return sample != 0; });
        return std::pair<std::size_t, double>(heard.apart.size(),
                                              static_cast<double>(loud) / 48000);
    };
    const auto [pictures, shortSound] = lengths("2", "0.5");
    EXPECT_GE(pictures, 40U);
    EXPECT_NEAR(shortSound, 0.5, 0.01);
    const auto [few, longSound] = lengths("0.4", "2");
    EXPECT_LE(few, 10U);
    EXPECT_NEAR(longSound, 2, 0.03); // a sine is 0 at times
}

TEST_F(VideoSound, AMachineWithoutSoundPlaysOn) {
    const fs::path file = makeClicks(folder_ / "c.mkv", 3);
    const Environment driver("SDL_AUDIODRIVER", "nonexistent");
    EXPECT_NE(viewer::soundProblem(), "");
    const Clock::time_point begin = Clock::now();
    Played played(file, once());
    ASSERT_TRUE(waitFor([&] { return played.isDone(); }));
    EXPECT_EQ(played.problem(), "");
    EXPECT_FALSE(played.player.state().sounds);
    EXPECT_GE(std::chrono::duration<double>(Clock::now() - begin).count(), 3);
    const auto whites = played.whites();
    ASSERT_EQ(whites.size(), 3U);
    for (std::size_t i = 1; i < whites.size(); ++i)
        EXPECT_NEAR(std::chrono::duration<double>(whites[i] - whites[i - 1]).count(), 1, 0.2);
}

// The device fails when it is given the first samples.
TEST_F(VideoSound, ALostDeviceDoesNotStopTheVideo) {
    const fs::path file = makeClicks(folder_ / "c.mkv", 2);
    const Environment driver("SDL_AUDIODRIVER", "disk");
    const Environment name("SDL_DISKAUDIOFILE", "/dev/full");
    Played played(file, once());
    ASSERT_TRUE(waitFor([&] { return played.isDone(); }));
    EXPECT_EQ(played.whites().size(), 2U);
}

TEST_F(VideoSound, AtTheEndItStopsUntilItPlaysAgain) {
    const fs::path file = makeClicks(folder_ / "c.mkv", 1);
    const Environment driver("SDL_AUDIODRIVER", "dummy");
    PlaySettings settings;
    settings.atEnd = AtEnd::Stop;
    Played played(file, settings);
    ASSERT_TRUE(waitFor([&] { return played.player.state().paused; }));
    EXPECT_EQ(played.whites().size(), 1U);
    EXPECT_FALSE(played.isDone());
    played.player.setPaused(false);
    ASSERT_TRUE(waitFor([&] { return played.whites().size() > 1; }));
    EXPECT_EQ(played.whites().size(), 2U);
}

// A receiver that needs 130 ms for each picture of 40 ms.
TEST_F(VideoSound, ASlowMachineDropsPicturesNotSound) {
    const fs::path file = makeClicks(folder_ / "c.mkv", 3);
    Recording recording(folder_ / "played.raw");
    {
        std::atomic<bool> isDone{false};
        VideoPlayer player(
            file,
            [](const cv::Mat&, double) {
                std::this_thread::sleep_for(std::chrono::milliseconds(130));
                return true;
            },
            [&](const std::string&) { isDone = true; }, once());
        ASSERT_TRUE(waitFor([&] { return isDone.load(); }));
        EXPECT_GE(player.counts().dropped, 20);
        EXPECT_GE(player.counts().shown, 8);
    }
    recording.stop();
    const std::vector<double> clicks = clicksOf(recording.samples());
    ASSERT_EQ(clicks.size(), 3U);
    EXPECT_EQ(clicks[2] - clicks[0], 96000);
}

} // namespace
} // namespace altiro3D::test
