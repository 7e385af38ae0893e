#include "altiro3D/video_io.hpp"

#include "altiro3D/error.hpp"
#include "support/files.hpp"
#include "support/slow.hpp"
#include "support/video.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr double kPi = 3.14159265358979323846;

// Left: a sine of 440 Hz; right: one of 1000 Hz; both of amplitude 0.5, 48000 samples per second.
double sine(bool right, std::int64_t sample, double rate = 48000) {
    return 0.5 * std::sin(2 * kPi * (right ? 1000 : 440) * static_cast<double>(sample) / rate);
}

std::vector<float> readAll(AudioReader& reader, std::size_t most = 10'000'000) {
    std::vector<float> samples(2 * most);
    samples.resize(2 * reader.read(samples.data(), most));
    return samples;
}

// Largest difference from the sines, which begin at sample `first` of theirs; the last samples,
// where a filter ends, are left out.
double farthest(const std::vector<float>& samples, std::int64_t first, double rate = 48000,
                std::size_t most = 1'000'000) {
    double worst = 0;
    const std::size_t count = std::min(samples.size() / 2, most);
    for (std::size_t i = 0; i + 64 < count; ++i) {
        for (const bool right : {false, true}) {
            const double expected = sine(right, first + static_cast<std::int64_t>(i), rate);
            worst = std::max(worst, std::abs(samples[2 * i + (right ? 1 : 0)] - expected));
        }
    }
    return worst;
}

// As farthest(), of the best shift by at most a ms, which is the unit of times in Matroska.
double farthestWithinAMillisecond(const std::vector<float>& samples, std::int64_t first) {
    double best = 2;
    for (std::int64_t shift = -48; shift <= 48; ++shift)
        best = std::min(best, farthest(samples, first + shift));
    return best;
}

class AudioReaderTest : public FfmpegTest {
  protected:
    fs::path makeSines(const std::string& name, const std::string& options) const {
        return make(name, "-f lavfi -i "
                          "'aevalsrc=0.5*sin(2*PI*440*t)|0.5*sin(2*PI*1000*t):s=48000:d=5' " +
                              options);
    }
};

std::string openError(const fs::path& file, const AudioReaderOptions& options = {}) {
    return errorOf([&] { AudioReader(file, options); });
}

TEST_F(AudioReaderTest, DeliversEverySampleOfALosslessTrack) {
    AudioReader reader(makeSines("s.mkv", "-c:a pcm_f32le"));
    const std::vector<float> samples = readAll(reader);
    EXPECT_EQ(samples.size(), 2U * 5 * 48000);
    EXPECT_LT(farthest(samples, 0), 1e-4);
    float more[2];
    EXPECT_EQ(reader.read(more, 1), 0U);
}

TEST_F(AudioReaderTest, SeeksToTheSample) {
    for (const char* name : {"s.wav", "s.flac", "s.mov"}) {
        const fs::path file =
            makeSines(name, std::string(name) == "s.flac" ? "-c:a flac" : "-c:a pcm_s16le");
        AudioReader reader(file);
        for (const double at : {3.25, 0.0, 4.5, 0.1, 1.000125}) {
            reader.seek(at);
            const std::vector<float> samples = readAll(reader, 4800);
            ASSERT_EQ(samples.size(), 2U * 4800) << name << " " << at;
            EXPECT_LT(farthest(samples, std::llround(at * 48000)), 1e-3) << name << " " << at;
        }
        AudioReaderOptions options;
        options.from = 2.5;
        AudioReader late(file, options);
        EXPECT_EQ(readAll(late).size(), 2U * 120000) << name;
        late.seek(100);
        EXPECT_EQ(readAll(late).size(), 0U) << name;
        late.seek(4);
        EXPECT_EQ(readAll(late).size(), 2U * 48000) << name;
    }
}

TEST_F(AudioReaderTest, KeepsTheTimeOfLossySoundAfterASeek) {
    AudioReader reader(makeSines("s.mp4", "-c:a aac -b:a 256k"));
    for (const double at : {0.5, 3.0, 0.25, 4.0}) {
        reader.seek(at);
        const std::vector<float> samples = readAll(reader, 9600);
        // a shift by one sample of the 1000 Hz would make 0.065, that of a frame of AAC up to 1
        EXPECT_LT(farthest(samples, std::llround(at * 48000)), 0.05) << at;
    }
}

TEST_F(AudioReaderTest, ResamplesAndMixes) {
    AudioReaderOptions options;
    options.sampleRate = 96000;
    AudioReader reader(makeSines("s.wav", "-c:a pcm_f32le"), options);
    reader.seek(1);
    const std::vector<float> samples = readAll(reader, 9600);
    EXPECT_LT(farthest(samples, 96000, 96000), 2e-3);

    ffmpeg("-f lavfi -i 'aevalsrc=0.5*sin(2*PI*440*t):s=48000:d=1' -c:a pcm_f32le " +
           arg(directory / "mono.wav"));
    AudioReader mono(directory / "mono.wav");
    const std::vector<float> both = readAll(mono);
    ASSERT_EQ(both.size(), 2U * 48000);
    for (std::size_t i = 0; i < both.size(); i += 2)
        ASSERT_EQ(both[i], both[i + 1]);
    EXPECT_NEAR(both[2 * 1000], sine(false, 1000) * std::sqrt(0.5), 1e-4); // as loud in both
}

// Sound that begins after the picture, and sound with a gap.
TEST_F(AudioReaderTest, ReplacesMissingSoundBySilence) {
    ALTIRO3D_TAKES(3);
    const fs::path tone = makeSines("s.wav", "-c:a pcm_s16le");
    ffmpeg("-f lavfi -i color=size=32x32:rate=25:duration=8 -itsoffset 2 -i " + arg(tone) +
           " -c:v ffv1 -c:a pcm_s16le " + arg(directory / "late.mkv"));
    AudioReader late(directory / "late.mkv");
    std::vector<float> samples = readAll(late);
    ASSERT_NEAR(static_cast<double>(samples.size()) / 2, 7 * 48000, 48);
    EXPECT_EQ(*std::max_element(samples.begin(), samples.begin() + 2 * 95900), 0.F);
    samples.erase(samples.begin(), samples.begin() + 2 * 96000);
    EXPECT_LT(farthestWithinAMillisecond(samples, 0), 1e-3);
    late.seek(1.5);
    samples = readAll(late, 24000);
    EXPECT_EQ(*std::max_element(samples.begin(), samples.begin() + 2 * 23900), 0.F);
    late.seek(3);
    EXPECT_LT(farthestWithinAMillisecond(readAll(late, 4800), 48000), 1e-3);
}

TEST_F(AudioReaderTest, ChoosesTheTrack) {
    const fs::path file = directory / "two.mkv";
    ffmpeg("-f lavfi -i color=size=32x32:rate=25:duration=1 -f lavfi -i "
           "sine=frequency=440:duration=1 -f lavfi -i anullsrc=r=48000:d=1 -map 0 -map 1 -map 2 "
           "-c:v ffv1 -c:a pcm_s16le -metadata:s:a:1 language=fra " +
           arg(file));
    AudioReaderOptions options;
    options.stream = 2;
    AudioReader silent(file, options);
    const std::vector<float> samples = readAll(silent);
    EXPECT_GE(samples.size(), 2U * 47000);
    EXPECT_EQ(*std::max_element(samples.begin(), samples.end()), 0.F);
    options.stream = 1;
    AudioReader tone(file, options);
    const std::vector<float> loud = readAll(tone);
    EXPECT_GT(*std::max_element(loud.begin(), loud.end()), 0.05F);
    options.stream = 0;
    EXPECT_TRUE(holds(openError(file, options), "has no sound in stream 0"));
    options.stream = 7;
    EXPECT_TRUE(holds(openError(file, options), "has no sound in stream 7"));
}

TEST_F(AudioReaderTest, RefusesWhatItCannotRead) {
    EXPECT_TRUE(holds(openError(directory / "none.mp4"), "does not exist"));
    spill(directory / "text.mp4", "no sound");
    EXPECT_TRUE(holds(openError(directory / "text.mp4"), "text.mp4"));
    ffmpeg("-f lavfi -i color=size=32x32:rate=25:duration=1 -c:v ffv1 " +
           arg(directory / "mute.mkv"));
    EXPECT_TRUE(holds(openError(directory / "mute.mkv"), "holds no sound"));
    const fs::path file = makeSines("s.wav", "-c:a pcm_s16le");
    AudioReaderOptions options;
    options.sampleRate = 1;
    EXPECT_TRUE(holds(openError(file, options), "sampleRate: is 1"));
    options = {};
    options.from = -1;
    EXPECT_TRUE(holds(openError(file, options), "from: is -1 s"));
    AudioReader reader(file);
    EXPECT_THROW(reader.seek(std::nan("")), Error);
}

// Each damaged copy is read to its end or refused; the sanitizers watch.
TEST_F(AudioReaderTest, SurvivesDamagedFiles) {
    const std::string whole = slurp(makeSines("s.mp4", "-c:a aac"));
    unsigned state = 1;
    for (int run = 0; run < 40; ++run) {
        std::string damaged = whole;
        for (int i = 0; i < 1 + run; ++i) {
            state = state * 1664525U + 1013904223U;
            damaged[(state >> 4) % damaged.size()] = static_cast<char>(state >> 24);
        }
        if (run % 4 == 0) damaged.resize(damaged.size() * static_cast<std::size_t>(run + 1) / 41);
        spill(directory / "d.mp4", damaged);
        try {
            AudioReader reader(directory / "d.mp4");
            (void)readAll(reader, 480'000);
            reader.seek(2);
            (void)readAll(reader, 4800);
        } catch (const Error& error) {
            EXPECT_TRUE(holds(std::string(error.what()), "d.mp4"));
        }
    }
}

} // namespace
} // namespace altiro3D::test
