#include "altiro3D/video_io.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/native_maker.hpp"
#include "media/ffmpeg.hpp"
#include "media/other_streams.hpp"
#include "media/video_container.hpp"
#include "media/video_input.hpp"
#include "media/video_packets.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/picture_files.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"
#include "support/video.hpp"
#include "video/conversion/video_pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <opencv2/core.hpp>
#include <set>
#include <tuple>
#include <utility>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

const cv::Size kSize(64, 48);

// The check sum of the packets of each stream of a kind ("a", "s"), in their order.
std::vector<std::string> streamHashes(const fs::path& file, const std::string& kind) {
    std::vector<std::string> sums;
    for (const std::string& line : lines(
             ffmpeg("-i " + arg(file) + " -map 0:" + kind + " -c copy -f streamhash -hash md5 -")))
        sums.push_back(line.substr(line.find("MD5=")));
    return sums;
}

// When a file begins: before 0 where sound begins before the picture (Matroska, FFmpeg 7).
double startOf(const fs::path& file) {
    return std::stod(lines(ffprobe(file, "format=start_time"))[0]);
}

std::vector<double> timesFromStart(const fs::path& file, const std::string& stream) {
    const double start = startOf(file);
    std::vector<double> times = packetTimes(file, stream);
    for (double& time : times)
        time -= start;
    return times;
}

// "800 One" for a chapter that ends 800 ms after the file's start.
std::vector<std::string> chapterEnds(const fs::path& file) {
    const double start = startOf(file);
    std::vector<std::string> ends;
    for (const std::string& line : lines(ffprobe(file, "chapter=end_time:chapter_tags=title"))) {
        const double end = std::stod(line) - start;
        ends.push_back(std::to_string(std::lround(1000 * end)) + " " +
                       line.substr(line.find('|') + 1));
    }
    return ends;
}

// The length that an MP4 or QuickTime file states. That of ffprobe 7 is the last stream's on the
// decoder's clock, which ends earlier where frames are out of order.
double statedSeconds(const fs::path& file) {
    const std::string bytes = slurp(file);
    const std::size_t header = bytes.find("mvhd"); // then version 0, two dates, units/s, units
    const double units = bigEndianAt(bytes, header + 20);
    return units / bigEndianAt(bytes, header + 16);
}

void expectNear(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        ASSERT_NEAR(a[i], b[i], tolerance) << i;
}

VideoWriterOptions optionsFor(const VideoReader& reader) {
    VideoWriterOptions options;
    options.size = reader.facts().size;
    options.timeBase = reader.facts().timeBase;
    options.frameRate = reader.facts().averageRate;
    options.constantRate = reader.facts().constantRate;
    options.preset = EncoderPreset::UltraFast;
    options.threads = 1;
    return options;
}

// Reads a film and writes it with its other streams; what the two remarked.
Notes copyFilm(const fs::path& from, const fs::path& to, const VideoReaderOptions& part = {},
               int most = 1000000) {
    VideoReader reader(from, part);
    VideoWriter writer(to, optionsFor(reader), &reader);
    VideoFrame frame;
    for (int i = 0; i < most && reader.read(frame); ++i)
        writer.write(frame);
    writer.finish();
    return writer.notes();
}

class VideoWriterTest : public FfmpegTest {
  protected:
    // A film with two sounds, subtitles, chapters and tags; AAC begins a little before 0 in it.
    fs::path makeFilm(const std::string& name,
                      const std::string& options = "-c:a:0 aac -c:a:1 pcm_s16le -c:s srt") const {
        spill(directory / "text.srt", "1\n00:00:00,200 --> 00:00:00,900\nHello\n\n"
                                      "2\n00:00:01,250 --> 00:00:01,750\n<i>World</i>\n");
        spill(directory / "film.txt",
              ";FFMETADATA1\ntitle=A film\nartist=Somebody\n"
              "[CHAPTER]\nTIMEBASE=1/1000\nSTART=0\nEND=800\ntitle=One\n"
              "[CHAPTER]\nTIMEBASE=1/1000\nSTART=800\nEND=2000\ntitle=Two\n");
        return make(name, "-f lavfi -i testsrc2=size=64x48:rate=24000/1001:duration=2 -f lavfi -i "
                          "sine=duration=2.3 -f lavfi -i sine=f=300:duration=2 -i " +
                              arg(directory / "text.srt") + " -i " + arg(directory / "film.txt") +
                              " -map 0:v -map 1:a -map 2:a -map 3:s -map_metadata 4 -c:v libx264 "
                              "-g 12 -bf 2 -pix_fmt yuv420p -metadata:s:a:0 language=eng "
                              "-metadata:s:a:1 language=slv -metadata:s:s:0 language=deu " +
                              options);
    }
};

struct Encoding {
    VideoCodec codec;
    const char* extension;
    bool compatible;
    double leastPsnr;   // dB at crf 16 or what the codec does by itself
    const char* pixels; // empty: the decoder's choice
};

class Encodings : public VideoWriterTest, public testing::WithParamInterface<Encoding> {};

// The program ffmpeg reads the picture back, so errors of reader and writer cannot cancel.
TEST_P(Encodings, KeepPicturesAndTimes) {
    const fs::path file = directory / (std::string("clip") + GetParam().extension);
    VideoWriterOptions options = smallOptions();
    options.codec = GetParam().codec;
    options.compatible = GetParam().compatible;
    writeClip(file, options, 10);
    const std::vector<cv::Mat> frames =
        ffmpegFrames(file, kSize, GetParam().codec == VideoCodec::Ffv1 ? "null" : "");
    ASSERT_EQ(frames.size(), 10u);
    VideoReader reader(file); // and by our own reader
    const std::vector<VideoFrame> again = allFrames(reader);
    ASSERT_EQ(again.size(), 10u);
    for (std::size_t i = 0; i < 10; ++i) {
        const cv::Mat picture = movingPicture(kSize, static_cast<int>(i));
        EXPECT_GE(cv::PSNR(frames[i], picture), GetParam().leastPsnr) << "frame " << i;
        EXPECT_GE(cv::PSNR(again[i].picture, picture), GetParam().leastPsnr) << "frame " << i;
    }
    const std::vector<double> times = packetTimes(file, "v:0");
    ASSERT_EQ(times.size(), 10u);
    for (int i = 0; i < 10; ++i)
        EXPECT_NEAR(times[static_cast<std::size_t>(i)], i / 25.0, 1e-6); // 40 ms fit everywhere
    if (GetParam().pixels[0] != '\0') {
        EXPECT_EQ(lines(ffprobe(file, "stream=pix_fmt"))[0], GetParam().pixels);
    }
    EXPECT_EQ(lines(ffprobe(file, "stream=avg_frame_rate"))[0], "25/1");
    EXPECT_NEAR(static_cast<double>(again[9].duration) * reader.facts().timeBase.value(), 0.04,
                1e-3);
}

std::string nameOf(const testing::TestParamInfo<Encoding>& encoding) {
    static const char* const kNames[] = {"H264", "H264Rgb", "Hevc", "Ffv1", "ProRes"};
    return std::string(kNames[static_cast<int>(encoding.param.codec)]) +
           (encoding.param.compatible ? "Compatible" : "") + "In" +
           std::string(encoding.param.extension).substr(1);
}

// Lossless is infinite, which cv::PSNR() gives as 361 dB.
INSTANTIATE_TEST_SUITE_P(VideoWriter, Encodings,
                         testing::Values(Encoding{VideoCodec::H264, ".mp4", false, 40, "yuv444p"},
                                         Encoding{VideoCodec::H264, ".mkv", false, 40, "yuv444p"},
                                         Encoding{VideoCodec::H264, ".mov", false, 40, "yuv444p"},
                                         Encoding{VideoCodec::H264, ".mp4", true, 30, "yuv420p"},
                                         Encoding{VideoCodec::H264Rgb, ".mp4", false, 40, "gbrp"},
                                         Encoding{VideoCodec::H264Rgb, ".mkv", false, 40, "gbrp"},
                                         Encoding{VideoCodec::Hevc, ".mp4", false, 38, "yuv444p"},
                                         Encoding{VideoCodec::Hevc, ".mkv", true, 28, "yuv420p"},
                                         Encoding{VideoCodec::Ffv1, ".mkv", false, 300, "bgr0"},
                                         Encoding{VideoCodec::ProRes, ".mov", false, 40, ""},
                                         Encoding{VideoCodec::ProRes, ".mkv", false, 40, ""}),
                         nameOf);

// A thing that moves before textured ground, each sub-pixel from its own view.
std::vector<cv::Mat> movingNatives(int count) {
    Display display;
    display.calibration = stripePanel(384, 256);
    display.quilt = QuiltLayout{8, 6, {96, 64}};
    const NativeMaker maker(display, {});
    const cv::Mat ground = randomPhoto({96, 64}, 5, 0.8);
    const cv::Mat near = randomPhoto({24, 24}, 6, 0.8);
    std::vector<cv::Mat> natives;
    for (int i = 0; i < count; ++i) {
        const cv::Rect place(10 + 2 * i, 20, near.cols, near.rows);
        altiro3D::Scene scene{ground.clone(), cv::Mat(ground.size(), CV_32FC1, cv::Scalar(0.2F))};
        near.copyTo(scene.photo(place));
        scene.depth(place).setTo(0.9F);
        natives.emplace_back();
        maker.makeNative(scene, natives.back());
    }
    return natives;
}

// What each sub-pixel shows counts, not a texture that looks alike, and colours as much as grey.
TEST_F(VideoWriterTest, NativesAreMoreAccurateThanOtherPicturesOfTheirSizeInTheFile) {
    ALTIRO3D_TAKES(15);
    const std::vector<cv::Mat> natives = movingNatives(12);
    const auto encoded = [&](VideoWriterOptions options, bool native) {
        options.native = native;
        const fs::path file = directory / "native.mkv";
        VideoWriter writer(file, options);
        for (std::size_t i = 0; i < natives.size(); ++i)
            writer.write({natives[i], static_cast<std::int64_t>(i), 1});
        writer.finish();
        double error = 0;
        const std::vector<cv::Mat> frames = ffmpegFrames(file, options.size);
        for (std::size_t i = 0; i < natives.size(); ++i)
            error += cv::norm(frames.at(i), natives[i], cv::NORM_L2SQR);
        return std::pair(error, static_cast<double>(fs::file_size(file)));
    };
    for (const VideoCodec codec : {VideoCodec::H264, VideoCodec::Hevc}) {
        for (const EncoderPreset preset :
             {EncoderPreset::UltraFast, EncoderPreset::SuperFast, EncoderPreset::Medium}) {
            VideoWriterOptions options = smallOptions();
            options.size = natives[0].size();
            options.codec = codec;
            options.preset = preset;
            const auto [error, size] = encoded(options, true);
            auto [usualError, usualSize] = encoded(options, false);
            while (usualSize < size && options.crf > 1) {
                options.crf -= 0.5;
                std::tie(usualError, usualSize) = encoded(options, false);
            }
            EXPECT_LT(error, usualError) << presetName(preset) << ", crf " << options.crf;
        }
    }
    VideoWriterOptions lossless = smallOptions();
    lossless.size = natives[0].size();
    lossless.crf = 0;
    EXPECT_EQ(encoded(lossless, true).first, encoded(lossless, false).first);
}

// Megabits of each second of a video, by its packets.
std::vector<double> megabitsOfSeconds(const fs::path& file) {
    std::vector<double> sums;
    for (const std::string& line : lines(ffprobe(file, "packet=pts_time,size"))) {
        const auto second = static_cast<std::size_t>(std::stod(line));
        sums.resize(std::max(sums.size(), second + 1));
        sums[second] += 8e-6 * std::stod(line.substr(line.find('|') + 1));
    }
    return sums;
}

void writeNoise(const fs::path& file, const VideoWriterOptions& options, int count) {
    VideoWriter writer(file, options);
    for (int i = 0; i < count; ++i)
        writer.write({randomPhoto(options.size, i + 1, 0.5), i, 1});
    writer.finish();
}

TEST_F(VideoWriterTest, MaxRateHoldsInEachSecondAndGivesTheSameBytes) {
    ALTIRO3D_TAKES(4);
    constexpr int kSeconds = 4;
    VideoWriterOptions options = smallOptions();
    options.size = {192, 128};
    options.native = true;
    options.threads = 4;
    const fs::path file = directory / "noise.mkv";
    const fs::path again = directory / "again.mkv";
    for (const VideoCodec codec : {VideoCodec::H264, VideoCodec::H264Rgb}) {
        options.codec = codec;
        for (const EncoderPreset preset :
             {EncoderPreset::UltraFast, EncoderPreset::SuperFast, EncoderPreset::Medium}) {
            SCOPED_TRACE(presetName(preset));
            options.preset = preset;
            options.maxRate = 0;
            writeNoise(file, options, 25);
            const double free = megabitsOfSeconds(file)[0];
            options.maxRate = free / 2;
            writeNoise(file, options, 25 * kSeconds);
            const std::vector<double> rates = megabitsOfSeconds(file);
            ASSERT_EQ(rates.size(), static_cast<std::size_t>(kSeconds));
            const double all = std::accumulate(rates.begin(), rates.end(), 0.0);
            EXPECT_LE(all, options.maxRate * (kSeconds + 1.5)); // some come early
            EXPECT_GE(all, options.maxRate * kSeconds * 0.8);
            for (std::size_t i = 1; i < rates.size(); ++i)
                EXPECT_LE(rates[i], options.maxRate * 1.25) << i;
            writeNoise(again, options, 25 * kSeconds);
            EXPECT_TRUE(slurp(file) == slurp(again));
            options.maxRate = 10 * free; // nothing to hold
            writeNoise(file, options, 25);
            EXPECT_NEAR(megabitsOfSeconds(file)[0], free, 0.1 * free);
        }
    }
}

// Arithmetic coding and deblocking take more than half of the time to decode.
TEST_F(VideoWriterTest, NativesAreCodedToBeDecodedQuickly) {
    const fs::path file = directory / "native.mkv";
    for (const EncoderPreset preset :
         {EncoderPreset::UltraFast, EncoderPreset::SuperFast, EncoderPreset::Fast}) {
        VideoWriterOptions options = smallOptions();
        options.preset = preset;
        options.native = true;
        writeClip(file, options, 3);
        std::set<std::string> found;
        for (const std::string& line : lines(ffmpeg(
                 "-v verbose -i " + arg(file) + " -c copy -bsf:v trace_headers -f null - 2>&1"))) {
            for (const char* field : {"entropy_coding_mode_flag", "disable_deblocking_filter_idc"})
                if (line.find(field) != std::string::npos)
                    found.insert(field + line.substr(line.rfind(' ')));
        }
        EXPECT_EQ(found, (std::set<std::string>{"entropy_coding_mode_flag 0",
                                                "disable_deblocking_filter_idc 1"}))
            << presetName(preset);
    }
}

TEST_F(VideoWriterTest, OddSizesAndSubMatricesAreKept) {
    for (const VideoCodec codec : {VideoCodec::H264, VideoCodec::H264Rgb, VideoCodec::Hevc,
                                   VideoCodec::Ffv1, VideoCodec::ProRes}) {
        for (const bool compatible : {false, true}) {
            if (compatible && codec != VideoCodec::H264) continue;
            VideoWriterOptions options = smallOptions();
            options.codec = codec;
            options.compatible = compatible; // takes even sizes alone
            options.size = compatible ? kSize : cv::Size(67, 41);
            const cv::Mat part = movingPicture({101, 83}, 3)(cv::Rect({7, 5}, options.size));
            VideoWriter writer(directory / "odd.mkv", options);
            for (int i = 0; i < 3; ++i)
                writer.write({part, i, 1});
            writer.finish();
            const std::vector<cv::Mat> frames = ffmpegFrames(directory / "odd.mkv", options.size);
            ASSERT_EQ(frames.size(), 3u) << static_cast<int>(codec);
            EXPECT_GE(cv::PSNR(frames[2], part), compatible ? 30 : 40) << static_cast<int>(codec);
        }
    }
}

TEST_F(VideoWriterTest, KnownColoursSurviveInEveryMatrixAndRange) {
    ALTIRO3D_TAKES(3);
    // Fields of 16 px: black, white, grey and strong colours.
    const cv::Vec3b colours[] = {{0, 0, 0},     {255, 255, 255}, {128, 128, 128}, {0, 0, 255},
                                 {0, 255, 0},   {255, 0, 0},     {0, 255, 255},   {255, 0, 255},
                                 {255, 255, 0}, {60, 120, 200},  {200, 120, 60},  {90, 200, 90}};
    cv::Mat chart(48, 64, CV_8UC3);
    for (int i = 0; i < 12; ++i) {
        const cv::Vec3b& c = colours[i];
        chart(cv::Rect(i % 4 * 16, i / 4 * 16, 16, 16)).setTo(cv::Scalar(c[0], c[1], c[2]));
    }
    const std::map<ColourMatrix, std::string> names = {{ColourMatrix::Bt601, "smpte170m"},
                                                       {ColourMatrix::Bt709, "bt709"},
                                                       {ColourMatrix::Bt2020, "bt2020nc"}};
    for (const auto& [matrix, name] : names) {
        for (const ColourRange range : {ColourRange::Limited, ColourRange::Full}) {
            for (const bool compatible : {false, true}) {
                VideoWriterOptions options = smallOptions();
                options.matrix = matrix;
                options.range = range;
                options.compatible = compatible;
                options.crf = 4;
                const fs::path file = directory / "chart.mp4";
                VideoWriter writer(file, options);
                writer.write({chart, 0, 1});
                writer.finish();
                EXPECT_EQ(lines(ffprobe(file, "stream=color_range,color_space"))[0],
                          (range == ColourRange::Full ? "pc|" : "tv|") + name);
                const std::vector<cv::Mat> frames = ffmpegFrames(file, kSize);
                ASSERT_EQ(frames.size(), 1u);
                for (int i = 0; i < 12; ++i) {
                    const auto found = frames[0].at<cv::Vec3b>(i / 4 * 16 + 8, i % 4 * 16 + 8);
                    for (int c = 0; c < 3; ++c) {
                        // Rounding of Y, U, V makes 2; crf 4 and 4:2:0 (in the middle) some more.
                        EXPECT_NEAR(found[c], colours[i][c], 5)
                            << name << " field " << i << " channel " << c;
                    }
                }
            }
        }
    }
}

TEST_F(VideoWriterTest, HighDefinitionIsBt709AndLimitedByItself) {
    VideoWriterOptions options = smallOptions();
    options.size = {32, 720};
    writeClip(directory / "high.mp4", options, 1);
    const std::string bytes = slurp(directory / "high.mp4");
    EXPECT_LT(bytes.find("moov"), bytes.find("mdat")); // the index comes first
    const std::string entries = "stream=color_range,color_space,color_transfer,color_primaries";
    EXPECT_EQ(lines(ffprobe(directory / "high.mp4", entries))[0], "tv|bt709|bt709|bt709");
    options.size = {32, 718};
    writeClip(directory / "low.mp4", options, 1);
    EXPECT_EQ(lines(ffprobe(directory / "low.mp4", "stream=color_range,color_space"))[0],
              "tv|smpte170m");
}

TEST_F(VideoWriterTest, TimesOfAnyBaseAreExactInMp4AndTo1msInMkv) {
    const struct {
        Fraction timeBase;
        std::vector<std::int64_t> times;
    } cases[] = {{{1001, 24000}, {0, 1, 2, 3, 4, 5, 6}},
                 {{1, 90000}, {0, 3003, 6007, 9009, 12100, 45001}},
                 {{1, 1000}, {0, 33, 67, 100, 340, 1230}},
                 {{1, 12800}, {512, 1024, 1536, 2048}}};
    for (const auto& [timeBase, times] : cases) {
        for (const char* const extension : {".mp4", ".mov", ".mkv"}) {
            VideoWriterOptions options = smallOptions();
            options.timeBase = timeBase;
            options.frameRate = {};
            options.constantRate = false;
            options.preset = EncoderPreset::VeryFast; // with B-frames
            const fs::path file = directory / (std::string("times") + extension);
            VideoWriter writer(file, options);
            for (std::size_t i = 0; i < times.size(); ++i) {
                const std::int64_t duration =
                    i + 1 < times.size() ? times[i + 1] - times[i] : 2 * times[1] - 2 * times[0];
                writer.write({movingPicture(kSize, static_cast<int>(i)), times[i], duration});
            }
            writer.finish();
            std::vector<double> expected;
            for (const std::int64_t time : times)
                expected.push_back(static_cast<double>(time) * timeBase.value());
            const bool mkv = std::string(extension) == ".mkv";
            // ffprobe writes six digits
            expectNear(packetTimes(file, "v:0"), expected, mkv ? 0.00051 : 0.000001);
            if (!mkv) {
                const double end = static_cast<double>(times.back() + 2 * (times[1] - times[0])) *
                                   timeBase.value();
                // the file's length is kept to 1 ms
                EXPECT_NEAR(statedSeconds(file), end, 0.0011);
                EXPECT_EQ(lines(ffprobe(file, "frame=pts", "-select_streams v:0")).size(),
                          times.size());
            }
        }
    }
}

TEST_F(VideoWriterTest, EverythingBesideThePicturesIsKept) {
    ALTIRO3D_TAKES(4);
    const fs::path film = makeFilm("film.mkv");
    const fs::path copy = directory / "copy.mkv";
    EXPECT_TRUE(copyFilm(film, copy).empty());
    EXPECT_EQ(lines(ffprobe(copy, "stream=codec_name")),
              (std::vector<std::string>{"h264", "aac", "pcm_s16le", "subrip"}));
    EXPECT_EQ(streamHashes(copy, "a"), streamHashes(film, "a"));
    EXPECT_EQ(streamHashes(copy, "s"), streamHashes(film, "s"));
    for (const char* const stream : {"v:0", "a:0", "a:1", "s:0"})
        expectNear(timesFromStart(copy, stream), timesFromStart(film, stream), 0.0011);
    EXPECT_EQ(lines(ffprobe(copy, "stream_tags=language", "-select_streams a")),
              (std::vector<std::string>{"eng", "slv"}));
    EXPECT_EQ(lines(ffprobe(copy, "format_tags=title,artist")),
              (std::vector<std::string>{"A film|Somebody"}));
    EXPECT_EQ(chapterEnds(copy), chapterEnds(film));
    EXPECT_EQ(lines(ffprobe(copy, "stream=avg_frame_rate", "-select_streams v"))[0], "24000/1001");
    EXPECT_EQ(lines(ffprobe(copy, "packet=duration_time", "-select_streams s")),
              lines(ffprobe(film, "packet=duration_time", "-select_streams s")));
}

TEST_F(VideoWriterTest, Mp4GetsTextSubtitlesAsMovText) {
    const fs::path film = makeFilm("film.mkv", "-c:a:0 aac -c:a:1 aac -c:s srt");
    const fs::path copy = directory / "copy.mp4";
    const Notes notes = copyFilm(film, copy);
    EXPECT_EQ(only(notes).text, film.string() + ": subtitles subrip (deu) become mov_text");
    EXPECT_EQ(lines(ffprobe(copy, "stream=codec_name", "-select_streams s"))[0], "mov_text");
    EXPECT_EQ(lines(ffprobe(copy, "stream_tags=language", "-select_streams s"))[0], "deu");
    EXPECT_EQ(ffmpeg("-i " + arg(copy) + " -map 0:s -f srt -"),
              ffmpeg("-i " + arg(film) + " -map 0:s -f srt -"));
    EXPECT_EQ(streamHashes(copy, "a"), streamHashes(film, "a"));
    EXPECT_EQ(chapterEnds(copy), chapterEnds(film));
    EXPECT_EQ(lines(ffprobe(copy, "format_tags=title,artist"))[0], "A film|Somebody");
    // ... and back: Matroska has no mov_text.
    const fs::path back = directory / "back.mkv";
    EXPECT_EQ(copyFilm(copy, back).size(), 1u);
    EXPECT_EQ(lines(ffprobe(back, "stream=codec_name", "-select_streams s"))[0], "subrip");
    EXPECT_EQ(ffmpeg("-i " + arg(back) + " -map 0:s -f srt -"),
              ffmpeg("-i " + arg(film) + " -map 0:s -f srt -"));
}

TEST_F(VideoWriterTest, SoundThatBeginsBeforeThePicturesDoesNotMoveThem) {
    ALTIRO3D_TAKES(3);
    const fs::path film = makeFilm("film.mp4", "-c:a aac -c:s mov_text");
    ASSERT_LT(packetTimes(film, "a:0").front(), 0);
    copyFilm(makeFilm("pcm.mkv"), directory / "pcm.mov"); // which holds uncompressed sound
    EXPECT_EQ(streamHashes(directory / "pcm.mov", "a"), streamHashes(directory / "pcm.mkv", "a"));
    for (const char* const name : {"copy.mp4", "copy.mkv", "copy.mov"}) {
        const fs::path copy = directory / name;
        copyFilm(film, copy);
        expectNear(packetTimes(copy, "v:0"), packetTimes(film, "v:0"),
                   copy.extension() == ".mkv" ? 0.00051 : 0.000001);
        EXPECT_EQ(streamHashes(copy, "a"), streamHashes(film, "a")) << name;
        expectNear(packetTimes(copy, "a:0"), packetTimes(film, "a:0"), 0.0011);
    }
}

TEST_F(VideoWriterTest, AContainerForTheSoundAndSubtitlesIsFound) {
    const auto extensionOf = [&](const std::string& codecs, const VideoWriterOptions& options) {
        const fs::path film = makeFilm("film.mkv", codecs);
        VideoReader reader(film);
        std::string extension = VideoWriter::extensionFor(reader, options);
        VideoReader again(film);
        VideoWriterOptions encoding = optionsFor(again);
        encoding.codec = options.codec;
        encoding.audio = options.audio;
        EXPECT_NO_THROW(VideoWriter(directory / ("copy" + extension), encoding, &again)) << codecs;
        return extension;
    };
    VideoWriterOptions options = smallOptions();
    EXPECT_EQ(extensionOf("-c:a aac -c:s srt", options), ".mp4");
    EXPECT_EQ(extensionOf("-c:a:0 aac -c:a:1 wavpack -c:s srt", options), ".mkv");
    options.audio = false;
    EXPECT_EQ(extensionOf("-c:a:0 aac -c:a:1 wavpack -c:s srt", options), ".mp4");
    options.audio = true;
    options.codec = VideoCodec::ProRes;
    EXPECT_EQ(extensionOf("-c:a pcm_s16le -c:s srt", options), ".mov");
    options.codec = VideoCodec::Ffv1;
    EXPECT_EQ(extensionOf("-c:a aac -c:s srt", options), ".mkv");
}

TEST_F(VideoWriterTest, AdviceAboutSoundIsRightWhenFollowed) {
    for (const std::string codec : {"wmav2", "adpcm_ms", "adpcm_ima_wav", "adpcm_g722"}) {
        const bool isG722 = codec == "adpcm_g722";
        const fs::path film =
            make(codec == "wmav2" ? "film.wmv" : "film.avi",
                 "-f lavfi -i testsrc2=size=96x64:rate=25:duration=0.4 -f lavfi -i "
                 "sine=duration=0.4 -c:v mpeg4 -c:a " +
                     codec + (isG722 ? " -ar 16000" : ""));
        VideoReader reader(film);
        EXPECT_TRUE(
            holds(errorOf([&] { VideoWriter(directory / "a.mp4", optionsFor(reader), &reader); }),
                  "expected a name that ends in .mkv, or no sound"))
            << codec;
        const fs::path copy = directory / "copy.mkv";
        copyFilm(film, copy);
        EXPECT_EQ(lines(ffprobe(copy, "stream=codec_name", "-select_streams a"))[0], codec);
        EXPECT_EQ(ffmpeg("-i " + arg(copy) + " -map 0:a -f md5 -"),
                  ffmpeg("-i " + arg(film) + " -map 0:a -f md5 -"));
    }
    const fs::path flash =
        make("film.flv", "-f lavfi -i testsrc2=size=96x64:rate=25:duration=0.4 -f lavfi -i "
                         "sine=duration=0.4:sample_rate=22050 -c:v flv -c:a adpcm_swf");
    VideoReader reader(flash);
    const std::string error =
        errorOf([&] { VideoWriter(directory / "a.mp4", optionsFor(reader), &reader); });
    EXPECT_TRUE(holds(error, ", expected no sound")); // nothing holds it
}

TEST_F(VideoWriterTest, WhatIsEncryptedIsSaid) {
    const fs::path film = make("film.mp4", "-f lavfi -i testsrc2=size=96x64:rate=25:duration=0.4 "
                                           "-f lavfi -i sine=duration=0.4 -c:v mpeg4 -c:a aac");
    const fs::path closed =
        make("closed.mp4", "-i " + arg(film) +
                               " -c copy -encryption_scheme cenc-aes-ctr "
                               "-encryption_key 76a6c65c5ea762046bd749a2e632ccbb "
                               "-encryption_kid a7e61c373e219033c21091fa607bf3b8");
    EXPECT_EQ(codeOf([&] { VideoReader{closed}; }), ErrorCode::Unsupported);
    EXPECT_TRUE(holds(errorOf([&] { VideoReader{closed}; }), closed.string() + ": is encrypted"));
    EXPECT_TRUE(holds(errorOf([&] { AudioReader{closed}; }), "has sound that is encrypted"));
    // only its sound
    std::string bytes = slurp(film);
    bytes.replace(bytes.find("mp4a", bytes.rfind("stsd")), 4, "enca");
    spill(film, bytes);
    EXPECT_EQ(only(copyFilm(film, directory / "copy.mp4")).text,
              film.string() + ": sound aac is encrypted and left out");
}

TEST_F(VideoWriterTest, WhatAContainerCannotHoldIsNamedBeforeWork) {
    // FFmpeg 7 puts PCM into MP4
    const fs::path film = makeFilm("film.mkv", "-c:a:0 aac -c:a:1 wavpack -c:s srt");
    const fs::path copy = directory / "copy.mp4";
    VideoReader begun(film);
    ASSERT_TRUE(begun.next());
    EXPECT_EQ(errorOf([&] { VideoWriter(directory / "x.mkv", optionsFor(begun), &begun); }),
              "source: has delivered a frame already, expected a writer before the first one");
    VideoReader reader(film);
    const auto problem = [&](const fs::path& file, const VideoWriterOptions& options,
                             VideoReader* source) {
        return problemOf(file, [&] { VideoWriter(file, options, source); });
    };
    EXPECT_EQ(problem(copy, optionsFor(reader), &reader),
              "cannot hold the sound wavpack (slv) of " + film.string() +
                  ", expected a name that ends in .mkv, or no sound");
    EXPECT_FALSE(fs::exists(copy) || fs::exists(copy.string() + ".part"));
    VideoWriterOptions options = smallOptions();
    options.codec = VideoCodec::Ffv1;
    EXPECT_EQ(problem(copy, options, nullptr),
              "cannot hold ffv1 video, expected a name that ends in .mkv");
    options.codec = VideoCodec::ProRes;
    EXPECT_EQ(problem(copy, options, nullptr),
              "cannot hold prores video, expected a name that ends in .mov or .mkv");
    EXPECT_EQ(problem(directory / "copy.avi", smallOptions(), nullptr),
              "has a name that no video container here has, expected .mkv, .mp4 or .mov");
    // Without the sound it goes.
    VideoReader again(film);
    VideoWriterOptions silent = optionsFor(again);
    silent.audio = false;
    silent.subtitles = false;
    silent.chapters = false;
    silent.metadata = false;
    silent.tags = {{"title", "Mine"}};
    VideoWriter writer(copy, silent, &again);
    while (const auto frame = again.next())
        writer.write(*frame);
    writer.finish();
    EXPECT_EQ(lines(ffprobe(copy, "stream=codec_name")), std::vector<std::string>{"h264"});
    EXPECT_EQ(ffprobe(copy, "chapter=start_time"), "");
    EXPECT_EQ(lines(ffprobe(copy, "format_tags=title,artist"))[0], "Mine");
}

TEST_F(VideoWriterTest, APartHasTheSoundOfThePart) {
    for (const char* const name : {"film.mkv", "film.mp4"}) {
        const fs::path film =
            makeFilm(name, std::string(name) == "film.mkv" ? "-c:a pcm_s16le -c:s srt"
                                                           : "-c:a aac -c:s mov_text");
        VideoReaderOptions part;
        part.from = 0.5;
        part.to = 1.5;
        const fs::path copy = directory / ("part-" + std::string(name));
        copyFilm(film, copy, part);
        std::vector<double> expected;
        for (const double time : packetTimes(film, "a:0"))
            if (time >= 0.5 - 1e-6 && time < 1.5 - 1e-6) expected.push_back(time - 0.5);
        expectNear(packetTimes(copy, "a:0"), expected, 0.0011);
        expected.clear();
        for (const double time : packetTimes(film, "v:0"))
            if (time >= 0.4995 && time < 1.4995) expected.push_back(time - 0.5);
        expectNear(packetTimes(copy, "v:0"), expected, 0.0011);
        // The first subtitle has begun before the part, the second ends behind it.
        EXPECT_EQ(lines(ffprobe(copy, "chapter=start_time,end_time:chapter_tags=title")),
                  (std::vector<std::string>{"0.000000|0.300000|One", "0.300000|1.000000|Two"}));
        EXPECT_EQ(ffmpeg("-i " + arg(copy) + " -map 0:s -f srt -").substr(0, 37),
                  "1\n00:00:00,000 --> 00:00:00,400\nHello");
    }
}

TEST_F(VideoWriterTest, AnEarlyStopEndsTheSoundWithThePictures) {
    const fs::path film = makeFilm("film.mkv");
    const fs::path copy = directory / "copy.mkv";
    copyFilm(film, copy, {}, 12);
    EXPECT_EQ(packetTimes(copy, "v:0").size(), 12u);
    EXPECT_NEAR(packetTimes(copy, "a:0").back(), 0.5, 0.03);
    // Read to the end, all of the sound is kept though it is longer.
    const fs::path whole = directory / "whole.mkv";
    copyFilm(film, whole);
    EXPECT_GT(packetTimes(whole, "a:0").back(), 2.2);
}

TEST_F(VideoWriterTest, ItsSourceMayBeReadInAnotherThread) {
    const fs::path film = makeFilm("film.mkv");
    const fs::path alone = directory / "alone.mkv";
    copyFilm(film, alone);

    const fs::path together = directory / "together.mkv";
    auto reader = std::make_unique<VideoReader>(film);
    VideoWriter writer(together, optionsFor(*reader), reader.get());
    runPipeline({{"read",
                  [&](PipelineFrame& frame) {
                      if (reader->read(frame.source)) return true;
                      reader.reset(); // the last frames are still to be written
                      return false;
                  }},
                 {"write", [&](PipelineFrame& frame) {
                      writer.write(frame.source);
                      return true;
                  }}});
    writer.finish();
    for (const char* const kind : {"v", "a", "s"}) // packets may come out in another order
        EXPECT_EQ(streamHashes(together, kind), streamHashes(alone, kind)) << kind;
}

// AAC of a transport stream has headers that .mp4 takes off; damaged ones cannot be.
TEST_F(VideoWriterTest, DamagedSoundIsLeftOutWithANote) {
    const fs::path film = makeFilm("film.mkv", "-map -0:s -c:a aac");
    const fs::path stream = directory / "film.ts";
    ffmpeg("-i " + arg(film) + " -map 0:v -map 0:a:0 -c copy " + arg(stream));
    std::string bytes = slurp(stream);
    // The headers (ff f1 50) of some packets in the middle.
    int broken = 0;
    for (std::size_t at = bytes.size() / 3;
         broken < 4 && (at = bytes.find("\xff\xf1\x50", at)) != std::string::npos; ++broken)
        bytes[at + 1] = '\x01';
    ASSERT_EQ(broken, 4);
    spill(stream, bytes);
    const fs::path copy = directory / "copy.mp4";
    const Notes notes = copyFilm(stream, copy);
    EXPECT_EQ(packetTimes(copy, "v:0").size(), 48u);
    // FFmpeg 7 loses more around a broken header than FFmpeg 5
    const std::size_t whole = packetTimes(film, "a:0").size();
    EXPECT_GT(packetTimes(copy, "a:0").size(), whole * 6 / 10);
    EXPECT_LT(packetTimes(copy, "a:0").size(), whole);
    EXPECT_FALSE(notes.empty());
    for (const Note& note : notes)
        EXPECT_TRUE(holds(note.text, "could not be kept"));
}

TEST(VideoWriterOptions, SoundOfTimesThatNoNumberHoldsIsLeftOut) {
    constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
    const auto taken = [](std::int64_t pts, std::int64_t duration, std::int64_t origin) {
        OtherStreams others;
        OtherStream& stream = others.streams.emplace_back();
        stream.parameters.reset(avcodec_parameters_alloc());
        stream.timeBase = {1, 1000000};
        others.want();
        others.take(0);
        others.begin();
        others.setRange(origin, std::nullopt, {1, 1}, true);
        PacketPtr packet = newPacket();
        packet->pts = pts;
        packet->dts = pts;
        packet->duration = duration;
        others.push(0, std::move(packet));
        return others.pop(0, std::nullopt, {1, 1000});
    };
    EXPECT_EQ(taken(7000000, 1, 5)->pts, 2000000);
    EXPECT_EQ(taken(7000000, kMax, 5)->pts, 2000000);
    EXPECT_EQ(taken(kMax, 1, 0), nullptr);
    EXPECT_EQ(taken(-kMax, 1, 5), nullptr);
    EXPECT_EQ(taken(7, 1, kMax / 3), nullptr) << "the origin is none in the stream's unit";
}

class VideoWriterFile : public FileTest {};

TEST_F(VideoWriterFile, ChaptersOfTimesThatNoNumberHoldsAreLeftOut) {
    writeClip(directory / "clip.mkv", smallOptions(), 2);
    VideoInput input = openVideoInput(directory / "clip.mkv", {});
    input.facts.chapters = {{0, 1, "One"}, {1, 1e300, "Long"}, {1e10, 2e10, "Late"}};
    OtherStreams others;
    describeOthers(input, {}, others);
    ASSERT_EQ(others.chapters.size(), 2u); // in ns, as they are written
    EXPECT_EQ(others.chapters[1].title, "Long");
    EXPECT_LT(others.chapters[1].end, 9.2e9);
}

TEST_F(VideoWriterFile, AfterAFailureAtTheEndItIsLost) {
    for (const char* const name : {"clip.mkv", "clip.mp4"}) {
        const fs::path file = directory / name;
        VideoWriter writer(file, smallOptions());
        writer.write({movingPicture(kSize, 0), 0, 1});
        fs::create_directory(file);
        EXPECT_TRUE(startsWith(errorOf([&] { writer.finish(); }), file.string() + ": cannot be "));
        const std::string lost = file.string() + ": cannot be written any further after a failure";
        EXPECT_EQ(errorOf([&] { writer.finish(); }), lost);
        EXPECT_EQ(errorOf([&] { writer.write({movingPicture(kSize, 1), 1, 1}); }), lost);
    }
}

TEST_F(VideoWriterFile, APictureThatTheContainerRefusesIsNoDamagedSound) {
    VideoContainer container(directory / "clip.mkv");
    const ParametersPtr parameters(avcodec_parameters_alloc());
    parameters->codec_type = AVMEDIA_TYPE_VIDEO;
    parameters->codec_id = AV_CODEC_ID_FFV1;
    parameters->width = kSize.width;
    parameters->height = kSize.height;
    const auto source = std::make_shared<OtherStreams>();
    source->want();
    source->begin();
    Notes notes;
    container.open(*parameters, smallOptions(), source, notes);
    for (const std::int64_t time : {0, 2, 1, 3}) { // the third is refused: times must rise
        const PacketPtr packet = newPacket();
        ASSERT_EQ(av_new_packet(packet.get(), 100), 0);
        std::memset(packet->data, 0, 100);
        packet->pts = packet->dts = time;
        packet->duration = 1;
        container.write(*packet);
    }
    EXPECT_EQ(errorOf([&] { container.finish(3, notes); }),
              (directory / "clip.mkv").string() +
                  ": would lack 1 of 4 pictures, which were refused as damaged");
    EXPECT_TRUE(notes.empty());
}

TEST_F(VideoWriterTest, PacketsAreInterleaved) {
    const fs::path film = makeFilm("film.mkv", "-c:a aac -c:s srt");
    for (const char* const name : {"copy.mkv", "copy.mp4"}) {
        const fs::path copy = directory / name;
        copyFilm(film, copy);
        std::vector<std::pair<std::int64_t, double>> packets;
        for (const std::string& line : lines(ffprobe(copy, "packet=dts_time,pos"))) {
            const std::size_t bar = line.find('|');
            if (line.compare(0, bar, "N/A") == 0) continue;
            packets.emplace_back(std::stoll(line.substr(bar + 1)), std::stod(line));
        }
        // all of them, or two seconds tell nothing
        EXPECT_EQ(packets.size(), lines(ffprobe(copy, "packet=size")).size()) << name;
        ASSERT_GT(packets.size(), 48U) << name;
        std::sort(packets.begin(), packets.end());
        double most = -1;
        for (const auto& [position, time] : packets) {
            EXPECT_GE(time, most - 1.1) << name; // mp4 gathers up to a second per chunk
            most = std::max(most, time);
        }
    }
}

TEST_F(VideoWriterTest, TheRotationOfTheSourceIsNotWrittenAgain) {
    const fs::path film = makeFilm("film.mp4", "-c:a aac -c:s mov_text");
    const fs::path turned = directory / "turned.mp4";
    spill(turned, turnedClockwise(slurp(film), 90)); // the video is the first track
    ASSERT_NE(VideoReader(turned).facts().rotationDegrees, 0);
    for (const char* const name : {"copy.mp4", "copy.mkv"}) {
        const fs::path copy = directory / name;
        copyFilm(turned, copy);
        EXPECT_EQ(lines(ffprobe(copy, "stream=width,height", "-select_streams v"))[0], "48|64");
        EXPECT_TRUE(lines(ffprobe(copy, "stream_side_data=rotation")).empty());
        EXPECT_TRUE(lines(ffprobe(copy, "stream_tags=rotate")).empty());
    }
}

TEST_F(VideoWriterTest, AttachmentsGoIntoMatroskaOnly) {
    spill(directory / "font.ttf", std::string(1000, 'f'));
    const fs::path film = directory / "film.mkv";
    ffmpeg("-f lavfi -i testsrc2=size=64x48:duration=1 -c:v libx264 -attach " +
           arg(directory / "font.ttf") + " -metadata:s:t mimetype=font/ttf " + arg(film));
    EXPECT_TRUE(copyFilm(film, directory / "copy.mkv").empty());
    EXPECT_EQ(lines(ffprobe(directory / "copy.mkv", "stream=codec_type")),
              (std::vector<std::string>{"video", "attachment"}));
    const Notes notes = copyFilm(film, directory / "copy.mp4");
    EXPECT_EQ(only(notes).text, film.string() + ": attachment is left out");
}

TEST_F(VideoWriterTest, RealClipsKeepTheirSoundAndTimes) {
    ALTIRO3D_TAKES(5);
    for (const char* const name : {"flower.mp4", "realshort.mp4", "bigbuckbunny.mp4"}) {
        ALTIRO3D_REQUIRE_DATA(std::string("videos/") + name);
        const fs::path film = dataPath(std::string("videos/") + name);
        VideoReader reader(film);
        VideoWriterOptions options = optionsFor(reader);
        options.size = kSize; // pictures of another size, as a Native has
        for (const char* const extension : {".mp4", ".mkv"}) {
            if (name[0] != 'f' && extension[2] == 'k') continue; // one film for both is enough
            const fs::path copy = directory / (std::string("copy") + extension);
            VideoReader source(film);
            VideoWriter writer(copy, options, &source);
            VideoFrame frame;
            for (int i = 0; source.read(frame); ++i)
                writer.write({movingPicture(kSize, i), frame.pts, frame.duration});
            writer.finish();
            EXPECT_EQ(streamHashes(copy, "a"), streamHashes(film, "a"));
            expectNear(packetTimes(copy, "v:0"), packetTimes(film, "v:0"),
                       std::string(extension) == ".mkv" ? 0.00051 : 0.000001);
        }
    }
}

TEST_F(VideoWriterFile, EqualFramesGiveEqualBytes) {
    for (const VideoCodec codec :
         {VideoCodec::H264, VideoCodec::Hevc, VideoCodec::Ffv1, VideoCodec::ProRes}) {
        const bool isThere = avcodec_find_encoder_by_name("libx265") != nullptr; // not on Windows
        if (codec == VideoCodec::Hevc && !isThere) continue;
        for (const char* const extension : {".mkv", ".mov"}) {
            if (codec == VideoCodec::Ffv1 && std::string(extension) == ".mov") continue;
            VideoWriterOptions options = smallOptions();
            options.codec = codec;
            options.threads = 2;
            const fs::path a = directory / (std::string("a") + extension);
            const fs::path b = directory / (std::string("b") + extension);
            writeClip(a, options, 12);
            if (codec == VideoCodec::Ffv1 || codec == VideoCodec::ProRes) options.threads = 1;
            writeClip(b, options, 12);
            EXPECT_EQ(slurp(a), slurp(b)) << static_cast<int>(codec) << extension;
        }
    }
}

TEST_F(VideoWriterFile, TheNameAppearsOnlyWhenTheFileIsWhole) {
    const fs::path file = directory / "clip.mkv";
    spill(file, "old");
    {
        VideoWriter writer(file, smallOptions());
        writer.write({movingPicture(kSize, 0), 0, 1});
        EXPECT_TRUE(fs::exists(directory / "clip.mkv.part"));
        EXPECT_EQ(slurp(file), "old");
        EXPECT_TRUE(holds(errorOf([&] { VideoWriter(file, smallOptions()); }),
                          "is being written by another process (clip.mkv.part)"));
    }
    EXPECT_EQ(slurp(file), "old");
    EXPECT_EQ(filesIn(directory.path()), 1u);
    spill(directory / "clip.mkv.part", "left by a crash");
    writeClip(file, smallOptions(), 3);
    EXPECT_EQ(filesIn(directory.path()), 1u);
    VideoReader reader(file);
    EXPECT_EQ(allFrames(reader).size(), 3u);
}

TEST_F(VideoWriterFile, FramesAreChecked) {
    VideoWriter writer(directory / "clip.mkv", smallOptions());
    const auto write = [&](const cv::Mat& picture, std::int64_t time) {
        return errorOf([&, frame = VideoFrame{picture, time, 1}] { writer.write(frame); });
    };
    const cv::Mat picture = movingPicture(kSize, 0);
    EXPECT_EQ(errorOf([&] { writer.finish(); }), "finish: comes before the first frame");
    EXPECT_EQ(write(cv::Mat(50, 64, CV_8UC3), 0),
              "frame: is 64 x 50 px of CV_8UC3, expected 64 x 48 px");
    EXPECT_EQ(write(cv::Mat(kSize, CV_8UC1), 0),
              "frame: is 64 x 48 px of CV_8UC1, expected CV_8UC3");
    EXPECT_EQ(write(picture, -1), "frame: has the time -1, expected 0 or more");
    EXPECT_TRUE(holds(write(picture, std::numeric_limits<std::int64_t>::max()),
                      "expected at most 1e+11 s after the last one"));
    EXPECT_EQ(write(picture, 5), "(no error)");
    EXPECT_EQ(write(picture, 5), "frame: has the time 5, expected more than the last one's, 5");
    writer.finish();
    EXPECT_EQ(write(picture, 6), "write: comes after finish()");
}

TEST_F(VideoWriterFile, PausesAreStoredOrRefused) {
    for (const char* name : {"clip.mp4", "clip.mkv"}) {
        for (const int rate : {25, 1000, 90000}) {
            for (const double seconds : {2e4, 1e5, 2e5, 1e9, 9e10}) {
                VideoWriterOptions options = smallOptions();
                options.timeBase = {1, rate};
                options.constantRate = false;
                VideoWriter writer(directory / name, options);
                writer.write({movingPicture(kSize, 0), 0, 1});
                const VideoFrame later{movingPicture(kSize, 1), std::llround(seconds * rate), 1};
                const std::string error = errorOf([&] { writer.write(later); });
                writer.finish();
                VideoReader reader(directory / name);
                ASSERT_TRUE(reader.next());
                const std::optional<VideoFrame> second = reader.next();
                EXPECT_EQ(second.has_value(), error == "(no error)") << error;
                EXPECT_TRUE(second || holds(error, " s after the last one")) << error;
                EXPECT_TRUE(second || (seconds > 2e4 && fs::path(name).extension() == ".mp4"));
                if (!second) continue;
                const auto ticks = static_cast<double>(second->pts);
                EXPECT_NEAR(ticks * reader.facts().timeBase.value(), seconds, 1e-3);
            }
        }
    }
}

TEST(VideoWriterOptions, AreChecked) {
    using Options = VideoWriterOptions;
    const std::pair<std::function<void(Options&)>, const char*> cases[] = {
        {[](Options&) {}, "(no error)"},
        {[](Options& o) { o.size = cv::Size(8, 48); },
         "size: is 8 x 48 px, expected 16..16384 px a side"},
        {[](Options& o) { o.crf = 52; }, "crf: is 52, expected 0..51"},
        {[](Options& o) { o.preset = static_cast<EncoderPreset>(9); },
         "preset: is 9, expected an EncoderPreset"},
        {[](Options& o) { o.timeBase.numerator = 0; }, "timeBase: is 0/25, expected more than 0"},
        {[](Options& o) { o.colour.emplace().primaries = 100000; },
         "colour.primaries: is 100000, expected 1.."},
        {[](Options& o) { o.colour.emplace().transfer = -1; },
         "colour.transfer: is -1, expected 1.."},
        {[](Options& o) { o.threads = -1; }, "threads: is -1, expected 0..64"}};
    const auto problem = [](const std::function<void(Options&)>& change) {
        Options options = smallOptions();
        change(options);
        return errorOf([&] { validate(options); });
    };
    for (const auto& [change, expected] : cases)
        EXPECT_TRUE(startsWith(problem(change), expected));
    for (const double rate : {-1.0, 0.5, 100001.0, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_TRUE(startsWith(problem([&](auto& o) { o.maxRate = rate; }), "maxRate: is "));
    // what does not go together
    Options together = smallOptions();
    together.maxRate = 50;
    const auto problemOfAll = [&] { return errorOf([&] { validate(together); }); };
    together.codec = VideoCodec::H264Rgb;
    EXPECT_EQ(problemOfAll(), "(no error)");
    together.crf = 0;
    EXPECT_EQ(problemOfAll(), "maxRate: is set, expected a crf of 1 or more with it");
    together.codec = VideoCodec::Hevc;
    EXPECT_EQ(problemOfAll(), "maxRate: is set, expected the codec H264 or H264Rgb with it");
    together = smallOptions();
    together.compatible = true;
    together.size.width = 65;
    EXPECT_EQ(problemOfAll(),
              "size: is 65 x 48 px, expected even sides for 4:2:0 (4:4:4 takes any, or change the "
              "size first)");
    together.codec = VideoCodec::ProRes;
    EXPECT_EQ(problemOfAll(), "compatible: is set, expected the codec H264 or Hevc with it");
    EXPECT_TRUE(canWriteVideo("a.MKV"));
    EXPECT_TRUE(canWriteVideo("a.m4v"));
    EXPECT_FALSE(canWriteVideo("a.webm"));
}

} // namespace
} // namespace altiro3D::test
