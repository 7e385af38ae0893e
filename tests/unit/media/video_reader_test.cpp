#include "altiro3D/video_io.hpp"

#include "media/frame_decoder.hpp"
#include "media/video_input.hpp"
#include "media/video_picture.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/heif_files.hpp"
#include "support/picture_files.hpp"
#include "support/slow.hpp"
#include "support/video.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <tuple>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

class VideoReaderTest : public FfmpegTest {
  protected:
    // A bar that moves by 16 px a frame, 8 px a field.
    fs::path makeInterlaced(const std::string& name, const std::string& codec) const {
        return make(name, "-f lavfi -i color=gray:size=320x96:rate=50:duration=1.2 -f lavfi -i "
                          "color=white:size=40x96:rate=50:duration=1.2 -filter_complex "
                          "'[0][1]overlay=x=mod(n*4\\,280):shortest=1,interlace=lowpass=0' "
                          "-pix_fmt yuv420p " +
                              codec);
    }
};

VideoReaderOptions partFrom(double from, double to = 0) {
    VideoReaderOptions options;
    options.from = from;
    if (to > 0) options.to = to;
    return options;
}

VideoReaderOptions ofBothEyes() {
    VideoReaderOptions options;
    options.bothEyes = true;
    return options;
}

// Chroma is brought to full size in 8 bits before it becomes BGR, in the program after: half a
// level of U or V is 1.1 levels of blue, and both round.
constexpr double kMaxDifference = 3;
constexpr double kMeanDifference = 0.6;

// The times that ffprobe gives for the frames of the first video stream.
std::vector<std::int64_t> probedTimes(const fs::path& file) {
    std::vector<std::int64_t> times;
    for (const std::string& line :
         lines(ffprobe(file, "frame=best_effort_timestamp", "-select_streams v:0")))
        times.push_back(std::stoll(line));
    return times;
}

std::vector<std::int64_t> timesOf(const std::vector<VideoFrame>& frames) {
    std::vector<std::int64_t> times;
    for (const VideoFrame& frame : frames)
        times.push_back(frame.pts);
    return times;
}

std::string matrixFilter(ColourMatrix matrix) {
    const char* const name = matrix == ColourMatrix::Bt709    ? "bt709"
                             : matrix == ColourMatrix::Bt2020 ? "bt2020"
                                                              : "bt601";
    return std::string("scale=in_color_matrix=") + name +
           ":in_h_chr_pos=0:flags=bicubic+accurate_rnd+full_chroma_int+full_chroma_inp";
}

class RealClips : public testing::TestWithParam<const char*> {};

TEST_P(RealClips, FramesAndTimesAreThoseOfFfmpeg) {
    ALTIRO3D_REQUIRE_FFMPEG();
    ALTIRO3D_REQUIRE_DATA(std::string("videos/") + GetParam());
    const fs::path file = dataPath(std::string("videos/") + GetParam());
    VideoReader reader(file);
    const std::vector<std::int64_t> times = probedTimes(file);
    const std::vector<cv::Mat> reference =
        ffmpegFrames(file, reader.facts().size, matrixFilter(reader.facts().colour.matrix), 12);
    ASSERT_EQ(reference.size(), std::min<std::size_t>(times.size(), 12));
    VideoFrame frame;
    std::size_t count = 0;
    for (; reader.read(frame); ++count) {
        ASSERT_LT(count, times.size());
        EXPECT_EQ(frame.pts, times[count]); // these clips begin at 0
        EXPECT_GT(frame.duration, 0);
        if (count >= reference.size()) continue;
        const Difference apart = compare(frame.picture, reference[count]);
        EXPECT_LE(apart.largest, kMaxDifference) << "frame " << count;
        EXPECT_LE(apart.mean, kMeanDifference) << "frame " << count;
    }
    EXPECT_EQ(count, times.size());
    EXPECT_FALSE(reader.counts().truncated);
    EXPECT_EQ(reader.counts().corrupt, 0);
    EXPECT_EQ(reader.counts().repairedTimes, 0);
    EXPECT_TRUE(reader.notes().empty());
    EXPECT_NEAR(static_cast<double>(reader.facts().frameCount.value_or(0)),
                static_cast<double>(count), 2);
}

INSTANTIATE_TEST_SUITE_P(VideoReader, RealClips,
                         testing::Values("bigbuckbunny.mp4", "bikes.mp4", "car-detection.mp4",
                                         "carphone_pristine.mp4", "flower.mp4", "flower.webm",
                                         "realshort.mp4"),
                         [](const testing::TestParamInfo<const char*>& clip) {
                             std::string name = clip.param;
                             std::replace_if(
                                 name.begin(), name.end(),
                                 [](char c) { return std::isalnum(static_cast<uchar>(c)) == 0; },
                                 '_');
                             return name;
                         });

TEST_F(VideoReaderTest, TellsWhatTheFileSays) {
    spill(directory / "text.srt", "1\n00:00:00,200 --> 00:00:01,000\nHello\n");
    spill(directory / "chapters.txt", ";FFMETADATA1\ntitle=A film\nartist=Somebody\n"
                                      "[CHAPTER]\nTIMEBASE=1/1000\nSTART=0\nEND=1000\ntitle=One\n"
                                      "[CHAPTER]\nTIMEBASE=1/1000\nSTART=1000\nEND=2000\n"
                                      "title=Two\n");
    const fs::path file = directory / "film.mkv";
    ffmpeg("-f lavfi -i testsrc2=size=96x64:rate=24000/1001:duration=2 -f lavfi -i "
           "sine=duration=2 -f lavfi -i sine=f=300:duration=2 -i " +
           arg(directory / "text.srt") + " -i " + arg(directory / "chapters.txt") +
           " -map 0:v -map 1:a -map 2:a -map 3:s -map_metadata 4 -c:v libx264 -pix_fmt yuv420p "
           "-c:a:0 aac -c:a:1 pcm_s16le -ac:a:1 2 -c:s srt -metadata:s:a:0 language=eng "
           "-metadata:s:a:1 language=slv -metadata:s:a:1 title=Commentary "
           "-vf setsar=4/3 " +
           arg(file));
    const VideoReader reader(file);
    const VideoFacts& facts = reader.facts();
    EXPECT_EQ(facts.format, "matroska,webm");
    EXPECT_EQ(facts.codec, "h264");
    EXPECT_EQ(facts.pixelFormat, "yuv420p");
    EXPECT_EQ(facts.size, cv::Size(96, 64));
    EXPECT_EQ(facts.rotationDegrees, 0);
    EXPECT_EQ(facts.sampleAspect.numerator, 4);
    EXPECT_EQ(facts.sampleAspect.denominator, 3);
    EXPECT_EQ(facts.averageRate.numerator, 24000);
    EXPECT_EQ(facts.averageRate.denominator, 1001);
    EXPECT_TRUE(facts.constantRate);
    EXPECT_EQ(facts.timeBase.denominator, 1000);
    EXPECT_NEAR(facts.duration.value_or(0), 2.0, 0.05);
    EXPECT_NEAR(static_cast<double>(facts.frameCount.value_or(0)), 48, 1);
    EXPECT_EQ(facts.colour.matrix, ColourMatrix::Bt601);
    EXPECT_FALSE(facts.colour.stated);
    ASSERT_EQ(facts.streams.size(), 4u);
    EXPECT_EQ(facts.streams[1].kind, StreamKind::Audio);
    EXPECT_EQ(facts.streams[1].codec, "aac");
    EXPECT_EQ(facts.streams[1].language, "eng");
    EXPECT_EQ(facts.streams[2].codec, "pcm_s16le");
    EXPECT_EQ(facts.streams[2].title, "Commentary");
    EXPECT_EQ(facts.streams[2].channels, 2);
    EXPECT_EQ(facts.streams[2].sampleRate, 44100);
    EXPECT_EQ(facts.streams[3].kind, StreamKind::Subtitle);
    EXPECT_EQ(facts.streams[3].codec, "subrip");
    ASSERT_EQ(facts.chapters.size(), 2u);
    EXPECT_EQ(facts.chapters[1].title, "Two");
    // FFmpeg 7 begins the file at its sound, 23 ms before the picture; times count from there
    const double start = std::stod(ffprobe(file, "format=start_time"));
    EXPECT_NEAR(facts.chapters[1].start, 1 - start, 1e-9);
    EXPECT_NEAR(facts.chapters[1].end, 2 - start, 1e-9);
    EXPECT_NE(std::find(facts.tags.begin(), facts.tags.end(),
                        std::make_pair(std::string("title"), std::string("A film"))),
              facts.tags.end());
}

TEST_F(VideoReaderTest, VariableFrameRateKeepsEachTimeAndDuration) {
    for (const char* const name : {"vfr.mp4", "vfr.mkv"}) {
        const fs::path file = makeClip(
            name, "-vf 'settb=1/1000,setpts=if(lt(N\\,9)\\,N*40\\,360+(N-9)*(N-9)*7+(N-9)*33)' "
                  "-vsync vfr -enc_time_base 1/1000");
        VideoReader reader(file);
        const std::vector<VideoFrame> frames = allFrames(reader);
        EXPECT_EQ(timesOf(frames), probedTimes(file)) << name;
        for (std::size_t i = 0; i + 1 < frames.size(); ++i)
            EXPECT_EQ(frames[i].duration, frames[i + 1].pts - frames[i].pts) << name;
        EXPECT_GT(frames.back().duration, 0);
    }
}

TEST_F(VideoReaderTest, TimesCountFromTheStartOfTheFile) {
    const fs::path file = makeClip("late.ts"); // begins at 1.4 s
    VideoReader reader(file);
    const std::vector<VideoFrame> frames = allFrames(reader);
    ASSERT_EQ(frames.size(), 50u);
    std::vector<std::int64_t> expected = probedTimes(file);
    const std::int64_t first = expected.front();
    EXPECT_GT(first, 90000);
    for (std::int64_t& time : expected)
        time -= first;
    EXPECT_EQ(timesOf(frames), expected);
}

class RotatedClips : public VideoReaderTest, public testing::WithParamInterface<int> {};

TEST_P(RotatedClips, ComeUpright) {
    const fs::path plain = makeClip("plain.mp4", "-frames:v 5 -pix_fmt yuv444p");
    const fs::path turned = directory / "turned.mp4";
    spill(turned, turnedClockwise(slurp(plain), GetParam()));
    // It counts counter-clockwise.
    const int turn =
        (360 - std::stoi(ffprobe(turned, "stream_side_data=rotation", "-select_streams v"))) % 360;
    VideoReader reader(turned);
    const cv::Size expected = GetParam() % 180 == 0 ? cv::Size(96, 64) : cv::Size(64, 96);
    EXPECT_EQ(reader.facts().size, expected);
    EXPECT_EQ(reader.facts().rotationDegrees, turn);
    EXPECT_FALSE(reader.facts().mirrored);
    const std::vector<VideoFrame> frames = allFrames(reader);
    VideoReader unturned(plain);
    const std::vector<cv::Mat> reference = ffmpegFrames(turned, expected);
    ASSERT_EQ(frames.size(), reference.size());
    for (const VideoFrame& frame : frames) {
        cv::Mat again;
        cv::rotate(unturned.next().value().picture, again,
                   turn == 90    ? cv::ROTATE_90_CLOCKWISE
                   : turn == 180 ? cv::ROTATE_180
                                 : cv::ROTATE_90_COUNTERCLOCKWISE);
        EXPECT_EQ(cv::norm(frame.picture, again, cv::NORM_INF), 0);
    }
    for (std::size_t i = 0; i < frames.size(); ++i)
        EXPECT_TRUE(samePicture(frames[i].picture, reference[i], kMaxDifference));
}

INSTANTIATE_TEST_SUITE_P(VideoReader, RotatedClips, testing::Values(90, 180, 270));

TEST(Orientation, EachDisplayMatrixTurnsAsItSays) {
    const cv::Mat picture = movingPicture({7, 5}, 1);
    const int one = 1 << 16;
    // a, b, c, d of x' = a x + c y, y' = b x + d y
    const int cases[8][4] = {{one, 0, 0, one},  {-one, 0, 0, -one}, {-one, 0, 0, one},
                             {one, 0, 0, -one}, {0, one, -one, 0},  {0, -one, one, 0},
                             {0, one, one, 0},  {0, -one, -one, 0}};
    for (const auto& [a, b, c, d] : cases) {
        const std::int32_t matrix[9] = {a, b, 0, c, d, 0, 0, 0, 1 << 30};
        VideoFacts facts;
        setRotation(facts, matrix);
        PictureMaker maker(orientationOf(facts), false, 1, "picture");
        const FramePtr frame = newFrame();
        frame->format = AV_PIX_FMT_BGR24;
        frame->width = picture.cols;
        frame->height = picture.rows;
        ASSERT_EQ(av_frame_get_buffer(frame.get(), 0), 0);
        for (int y = 0; y < picture.rows; ++y)
            std::copy_n(picture.ptr(y), 3 * picture.cols,
                        frame->data[0] + static_cast<std::ptrdiff_t>(y) * frame->linesize[0]);
        cv::Mat upright;
        maker.make(*frame, upright);
        ASSERT_EQ(upright.size(), a != 0 ? picture.size() : cv::Size(picture.rows, picture.cols));
        // Moved so that all corners lie inside.
        const int shiftX = (a < 0 || c < 0) ? upright.cols - 1 : 0;
        const int shiftY = (b < 0 || d < 0) ? upright.rows - 1 : 0;
        for (int i = 0; i < picture.rows * picture.cols; ++i) {
            const int x = i % picture.cols;
            const int y = i / picture.cols;
            const int toX = (a * x + c * y) / one + shiftX;
            const int toY = (b * x + d * y) / one + shiftY;
            ASSERT_EQ(upright.at<cv::Vec3b>(toY, toX), picture.at<cv::Vec3b>(y, x));
        }
    }
}

// Known colours, stored in each way that a file may state.
TEST_F(VideoReaderTest, ColoursFollowTheStatedMatrixAndRange) {
    const struct {
        const char* filter;
        const char* tags;
        ColourMatrix matrix;
        ColourRange range;
    } cases[] = {{"bt601:out_range=tv", "-colorspace smpte170m -color_range tv",
                  ColourMatrix::Bt601, ColourRange::Limited},
                 {"bt709:out_range=tv", "-colorspace bt709 -color_range tv", ColourMatrix::Bt709,
                  ColourRange::Limited},
                 {"bt709:out_range=pc", "-colorspace bt709 -color_range pc", ColourMatrix::Bt709,
                  ColourRange::Full},
                 {"bt2020:out_range=tv", "-colorspace bt2020nc -color_range tv",
                  ColourMatrix::Bt2020, ColourRange::Limited}};
    for (const auto& one : cases) {
        for (const char* const pixels : {"yuv420p", "yuv444p", "yuv420p10le"}) {
            const fs::path file = directory / "colour.mkv";
            ffmpeg("-f lavfi -i color=c=0xC83264:size=64x64:rate=5:duration=1 -vf "
                   "format=gbrp,scale=out_color_matrix=" +
                   std::string(one.filter) + ",format=" + pixels + " -c:v ffv1 " + one.tags + " " +
                   arg(file));
            VideoReader reader(file);
            EXPECT_TRUE(reader.facts().colour.stated);
            EXPECT_EQ(reader.facts().colour.matrix, one.matrix);
            EXPECT_EQ(reader.facts().colour.range, one.range);
            const std::optional<VideoFrame> frame = reader.next();
            ASSERT_TRUE(frame);
            const auto pixel = frame->picture.at<cv::Vec3b>(30, 30);
            // half a level of U or V is 1.1 of blue; swscale 8 rounds light down: 1.2 of it
            EXPECT_NEAR(pixel[2], 0xC8, 3) << one.filter << " " << pixels;
            EXPECT_NEAR(pixel[1], 0x32, 3) << one.filter << " " << pixels;
            EXPECT_NEAR(pixel[0], 0x64, 3) << one.filter << " " << pixels;
        }
    }
}

TEST(VideoReaderOptions, UnstatedAndUnknownColoursAreAssumedByTheNumberOfLines) {
    const auto unstated = [](AVPixelFormat format, int rows) {
        return videoColour(format, AVCOL_SPC_UNSPECIFIED, AVCOL_RANGE_UNSPECIFIED,
                           AVCOL_PRI_UNSPECIFIED, AVCOL_TRC_UNSPECIFIED, rows);
    };
    EXPECT_EQ(unstated(AV_PIX_FMT_YUV420P, 576).matrix, ColourMatrix::Bt601);
    EXPECT_EQ(unstated(AV_PIX_FMT_YUV420P, 577).matrix, ColourMatrix::Bt709);
    EXPECT_EQ(unstated(AV_PIX_FMT_YUV420P, 577).range, ColourRange::Limited);
    EXPECT_EQ(unstated(AV_PIX_FMT_YUVJ420P, 100).range, ColourRange::Full);
    EXPECT_EQ(unstated(AV_PIX_FMT_GBRP, 100).matrix, ColourMatrix::Rgb);
    EXPECT_FALSE(unstated(AV_PIX_FMT_YUV420P, 577).stated);
    // numbers that FFmpeg does not know
    const VideoColour colour = videoColour(AV_PIX_FMT_YUV420P, 244, 99, -7, 255, 100);
    EXPECT_EQ(colour.matrix, ColourMatrix::Bt601);
    EXPECT_EQ(colour.range, ColourRange::Limited);
    EXPECT_FALSE(colour.stated);
    EXPECT_EQ(colour.primaries, AVCOL_PRI_UNSPECIFIED);
    EXPECT_EQ(colour.transfer, AVCOL_TRC_UNSPECIFIED);
}

// Strong colours side by side: where colour is brought to full size it overshoots, and is clamped
// before the step to BGR here, after it there.
constexpr double kSmallFrames = 8;

TEST_F(VideoReaderTest, PixelFormatsAndSizesOfAllKinds) {
    ALTIRO3D_TAKES(11);
    const struct {
        const char* pixels;
        const char* codec;
    } formats[] = {{"yuv420p", "ffv1"},  {"yuv422p", "ffv1"},  {"yuv410p", "ffv1"},
                   {"yuva444p", "ffv1"}, {"gray", "ffv1"},     {"gray16le", "ffv1"},
                   {"bgr0", "ffv1"},     {"gbrp10le", "ffv1"}, {"yuvj420p", "mjpeg"},
                   {"pal8", "png"},      {"rgb24", "png"}};
    for (const auto& [pixels, codec] : formats) {
        for (const char* const size : {"1x1", "2x2", "17x13", "33x2", "64x48"}) {
            // a colour sample for 4 x 4 px is placed by the program in its own way at odd edges
            if (std::string(pixels) == "yuv410p" && std::string(size) == "17x13") continue;
            const fs::path file = directory / "small.mkv";
            ffmpeg(std::string("-f lavfi -i testsrc2=size=64x48:rate=5:duration=0.6 -vf scale=") +
                   size + " -c:v " + codec + " -pix_fmt " + pixels + " " + arg(file));
            VideoReader reader(file);
            const std::vector<VideoFrame> frames = allFrames(reader);
            ASSERT_EQ(frames.size(), 3u) << pixels << " " << size;
            const bool middle =
                std::string(pixels) == "yuvj420p" || std::string(pixels) == "yuv410p";
            const std::vector<cv::Mat> reference = ffmpegFrames(
                file, reader.facts().size,
                middle ? "scale=flags=bicubic+accurate_rnd+full_chroma_int+full_chroma_inp" : "");
            ASSERT_EQ(reference.size(), 3u);
            for (std::size_t i = 0; i < 3; ++i) {
                EXPECT_TRUE(samePicture(frames[i].picture, reference[i], kSmallFrames))
                    << pixels << " " << size;
            }
        }
    }
}

TEST_F(VideoReaderTest, APartIsExactToTheFrame) {
    for (const char* const name : {"part.mp4", "part.mkv", "part.ts"}) {
        const fs::path file = makeClip(name);
        const std::vector<VideoFrame> all = allFrames(file);
        ASSERT_EQ(all.size(), 50u);
        const double unit = VideoReader(file).facts().timeBase.value();
        for (const std::size_t first : {1U, 9U, 10U, 11U, 19U, 23U, 49U}) {
            const std::size_t last = std::min<std::size_t>(first + 7, 49);
            const double end = first == last ? 100 : static_cast<double>(all[last].pts) * unit;
            VideoReader reader(file, partFrom(static_cast<double>(all[first].pts) * unit, end));
            const std::vector<VideoFrame> part = allFrames(reader);
            ASSERT_EQ(part.size(), std::max<std::size_t>(last - first, 1)) << name << " " << first;
            EXPECT_TRUE(sameFrames(part, all, first, all[first].pts)) << name;
            EXPECT_FALSE(reader.counts().truncated);
            EXPECT_EQ(reader.counts().corrupt, 0);
        }
    }
}

// Without a list of key frames, or without times, the reader counts frames from the start.
TEST_F(VideoReaderTest, APartOfAFileWithoutAnIndexIsExactToo) {
    for (const fs::path& file : {makeClip("streamed.mkv", "-f matroska - >"), makeClip("bare.h264"),
                                 makeClip("f.mp4", "-movflags frag_keyframe+empty_moov")}) {
        VideoReader whole(file);
        const std::vector<VideoFrame> all = allFrames(whole);
        ASSERT_EQ(all.size(), 50u) << file;
        const std::vector<VideoFrame> part = allFrames(file, partFrom(0.92));
        ASSERT_EQ(part.size(), 27u) << file;
        EXPECT_TRUE(sameFrames(part, all, 23, all[23].pts)) << file;
        EXPECT_FALSE(whole.counts().truncated) << file;
    }
    VideoReader late(directory / "f.mp4", partFrom(5)); // behind the end
    EXPECT_FALSE(late.next());
    EXPECT_FALSE(late.next());
    EXPECT_EQ(late.counts().frames, 0);
}

TEST_F(VideoReaderTest, FramesDoNotDependOnTheThreadsAndHaveMemoryOfTheirOwn) {
    VideoReaderOptions options;
    options.threads = 1;
    const std::vector<VideoFrame> expected = allFrames(makeClip("clip.mp4"), options);
    options.threads = 5;
    VideoReader reader(directory / "clip.mp4", options);
    VideoFrame frame; // one for all
    for (const VideoFrame& one : expected) {
        const cv::Mat kept = frame.picture;
        const cv::Mat copy = kept.clone();
        ASSERT_TRUE(reader.read(frame));
        EXPECT_TRUE(sameFrames({frame}, {one}));
        EXPECT_TRUE(kept.empty() || samePicture(kept, copy));
    }
    EXPECT_FALSE(reader.read(frame));
}

TEST_F(VideoReaderTest, ReadsTheStandardInput) {
    const fs::path file = makeClip("clip.mkv");
    const std::vector<VideoFrame> expected = allFrames(file);
    const StandardInput input(file);
    const std::vector<VideoFrame> frames = allFrames("-", partFrom(0.4)); // skipping is reading
    ASSERT_EQ(frames.size(), expected.size() - 10);
    EXPECT_TRUE(sameFrames(frames, expected, 10, expected[10].pts));
}

TEST_F(VideoReaderTest, OpensDevicesByTheirFormat) {
    VideoReaderOptions options;
    options.format = "lavfi"; // a device that is always there
    VideoReader reader("testsrc2=size=32x24:rate=10:duration=0.5", options);
    const std::vector<VideoFrame> frames = allFrames(reader);
    ASSERT_EQ(frames.size(), 5u);
    EXPECT_EQ(frames[4].pts, 4);
    options.format = "no-such-device";
    EXPECT_EQ(errorOf([&] { const VideoReader other("x", options); }),
              "format: is \"no-such-device\", which this FFmpeg does not know");
    options.format = "lavfi";
    options.formatOptions = {{"no_such_option", "1"}};
    EXPECT_EQ(errorOf([&] { const VideoReader other("testsrc2=duration=1", options); }),
              "formatOptions: have \"no_such_option\", which the format lavfi does not know");
}

// Threads with a frame each hold as many frames back. Those of files may.
TEST_F(VideoReaderTest, DecodersOfLivePicturesHoldNoFramesBack) {
    VideoReaderOptions options;
    options.threads = 4;
    EXPECT_EQ(openVideoInput(makeClip("clip.mkv"), options).decoder->active_thread_type,
              FF_THREAD_FRAME);
    const auto openPiped = [&](const std::string& name, const std::string& format) {
        const StandardInput piped(directory / name);
        options.format = format;
        const VideoInput input = openVideoInput("-", options);
        return std::make_pair(input.facts.isLive, input.decoder->active_thread_type);
    };
    EXPECT_EQ(openPiped("clip.mkv", ""), std::make_pair(false, FF_THREAD_FRAME));
    ffmpeg("-i " + arg(directory / "clip.mkv") + " -c:v png -f image2pipe " +
           arg(directory / "pictures"));
    const auto [isLive, threads] = openPiped("pictures", "png_pipe");
    EXPECT_TRUE(isLive);
    EXPECT_EQ(threads & FF_THREAD_FRAME, 0);
    options.format = "png_pipe"; // the same pictures in a file
    const VideoInput file = openVideoInput(directory / "pictures", options);
    EXPECT_FALSE(file.facts.isLive);
    EXPECT_EQ(file.decoder->active_thread_type, FF_THREAD_FRAME);
    options.format = "lavfi";
    const VideoInput device = openVideoInput("testsrc2=size=32x24", options);
    EXPECT_TRUE(device.facts.isLive);
    EXPECT_EQ(device.decoder->thread_type, FF_THREAD_SLICE);
}

TEST_F(VideoReaderTest, FramesBeforeAPartAreCounted) {
    ALTIRO3D_TAKES(6);
    const std::string varying = "-vf 'settb=1/1000,setpts=if(lt(N\\,20)\\,N*100\\,2000+(N-20)*33)' "
                                "-vsync vfr -enc_time_base 1/1000";
    const std::string source = "testsrc2=size=96x64:rate=25:duration=4";
    std::vector<fs::path> files = {
        makeClip("vfr.mp4", varying, source),
        makeClip("vfr.mkv", varying, source),
        makeClip("fragments.mp4", "-movflags frag_keyframe+empty_moov", source),
        makeClip("open.mkv", "-x264-params open-gop=1", source),
        makeClip("fields.mp4", "-flags +ilme+ildct", source),
        makeClip("stream.ts", "", source),
        makeClip("bare.h264", "", source),
        makeClip("hevc.mkv", "-c:v libx265 -x265-params log-level=none", source),
        makeClip("old.avi", "-c:v mpeg4", source),
        makeClip("old.mpg", "-c:v mpeg2video", source),
        makeClip("vp8.webm", "-c:v libvpx -auto-alt-ref 1 -lag-in-frames 16 -b:v 200k", source),
        makeClip("vp9.webm", "-c:v libvpx-vp9 -lag-in-frames 16 -deadline realtime", source),
        makeClip("ffv1.mkv", "-c:v ffv1", source)};
    // a copy from the middle of a group of pictures, with frames that are not to be shown
    files.push_back(directory / "edited.mp4");
    ffmpeg("-ss 0.5 -i " + arg(files[2]) + " -c copy " + arg(files.back()));
    files.push_back(directory / "later.ts"); // begins without a key frame
    const std::string whole = slurp(files[5]);
    spill(files.back(), whole.substr(whole.size() / 188 / 4 * 188));
    for (const fs::path& file : files) {
        VideoReader reader(file);
        const std::vector<VideoFrame> all = allFrames(reader);
        ASSERT_GT(all.size(), 60u) << file;
        for (const double from : {0.01, 2.0, 2.35, 99.0}) {
            const std::vector<VideoFrame> expected = allFrames(file, partFrom(from));
            VideoReader part(file, partFrom(from));
            const auto before = static_cast<std::size_t>(part.framesBefore());
            ASSERT_EQ(before, all.size() - expected.size()) << file << " from " << from;
            const std::vector<VideoFrame> frames = allFrames(part);
            ASSERT_EQ(timesOf(frames), timesOf(expected)) << file << " from " << from;
            if (frames.empty()) continue;
            EXPECT_EQ(cv::norm(frames[0].picture, all[before].picture, cv::NORM_INF), 0)
                << file << " from " << from;
            EXPECT_EQ(static_cast<std::size_t>(part.framesBefore()), before); // known by now
        }
        EXPECT_EQ(errorOf([&] { reader.framesBefore(); }),
                  "framesBefore: comes after the first frame");
    }
}

TEST_F(VideoReaderTest, FramesBeforeAPartOfWhatIsReadOnceAreCounted) {
    VideoReaderOptions options;
    options.format = "lavfi";
    options.from = 1.2;
    VideoReader reader("testsrc2=size=32x24:rate=10:duration=2", options);
    EXPECT_EQ(reader.framesBefore(), 12);
    const std::vector<VideoFrame> frames = allFrames(reader);
    ASSERT_EQ(frames.size(), 8u);
    EXPECT_EQ(frames[0].pts, 0);
}

TEST_F(VideoReaderTest, ColoursAndDepthAreTheirOwnTracksInAnyOrder) {
    const std::string depth = "-f lavfi -i color=gray:size=96x64:rate=25:duration=0.2 ";
    const std::string colours = "-f lavfi -i testsrc2=size=64x48:rate=25:duration=0.2 ";
    for (const bool isDepthFirst : {true, false}) {
        const std::string grey = isDepthFirst ? "0" : "1";
        const std::string other = isDepthFirst ? "1" : "0";
        const fs::path file = make(
            "rgbd.mkv", (isDepthFirst ? depth + colours : colours + depth) +
                            "-map 0 -map 1 -c:v ffv1 -disposition:v:0 default -pix_fmt:v:" + grey +
                            " gray16le -pix_fmt:v:" + other + " yuv420p -metadata:s:v:" + grey +
                            " title=DEPTH -metadata:s:v:" + other + " title=COLOR");
        VideoReader reader(file);
        EXPECT_EQ(reader.facts().size, cv::Size(64, 48));
        ASSERT_FALSE(reader.notes().empty());
        EXPECT_TRUE(holds(reader.notes()[0].text, "seems to hold depth (DEPTH)"));
        VideoReaderOptions options;
        options.isDepth = true;
        VideoReader depths(file, options);
        EXPECT_EQ(depths.next()->picture.type(), CV_16UC1);
        EXPECT_EQ(depths.facts().size, cv::Size(96, 64));
        EXPECT_TRUE(depths.notes().empty());
    }
}

TEST_F(VideoReaderTest, TimesAtTheEndOfTheNumbersCountAsMissing) {
    const fs::path file = makeClip("clip.mp4", "-bf 0 -t 1.2 -movflags frag_keyframe+empty_moov");
    std::string bytes = slurp(file);
    const std::size_t last = bytes.rfind("tfdt"); // the time at which the last third begins
    ASSERT_NE(last, std::string::npos);
    bytes[last + 8] = 0x60; // the first of its eight bytes
    spill(file, bytes);
    VideoReader reader(file);
    const std::vector<VideoFrame> frames = allFrames(reader);
    ASSERT_EQ(frames.size(), 30u);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        EXPECT_EQ(frames[i].pts, 512 * static_cast<std::int64_t>(i));
        EXPECT_EQ(frames[i].duration, 512);
    }
    EXPECT_EQ(reader.counts().repairedTimes, 10);
}

TEST_F(VideoReaderTest, AFewEqualTimesMoveNoOthers) {
    // three frames one tick after the one before, which is as near as ffmpeg puts them
    const fs::path file =
        makeClip("clip.mp4", "-bf 0 -bsf:v \"setts=pts='if(between(N,11,13),PREV_OUTPTS,PTS)'\"");
    std::string bytes = slurp(file);
    const std::string three({0, 0, 0, 3, 0, 0, 0, 1}); // of the table of durations
    const std::size_t place = bytes.find(three, bytes.find("stts"));
    ASSERT_NE(place, std::string::npos);
    bytes[place + 7] = 0;
    spill(file, bytes);
    VideoReader reader(file);
    const std::vector<std::int64_t> times = timesOf(allFrames(reader));
    const std::vector<std::int64_t> stated = probedTimes(file);
    ASSERT_EQ(times.size(), 50U);
    ASSERT_EQ(stated.size(), 50U);
    for (std::size_t i = 0; i < times.size(); ++i) {
        const bool equal = i > 0 && stated[i] == stated[i - 1];
        EXPECT_EQ(times[i], equal ? times[i - 1] + 1 : stated[i]) << i;
    }
    EXPECT_EQ(reader.counts().repairedTimes, 3);
}

TEST_F(VideoReaderTest, ConcatenatedFilesAreReadToTheEnd) {
    const auto piece = [&](const char* source) {
        return slurp(makeClip("piece.ts", "-bf 0", source));
    };
    const std::string brief = piece("testsrc2=size=96x64:duration=0.8");
    const fs::path file = directory / "all.ts"; // times begin again at each piece
    spill(file, brief + brief + brief + piece("testsrc2=size=96x64:duration=4") +
                    piece("testsrc=size=96x64:duration=6"));
    VideoReader reader(file);
    const std::vector<VideoFrame> frames = allFrames(reader);
    ASSERT_EQ(frames.size(), 310U);
    for (std::size_t i = 1; i < frames.size(); ++i)
        EXPECT_EQ(frames[i].pts - frames[i - 1].pts, 3600) << i;
    EXPECT_EQ(reader.counts().repairedTimes, 0);
    EXPECT_TRUE(reader.notes().empty());
    // and each place again without what was before
    for (std::size_t place = 5; place < frames.size(); place += 30) {
        VideoReader later(file);
        later.skipTo(frames[place].pts);
        VideoFrame frame;
        ASSERT_TRUE(later.read(frame)) << place;
        EXPECT_EQ(frame.pts, frames[place].pts);
        EXPECT_EQ(cv::norm(frame.picture, frames[place].picture, cv::NORM_INF), 0) << place;
    }
}

// Recordings with sound whose times begin again, jump by 1000 s and go back, as FFmpeg's tool joins
// them: all pictures and all sound, in step.
TEST_F(VideoReaderTest, PicturesAndSoundStayInStepWhereTimesJump) {
    const auto piece = [&](int offset) {
        ffmpeg("-f lavfi -i testsrc2=size=96x64:rate=25:duration=2 -f lavfi -i sine=duration=2 "
               "-c:v libx264 -bf 2 -g 10 -pix_fmt yuv420p -c:a mp2 -output_ts_offset " +
               std::to_string(offset) + " " + arg(directory / "piece.ts"));
        return slurp(directory / "piece.ts");
    };
    const std::string early = piece(0);
    const std::string late = piece(1000);
    const auto soundOf = [&](const fs::path& file) { return packetTimes(file, "a").size(); };
    const std::size_t sounds = soundOf(directory / "piece.ts");
    for (const std::string& bytes : {early + early, early + late, late + early + early}) {
        const std::size_t count = bytes.size() / early.size();
        const fs::path file = directory / "all.ts";
        spill(file, bytes);
        VideoReader reader(file);
        VideoWriterOptions options;
        options.size = {96, 64};
        options.timeBase = reader.facts().timeBase;
        VideoWriter writer(directory / "copy.mp4", options, &reader);
        VideoFrame frame;
        std::int64_t last = -3600;
        for (; reader.read(frame); last = frame.pts) {
            EXPECT_GT(frame.pts, last);
            EXPECT_LE(frame.pts - last, 9000 + 3600); // no frame is held: the sound may be longer
            writer.write(frame);
        }
        writer.finish();
        EXPECT_EQ(reader.counts().frames, static_cast<std::int64_t>(50 * count));
        EXPECT_EQ(reader.counts().repairedTimes, 0);
        EXPECT_TRUE(reader.notes().empty());
        const std::vector<double> sound = packetTimes(directory / "copy.mp4", "a");
        EXPECT_EQ(sound.size(), sounds * count);
        for (std::size_t i = 1; i < sound.size(); ++i)
            EXPECT_NEAR(sound[i] - sound[i - 1], 1152 / 44100.0, 0.1) << i;
        EXPECT_NEAR(sound.back(), 2.0 * static_cast<double>(count),
                    0.15 * static_cast<double>(count));
        // each piece of sound begins with its pictures
        EXPECT_NEAR(packetTimes(directory / "copy.mp4", "v").back(), sound.back(), 0.15);
    }
}

// Mean difference between the lines of the two fields: that of a comb, against the line's own.
double combing(const cv::Mat& picture) {
    double sum = 0;
    for (int y = 2; y + 2 < picture.rows; ++y) {
        for (int x = 0; x < picture.cols; ++x) {
            const auto at = [&](int row) {
                return static_cast<double>(picture.at<cv::Vec3b>(row, x)[1]);
            };
            sum += std::max(0.0, std::abs(at(y) - at(y - 1)) - std::abs(at(y + 1) - at(y - 1)));
        }
    }
    return sum / picture.rows;
}

TEST_F(VideoReaderTest, InterlacedFramesAreDeinterlacedUnlessAsked) {
    for (const auto& [name, codec] : std::vector<std::pair<std::string, std::string>>{
             {"a.mp4", "-c:v libx264 -crf 10 -g 8 -x264opts tff=1"},
             {"b.mpg", "-c:v mpeg2video -flags +ilme+ildct -q:v 2 -g 8"},
             {"c.mkv", "-c:v ffv1 -top 1"}}) {
        const fs::path file = makeInterlaced(name, codec);
        VideoReader reader(file);
        const std::vector<VideoFrame> frames = allFrames(reader);
        VideoReaderOptions options;
        options.deinterlace = false;
        VideoReader asItIs(file, options);
        const std::vector<VideoFrame> combed = allFrames(asItIs);
        ASSERT_EQ(frames.size(), 30U) << name;
        EXPECT_EQ(timesOf(frames), timesOf(combed)) << name;
        EXPECT_GT(combing(combed[10].picture), 400) << name;
        for (const VideoFrame& frame : frames)
            EXPECT_LT(combing(frame.picture), 60) << name;
        EXPECT_FALSE(holds(textOf(reader.notes()), "not deinterlaced")) << name;
        EXPECT_TRUE(holds(textOf(asItIs.notes()), "not deinterlaced")) << name;
        // a frame is the same after a seek, although it depends on those before and after it
        for (const std::size_t place : {9U, 16U, 29U}) {
            VideoReader later(file);
            later.skipTo(frames[place].pts);
            const auto frame = later.next();
            ASSERT_TRUE(frame) << name;
            EXPECT_EQ(frame->pts, frames[place].pts) << name;
            EXPECT_EQ(cv::norm(frame->picture, frames[place].picture, cv::NORM_INF), 0) << name;
        }
    }
}

TEST_F(VideoReaderTest, InterlacedPartsAreDeinterlacedAndOthersStay) {
    const std::string mixed =
        slurp(makeClip("p.h264", "-bf 0", "testsrc2=size=320x96:rate=25:duration=1")) +
        slurp(makeInterlaced("i.h264", "-c:v libx264 -crf 10 -x264opts tff=1")) +
        slurp(makeClip("q.h264", "-bf 0", "testsrc=size=200x96:rate=25:duration=1"));
    spill(directory / "mixed.h264", mixed);
    VideoReader reader(directory / "mixed.h264");
    const std::vector<VideoFrame> frames = allFrames(reader);
    VideoReaderOptions options;
    options.deinterlace = false;
    const std::vector<VideoFrame> asItIs = allFrames(directory / "mixed.h264", options);
    ASSERT_EQ(frames.size(), 80U);
    ASSERT_EQ(asItIs.size(), 80U);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const bool isInterlaced = i >= 25 && i < 55;
        const bool isSame = cv::norm(frames[i].picture, asItIs[i].picture, cv::NORM_INF) == 0;
        EXPECT_EQ(isSame, !isInterlaced) << i;
        EXPECT_TRUE(!isInterlaced || combing(frames[i].picture) < 60) << i;
    }
}

TEST_F(VideoReaderTest, PicturesOfBothEyesAreSaid) {
    using Stated = std::pair<std::string, std::optional<StereoLayout>>;
    const std::tuple<const char*, const char*, Stated> cases[] = {
        {"a.mp4", "-x264opts frame-packing=3", {"side by side", StereoLayout::LeftRight}},
        {"b.mkv",
         "-metadata:s:v stereo_mode=top_bottom",
         {"top and bottom", StereoLayout::TopBottom}},
        {"c.mkv",
         "-metadata:s:v stereo_mode=right_left",
         {"side by side, inverted", StereoLayout::RightLeft}},
        {"d.mkv",
         "-metadata:s:v stereo_mode=row_interleaved_lr",
         {"interleaved lines", std::nullopt}},
        {"e.mp4", "-x264opts frame-packing=6", {}}}; // 2D
    for (const auto& [name, options, stated] : cases) {
        VideoReader reader(makeClip(name, options));
        static_cast<void>(reader.next());
        EXPECT_EQ(Stated(reader.facts().eyes, reader.facts().eyesLayout), stated) << name;
    }
}

// Adds boxes to the end of the first sample entry of an MP4 file whose index is at its end.
std::string withBoxesInEntry(std::string bytes, const std::string& boxes,
                             const std::string& kind = "hvc1") {
    const std::size_t entry = bytes.find(kind, bytes.find("stsd")) - 4;
    const std::size_t end = entry + bigEndianAt(bytes, entry);
    for (const std::string& name :
         {std::string("moov"), std::string("trak"), std::string("mdia"), std::string("minf"),
          std::string("stbl"), std::string("stsd"), kind}) {
        const std::size_t at = bytes.rfind(name, entry + 4) - 4;
        bytes.replace(at, 4, bigEndian(bigEndianAt(bytes, at) + boxes.size()));
    }
    return bytes.insert(end, boxes);
}

#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(61, 19, 100)
// A picture of one eye as FFmpeg's decoder delivers it.
FramePtr eyePicture(int view, std::int64_t pts, int grey) {
    FramePtr frame = newFrame(AV_PIX_FMT_YUV420P, 6, 4);
    frame->pts = pts;
    for (int plane = 0; plane < 3; ++plane) {
        for (int y = 0; y < (plane == 0 ? 4 : 2); ++y)
            std::memset(frame->data[plane] + y * frame->linesize[plane], grey + plane,
                        plane == 0 ? 6 : 3);
    }
    AVFrameSideData* const side =
        av_frame_new_side_data(frame.get(), AV_FRAME_DATA_VIEW_ID, sizeof view);
    std::memcpy(side->data, &view, sizeof view);
    return frame;
}

TEST(EyesJoiner, JoinsPicturesOfOneTimeAndLosesThoseWithoutTheOther) {
    EyesJoiner joiner;
    EXPECT_FALSE(joiner.join(*eyePicture(0, 0, 10)));
    EXPECT_FALSE(joiner.join(*eyePicture(0, 1, 50))); // the right one of time 0 was damaged
    EXPECT_EQ(joiner.takeLost(), 1);
    const FramePtr frame = eyePicture(1, 1, 90);
    ASSERT_TRUE(joiner.join(*frame));
    EXPECT_EQ(joiner.takeLost(), 0);
    EXPECT_EQ(frame->width, 12);
    EXPECT_EQ(frame->height, 4);
    EXPECT_EQ(frame->pts, 1);
    for (int plane = 0; plane < 3; ++plane) {
        const int width = plane == 0 ? 6 : 3;
        for (int y = 0; y < (plane == 0 ? 4 : 2); ++y) {
            for (int x = 0; x < 2 * width; ++x) {
                EXPECT_EQ(frame->data[plane][y * frame->linesize[plane] + x],
                          (x < width ? 50 : 90) + plane);
            }
        }
    }
    EXPECT_FALSE(joiner.join(*eyePicture(1, 2, 90))); // the right one may come first
    const FramePtr last = eyePicture(0, 2, 50);
    ASSERT_TRUE(joiner.join(*last));
    EXPECT_EQ(last->data[0][0], 50);
    EXPECT_EQ(last->data[0][6], 90);
}
#endif

TEST_F(VideoReaderTest, SpatialVideosAreSaidToBeOfOneEye) {
    const fs::path flat = directory / "flat.mp4";
    ffmpeg("-f lavfi -i testsrc2=size=64x48:rate=5:duration=0.4 -c:v libx265 -x265-params "
           "log-level=none -tag:v hvc1 " +
           arg(flat));
    const auto textOfNotes = [](const fs::path& file) {
        VideoReader reader(file);
        EXPECT_TRUE(reader.next());
        return textOf(reader.notes());
    };
    EXPECT_EQ(textOfNotes(flat), "");
    // beginnings of the second layer's parameter sets
    const std::string layer("\0\0\0\x1elhvC\x01\xf0\0\xfc\xcb\x02"
                            "\xa1\0\x01\0\x03\x42\x09\x0e\xa2\0\x01\0\x03\x44\x09\x48",
                            30);
    const std::string eyes("\0\0\0\x1dvexu\0\0\0\x15"
                           "eyes\0\0\0\x0dstri\0\0\0\0\x03",
                           29);
    spill(directory / "spatial.mp4", withBoxesInEntry(slurp(flat), layer + eyes));
    EXPECT_TRUE(holds(textOfNotes(directory / "spatial.mp4"), "spatial video (MV-HEVC)"));
    spill(directory / "other.mp4", withBoxesInEntry(slurp(flat), layer));
    EXPECT_EQ(textOfNotes(directory / "other.mp4"), "");
}

TEST_F(VideoReaderTest, FramesOfBothEyesByTurnsBecomePairs) {
    const std::string source =
        "color=size=96x64:rate=10:duration=1,geq=lum='40+10*N':cb=128:cr=128"; // number of a frame
    const auto grey = [](const VideoFrame& frame, int x) {
        return std::lround((frame.picture.at<cv::Vec3b>(32, x)[1] * 219 / 255.0 + 16 - 40) / 10);
    };
    const VideoReaderOptions both = ofBothEyes();
    for (const char* const name : {"sei.mp4", "sei.ts", "left.mkv", "right.mkv"}) {
        const bool hasMessages = name[0] == 's';
        const bool isRightFirst = name[0] == 'r';
        const fs::path file =
            makeClip(name,
                     hasMessages ? "-qp 1 -x264opts frame-packing=5"
                                 : std::string("-qp 1 -metadata:s:v stereo_mode=block_") +
                                       (isRightFirst ? "rl" : "lr"),
                     source);
        VideoReader reader(file, both);
        EXPECT_EQ(reader.facts().size, cv::Size(192, 64)) << name;
        EXPECT_EQ(reader.facts().eyesLayout, StereoLayout::LeftRight) << name;
        EXPECT_NEAR(reader.facts().averageRate.value(), 5, 0.01) << name;
        const std::vector<VideoFrame> pairs = allFrames(reader);
        EXPECT_EQ(textOf(reader.notes()), "") << name;
        const double unit = reader.facts().timeBase.value();
        ASSERT_EQ(pairs.size(), 5U) << name;
        for (int i = 0; i < 5; ++i) {
            const VideoFrame& pair = pairs[static_cast<std::size_t>(i)];
            EXPECT_EQ(grey(pair, 40), 2 * i + (isRightFirst ? 1 : 0)) << name;
            EXPECT_EQ(grey(pair, 140), 2 * i + (isRightFirst ? 0 : 1)) << name;
            EXPECT_NEAR(static_cast<double>(pair.pts) * unit, 0.2 * i, 1e-9) << name;
            EXPECT_NEAR(static_cast<double>(pair.duration) * unit, 0.2, 1e-9) << name;
        }
        VideoReaderOptions part = both;
        part.from = 0.3; // in the middle of a pair
        VideoReader later(file, part);
        EXPECT_EQ(later.framesBefore(), 2) << name;
        EXPECT_TRUE(sameFrames(allFrames(later), pairs, 2, std::llround(0.3 / unit))) << name;
        VideoReader left(file);
        const std::vector<VideoFrame> alone = allFrames(left);
        ASSERT_EQ(alone.size(), 5U) << name;
        EXPECT_EQ(grey(alone[3], 40), isRightFirst ? 7 : 6) << name;
        EXPECT_TRUE(holds(textOf(left.notes()), "of which the left eye alone is read")) << name;
    }
}

// A film of two videos. The luma of the left eye's frame N is 30 + X + 4 N, that of the right one's
// 10 more, as if it were seen 10 px further left.
constexpr int kShift = 10; // px

std::string twoVideos(const std::string& options, bool isRightFirst = false) {
    std::string arguments;
    for (const bool isRight : {isRightFirst, !isRightFirst}) {
        arguments +=
            "-f lavfi -i 'color=size=96x64:rate=10:duration=1,format=yuv420p,geq=lum=30+X+4*N" +
            (isRight ? "+" + std::to_string(kShift) : "") + ":cb=128:cr=128' ";
    }
    return arguments + "-map 0 -map 1 " + options;
}

// @param number of the frame that both eyes show
void expectPair(const VideoFrame& pair, int number, const std::string& what) {
    ASSERT_EQ(pair.picture.size(), cv::Size(192, 64)) << what;
    for (const int x : {3, 40, 92}) {
        const auto seen = [&](int at) { // luma of limited range
            return pair.picture.at<cv::Vec3b>(32, at)[1] * 219 / 255.0 + 16;
        };
        EXPECT_NEAR(seen(x), 30 + x + 4 * number, 1.8) << what << ' ' << x;
        EXPECT_NEAR(seen(96 + x), 30 + x + kShift + 4 * number, 1.8) << what << ' ' << x;
    }
}

TEST_F(VideoReaderTest, TheVideosOfBothEyesBecomePairs) {
    const std::string jpeg = "-c:v mjpeg -pix_fmt yuvj420p -q:v 1 -qmin 1 -huffman default";
    const std::string h264 = "-c:v libx264 -qp 1 -g 4 -bf 2 ";
    const fs::path plain = make("plain.avi", twoVideos(jpeg));
    std::string bytes = slurp(plain); // with the camera's name, where the muxer left room
    const std::string stated = "AVIF" + std::string(4, '\0') +
                               std::string("\1\0\x0f\1\2\0\x9\0\0\0\x12\0\0\0\0\0\0\0", 18) +
                               std::string("FUJIFILM\0", 9);
    const std::size_t room = bytes.find("JUNK");
    bytes.replace(room, 4, "strd");
    bytes.replace(room + 8, stated.size(), stated);
    spill(directory / "fuji.avi", bytes);
    make("titles.mkv",
         twoVideos(h264 + "-metadata:s:0 title=RIGHT -metadata:s:1 title='left eye'", true));
    make("names.mp4",
         twoVideos(h264 + "-metadata:s:0 handler_name=Left -metadata:s:1 handler_name=Right"));
    make("unsaid.mkv", twoVideos(h264));
    const VideoReaderOptions both = ofBothEyes();
    VideoReaderOptions wanted = both;
    wanted.joinsVideos = true;
    for (const auto& [name, options, remark] :
         {std::tuple("plain.avi", both, "--stereo off reads one"), std::tuple("fuji.avi", both, ""),
          std::tuple("titles.mkv", both, ""), std::tuple("names.mp4", both, ""),
          std::tuple("unsaid.mkv", wanted, "")}) {
        VideoReader reader(directory / name, options);
        EXPECT_EQ(reader.facts().size, cv::Size(192, 64)) << name;
        EXPECT_EQ(reader.facts().eyes, kTwoVideos) << name;
        EXPECT_EQ(reader.facts().eyesLayout, StereoLayout::LeftRight) << name;
        const std::vector<VideoFrame> pairs = allFrames(reader);
        ASSERT_EQ(pairs.size(), 10U) << name;
        for (int i = 0; i < 10; ++i)
            expectPair(pairs[static_cast<std::size_t>(i)], i, name);
        const std::string notes = textOf(reader.notes());
        EXPECT_TRUE(remark[0] == 0 ? notes.empty() : holds(notes, remark)) << name << notes;
        VideoReaderOptions part = options;
        part.from = 0.55;
        VideoReader later(directory / name, part);
        EXPECT_EQ(later.framesBefore(), 6) << name;
        EXPECT_TRUE(sameFrames(allFrames(later), pairs, 6,
                               std::llround(0.55 / reader.facts().timeBase.value())))
            << name;
        // a writer has no further video to leave out
        VideoReader source(directory / name, options);
        VideoWriterOptions copy;
        copy.size = {192, 64};
        const VideoWriter writer(directory / "copy.mkv", copy, &source);
        EXPECT_EQ(textOf(writer.notes()), "") << name;
        VideoReader left(directory / name);
        const std::vector<VideoFrame> alone = allFrames(left);
        ASSERT_EQ(alone.size(), 10U) << name;
        EXPECT_EQ(cv::norm(alone[4].picture, pairs[4].picture.colRange(0, 96), cv::NORM_INF), 0)
            << name;
        EXPECT_TRUE(holds(textOf(left.notes()), "two videos of one size")) << name;
    }
    VideoReader unsaid(directory / "unsaid.mkv", both);
    EXPECT_EQ(unsaid.facts().size, cv::Size(96, 64));
    EXPECT_TRUE(holds(textOf(unsaid.notes()), "--stereo videos reads both"));
    EXPECT_TRUE(holds(errorOf([&] { VideoReader(makeClip("one.mkv"), wanted); }),
                      "does not hold two videos of one size"));
}

TEST_F(VideoReaderTest, FramesWithoutTheOtherEyesAreLeftOut) {
    for (const char* const name : {"a.mkv", "b.mp4"}) {
        for (const int lacking : {0, 1}) {
            const fs::path file = make(
                name, twoVideos("-y -c:v libx264 -qp 1 -bf 2 -fps_mode passthrough -filter:v:" +
                                std::to_string(lacking) +
                                " 'select=not(eq(n\\,4))' -metadata:s:0 handler_name=left "
                                "-metadata:s:1 handler_name=right -metadata:s:0 title=left "
                                "-metadata:s:1 title=right"));
            VideoReader reader(file, ofBothEyes());
            const std::vector<VideoFrame> pairs = allFrames(reader);
            ASSERT_EQ(pairs.size(), 9U) << name << lacking;
            for (int i = 0; i < 9; ++i)
                expectPair(pairs[static_cast<std::size_t>(i)], i < 4 ? i : i + 1, name);
            EXPECT_EQ(reader.counts().corrupt, 1) << name << lacking;
        }
    }
}

TEST_F(VideoReaderTest, OtherVideosThanThoseOfBothEyesAreReadAlone) {
    const auto notesOf = [&](const char* name, const std::string& options) {
        VideoReader reader(make(name, twoVideos("-c:v libx264 " + options)), ofBothEyes());
        EXPECT_EQ(reader.facts().size, cv::Size(96, 64)) << name;
        return textOf(reader.notes());
    };
    EXPECT_EQ(notesOf("cut.mkv", "-filter:v:1 crop=64:64"), "");
    EXPECT_EQ(notesOf("two.mkv", "-metadata:s:1 language=ger"), "");
    EXPECT_EQ(notesOf("said.mkv", "-disposition:1 comment"), "");
    EXPECT_EQ(notesOf("sides.mkv", "-metadata:s:0 stereo_mode=left_right"), "");
    EXPECT_TRUE(holds(notesOf("half.mkv", "-metadata:s:0 title=left"), "of which one is read"));
}

TEST_F(VideoReaderTest, OfMvcTheBaseViewIsSaidToBeReadAlone) {
    const std::string base = slurp(makeClip("base.h264", "-bf 0"));
    const auto notesOf = [&](const std::string& unit, const char* name) {
        std::string bytes = base;
        bytes.insert(bytes.find(std::string("\0\0\1\x68", 4)), std::string("\0\0\1", 3) + unit);
        spill(directory / "layers.h264", bytes);
        ffmpeg("-r 25 -i " + arg(directory / "layers.h264") +
               " -c copy -metadata:s:v stereo_mode=block_lr " + arg(directory / name));
        VideoReader reader(directory / name);
        EXPECT_EQ(allFrames(reader).size(), holds(textOf(reader.notes()), "MVC") ? 50U : 25U);
        return textOf(reader.notes());
    };
    const std::string stereoHigh("\x6f\x80\0\x1e", 4);
    const std::string scalable("\x6f\x53\0\x1e", 4);
    const std::string slice("\x74\x40\1\7\x99", 5);
    EXPECT_TRUE(holds(notesOf(stereoHigh, "a.mkv"), "is a 3D video in MVC"));
    EXPECT_TRUE(holds(notesOf(slice, "b.mkv"), "the base view alone"));
    EXPECT_TRUE(holds(notesOf(scalable, "c.mkv"), "by turns"));
}

TEST_F(VideoReaderTest, SphericalVideosAreRefusedWithACommandThatMakesAFlatOne) {
    // grey is the longitude, once for each eye
    const auto clip = [&](const char* name, const char* grey) {
        return makeClip(name, "-c:v libx264 -qp 1",
                        "color=size=512x256:rate=5:duration=0.2,geq=lum='" + std::string(grey) +
                            "':cb=128:cr=128");
    };
    const std::string full(4, '\0');
    const std::string none(16, '\0');
    const std::string half("\0\0\0\0\0\0\0\0\x40\0\0\0\x40\0\0\0", 16);
    const auto sphere = [&](const std::string& shape) { // Google's second marks
        return heifBox("sv3d",
                       heifBox("svhd", full + std::string("x", 2)) +
                           heifBox("proj", heifBox("prhd", full + std::string(12, '\0')) + shape));
    };
    const std::string uuid("\xff\xcc\x82\x63\xf8\x55\x4a\x93\x88\x14\x58\x7a\x02\x52\x1f\xdd", 16);
    const std::string first = "<GSpherical:Spherical>true</GSpherical:Spherical>";
    const std::string pair = heifBox("st3d", full + "\2");
    const fs::path whole = clip("whole.mp4", "40+160*X/W");
    const fs::path eyes = clip("eyes.mp4", "40+320*X/W-120*floor(2*X/W)");
    const auto refusal = [&](const fs::path& flat, const std::string& boxes) {
        spill(directory / "bent.mp4", withBoxesInEntry(slurp(flat), boxes, "avc1"));
        return openError(directory / "bent.mp4");
    };
    // @param degrees of the video; flat pictures show 90 of them: tan(longitude) is even
    const auto expectFlat = [&](const std::string& error, double degrees, bool hasEyes) {
        const std::size_t command = error.find("ffmpeg -i");
        ASSERT_NE(command, std::string::npos) << error;
        const std::size_t end = error.rfind(' ') + 1;
        ffmpeg(error.substr(command + 6, end - command - 6) + "-qp 1 " +
               arg(directory / error.substr(end)));
        VideoReader reader(directory / error.substr(end));
        const auto frame = reader.next();
        ASSERT_TRUE(frame);
        const int eyeWidth = frame->picture.cols / (hasEyes ? 2 : 1);
        EXPECT_NEAR(static_cast<double>(eyeWidth) / frame->picture.rows, 16.0 / 9, 0.01);
        for (int eye = 0; eye < (hasEyes ? 2 : 1); ++eye) {
            for (const double place : {0.1, 0.25, 0.5, 0.8}) {
                const int x = static_cast<int>(place * eyeWidth);
                const double tangent = 2 * (x + 0.5) / eyeWidth - 1;
                const double longitude = std::atan(tangent) * 180 / CV_PI;
                const double stored = 40 + 160 * (0.5 + longitude / degrees) + 40 * eye;
                const double seen = (stored - 16) * 255 / 219; // of limited range
                const cv::Vec3b& pixel =
                    frame->picture.at<cv::Vec3b>(frame->picture.rows / 2, eye * eyeWidth + x);
                EXPECT_NEAR(pixel[1], seen, 3) << error << ' ' << eye << ' ' << place;
            }
        }
    };
    const std::string bent = refusal(whole, sphere(heifBox("equi", full + none)));
    expectFlat(bent, 360, false);
    EXPECT_EQ(refusal(whole, heifBox("uuid", uuid + first)), bent);
    expectFlat(refusal(eyes, pair + sphere(heifBox("equi", full + half))), 180, true);
    EXPECT_TRUE(holds(refusal(eyes, pair + sphere(heifBox("mshp", none))), "mesh"));
    EXPECT_TRUE(holds(refusal(whole, sphere(heifBox("cbmp", full + full + full))), "cubemap"));
    EXPECT_TRUE(holds(refusal(whole, heifBox("prji", full + "hequ")), "180 degrees"));
    EXPECT_EQ(refusal(whole, heifBox("prji", full + "rect")), "(no error)");
    EXPECT_EQ(refusal(whole, heifBox("uuid", uuid + "<Spherical>false")), "(no error)");
    refusal(whole, sphere(heifBox("equi", full + none)));
    ffmpeg("-i " + arg(directory / "bent.mp4") + " -c copy -strict unofficial " +
           arg(directory / "bent.mkv"));
    EXPECT_TRUE(
        holds(openError(directory / "bent.mkv"), "is a video of 360 degrees (equirectangular)"));
}

TEST_F(VideoReaderTest, ACutOffFileDeliversItsReadablePart) {
    for (const char* const name : {"whole.mkv", "whole.mp4"}) {
        const fs::path whole =
            makeClip(name, "-movflags +faststart", "testsrc2=size=160x120:rate=25:duration=4");
        const std::string bytes = slurp(whole);
        const fs::path cut = directory / ("cut-" + std::string(name));
        spill(cut, bytes.substr(0, bytes.size() / 2));
        VideoReader reader(cut);
        const std::vector<VideoFrame> frames = allFrames(reader);
        EXPECT_GT(frames.size(), 20u) << name;
        EXPECT_LT(frames.size(), 80u) << name;
        EXPECT_TRUE(reader.counts().truncated) << name;
        ASSERT_FALSE(reader.notes().empty()) << name;
        EXPECT_TRUE(holds(reader.notes()[0].text, "is cut off: it ends after"));
        EXPECT_TRUE(holds(reader.notes()[0].text, "s of 4 s"));
        EXPECT_TRUE(sameFrames(frames, allFrames(whole))) << name;
    }
}

TEST_F(VideoReaderTest, DamagedFramesAreLeftOutAndCounted) {
    // Damage in the middle of pictures; in Matroska it would hit the container as well.
    for (const char* const codec : {"libx264 -movflags +faststart", "ffv1 -slicecrc 1 -level 3"}) {
        const fs::path file =
            makeClip(std::string(codec)[0] == 'l' ? "clip.mp4" : "clip.mkv",
                     std::string("-c:v ") + codec, "testsrc2=size=160x120:rate=25:duration=4");
        std::string bytes = slurp(file);
        for (std::size_t at = bytes.size() / 3; at < bytes.size() / 3 + 300; ++at)
            bytes[at] = static_cast<char>(~bytes[at]);
        const fs::path broken = directory / "broken.video";
        spill(broken, bytes);
        VideoReader reader(broken);
        const std::vector<VideoFrame> frames = allFrames(reader);
        EXPECT_GT(reader.counts().corrupt, 0) << codec;
        EXPECT_GT(frames.size(), 50u) << codec;
        EXPECT_LT(frames.size(), 100u) << codec;
        EXPECT_FALSE(reader.notes().empty());
        // The frame before a gap stays until the next one.
        for (std::size_t i = 0; i + 1 < frames.size(); ++i)
            EXPECT_EQ(frames[i].pts + frames[i].duration, frames[i + 1].pts);
    }
}

class VideoReaderInput : public FileTest {};

TEST_F(VideoReaderInput, BadInputIsNamed) {
    const std::string text = "This is no video, but a text of some length.\nAnd another line.\n";
    const std::tuple<const char*, std::string, const char*> cases[] = {
        {"empty.mp4", "", "is empty, expected a video file"},
        {"text.txt", text, "is not a video that FFmpeg can read"},
        {"huge.y4m", "YUV4MPEG2 W60000 H60000 F25:1 C420\nFRAME\n", // more than it can count
         "is not a video that FFmpeg can read"},
        {"text.nfo", text, "is a text, expected a video file"}}; // FFmpeg would draw it
    for (const auto& [name, contents, problem] : cases) {
        spill(directory / name, contents);
        EXPECT_EQ(openError(directory / name), problem) << name;
    }
    EXPECT_EQ(openError(directory / "missing.mp4"), "does not exist, expected a video file");
}

TEST_F(VideoReaderTest, FilesWithoutVideosThatAreReadAreNamed) {
    EXPECT_EQ(openError(make("sound.mka", "-f lavfi -i sine=duration=1 -c:a flac")),
              "holds no video stream but audio flac, expected a video");
    // A cover picture is not a video.
    EXPECT_TRUE(holds(
        openError(make("cover.m4a",
                       "-f lavfi -i sine=duration=1 -f lavfi -i testsrc2=size=32x32 -frames:v 1 "
                       "-c:a aac -c:v mjpeg -pix_fmt yuvj420p -disposition:v attached_pic")),
        "holds no video stream"));
    EXPECT_EQ(
        openError(make("moving.webp",
                       "-f lavfi -i testsrc2=size=64x48:rate=5:duration=1 -c:v libwebp_anim")),
        "is an animated WebP picture, expected a video; convert it first");
    std::string bytes = slurp(makeClip("clip.avi"));
    for (std::size_t at = 0; (at = bytes.find("H264", at)) != std::string::npos;)
        bytes.replace(at, 4, "QQ77");
    spill(directory / "odd.avi", bytes);
    EXPECT_EQ(openError(directory / "odd.avi"),
              "has video of the codec \"QQ77\", which this FFmpeg cannot decode");
    bytes = slurp(makeClip("whole.mp4"));
    spill(directory / "cut.mp4", bytes.substr(0, bytes.size() / 2));
    EXPECT_EQ(openError(directory / "cut.mp4"),
              "has no index (moov): it is cut off or was never finished, expected a whole file");
}

TEST(VideoReaderOptions, OptionsAreChecked) {
    VideoReaderOptions options;
    options.from = -1;
    EXPECT_EQ(errorOf([&] { validate(options); }),
              "from: is -1 s, expected 0 or more, less than 1e9 s");
    options.from = 3;
    options.to = 3;
    EXPECT_EQ(errorOf([&] { validate(options); }), "to: is 3 s, expected more than from, 3 s");
    options.to = 4;
    options.threads = 65;
    EXPECT_EQ(errorOf([&] { validate(options); }), "threads: is 65, expected 0..64");
}

TEST_F(VideoReaderTest, TheFramesThatFollowAreTheSame) {
    const fs::path clip =
        makeClip("clip.mp4", "-vf \"select='not(eq(mod(n,7),3))'\" -fps_mode vfr -g 40",
                 "testsrc2=size=64x48:rate=25:duration=12");
    const fs::path bare = // without times
        makeClip("clip.h264", "-g 40", "testsrc2=size=64x48:rate=25:duration=6");
    for (const fs::path& file : {clip, bare}) {
        for (const double from : {0.0, 1.5}) {
            const std::vector<VideoFrame> all = allFrames(file, partFrom(from));
            ASSERT_GT(all.size(), 100u);
            for (const std::size_t k :
                 {std::size_t{0}, std::size_t{1}, std::size_t{77}, all.size() - 1}) {
                VideoReader reader(file, partFrom(from));
                reader.skipTo(all[k].pts);
                const std::vector<VideoFrame> rest = allFrames(reader);
                ASSERT_EQ(rest.size(), all.size() - k) << file << " " << from << " " << k;
                EXPECT_TRUE(sameFrames(rest, all, k)) << file << " " << from << " " << k;
            }
            VideoReader reader(file, partFrom(from));
            reader.skipTo(all.back().pts + 1000000);
            EXPECT_FALSE(reader.next());
        }
    }
}

TEST_F(VideoReaderTest, AWantedPartEndsWhereItEndsWithoutSkipping) {
    const fs::path clip = makeClip("clip.mp4", "", "testsrc2=size=96x64:rate=24:duration=9");
    for (const double from : {0.0, 0.5}) {
        const VideoReaderOptions options = partFrom(from, 7);
        const std::vector<VideoFrame> all = allFrames(clip, options);
        ASSERT_EQ(all.size(), from > 0 ? 156u : 168u);
        const std::int64_t end = all.back().pts + all.back().duration; // where the next one stands
        for (const std::int64_t goal : {end, end + all.back().duration, end - 1}) {
            VideoReader reader(clip, options);
            reader.skipTo(goal);
            EXPECT_FALSE(reader.next()) << "from " << from << ", skipped to " << goal;
        }
        VideoReader reader(clip, options);
        reader.skipTo(all.back().pts);
        EXPECT_TRUE(reader.next());
        EXPECT_FALSE(reader.next());
    }
}

} // namespace
} // namespace altiro3D::test
