#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/heif_files.hpp"
#include "support/onnx.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"
#include "support/stereo_scene.hpp"
#include "support/video.hpp"

#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sys/stat.h>
#include <thread>

namespace altiro3D::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr const char* kTool = "video2native";

std::string streamHash(const fs::path& file, const std::string& stream) {
    return ffmpeg("-i " + arg(file) + " -map 0:" + stream + " -c copy -f md5 -");
}

std::size_t frameCount(const fs::path& file) {
    return lines(ffprobe(file, "packet=pts", "-select_streams v:0")).size();
}

std::vector<double> frameTimes(const fs::path& file) {
    std::vector<double> times;
    for (const std::string& line : lines(ffprobe(file, "packet=pts_time", "-select_streams v:0")))
        times.push_back(std::stod(line));
    std::sort(times.begin(), times.end());
    return times;
}

// A small display, clip.mp4 (3 s with sound, subtitles, chapters) and depth.mp4 that goes with it.
class VideoStudio : public SmallStudio {
  public:
    explicit VideoStudio(double seconds = 3) {
        spill(*this / "words.srt", "1\n00:00:00,200 --> 00:00:01,000\nHello\n");
        spill(*this / "chapters.txt",
              ";FFMETADATA1\ntitle=A clip\n[CHAPTER]\nTIMEBASE=1/1000\nSTART=0\nEND=1000\n"
              "title=One\n[CHAPTER]\nTIMEBASE=1/1000\nSTART=1000\nEND=3000\ntitle=Two\n");
        const std::string length = std::to_string(seconds);
        ffmpeg("-f lavfi -i testsrc2=size=120x160:rate=30000/1001:duration=" + length +
               " -f lavfi -i sine=440:duration=" + length + " -f lavfi -i sine=880:duration=" +
               length + " -i " + arg(*this / "words.srt") + " -i " + arg(*this / "chapters.txt") +
               " -map 0 -map 1 -map 2 -map 3 -map_metadata 4 -map_chapters 4 -c:v libx264 -crf 10"
               " -g 30 -c:a aac -c:s mov_text " +
               arg(*this / "clip.mp4"));
        ffmpeg("-f lavfi -i gradients=size=60x80:rate=30000/1001:c0=black:c1=white:nb_colors=2:"
               "speed=0.02:seed=3:duration=" +
               length + " -c:v libx264 -crf 4 " + arg(*this / "depth.mp4"));
    }
    Arguments call(const std::string& output, const Arguments& more = {}) const {
        return display() + Arguments("-j 1 --depth depth.mp4") + more +
               Arguments{"clip.mp4", output};
    }
    Outcome make(const std::string& output, const Arguments& more = {}) const {
        return run(kTool, call(output, more));
    }
};

class Video2NativeTool : public ::testing::Test {
  protected:
    void SetUp() override { ALTIRO3D_REQUIRE_FFMPEG(); }
};
using Video2NativeFolder = Video2NativeTool;

// --- what is in the file ---------------------------------------------------------------------

TEST_F(Video2NativeTool, KeepsTimesSoundSubtitlesChaptersAndTags) {
    VideoStudio studio;
    ASSERT_TRUE(isDone(studio.make("native.mp4")));
    EXPECT_EQ(ffprobe(studio / "native.mp4", "stream=codec_name,profile,width,height,pix_fmt",
                      "-select_streams v"),
              "h264|High 4:4:4 Predictive|96|128|yuv444p\n");
    EXPECT_EQ(
        lines(ffprobe(studio / "native.mp4", "stream=codec_type")),
        (std::vector<std::string>{"video", "audio", "audio", "subtitle", "data"})); // chapters
    EXPECT_EQ(frameTimes(studio / "native.mp4"), frameTimes(studio / "clip.mp4"));
    for (const char* stream : {"a:0", "a:1", "s:0"})
        EXPECT_EQ(streamHash(studio / "native.mp4", stream),
                  streamHash(studio / "clip.mp4", stream));
    for (const char* entries :
         {"chapter=start_time,end_time:chapter_tags=title", "format_tags=title"})
        EXPECT_EQ(ffprobe(studio / "native.mp4", entries), ffprobe(studio / "clip.mp4", entries));
    EXPECT_FALSE(fs::exists(studio / "native.mp4.parts"));
    ffmpeg("-xerror -i " + arg(studio / "native.mp4") + " -f null -");
    // and without sound and subtitles, in another container
    ASSERT_TRUE(isDone(studio.make("native.mkv", "--no-audio --no-subtitles --codec ffv1")));
    EXPECT_EQ(lines(ffprobe(studio / "native.mkv", "stream=codec_name")),
              std::vector<std::string>{"ffv1"});
    const std::vector<double> times = frameTimes(studio / "native.mkv");
    const std::vector<double> expected = frameTimes(studio / "clip.mp4");
    ASSERT_EQ(times.size(), expected.size());
    for (std::size_t i = 0; i < times.size(); ++i)
        EXPECT_NEAR(times[i], expected[i], 0.00101);
}

// Each frame that the tool wrote to native.mkv equals the library's result for clip.mp4 and the
// depths.
void expectNatives(const Sandbox& studio, const Calibration& calibration,
                   const std::vector<cv::Mat>& depths, const LibraryPath& path,
                   const std::string& call) {
    SCOPED_TRACE(call);
    VideoReader natives(studio / "native.mkv");
    VideoReader clip(studio / "clip.mp4");
    for (const cv::Mat& depth : depths) {
        const auto native = natives.next();
        const auto frame = clip.next();
        ASSERT_TRUE(native && frame);
        ASSERT_TRUE(
            samePicture(native->picture, libraryNative(calibration, frame->picture, depth, path)));
    }
    EXPECT_FALSE(natives.next());
}

// The grey values of depth.mp4 as they are.
std::vector<cv::Mat> givenDepths(const Sandbox& studio) {
    VideoReader reader(studio / "depth.mp4");
    std::vector<cv::Mat> depths;
    while (const auto frame = reader.next()) {
        cv::Mat grey;
        cv::cvtColor(frame->picture, grey, cv::COLOR_BGR2GRAY);
        grey.convertTo(depths.emplace_back(), CV_32F, 1 / 255.0);
    }
    return depths;
}

const Arguments kLossless("-y --codec ffv1 --no-audio --no-subtitles");

TEST_F(Video2NativeTool, EveryFrameIsTheNativeOfThePhotoAndItsDepth) {
    VideoStudio studio(0.2);
    const std::vector<cv::Mat> depths = givenDepths(studio);
    ASSERT_EQ(depths.size(), 6u);
    writeCalibration(studio / "other.json", {128, 96}, 50, "OTHER-2");
    studio.makeMap();
    const Calibration small = readCalibration(studio / "small.json");
    const Calibration other = readCalibration(studio / "other.json");

    struct Case {
        Arguments arguments;
        LibraryPath path;
        bool other = false; // display
    };
    std::vector<Case> cases;
    const auto add = [&](const Arguments& arguments, const std::function<void(LibraryPath&)>& set) {
        cases.push_back({arguments, {}, false});
        cases.back().path.views.strengthPercent = 40; // at 30 px, 10 % would show little
        cases.back().path.refine = false; // in a video the flaws are those of a scene's first frame
        set(cases.back().path);
        return &cases.back();
    };
    const auto none = [](LibraryPath&) {};
    add({}, none);
    add({"--profile", "live"}, [](LibraryPath& path) { path.views.method = ViewMethod::Fast; });
    add({"--profile", "best"}, [](LibraryPath& path) {
        path.quilt = false;
        path.keep = true;
        path.positions = ViewPositions::Continuous;
    });
    add({"--profile", "best", "-g"}, [](LibraryPath& path) { // cannot be continuous
        path.views.method = ViewMethod::Real;
        path.keep = true;
    });
    add({"--layout", "4x2", "--resolution", "20x18"}, [](LibraryPath& path) {
        path.layout = {2, 4, {18, 20}, 8};
    });
    add({"-m", "a.map"}, none);
    add({"--calibration", "other.json", "--fit", "contain"}, [](LibraryPath& path) {
        path.fit = FitMode::Contain;
    })->other = true;
    for (const auto& [arguments, path, otherDisplay] : cases) {
        // what is given last counts
        const Outcome outcome = studio.convert(
            kTool, kLossless + Arguments("--exact-depth --strength 40 --depth depth.mp4") +
                       arguments + Arguments("clip.mp4 native.mkv"));
        ASSERT_EQ(outcome.status, 0) << outcome.text();
        expectNatives(studio, otherDisplay ? other : small, depths, path, outcome.call);
    }
}

TEST_F(Video2NativeTool, AutoChoosesOnceForEachScene) { // what the library chooses
    SmallStudio studio;
    constexpr int kCut = 8; // first frame of the second scene
    std::vector<cv::Mat> pictures;
    std::vector<cv::Mat> depths;         // 8 bits, as colours
    for (int i = 0; i < 2 * kCut; ++i) { // a sharp near thing moves on the left, then on the right
        const bool second = i >= kCut;
        const cv::Rect thing((second ? 100 : 10) + 2 * (i % kCut), 40, 30, 70);
        pictures.push_back(scenery({160, 120}, second ? 11 : 3));
        randomPhoto(thing.size(), 9, 0.8).copyTo(pictures.back()(thing));
        depths.emplace_back(120, 160, CV_8UC3, cv::Scalar::all(second ? 60 : 20));
        depths.back()(thing).setTo(cv::Scalar::all(second ? 180 : 230));
    }
    writeLossless(studio / "clip.mkv", pictures);
    writeLossless(studio / "depth.mkv", depths);
    const Outcome outcome = studio.convert(
        kTool, kLossless + Arguments("--exact-depth --depth depth.mkv --fit auto --focus auto "
                                     "--strength auto --report r.json clip.mkv native.mkv"));
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.out, "(first of 2 scenes)"));
    const Json choices = studio.json("r.json").at("choices");
    ASSERT_EQ(choices.size(), 2U);
    EXPECT_DOUBLE_EQ(choices[0].at("start"), 0);
    EXPECT_NEAR(choices[1].at("start").get<double>(), kCut / 25.0, 1e-6);
    EXPECT_LT(choices[0].at("center").at(0), 0.5); // where the thing is
    EXPECT_GT(choices[1].at("center").at(0), 0.5);
    for (const Json& choice : choices) {
        EXPECT_GT(choice.at("focus"), 0.5);
        EXPECT_GT(choice.at("strengthPercent"), 0);
    }
}

// The library's depth of clip.mp4 for a given rate of inferences and input size.
std::vector<cv::Mat> estimatedDepths(const Sandbox& studio, const VideoDepth::Estimator& estimate,
                                     int every) {
    VideoDepthOptions options;
    options.every = every;
    VideoDepth depth(estimate, DepthKind::NearWhite, options);
    VideoReader clip(studio / "clip.mp4");
    std::vector<cv::Mat> depths;
    while (const auto frame = clip.next())
        depth.next(frame->picture, depths.emplace_back());
    return depths;
}

TEST_F(Video2NativeTool, NetworksAreRunAsOftenAndAsLargeAsAsked) {
    VideoStudio studio(0.2);
    fs::create_directory(studio / "net");
    spill(studio / "net/small.onnx", onnx::mixModel({0.2F, 0.3F, 0.5F}, {64, 32}));
    spill(studio / "net/large.onnx", onnx::mixModel({0.9F, 0.1F, 0.0F}, {64, 32}));
    spill(studio / "net/catalog.json", R"({"networks": [
        {"name": "midas-small", "file": "small.onnx", "inputWidth": 64, "inputHeight": 32,
         "multipleOf": 16},
        {"name": "midas-large", "file": "large.onnx", "inputWidth": 64, "inputHeight": 32,
         "multipleOf": 16, "large": true}]})");
    studio.set("ALTIRO3D_MODELS", (studio / "net").string());
    spill(studio / "mine.onnx", onnx::mixModel({0.1F, 0.6F, 0.3F}, {32, 96}));
    spill(studio / "mine.json", R"({"name": "mine", "inputWidth": 32, "inputHeight": 96})");

    struct Case {
        Arguments arguments;
        const char* file;
        cv::Size input;
        int every; // 0: as the pictures need it
    };
    const Case cases[] = {
        {{}, "net/small.onnx", {64, 32}, 0},
        {"--network net/small.onnx --depth-every 2", "net/small.onnx", {64, 32}, 2},
        {"--profile best", "net/small.onnx", {64, 32}, 1},
        {"--network-size 128", "net/small.onnx", {128, 64}, 0},
        {"-l", "net/large.onnx", {64, 32}, 0},
        {"-n mine.onnx --net-profile mine.json", "mine.onnx", {32, 96}, 0}};
    const RestoredThreads restored;
    cv::setNumThreads(1); // as -j 1: a network's sums depend on it
    for (const auto& [arguments, file, input, every] : cases) {
        const Outcome outcome =
            studio.convert(kTool, kLossless + Arguments("-j 1 --report r.json --exact-depth") +
                                      arguments + Arguments("clip.mp4 native.mkv"));
        ASSERT_TRUE(isDone(outcome));
        const Json report = studio.json("r.json");
        EXPECT_EQ(report["settings"]["networkSize"], Json({input.width, input.height}))
            << outcome.call;
        EXPECT_EQ(report["settings"]["depthEvery"], every) << outcome.call;
        if (every > 0) {
            EXPECT_EQ(report["inferences"], (6 + every - 1) / every) << outcome.call;
        }
        NetworkProfile profile;
        profile.name = "reference";
        profile.inputWidth = std::string(file) == "mine.onnx" ? 32 : 64;
        profile.inputHeight = std::string(file) == "mine.onnx" ? 96 : 32;
        profile.multipleOf = 16;
        const auto source =
            depthFromNetworkFile(studio / file, profile, InferenceTarget::Cpu, input);
        LibraryPath path;
        path.refine = false;
        if (report["settings"]["profile"] == "best") {
            path.quilt = false;
            path.keep = true;
            path.positions = ViewPositions::Continuous;
        }
        expectNatives(studio, readCalibration(studio / "small.json"),
                      estimatedDepths(
                          studio,
                          [&](const cv::Mat& picture, cv::Mat& raw) {
                              cv::Mat photo;
                              source->readFrame(picture, photo, raw);
                          },
                          every),
                      path, outcome.call);
    }
}

TEST_F(Video2NativeTool, EqualFramesAreMadeOnce) {
    SmallStudio studio;
    ffmpeg("-loop 1 -i " + arg(studio / "photo.png") +
           " -t 2 -r 25 -c:v libx264 -qp 0 -pix_fmt yuv444p " + arg(studio / "still.mp4"));
    ASSERT_TRUE(isDone(studio.convert(kTool, "--report r.json still.mp4 native.mp4")));
    const Json report = studio.json("r.json");
    EXPECT_EQ(report["frames"], 50);
    EXPECT_EQ(report["inferences"], 1);
    EXPECT_EQ(report["repeatedFrames"], 49);
    EXPECT_EQ(report["sceneCuts"].size(), 0u);
    EXPECT_EQ(frameCount(studio / "native.mp4"), 50u);
}

TEST_F(Video2NativeTool, SizeAndRateAreSaidAndTheCapIsThePanels) {
    VideoStudio studio;
    const auto made = [&](const Arguments& more) {
        const Outcome outcome = studio.make("n.mp4", Arguments("-y --report r.json") + more);
        EXPECT_TRUE(isDone(outcome));
        return std::pair(outcome.out, studio.json("r.json"));
    };
    const auto [text, report] = made("--profile balanced --preview 0.5");
    const auto bytes = static_cast<double>(fs::file_size(studio / "n.mp4"));
    EXPECT_EQ(report["bytes"].get<double>(), bytes);
    EXPECT_NEAR(report["megabitsPerSecond"].get<double>(), 8e-6 * bytes / 0.5, 0.005);
    EXPECT_EQ(report["settings"]["encoder"]["maxRate"], 1); // of 96 x 128 px: .6, at least 1
    char expected[100];
    std::snprintf(expected, sizeof expected, ", %.1f MB, %.1f Mbit/s; ", 1e-6 * bytes,
                  report["megabitsPerSecond"].get<double>());
    EXPECT_TRUE(holds(text, expected));
    std::snprintf(expected, sizeof expected, "the whole video (0:03.0) becomes about %.1f MB",
                  6e-6 * bytes);
    EXPECT_TRUE(holds(text, expected));
    EXPECT_EQ(made("--profile live").second["settings"]["encoder"]["maxRate"], 0);
    EXPECT_EQ(made("--max-rate 7").second["settings"]["encoder"]["maxRate"], 7);
    EXPECT_FALSE(holds(made("--max-rate 0").first, "becomes about"));
}

// --- on the display ----------------------------------------------------------------------------

TEST_F(Video2NativeTool, ShowHandsTheNativesToTheViewerBesideIt) {
    VideoStudio studio(0.2);
    studio.makeMap();
    // a substitute for altiro3Dview that keeps its arguments and input
    fs::create_directory(studio / "bin");
    const fs::path tool = studio / "bin" / kTool;
    fs::copy(toolPath(kTool), tool);
    const auto viewerEndsWith = [&](const char* status) {
        spill(studio / "bin/altiro3Dview",
              std::string("#!/bin/sh\nprintf '%s\\n' \"$@\" >arguments\ncat >shown\nexit ") +
                  status);
        fs::permissions(studio / "bin/altiro3Dview", fs::perms::owner_all);
    };
    viewerEndsWith("0");
    struct Case {
        Arguments arguments;
        std::vector<std::string> expected; // of altiro3Dview
        ViewMethod method;
    };
    const Case cases[] = {
        {"-c small.json", {"--show", "-", "-c", "small.json"}, ViewMethod::Fast},
        {"-c small.json -m a.map", {"--show", "-", "-c", "small.json"}, ViewMethod::Fast},
        {"-m a.map --screen HDMI-1", {"--show", "-", "--screen", "HDMI-1"}, ViewMethod::Fast},
        {"-c small.json --screen 1 --serial TEST-1 --profile balanced",
         {"--show", "-", "-c", "small.json", "--serial", "TEST-1", "--screen", "1"},
         ViewMethod::Layered}};
    const Calibration calibration = readCalibration(studio / "small.json");
    const std::vector<cv::Mat> depths = givenDepths(studio);
    for (const auto& [arguments, expected, method] : cases) {
        const Outcome outcome = studio.run(
            tool.string(),
            arguments +
                Arguments("--exact-depth -q 2x3 -r 40x30 --depth depth.mp4 --show clip.mp4"));
        ASSERT_TRUE(isDone(outcome));
        EXPECT_EQ(lines(slurp(studio / "arguments")), expected);
        // late frames may be left out; each that is there is one of the Natives, in order
        LibraryPath path;
        path.views.method = method;
        path.refine = false;
        std::vector<std::string> natives;
        VideoReader clip(studio / "clip.mp4");
        for (const cv::Mat& depth : depths) {
            cv::Mat rgb;
            cv::cvtColor(libraryNative(calibration, clip.next()->picture, depth, path), rgb,
                         cv::COLOR_BGR2RGB);
            natives.emplace_back(reinterpret_cast<const char*>(rgb.data), rgb.total() * 3);
        }
        const std::string head = "P6\n96 128\n255\n";
        const std::string shown = slurp(studio / "shown");
        std::size_t count = 0;
        std::size_t next = 0;
        for (std::size_t at = 0; at < shown.size(); ++count) {
            ASSERT_EQ(shown.compare(at, head.size(), head), 0);
            at += head.size();
            while (next < natives.size() &&
                   shown.compare(at, natives[next].size(), natives[next]) != 0)
                ++next;
            ASSERT_LT(next++, natives.size()) << "frame " << count << " is none of the Natives";
            at += natives.front().size();
        }
        EXPECT_GE(count, 1u);
        EXPECT_TRUE(holds(outcome.out, std::to_string(count) + " frames shown, " +
                                           std::to_string(natives.size() - count) + " dropped"));
    }
    const Arguments call = studio.display() + Arguments("--depth depth.mp4 --show clip.mp4");
    viewerEndsWith("1"); // and reports the reason itself
    EXPECT_EQ(studio.run(tool.string(), call).status, 1);
    fs::remove(studio / "bin/altiro3Dview");
    EXPECT_TRUE(fails(studio.run(tool.string(), call), 1,
                      "altiro3Dview: cannot be started, expected it beside video2native"));
}

// Depth of a camera of 12 bits, or of a part of 16 bits, as a photo's depth: by percentiles.
TEST_F(Video2NativeTool, DepthOf16BitsHasOneRange) {
    SmallStudio studio;
    ffmpeg("-f lavfi -i testsrc2=size=96x64:rate=10:duration=1 -c:v libx264 -g 5 " +
           arg(studio / "clip.mp4"));
    fs::create_directory(studio / "depths");
    // a ramp of 0..4095; the second half of the frames has the near half of it alone
    for (int k = 0; k < 10; ++k) {
        cv::Mat depth(64, 96, CV_16UC1);
        for (int x = 0; x < depth.cols; ++x)
            depth.col(x).setTo(k < 5 ? x * 4095 / 95 : 2047 + x * 2048 / 95);
        writeImage(studio / ("depths/d" + std::to_string(k) + ".png"), depth);
    }
    ffmpeg("-framerate 10 -i " + arg(studio / "depths/d%d.png") + " -c:v ffv1 -pix_fmt gray16le " +
           arg(studio / "depth.mkv"));
    const auto made = [&](const Arguments& more, const std::string& name) {
        const Outcome outcome =
            studio.convert(kTool, Arguments("-j 1 --rgbd-out --codec ffv1 --exact-depth") + more +
                                      Arguments{"clip.mp4", name});
        EXPECT_EQ(outcome.status, 0) << outcome.text();
        std::vector<cv::Mat> depths;
        VideoReader reader(studio / name);
        while (const auto frame = reader.next())
            depths.push_back(frame->picture.colRange(96, 192).clone());
        return depths;
    };
    const std::vector<cv::Mat> whole = made("--depth depths", "whole.mkv");
    ASSERT_EQ(whole.size(), 10U);
    const auto expect = [](const cv::Mat& depth, int x, double value) {
        EXPECT_NEAR(depth.at<cv::Vec3b>(30, x)[0], value, 3) << x;
    };
    expect(whole[0], 0, 0);
    expect(whole[0], 48, 129);
    expect(whole[0], 95, 255);
    expect(whole[9], 0, 127); // one range for all
    expect(whole[9], 95, 255);
    // a video and a stated range
    const std::vector<cv::Mat> video = made("--depth depth.mkv", "video.mkv");
    ASSERT_EQ(video.size(), 10U);
    for (std::size_t i = 0; i < video.size(); ++i)
        EXPECT_LE(cv::norm(video[i], whole[i], cv::NORM_INF), 0) << i;
    const std::vector<cv::Mat> stated = made("--depth depths --depth-range 0:8190", "stated.mkv");
    expect(stated[0], 95, 127);
    // a pipe is read once
    studio.readInputFrom(studio / "depth.mkv");
    const Arguments piped = studio.display() + Arguments("--rgbd-out --depth - clip.mp4");
    EXPECT_TRUE(fails(studio.run(kTool, piped + Arguments{"p.mkv"}), 1, "--depth-range A:B"));
    studio.readInputFrom(studio / "depth.mkv");
    EXPECT_TRUE(
        isDone(studio.run(kTool, piped + Arguments("--depth-range 0:4095 --codec ffv1 q.mkv"))));
}

TEST_F(Video2NativeTool, InputsThatMayNotBeMeantAreWarnedOf) {
    SmallStudio studio;
    for (const char* name : {"film_LR.mp4", "film.3D.HSBS.mp4", "plain.mp4", "color.mp4"}) {
        ffmpeg("-f lavfi -i testsrc2=size=96x64:rate=5:duration=0.4 -c:v libx264 " +
               arg(studio / name));
        const Outcome outcome = studio.convert(kTool, {"-y", "--rgbd-out", name, "out.mp4"});
        EXPECT_EQ(outcome.status, 0) << outcome.text();
        EXPECT_EQ(outcome.err.find("both eyes") != std::string::npos, name[0] == 'f') << name;
    }
    EXPECT_TRUE(warns(studio.convert(kTool, "-y -d plain.mp4 color.mp4 out.mp4"),
                      "color.mp4: has colours, and depth has none"));
    ASSERT_TRUE(isDone(studio.convert(kTool, "plain.mp4 native.mp4")));
    EXPECT_TRUE(warns(studio.convert(kTool, "native.mp4 again.mp4"), "like a Native video"));
}

// --- inputs ----------------------------------------------------------------------------------

TEST_F(Video2NativeTool, AllWaysToGiveDepthMakeTheSameVideo) {
    VideoStudio studio(0.6);
    const auto frames = [&](const Arguments& arguments) {
        const Outcome outcome = studio.convert(
            kTool, Arguments("-y -j 1 --codec ffv1 --no-audio --no-subtitles --exact-depth") +
                       arguments + Arguments{"native.mkv"});
        EXPECT_TRUE(isDone(outcome));
        return ffmpeg("-i " + arg(studio / "native.mkv") + " -map 0:v -f framemd5 -");
    };
    const std::string byOption = frames("--depth depth.mp4 clip.mp4");
    EXPECT_EQ(frames("-d clip.mp4 depth.mp4"), byOption);
    fs::create_directory(studio / "depths");
    VideoReader depths(studio / "depth.mp4");
    for (int i = 1; const auto frame = depths.next(); ++i) {
        cv::Mat grey;
        cv::cvtColor(frame->picture, grey, cv::COLOR_BGR2GRAY);
        writeImage(studio / ("depths/d" + std::to_string(i) + ".png"), grey);
    }
    EXPECT_EQ(frames("--depth depths clip.mp4"), byOption);
    // far = white
    VideoReader clip(studio / "clip.mp4");
    VideoReader again(studio / "depth.mp4");
    VideoWriterOptions options;
    options.codec = VideoCodec::Ffv1;
    options.timeBase = clip.facts().timeBase;
    options.size = {60, 80};
    VideoWriter far(studio / "far.mkv", options);
    while (auto frame = clip.next()) {
        const cv::Mat depth = again.next()->picture;
        VideoFrame made = *frame;
        cv::subtract(cv::Scalar::all(255), depth, made.picture);
        far.write(made);
    }
    far.finish();
    EXPECT_EQ(frames("--depth far.mkv --depth-kind far-white clip.mp4"), byOption);
    // a directory that is too short
    fs::remove(studio / "depths/d18.png");
    EXPECT_TRUE(warns(studio.convert(kTool, "-y --depth depths clip.mp4 short.mp4"),
                      "17 pictures, fewer than the video has frames"));
}

// A run of a long clip that was killed after its first segment.
class KilledRun {
  public:
    KilledRun(const SmallStudio& studio, Arguments call) : studio_(studio), call_(std::move(call)) {
        const Outcome killed = studio.run(kTool, call_ + Arguments("-y out.mp4"), SIGKILL, [&] {
            return fs::exists(studio / "out.mp4.parts" / "000002.mp4");
        });
        EXPECT_EQ(killed.status, 128 + SIGKILL) << killed.text();
    }
    Outcome resumed(const Arguments& more = {}) const {
        return studio_.run(kTool, call_ + more + Arguments("--resume out.mp4"));
    }

  private:
    const SmallStudio& studio_;
    Arguments call_;
};

constexpr int kGreys = 85; // 3 levels apart, which 4:2:0 of less than the full range keeps apart

// The numbers, modulo kGreys, of the pictures of a directory that frames were made with.
std::vector<int> picturesUsed(const fs::path& rgbd) {
    std::vector<int> numbers;
    VideoReader reader(rgbd);
    while (const auto frame = reader.next()) {
        const int half = frame->picture.cols / 2;
        const cv::Rect depth(half + half / 4, frame->picture.rows / 4, half / 2,
                             frame->picture.rows / 2);
        numbers.push_back(static_cast<int>(std::lround(cv::mean(frame->picture(depth))[0] / 3)));
    }
    return numbers;
}

// A directory of 120 pictures for picturesUsed().
void writeNumberedDepths(const fs::path& directory) {
    fs::create_directory(directory);
    for (int k = 0; k < 120; ++k)
        writeImage(directory / ("d" + std::to_string(k) + ".png"),
                   cv::Mat(8, 6, CV_8UC1, cv::Scalar(k % kGreys * 3)));
}

TEST_F(Video2NativeTool, PicturesOfDepthBelongToTheFramesByCount) {
    SmallStudio studio;
    writeNumberedDepths(studio / "depths");
    // 10 frames a second for 2 s, then 30 for 2 s; bare streams state no rate to rely on
    const std::string varying =
        "-f lavfi -i testsrc2=size=48x64:rate=30:duration=2.7 -vf "
        "'settb=1/1000,setpts=if(lt(N\\,20)\\,N*100\\,2000+(N-20)*100/3)' -vsync vfr "
        "-enc_time_base 1/1000 -c:v libx264 -g 7 -bf 2 ";
    ffmpeg(varying + arg(studio / "vfr.mp4"));
    ffmpeg(varying + arg(studio / "vfr.mkv"));
    ffmpeg("-i " + arg(studio / "vfr.mkv") + " -c copy " + arg(studio / "vfr.ts"));
    const auto used = [&](const std::string& clip, const Arguments& part) {
        const Outcome outcome = studio.convert(
            kTool, part + Arguments{"-y", "--rgbd-out", "--crf", "2", "--preset", "ultrafast",
                                    "--depth", "depths", clip, "out.mp4"});
        EXPECT_EQ(outcome.status, 0) << outcome.text();
        return picturesUsed(studio / "out.mp4");
    };
    for (const char* const clip : {"vfr.mp4", "vfr.mkv", "vfr.ts", "-"}) {
        const bool isPiped = std::string(clip) == "-";
        if (isPiped) studio.readInputFrom(studio / "vfr.mkv");
        const std::vector<int> all = used(clip, {});
        // FFmpeg 7 writes an edit list into MP4 that hides the last of the 81 frames
        const std::vector<std::string> shown =
            lines(ffprobe(studio / (isPiped ? "vfr.mkv" : clip), "frame=pts", "-select_streams v"));
        ASSERT_GE(shown.size(), 80u) << clip;
        ASSERT_EQ(all.size(), shown.size()) << clip;
        for (std::size_t k = 0; k < all.size(); ++k)
            EXPECT_EQ(all[k], static_cast<int>(k)) << clip;
        for (const auto& [from, first] :
             std::vector<std::pair<const char*, std::size_t>>{{"0.15", 2}, {"3", 50}}) {
            const std::vector<int> part = used(clip, {"--from", from});
            EXPECT_EQ(part,
                      std::vector<int>(all.begin() + static_cast<std::ptrdiff_t>(first), all.end()))
                << clip << " from " << from;
        }
    }
}

TEST_F(Video2NativeTool, DepthInAVideoOfTheFileIsUsed) {
    SmallStudio studio;
    const auto film = [&](const std::string& name, const std::string& depth,
                          const std::string& pixels) {
        ffmpeg("-f lavfi -i color=gray:size=" + depth +
               ":rate=10:duration=0.4,format=gray16le,geq=lum=1000+X*600 -f lavfi -i "
               "testsrc2=size=48x64:rate=10:duration=0.4 -map 0 -map 1 -c:v ffv1 -pix_fmt:v:0 " +
               pixels + " -pix_fmt:v:1 yuv420p -metadata:s:v:0 title=DEPTH " + arg(studio / name));
    };
    const auto makes = [&](const Arguments& arguments, const std::string& output) {
        return studio.convert(kTool, Arguments{"--rgbd-out", "-y"} + arguments + Arguments{output});
    };
    const auto tells = [&](const std::string& clip, const char* text) {
        const Outcome outcome = makes({clip}, "a.mp4");
        return outcome.status == 0 && holds(outcome.err, text);
    };
    const auto isAsGiven = [&](const Arguments& given) {
        return makes(given, "b.mp4").status == 0 &&
               slurp(studio / "a.mp4") == slurp(studio / "b.mp4");
    };
    film("mm.mkv", "24x32", "gray16le");
    EXPECT_TRUE(tells("mm.mkv", "is used, as distances"));
    EXPECT_TRUE(isAsGiven(Arguments("--depth mm.mkv --depth-kind metric mm.mkv")));
    EXPECT_FALSE(isAsGiven(Arguments("--depth mm.mkv mm.mkv")));
    film("white.mkv", "24x32", "gray");
    EXPECT_TRUE(tells("white.mkv", "is used, white as near"));
    EXPECT_TRUE(isAsGiven(Arguments("--depth white.mkv white.mkv")));
    film("wide.mkv", "32x24", "gray16le");
    EXPECT_TRUE(tells("wide.mkv", "it has another shape than the colours"));
}

TEST_F(Video2NativeTool, PicturesOfDepthBelongToTheSameFramesAfterAResume) {
    SmallStudio studio;
    writeNumberedDepths(studio / "depths");
    // 5 frames a second for 6 s, then 10
    ffmpeg("-f lavfi -i testsrc2=size=48x64:rate=10:duration=12 -vf "
           "'settb=1/1000,setpts=if(lt(N\\,30)\\,N*200\\,6000+(N-30)*100)' -vsync vfr "
           "-enc_time_base 1/1000 -c:v libx264 -g 7 -bf 2 " +
           arg(studio / "vfr.mkv"));
    const Arguments call =
        studio.display() + Arguments("-j 1 --rgbd-out --crf 2 --depth depths --from 5 vfr.mkv");
    ASSERT_TRUE(isDone(studio.run(kTool, call + Arguments{"whole.mp4"})));
    std::vector<int> expected;
    for (int k = 25; k < 120; ++k)
        expected.push_back(k % kGreys);
    EXPECT_EQ(picturesUsed(studio / "whole.mp4"), expected);
    EXPECT_TRUE(says(KilledRun(studio, call).resumed(), "continues at 0:"));
    EXPECT_TRUE(slurp(studio / "out.mp4") == slurp(studio / "whole.mp4"));
}

TEST_F(Video2NativeTool, QuiltVideosGoInAndOut) {
    VideoStudio studio(1);
    ASSERT_TRUE(isDone(studio.make("q.mp4", "--quilt-out --crf 2")));
    const fs::path quilt = studio / "q_qs3x2a0.75.mp4";
    EXPECT_EQ(ffprobe(quilt, "stream=width,height,pix_fmt", "-select_streams v"),
              "90|80|yuv420p\n");
    EXPECT_EQ(streamHash(quilt, "a:0"), streamHash(studio / "clip.mp4", "a:0"));
    ASSERT_TRUE(isDone(studio.run(kTool, {"-c", "small.json", "--from-quilt", quilt.string(),
                                          "--codec", "ffv1", "n.mkv", "--no-subtitles"})));
    VideoReader quilts(quilt);
    VideoReader natives(studio / "n.mkv");
    int count = 0;
    while (const auto frame = quilts.next()) {
        EXPECT_TRUE(
            samePicture(natives.next()->picture, libraryNative(studio, frame->picture, 3, 2, {})));
        ++count;
    }
    EXPECT_EQ(count, 30);
    // with even sides
    writeCalibration(studio / "portrait.json", {1536, 2048}, 52.58, "LKG-P00001"); // 3360 : 9 px
    ASSERT_TRUE(isDone(studio.run(kTool, "-c portrait.json --method fast --preset ultrafast "
                                         "--preview 0.03 --depth depth.mp4 -q 7x9 --quilt-out "
                                         "clip.mp4 q_qs9x7a0.75.mp4")));
    EXPECT_EQ(ffprobe(studio / "q_qs9x7a0.75.mp4", "stream=width,height", "-select_streams v:0"),
              "3348|3360\n");
}

TEST_F(Video2NativeTool, StandardInputPipesAndDevicesAreRead) {
    VideoStudio studio(1);
    ffmpeg("-i " + arg(studio / "clip.mp4") + " -map 0:v -map 0:a -c copy " +
           arg(studio / "clip.mkv"));
    studio.readInputFrom(studio / "clip.mkv");
    ASSERT_TRUE(isDone(studio.convert(kTool, "--depth depth.mp4 - piped.mp4")));
    EXPECT_EQ(frameCount(studio / "piped.mp4"), 30u);
    EXPECT_TRUE(fails(studio.run(kTool, Arguments("-c small.json --from-quilt - o.mp4")), 2,
                      "as it is read only once; expected -q ROWSxCOLUMNS"));
    EXPECT_EQ(streamHash(studio / "piped.mp4", "a:1"), streamHash(studio / "clip.mp4", "a:1"));
    studio.readInputFrom("/dev/null");
    // only devices lose frames
    ASSERT_TRUE(isDone(studio.convert(
        kTool,
        "--profile live --input-format lavfi --preview 0.4 testsrc2=size=64x48:rate=25 live.mkv")));
    EXPECT_GE(frameCount(studio / "live.mkv"), 1u);
    EXPECT_LE(frameCount(studio / "live.mkv"), 10u);
    ASSERT_TRUE(isDone(studio.make("stated.mp4", "--input-format mov")));
    EXPECT_EQ(frameCount(studio / "stated.mp4"), 30u);
    ASSERT_EQ(mkfifo((studio / "pipe").c_str(), 0600), 0);
    std::thread feeder(
        [&] { std::ofstream(studio / "pipe", std::ios::binary) << slurp(studio / "clip.mkv"); });
    const Outcome piped = studio.convert(kTool, "-y --depth depth.mp4 pipe piped.mp4");
    feeder.join();
    ASSERT_TRUE(isDone(piped));
    EXPECT_EQ(frameCount(studio / "piped.mp4"), 30u);
}

TEST_F(Video2NativeTool, StandardOutputIsWrittenAsMatroska) {
    VideoStudio studio(1);
    const Arguments lossless("--codec ffv1 --no-subtitles --depth depth.mp4 clip.mp4");
    ASSERT_TRUE(isDone(studio.convert(kTool, lossless + Arguments("file.mkv"))));
    studio.sendOutputTo(studio / "out.mkv");
    const Outcome outcome = studio.convert(kTool, lossless + Arguments("- --report r.json"));
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.err, "standard output: Native video")); // not in the video
    EXPECT_EQ(frameCount(studio / "out.mkv"), 30u);
    for (const char* stream : {"v", "a:0", "a:1"})
        EXPECT_EQ(streamHash(studio / "out.mkv", stream), streamHash(studio / "file.mkv", stream));
    EXPECT_TRUE(studio.json("r.json")["bytes"].is_null());
    EXPECT_FALSE(fs::exists(studio / "-"));
    studio.sendOutputTo("/dev/full");
    EXPECT_EQ(studio.convert(kTool, lossless + Arguments("-")).status, 1);
}

TEST_F(Video2NativeTool, ConvertsTheReadablePartOfACutOffVideo) {
    VideoStudio studio;
    ffmpeg("-i " + arg(studio / "clip.mp4") + " -map 0:v -map 0:a -c copy " +
           arg(studio / "clip.mkv"));
    const std::string whole = slurp(studio / "clip.mkv");
    spill(studio / "cut.mkv", whole.substr(0, whole.size() / 2));
    EXPECT_TRUE(
        fails(studio.convert(kTool, "--depth depth.mp4 cut.mkv native.mp4"), 1, "is cut off"));
    const std::size_t count = frameCount(studio / "native.mp4");
    EXPECT_GT(count, 20u);
    EXPECT_LT(count, 70u);
    // damaged in the middle
    std::string damaged = whole;
    for (std::size_t i = damaged.size() / 4; i < damaged.size() / 4 * 3; ++i)
        if (i % 4000 < 40) damaged[i] = static_cast<char>(damaged[i] ^ 0x5a);
    spill(studio / "damaged.mkv", damaged);
    const Outcome outcome =
        studio.convert(kTool, "--depth depth.mp4 --report r.json damaged.mkv repaired.mp4");
    EXPECT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_GT(frameCount(studio / "repaired.mp4"), 40u);
    EXPECT_GT(studio.json("r.json")["corruptFrames"].get<int>(), 0);
}

// --- long runs -------------------------------------------------------------------------------

TEST_F(Video2NativeTool, AKilledRunContinuesToTheSameBytes) {
    ALTIRO3D_TAKES(7);
    VideoStudio studio(27);
    const Outcome whole = studio.make("whole.mp4", "--depth-kind near-white");
    ASSERT_TRUE(isDone(whole));
    const Arguments call = studio.call("out.mp4", "--depth-kind near-white");
    for (const char* segment : {"000001.mp4", "000002.mp4", "000004.mp4"}) {
        const Outcome killed = studio.run(kTool, call + Arguments{"--resume"}, SIGKILL, [&] {
            return fs::exists(studio / "out.mp4.parts" / segment);
        });
        EXPECT_EQ(killed.status, 128 + SIGKILL);
        EXPECT_FALSE(fs::exists(studio / "out.mp4"));
    }
    const Outcome again = studio.run(kTool, call);
    EXPECT_EQ(again.status, 1);
    EXPECT_TRUE(holds(again.err, "expected --resume to continue it, or -y"));
    EXPECT_TRUE(fails(studio.run(kTool, call + Arguments("--resume --focus 0.4")), 1,
                      "(--focus was not set and is 0.4), expected the same; -y begins again"));
    EXPECT_TRUE(
        says(studio.run(kTool, call + Arguments("--resume --report r.json")), "continues at 0:"));
    EXPECT_TRUE(slurp(studio / "out.mp4") == slurp(studio / "whole.mp4"));
    EXPECT_FALSE(fs::exists(studio / "out.mp4.parts"));
    const Json report = studio.json("r.json");
    EXPECT_EQ(report["frames"], 810);
    EXPECT_LT(report["framesOfThisRun"], 631);
}

TEST_F(Video2NativeTool, WhatMovesInGivenDepthAloneIsSeenAfterAResume) {
    VideoStudio studio(1);
    ffmpeg("-f lavfi -i testsrc2=size=120x160:rate=10:duration=0.1 -vf loop=139:1 -c:v ffv1 " +
           arg(studio / "still.mkv"));
    ffmpeg("-f lavfi -i testsrc2=size=60x80:rate=10:duration=14 -vf format=gray -c:v ffv1 " +
           arg(studio / "moving.mkv"));
    const Arguments call =
        studio.display() + Arguments("-j 1 --depth-kind metric --depth moving.mkv still.mkv");
    ASSERT_TRUE(isDone(studio.run(kTool, call + Arguments{"whole.mp4"})));
    EXPECT_TRUE(says(KilledRun(studio, call).resumed(), "continues at 0:"));
    EXPECT_TRUE(slurp(studio / "out.mp4") == slurp(studio / "whole.mp4"));
}

TEST_F(Video2NativeTool, APartThatWasMadeButNotJoinedGetsNoFurtherFrames) {
    VideoStudio studio(1);
    ffmpeg("-f lavfi -i testsrc2=size=120x160:rate=4:duration=10 -f lavfi -i sine=duration=10 "
           "-c:v libx264 -g 4 -c:a pcm_s16le " +
           arg(studio / "long.mkv"));
    for (const Arguments& part : {Arguments("--to 7"), Arguments("--preview 7")}) {
        const auto made = [&](const std::string& name, const Arguments& more = {}) {
            return studio.convert(
                kTool, part + more + Arguments{"-j", "1", "--depth", "long.mkv", "long.mkv", name});
        };
        const std::string whole = "whole" + part[0] + ".mkv";
        const std::string out = "out" + part[0] + ".mkv";
        ASSERT_EQ(made(whole).status, 0);
        ASSERT_EQ(frameCount(studio / whole), 28u);
        studio.limitFiles(fs::file_size(studio / whole) - 1000); // a disk too full to join them
        ASSERT_EQ(made(out).status, 1);
        ASSERT_TRUE(fs::exists(studio / (out + ".parts")));
        studio.limitFiles(0);
        const Outcome resumed = made(out, "--resume");
        EXPECT_EQ(resumed.status, 0) << resumed.text();
        EXPECT_EQ(frameCount(studio / out), 28u);
        EXPECT_TRUE(slurp(studio / out) == slurp(studio / whole));
    }
}

TEST_F(Video2NativeTool, ARunContinuesOnlyWithTheSameInputs) {
    VideoStudio studio(14);
    fs::create_directory(studio / "other"); // a depth video of the clip's name
    fs::rename(studio / "depth.mp4", studio / "other" / "clip.mp4");
    const Arguments inputs("-j 1 --depth other/clip.mp4 clip.mp4");
    const KilledRun run(studio, studio.display() + inputs);
    for (const fs::path& input : {studio / "clip.mp4", studio / "other" / "clip.mp4"}) {
        const auto time = fs::last_write_time(input);
        fs::last_write_time(input, time + std::chrono::seconds(3));
        EXPECT_TRUE(fails(run.resumed(), 1, "video has changed")) << input;
        fs::last_write_time(input, time);
    }
    if (cv::getNumberOfCPUs() > 1) {
        EXPECT_TRUE(fails(run.resumed("-j 2"), 1, "(threads was 1 and is 2)"));
    }
    // lenses of the same kind, but another model, which has another quilt of its own
    std::string other = slurp(studio / "small.json");
    other.replace(other.find("TEST-1"), 6, "LKG-A1");
    spill(studio / "other.json", other);
    const Arguments rest = inputs + Arguments("--resume out.mp4");
    EXPECT_TRUE(fails(studio.run(kTool, Arguments("-c other.json") + rest), 1, "other settings"));
    fs::rename(studio / "small.json", studio / "mine.json"); // the same display
    EXPECT_TRUE(isDone(studio.run(kTool, Arguments("-c mine.json -q 2x3 -r 40x30") + rest)));
}

TEST_F(Video2NativeTool, AnInterruptEndsTheFileProperly) {
    VideoStudio studio(30);
    const auto begun = [&] { return fs::exists(studio / "out.mp4.parts" / "000002.mp4"); };
    const Outcome stopped = studio.run(kTool, studio.call("out.mp4"), SIGINT, begun);
    EXPECT_EQ(stopped.status, 130) << stopped.text();
    EXPECT_TRUE(holds(stopped.err, "stopped at 0:"));
    const std::size_t count = frameCount(studio / "out.mp4");
    EXPECT_GT(count, 119u);
    EXPECT_LT(count, 900u);
    ffmpeg("-xerror -i " + arg(studio / "out.mp4") + " -f null -");
    EXPECT_NEAR(std::stod(ffprobe(studio / "out.mp4", "stream=duration", "-select_streams a:0")),
                static_cast<double>(count) * 1001 / 30000, 0.1);
    ASSERT_TRUE(isDone(studio.make("out.mp4", "--resume")));
    EXPECT_EQ(frameCount(studio / "out.mp4"), 900u);
}

TEST_F(Video2NativeTool, MemoryDoesNotGrowWithTheLength) {
    ALTIRO3D_TAKES(23);
#ifdef ALTIRO3D_SANITIZED
    GTEST_SKIP() << "AddressSanitizer keeps what was freed";
#endif
    const auto peakOf = [](const char* seconds) {
        SmallStudio studio;
        ffmpeg(std::string("-f lavfi -i testsrc2=size=64x48:rate=25:duration=") + seconds +
               " -f lavfi -i sine=duration=" + seconds +
               " -map 0 -map 1 -map 0 -c:v libx264 -preset ultrafast -c:a aac" +
               " -c:v:1 rawvideo -s:v:1 64x48 -allow_raw_vfw 1 " + arg(studio / "clip.mkv"));
        EXPECT_TRUE(
            warns(studio.convert(
                      kTool, "--method fast --preset ultrafast --report r.json clip.mkv out.mp4"),
                  "further video rawvideo is left out"));
        const Json report = studio.json("r.json");
        EXPECT_EQ(report["frames"], 25 * std::stoi(seconds));
        return report["peakMegabytes"].get<double>();
    };
    const double brief = peakOf("20");
    const double tenMinutes = peakOf("600");
    RecordProperty("peakMegabytes", std::to_string(tenMinutes));
    // 30 times as many frames, and 69 MB of a second video stream that is not used; only an index
    // of some 100 bytes per packet grows, once for reading and once for writing
    EXPECT_LT(tenMinutes, brief + 30) << brief;
}

TEST_F(Video2NativeTool, AFullDiskLosesNothingElse) {
    VideoStudio studio(2);
    spill(studio / "out.mkv", "old");
    EXPECT_TRUE(fails(studio.make("out.mkv", "--resume"), 1,
                      "out.mkv: exists, and no unfinished run of it is kept, so it may be "
                      "complete, expected a new name"));
    for (const std::size_t bytes : {12000U, 60000U}) { // as a disk that is full for each file
        studio.limitFiles(bytes);
        const Outcome outcome = studio.make("out.mkv", "-y --codec ffv1");
        EXPECT_EQ(outcome.status, 1);
        EXPECT_EQ(outcome.errLines().size(), 1u) << outcome.text();
        EXPECT_TRUE(holds(outcome.err, "File too large"));
        EXPECT_EQ(slurp(studio / "out.mkv"), "old");
        EXPECT_FALSE(holds(outcome.out, "is kept")); // no segment was whole
        EXPECT_FALSE(fs::exists(studio / "out.mkv.parts"));
    }
    studio.limitFiles(0);
    ASSERT_TRUE(isDone(studio.make("out.mkv", "-y --codec ffv1 --no-subtitles")));
}

TEST_F(Video2NativeTool, ProgressIsForProgramsToo) {
    VideoStudio studio;
    const Outcome outcome = studio.make("out.mp4", "--progress json --report r.json");
    ASSERT_TRUE(isDone(outcome));
    std::vector<Json> progress;
    for (const std::string& line : lines(outcome.out))
        progress.push_back(Json::parse(line)); // nothing else is on standard output
    ASSERT_GE(progress.size(), 2u);
    EXPECT_EQ(progress.front()["state"], "running");
    EXPECT_EQ(progress.front()["framesInAll"], 90);
    EXPECT_EQ(progress[progress.size() - 2]["state"], "finishing");
    EXPECT_EQ(progress.back()["state"], "done");
    EXPECT_EQ(progress.back()["frames"], 90);
    const Json report = studio.json("r.json");
    EXPECT_EQ(report["state"], "done");
    EXPECT_EQ(report["frames"], 90);
    const double finish = report["finishSeconds"];
    EXPECT_GT(finish, 0);
    EXPECT_GT(report["seconds"], finish);
    const double rate = report["framesPerSecond"];
    EXPECT_NEAR(rate, 90 / report["seconds"].get<double>(), 1e-5 * rate); // both are rounded
    ASSERT_EQ(report["stages"].size(), 4u);
    const char* const names[] = {"decode", "depth", "render", "encode"};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(report["stages"][i]["name"], names[i]);
        EXPECT_EQ(report["stages"][i]["frames"], 90);
        EXPECT_GT(report["stages"][i]["millisecondsPerFrame"], 0);
        EXPECT_GE(report["stages"][i]["longestMilliseconds"],
                  report["stages"][i]["millisecondsPerFrame"]);
    }
    EXPECT_EQ(report["settings"]["given"]["depth"], "depth.mp4");
}

TEST_F(Video2NativeTool, PicturesOneAfterTheOtherAreAVideo) {
    VideoStudio studio(1);
    ffmpeg("-i " + arg(studio / "clip.mp4") + " -frames:v 3 -f image2pipe -c:v png " +
           arg(studio / "pictures.png"));
    const Arguments call = studio.display() + Arguments{"-y"};
    EXPECT_TRUE(isDone(studio.run(kTool, call + Arguments("pictures.png o.mp4"))));
    EXPECT_EQ(frameCount(studio / "o.mp4"), 3U);
    // a given input format is followed even for a picture
    EXPECT_TRUE(
        isDone(studio.run(kTool, call + Arguments("--input-format png_pipe photo.png o.mp4"))));
    EXPECT_TRUE(fails(studio.run(kTool, call + Arguments("--from-quilt quilt.png o.mp4")), 2,
                      "quilt.png: is a picture, expected a video; quilt2native"));
    for (const auto& [name, picture] :
         {std::pair("a.avif", av1Colours(1)), {"a.heic", hevcColours(1)}}) {
        spill(studio / name, heifFile(std::string(name).substr(2), {picture}));
        EXPECT_TRUE(fails(studio.run(kTool, call + Arguments{name, "out.mp4"}), 2,
                          "is a picture, expected a video; photo2native"));
    }
}

// --- folders ---------------------------------------------------------------------------------

// in/ holds short clips and what phones and people put beside them.
class FolderStudio : public SmallStudio {
  public:
    explicit FolderStudio(double seconds = 0.2) {
        fs::create_directories(*this / "in/trip");
        for (const char* name : {"in/a.mp4", "in/a.mov", "in/trip/a.mkv"}) {
            ffmpeg("-f lavfi -i testsrc2=size=64x48:rate=25:duration=" + std::to_string(seconds) +
                   " -c:v libx264 " + arg(*this / name));
        }
    }
    Outcome make(const Arguments& more, int signal = 0,
                 const std::function<bool()>& when = {}) const {
        const Arguments quick("--method fast --preset ultrafast -j 1");
        return run(kTool, display() + quick + more, signal, when);
    }
};

TEST_F(Video2NativeFolder, LongVideosBesidePhotosAreNoClipsOfThem) {
    const FolderStudio studio;
    ffmpeg("-f lavfi -i testsrc2=size=64x48:rate=2:duration=6 -c:v libx264 " +
           arg(studio / "in/holiday.mp4"));
    fs::copy(studio / "in/a.mp4", studio / "in/live.mov");
    for (const char* name : {"in/holiday.jpg", "in/LIVE.JPG"})
        spill(studio / name, "a photo");
    const Outcome outcome = studio.make("in out");
    EXPECT_TRUE(isDone(outcome));
    EXPECT_TRUE(fs::exists(studio / "out/holiday_native.mp4"));
    EXPECT_TRUE(holds(outcome.out, "in/live.mov: is the clip of the Live Photo LIVE.JPG\n"));
}

// A video of one picture.
void writeStill(const fs::path& file, const cv::Mat& picture) {
    writeLossless(file, {picture, picture, picture});
}

TEST_F(Video2NativeFolder, VideosThatAreNotFlatAreLeftOutByName) {
    const SmallStudio studio;
    fs::create_directory(studio / "in");
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat both;
    cv::hconcat(eyes.left, eyes.right, both);
    cv::Mat rgbd;
    joinRgbd(eyes.left, cv::Mat(eyes.left.size(), CV_32FC1, cv::Scalar(0.5)), DepthSide::Right,
             rgbd);
    writeStill(studio / "in/film_LR.mkv", both);
    writeStill(studio / "in/clip_RGBD.mkv", rgbd);
    writeStill(studio / "in/flat_LR.mkv", scenery({400, 300}, 7));
    writeStill(studio / "in/far_180x180_LR.mkv", both);
    cv::Mat quilt; // whose name does not say it
    Depth2Quilt({4, 5, {140, 100}, 20})
        .render({scenery({140, 100}, 3), randomDepth({140, 100})}, quilt);
    writeStill(studio / "in/film.mkv", quilt);
    const auto make = [&](const Arguments& arguments) {
        return studio.convert(kTool, Arguments("--codec ffv1") + arguments);
    };
    const Outcome outcome = make("in out");
    EXPECT_TRUE(warns(outcome, "flat_LR.mkv: its name (LR) may mean that it holds both eyes, but "
                               "its halves do not match"));
    for (const char* line :
         {"both eyes: beside each other, as its name says it (LR), and its halves match",
          "clip_RGBD.mkv: holds photo and depth by its name (RGBD); video2native --rgbd right",
          "far_180x180_LR.mkv: is made for headsets (VR) by its name",
          "film.mkv: is a video of quilts of 4 columns x 5 rows; quilt2native",
          "2 videos made, 3 left out (1 VR file, 1 3D video, 1 quilt video)"})
        EXPECT_TRUE(holds(outcome.out, line));
    EXPECT_EQ(filesBelow(studio / "out"),
              (std::set<std::string>{"film_LR_native.mkv", "flat_LR_native.mkv"}));

    EXPECT_TRUE(fails(
        make("in/clip_RGBD.mkv a.mkv"), 2,
        "holds photo and depth by its name (RGBD), expected --rgbd with the side of the depth"));
    EXPECT_TRUE(isDone(make("--rgbd right in/clip_RGBD.mkv a.mkv")));
    EXPECT_TRUE(isDone(make("--stereo off in/film_LR.mkv b.mkv")));
    EXPECT_TRUE(fails(make("in/far_180x180_LR.mkv c.mkv"), 1, "is made for headsets (VR)"));
}

TEST_F(Video2NativeTool,
       EyesNeedNoDisplayAndAreReadAsWhatTheyAre) { // their pictures: VideoConverterTest
    const SmallStudio studio;
    studio.makeClip();
    const auto made = [&](const Arguments& arguments) {
        return studio.run(kTool, Arguments("-y --codec ffv1") + arguments);
    };
    EXPECT_TRUE(isDone(made("--stereo-out e_LRF.mkv --stereo-keep left --stereo-swap clip.mp4")));
    const cv::Mat eyes = allFrames(studio / "e_LRF.mkv")[0].picture;
    EXPECT_TRUE(samePicture(eyes.colRange(eyes.cols / 2, eyes.cols),
                            allFrames(studio / "clip.mp4")[0].picture));
    const Outcome again = made("--stereo-out t.mkv --stereo-layout tb e_LRF.mkv");
    EXPECT_TRUE(says(again, "as the file states it (side by side)"));
    EXPECT_TRUE(holds(again.out, "both pictures stay as they were filmed"));
    EXPECT_TRUE(holds(again.out, "only by its name, as t_TBF.mkv"));
    // with a Native
    EXPECT_TRUE(isDone(studio.convert(kTool, "-y --stereo-out e_LRF.mkv clip.mp4 n.mkv")));
    EXPECT_EQ(VideoReader(studio / "n.mkv").facts().size, cv::Size(96, 128));
}

TEST_F(Video2NativeTool, StatedHalvesAreNotStretchedTwice) {
    const SmallStudio studio;
    const std::string beside = "-metadata:s:v stereo_mode=left_right ";
    const std::string above = "-metadata:s:v stereo_mode=top_bottom ";
    struct Case {
        const char* size;
        std::string mode;
        const char* shape; // of the frame by the size that the file states, or null: it is an eye's
        const char* stereo; // the option
    };
    for (const auto& [size, mode, shape, stereo] :
         {Case{"256x144", beside, "32:9", "left-right:squeezed"},
          Case{"256x144", above, "8:9", "top-bottom:squeezed"},
          Case{"180x120", beside, "32:9", "left-right:squeezed"},
          Case{"512x144", beside, "64:9", "left-right:full"},
          Case{"256x144", beside, nullptr, "left-right:squeezed"},
          Case{"256x288", above, nullptr, "top-bottom:full"},
          // half of the px of a 16:9 frame, whose halves are squeezed once more
          Case{"128x144", "", "16:9", "left-right:squeezed"}}) {
        ffmpeg("-y -f lavfi -i testsrc2=rate=5:duration=0.4:size=" + std::string(size) +
               " -c:v libx264 " + mode + arg(studio / "film.mkv"));
        const std::string aspect = shape == nullptr ? "" : std::string(" -aspect ") + shape;
        ffmpeg("-y -i " + arg(studio / "film.mkv") + " -c copy" + aspect + " " +
               arg(studio / "stated.mkv"));
        EXPECT_TRUE(isDone(
            studio.run(kTool, {"-y", "--codec", "ffv1", "--stereo-out", "e_RLF.mkv",
                               "--stereo-layout", "cross", "--stereo", stereo, "stated.mkv"})));
        const VideoFacts facts = VideoReader(studio / "e_RLF.mkv").facts();
        EXPECT_NEAR(facts.sampleAspect.value() * facts.size.width / 2 / facts.size.height, 16.0 / 9,
                    0.02)
            << size << ' ' << stereo;
    }
}

TEST_F(Video2NativeTool, TheVideosOfBothEyesAreAPair) {
    const SmallStudio studio;
    ffmpeg("-f lavfi -i testsrc2=rate=5:duration=0.4:size=96x64 -f lavfi -i "
           "testsrc=rate=5:duration=0.4:size=96x64 -map 0 -map 1 -c:v ffv1 -pix_fmt yuv444p " +
           arg(studio / "two.mkv"));
    const auto made = [&](const Arguments& more) {
        return studio.run(kTool, Arguments("-y --codec ffv1 --stereo-out e_TBF.mkv "
                                           "--stereo-layout tb two.mkv") +
                                     more);
    };
    const Outcome pair = made("--stereo videos");
    EXPECT_TRUE(isDone(pair));
    EXPECT_TRUE(holds(pair.out, "both eyes: beside each other, as --stereo says it"));
    const cv::Mat frame = allFrames(studio / "e_TBF.mkv")[0].picture;
    ASSERT_EQ(frame.size(), cv::Size(96, 128));
    EXPECT_LE(cv::norm(frame.rowRange(0, 64), ffmpegFrames(studio / "two.mkv", {96, 64})[0],
                       cv::NORM_INF),
              3);
    const Outcome one = made({});
    EXPECT_EQ(one.status, 0);
    EXPECT_TRUE(holds(one.err, "--stereo videos reads both"));
}

TEST_F(Video2NativeTool, HalvesOfRgbdFramesMayBeSqueezed) { // what says it: HalvesOf
    const SmallStudio studio;
    cv::Mat both; // of 16:9
    joinRgbd(randomPhoto({80, 90}, 4), randomDepth({80, 90}), DepthSide::Right, both);
    writeStill(studio / "a_HRGBD.mkv", both);
    const auto size = [&](const char* layout, const char* name) {
        EXPECT_TRUE(isDone(studio.convert(kTool, {"-y", "--codec", "ffv1", "--rgbd-out", "--rgbd",
                                                  layout, "a_HRGBD.mkv", name})));
        return VideoReader(studio / name).facts().size;
    };
    EXPECT_EQ(size("right", "o.mkv"), cv::Size(320, 90));
    EXPECT_EQ(size("right:full", "o.mkv"), cv::Size(160, 90));
    EXPECT_EQ(size("right", "o_HRGBD.mkv"), cv::Size(160, 90)); // and are written so
}

TEST_F(Video2NativeFolder, NothingIsLostSilently) {
    const FolderStudio studio;
    const fs::path clip = studio / "in/a.mp4";
    for (const char* name : {"in/IMG_1.MOV", "in/a-depth.mp4", "in/q_qs3x2a0.75.mp4"})
        fs::copy(clip, studio / name);
    for (const char* name : {"in/IMG_1.HEIC", "in/broken.mp4", "in/notes.txt", "in/.hidden.mp4"})
        spill(studio / name, "not a video");
    fs::copy(studio / "photo.png", studio / "in/photo.png");
    ffmpeg("-f lavfi -i testsrc2=size=96x128:rate=25:duration=0.2 -c:v libx264 -pix_fmt yuv444p " +
           arg(studio / "in/shown.mp4"));
    const Outcome outcome = studio.make("--recursive --report r.json in in/out");
    EXPECT_TRUE(fails(outcome, 1, "in/broken.mp4"));
    EXPECT_EQ(filesBelow(studio / "in/out"),
              (std::set<std::string>{"a.mov_native.mp4", "a.mp4_native.mp4", "trip/a_native.mkv"}));
    for (const char* line :
         {"\nin/IMG_1.MOV: is the clip of the Live Photo IMG_1.HEIC\n",
          "\nin/a-depth.mp4: is the depth of a video by its name; video2native --depth takes it",
          "\nin/notes.txt: is no picture or video of a format that can be read\n",
          "\nin/photo.png: is a picture; photo2native makes Natives of photos\n",
          "\nin/q_qs3x2a0.75.mp4: is a video of quilts by its name; quilt2native",
          "\nshown.mp4: has the panel's size and 4:4:4 colour, like a Native video",
          "\na.mp4: 64 x 48 px, 25.00 fps, ",
          "\na.mp4: in/out/a.mp4_native.mp4: Native video, 96 x 128 px, 5 frames, "})
        EXPECT_TRUE(holds(("\n" + outcome.out), line)) << outcome.out;
    EXPECT_TRUE(holds(outcome.out,
                      "\n3 videos made, 1 failed, 7 left out (1 depth video, 2 photos, 1 "
                      "Live Photo clip, 1 .txt file, 1 quilt video, 1 Native video), in "));
    EXPECT_FALSE(holds(outcome.out, "hidden"));

    const Json report = studio.json("r.json");
    std::map<std::string, std::string> states;
    for (const Json& video : report.at("videos")) {
        const char* state = video.contains("error")     ? "error"
                            : video.contains("leftOut") ? "leftOut"
                                                        : "state";
        states[video.at("input")] = *state == 's' ? video.at(state).get<std::string>() : state;
    }
    EXPECT_EQ(states, (std::map<std::string, std::string>{{"in/a.mov", "done"},
                                                          {"in/a.mp4", "done"},
                                                          {"in/broken.mp4", "error"},
                                                          {"in/shown.mp4", "leftOut"},
                                                          {"in/trip/a.mkv", "done"}}));
    // alone it is the same video
    ASSERT_TRUE(isDone(studio.make("in/a.mov alone.mp4")));
    EXPECT_EQ(slurp(studio / "alone.mp4"), slurp(studio / "in/out/a.mov_native.mp4"));
}

TEST_F(Video2NativeFolder, SoundThatMp4CannotHoldGetsAnotherContainer) {
    const FolderStudio studio;
    fs::create_directory(studio / "camera");
    const std::string film = "-f lavfi -i testsrc2=size=64x48:rate=25:duration=0.2 -f lavfi -i "
                             "sine=duration=0.2 -c:v mjpeg -c:a ";
    ffmpeg(film + "pcm_u8 " + arg(studio / "camera/old.avi"));         // in no MP4
    ffmpeg(film + "adpcm_ima_qt " + arg(studio / "camera/older.mov")); // nor in Matroska
    ffmpeg(film + "aac " + arg(studio / "camera/usual.mov"));
    ASSERT_TRUE(isDone(studio.make("camera out")));
    EXPECT_EQ(filesBelow(studio / "out"),
              (std::set<std::string>{"old_native.mkv", "older_native.mov", "usual_native.mp4"}));
    EXPECT_EQ(ffprobe(studio / "out/old_native.mkv", "stream=codec_name", "-select_streams a"),
              "pcm_u8\n");
}

TEST_F(Video2NativeFolder, OutputsThatExistAreKeptUnlessReplaced) {
    const FolderStudio studio;
    spill(studio / "in/b.mp4", "broken");
    fs::create_directory(studio / "out");
    spill(studio / "out/a.mp4_native.mp4", "old");
    spill(studio / "out/b_native.mp4", "old");
    const auto contents = [&](const char* name) { return slurp(studio / "out" / name); };
    EXPECT_TRUE(fails(studio.make("in out"), 1,
                      "out/a.mp4_native.mp4: exists, and so does one other, expected new names"));
    EXPECT_EQ(filesBelow(studio / "out").size(), 2U);

    const Outcome resumed = studio.make("--resume in out"); // complete ones stay
    EXPECT_EQ(resumed.status, 0) << resumed.text();
    EXPECT_TRUE(holds(resumed.out, "\n1 video made, 2 skipped as the outputs exist, 1 left out (1 "
                                   "folder), in "));
    EXPECT_EQ(contents("a.mp4_native.mp4"), "old");

    EXPECT_TRUE(fails(studio.make("-y in out"), 1, "in/b.mp4"));
    EXPECT_EQ(contents("b_native.mp4"), "old"); // the new one failed
    EXPECT_EQ(frameCount(studio / "out/a.mp4_native.mp4"), 5U);
    EXPECT_EQ(filesBelow(studio / "out").size(), 3U);
}

TEST_F(Video2NativeFolder, CtrlCEndsTheRunAndResumeCompletesIt) {
    const FolderStudio studio(30);
    const auto begun = [&] { return fs::exists(studio / "out/a.mp4_native.mp4.parts/000002.mp4"); };
    const Arguments call("--to 20 in out");
    const Outcome stopped = studio.make(call, SIGINT, begun);
    EXPECT_EQ(stopped.status, 130) << stopped.text();
    EXPECT_TRUE(holds(stopped.out, "\n1 video made, 1 stopped, 1 left out (1 folder), in "));
    EXPECT_TRUE(holds(stopped.err, "a.mp4_native.mp4 is whole up to there, --resume continues"));
    EXPECT_EQ(frameCount(studio / "out/a.mov_native.mp4"), 500U);
    EXPECT_LT(frameCount(studio / "out/a.mp4_native.mp4"), 500U);
    EXPECT_TRUE(says(studio.make(Arguments{"--resume"} + call),
                     "\n1 video made, 1 skipped as the outputs exist, "));
    EXPECT_EQ(frameCount(studio / "out/a.mp4_native.mp4"), 500U);
    EXPECT_EQ(filesBelow(studio / "out").size(), 2U);
}

TEST_F(Video2NativeFolder, QuiltAndRgbdVideosAreNamedAsSuch) {
    const FolderStudio studio;
    EXPECT_TRUE(isDone(studio.make("--quilt-out in quilts")));
    EXPECT_TRUE(isDone(studio.run(kTool, "--rgbd-out --codec ffv1 in rgbd")));
    EXPECT_EQ(filesBelow(studio / "quilts"),
              (std::set<std::string>{"a.mov_qs3x2a0.75.mp4", "a.mp4_qs3x2a0.75.mp4"}));
    EXPECT_EQ(filesBelow(studio / "rgbd"),
              (std::set<std::string>{"a.mov_rgbd.mkv", "a.mp4_rgbd.mkv"}));
    const Outcome natives = studio.convert(kTool, "--from-quilt quilts natives");
    EXPECT_EQ(natives.status, 0) << natives.text();
    EXPECT_EQ(filesBelow(studio / "natives").size(), 2U);
}

TEST_F(Video2NativeFolder, WrongCallsSayWhatToDo) {
    const FolderStudio studio;
    fs::create_directory(studio / "empty");
    fs::copy(studio / "photo.png", studio / "empty/photo.png");
    EXPECT_TRUE(fails(studio.make("in out.mp4"), 2, "out.mp4: names one file, expected a dir"));
    EXPECT_TRUE(fails(studio.make("empty out"), 1,
                      "empty: holds no videos to convert, expected videos (left out: 1 photo)"));
    EXPECT_FALSE(fs::exists(studio / "out"));
    const Outcome json = studio.make("--progress json in out");
    EXPECT_TRUE(isDone(json));
    std::set<std::string> inputs;
    const std::vector<std::string> told = lines(json.out);
    for (std::size_t i = 0; i + 1 < told.size(); ++i)
        inputs.insert(Json::parse(told[i]).at("input").get<std::string>());
    EXPECT_EQ(inputs, (std::set<std::string>{"in/a.mov", "in/a.mp4"}));
    EXPECT_EQ(Json::parse(told.back()), Json::parse(R"({"state": "done", "videos": 2})"));
}

// --- calls -----------------------------------------------------------------------------------

TEST_F(Video2NativeTool, WrongCallsSayWhatToDo) {
    VideoStudio studio(0.2);
    const std::size_t before = filesIn(studio.work());
    EXPECT_TRUE(fails(studio.convert(kTool, "photo.png o.mp4"), 2, // others: Jobs
                      "photo.png: is a picture, expected a video; photo2native"));
    const std::pair<Arguments, const char*> failing[] = {
        {"missing.mp4 o.mp4", "does not exist"},
        {"small.json o.mp4", "small.json"},
        {"--codec ffv1 clip.mp4 o.mp4", "cannot hold ffv1 video"},
        {"--codec ffv1 clip.mp4 nowhere/o.mkv", "there is no directory"},
        {"--depth missing.mp4 clip.mp4 o.mp4", "missing.mp4: does not exist"}};
    for (const auto& [arguments, message] : failing)
        EXPECT_TRUE(fails(studio.convert(kTool, arguments), 1, message));
    for (const char* call : {"--resume clip.mp4 clip.mp4", "--depth depth.mp4 clip.mp4 clip.mp4",
                             "--depth depth.mp4 clip.mp4 depth.mp4"})
        EXPECT_TRUE(fails(studio.convert(kTool, call), 2, "is also an input"));
    EXPECT_EQ(filesIn(studio.work()), before);
    ffmpeg("-f lavfi -i testsrc2=size=2x2:rate=5:duration=0.4 -c:v ffv1 " +
           arg(studio / "tiny.mkv"));
    EXPECT_TRUE(fails(studio.run(kTool, "--stereo-out o_LRF.mkv tiny.mkv"), 1,
                      "tiny.mkv: makes a video of 4 x 2 px, expected at least 16 px a side"));
    studio.readInputFrom(studio / "tiny.mkv");
    EXPECT_TRUE(
        fails(studio.convert(kTool, "--resume - o.mp4"), 2, "--resume reads the input again"));
    const Outcome compat = studio.make("o.mp4", "--compat");
    EXPECT_TRUE(warns(compat, "4:2:0"));
    EXPECT_EQ(ffprobe(studio / "o.mp4", "stream=pix_fmt", "-select_streams v"), "yuv420p\n");
}

} // namespace
} // namespace altiro3D::test
