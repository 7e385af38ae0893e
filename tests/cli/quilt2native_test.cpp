#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/video_io.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/heif_files.hpp"
#include "support/random_pictures.hpp"
#include "support/video.hpp"

#include <memory>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTool = "quilt2native";

// PSNR of crf 16 for Natives as small and detailed as these, dB; 32 dB were measured.
constexpr double kMinPsnr = 30;

// 3 columns x 2 rows of 30 x 40 px, another picture for each number.
cv::Mat movingQuilt(int number) {
    return movingPicture({90, 80}, number);
}

// 4 columns x 5 rows of 140 x 100 px, whose layout can be found in it.
cv::Mat quiltOfAScene() {
    const cv::Mat photo = scenery({140, 100}, 3);
    cv::Mat quilt;
    Depth2Quilt({4, 5, {140, 100}, 20}).render({photo, randomDepth({140, 100})}, quilt);
    return quilt;
}

// A video of quilts without loss; its frames stay unequally long.
void writeQuiltVideo(const fs::path& file, int frames) {
    VideoWriterOptions options;
    options.size = {90, 80};
    options.codec = VideoCodec::Ffv1;
    options.timeBase = {1, 100};
    VideoWriter writer(file, options);
    for (int i = 0; i < frames; ++i)
        writer.write({movingQuilt(i), 10 * i + i % 2, 10});
    writer.finish();
}

} // namespace

class Quilt2NativeTool : public StudioTest {
  protected:
    Quilt2NativeTool() : StudioTest(kTool) {}
};

TEST_F(Quilt2NativeTool, AnAvifIsAPicture) {
    spill(studio_ / "q.avif", heifFile("avif", {av1Colours(1)}));
    const Outcome outcome = run("-c small.json -q 2x2 q.avif n.png");
    if (outcome.err.find("built without libheif") != std::string::npos) GTEST_SKIP() << outcome.err;
    EXPECT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_EQ(readBack(studio_ / "n.png").size(), cv::Size(96, 128));
}

TEST_F(Quilt2NativeTool, GivesTheNativeOfTheLibrary) {
    const cv::Mat quilt = readBack(studio_ / "quilt.png");
    const std::pair<Arguments, QuiltSampling> cases[] = {
        {{}, {ViewFilter::Nearest, TileSampling::Linear}},
        {"--sampling nearest", {}},
        {"--sampling nearest --view-filter linear", {ViewFilter::Linear, TileSampling::Nearest}},
        {"--sampling linear", {ViewFilter::Nearest, TileSampling::Linear}},
        {"--sampling linear --view-filter linear -j 1",
         {ViewFilter::Linear, TileSampling::Linear}}};
    for (const auto& [arguments, sampling] : cases) {
        EXPECT_TRUE(isDone(run(arguments + Arguments("-y -c small.json -q 2x3 quilt.png a.png"))));
        EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"),
                                libraryNative(studio_, quilt, 3, 2, sampling)));
    }
}

TEST_F(Quilt2NativeTool, ReadsStandardInputAndWritesStandardOutput) {
    ASSERT_TRUE(isDone(convert("quilt.png file.png")));
    studio_.readInputFrom(studio_ / "quilt.png");
    studio_.sendOutputTo(studio_ / "out.png");
    const Outcome outcome = convert("- -");
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.err, "standard output: Native")); // not in the picture
    EXPECT_EQ(slurp(studio_ / "out.png"), slurp(studio_ / "file.png"));
    EXPECT_EQ(convert(". -").status, 2); // a folder
}

TEST_F(Quilt2NativeTool, TheFileNameTellsTheLayout) {
    fs::copy(studio_ / "quilt.png", studio_ / "q_qs3x2a0.75.png");
    EXPECT_TRUE(says(run("-c small.json q_qs3x2a0.75.png a.png"),
                     "3 columns x 2 rows, each view 30 x 40 px"));
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"),
                            libraryNative(studio_, readBack(studio_ / "quilt.png"), 3, 2)));
    // 2x3 is rows x columns for -q, and 3x2 columns x rows in the name
    EXPECT_TRUE(isDone(run("-y -c small.json -q 2x3 q_qs3x2a0.75.png a.png")));
    EXPECT_TRUE(
        fails(run("-y -c small.json -q 3x2 q_qs3x2a0.75.png a.png"), 1, "2 columns x 3 rows"));
    fs::copy(studio_ / "quilt.png", studio_ / "q_qs0x2.png");
    EXPECT_TRUE(fails(run("-y -c small.json q_qs0x2.png a.png"), 1, "q_qs0x2"));
}

TEST_F(Quilt2NativeTool,
       WhatAMapLeavesOutIsTold) { // 44 x 50 px are more than 5 x 9 views of 8 x 5 px
    writeImage(studio_ / "rest.png", madePhoto(44, 50));
    ASSERT_TRUE(isDone(studio_.run("altiro3Dnative", "-m a.map -q 9x5 -r 5x8 small.json")));
    EXPECT_TRUE(warns(run("-m a.map --fit stretch rest.png m.png"), "44 x 50"));
}

TEST_F(Quilt2NativeTool, ALayoutThatNothingStatesIsFoundInThePicture) {
    const cv::Mat quilt = quiltOfAScene();
    const cv::Mat black(quilt.size(), CV_8UC3, cv::Scalar::all(0));
    writeImage(studio_ / "web.png", quilt);
    writeLossless(studio_ / "web.mkv", {black, quilt, quilt, quilt});
    for (const char* call : {"web.png a.png", "web.mkv a.mkv"})
        EXPECT_TRUE(says(run(Arguments("-c small.json --fit stretch") + Arguments(call)),
                         "each view 140 x 100 px, shown 3:4; found in the picture, 100 % sure"));
    ASSERT_TRUE(isDone(run("-c small.json --fit stretch -q 5x4 web.png b.png")));
    EXPECT_EQ(slurp(studio_ / "a.png"), slurp(studio_ / "b.png"));
    // options and names come first
    fs::copy(studio_ / "web.png", studio_ / "web_qs2x5.png");
    EXPECT_TRUE(holds(run("-y -c small.json web_qs2x5.png a.png").out, "2 columns x 5 rows"));
    const Outcome asked = run("-y -c small.json -q 5x2 web.png a.png");
    EXPECT_TRUE(holds(asked.out, "2 columns x 5 rows"));
    EXPECT_FALSE(holds(asked.out, "% sure"));
    // quilt2video needs no display then
    EXPECT_TRUE(says(studio_.run("quilt2video", "--seconds 0.2 --turns 1 web.png a.mp4"),
                     "4 columns x 5 rows"));
}

TEST_F(Quilt2NativeTool, APhotoIsRefusedAndAnUnclearPictureIsAskedAbout) {
    writeImage(studio_ / "photo2.png", scenery({400, 300}, 7));
    EXPECT_TRUE(fails(run("-c small.json photo2.png a.png"), 1,
                      "photo2.png: is a photo or another picture of one view, expected a quilt"));
    EXPECT_TRUE(isDone(run("-c small.json --fit stretch -q 2x3 photo2.png a.png")));
    fs::remove(studio_ / "a.png");
    EXPECT_TRUE(fails(run("-c small.json quilt.png a.png"), 2,
                      "quilt.png: its name does not state the layout, and the picture shows none "
                      "clearly, expected -q ROWSxCOLUMNS"));
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

TEST_F(Quilt2NativeTool, AFolderIsConvertedAndNothingInItIsLostSilently) {
    fs::create_directories(studio_ / "in/deeper");
    writeImage(studio_ / "in/web.png", quiltOfAScene());
    fs::copy(studio_ / "quilt.png", studio_ / "in/q_qs3x2a0.75.png");
    writeImage(studio_ / "in/photo.png", scenery({400, 300}, 7));
    spill(studio_ / "in/clip.mp4", "not a picture");
    writeQuiltVideo(studio_ / "in/film_qs3x2a0.75.mkv", 3);
    writeImage(studio_ / "in/n.png", madePhoto(96, 128), ImageMark::Native);
    const Outcome outcome = run("-c small.json --fit stretch in out");
    EXPECT_TRUE(warns(outcome, "in/n.png: is a Native, which is finished; it is left out"));
    for (const char* line :
         {"photo.png: is a photo or another picture of one view; photo2",
          "3 quilts made, 4 left out (1 video, 1 Native, 1 folder, 1 photo), in "})
        EXPECT_TRUE(holds(outcome.out, line));
    EXPECT_TRUE(isDone(run("-c small.json --fit stretch in/web.png alone.png")));
    EXPECT_EQ(slurp(studio_ / "out/web_native.png"), slurp(studio_ / "alone.png"));
    EXPECT_TRUE(fs::exists(studio_ / "out/q_qs3x2a0.75_native.png"));
    EXPECT_TRUE(isDone(run("-c small.json in/film_qs3x2a0.75.mkv film.mkv")));
    EXPECT_EQ(slurp(studio_ / "out/film_qs3x2a0.75_native.mkv"), slurp(studio_ / "film.mkv"));
    EXPECT_FALSE(fs::exists(studio_ / "out/photo_native.png"));
    EXPECT_TRUE(holds(run("-c small.json --fit stretch --skip-existing in out").out,
                      "0 quilts made, 3 skipped as the outputs exist, "));
}

TEST_F(Quilt2NativeTool, OptionsWithoutAnEffectAreRefusedForFoldersToo) {
    fs::create_directory(studio_ / "in");
    writeImage(studio_ / "in/web.png", quiltOfAScene());
    const Arguments calibration("-c small.json");
    for (const Arguments& option :
         {Arguments("--report r.json"), Arguments("--codec hevc"), Arguments("--crf 9"),
          Arguments("--preset fast"), Arguments{"--compat"}, Arguments{"--no-audio"},
          Arguments{"--no-subtitles"}, Arguments{"--resume"}, Arguments("--progress json")}) {
        for (const char* input : {"in", "in/web.png"}) {
            const std::string output = input == std::string("in") ? "out" : "a.png";
            EXPECT_TRUE(fails(run(calibration + option + Arguments{input, output}), 2,
                              option[0] + " applies to videos, expected a video as output"));
        }
    }
    EXPECT_TRUE(fails(run(calibration + Arguments("--seconds 3 in out")), 2, "--seconds"));
    for (const char* option : {"--skip-existing", "--recursive"}) {
        EXPECT_TRUE(
            fails(run(calibration + Arguments{option, "in/web.png", "a.png"}), 2,
                  option + std::string(" applies to folders, expected a directory of quilts")));
    }
    for (const char* input : {"in", "in/web.png"}) {
        EXPECT_TRUE(fails(run(calibration + Arguments{"-y", "--skip-existing", input, "a.png"}), 2,
                          "exclude each other"));
    }
    EXPECT_FALSE(fs::exists(studio_ / "out"));
}

TEST_F(Quilt2NativeTool, RowsFromTheTopAndStretchedViewsAreSaid) {
    const cv::Mat quilt = quiltOfAScene();
    writeImage(studio_ / "web.png", quilt); // views of 1.4 : 1 for a panel of 0.75 : 1
    cv::Mat turned(quilt.size(), quilt.type());
    for (int row = 0; row < 5; ++row)
        quilt.rowRange(100 * row, 100 * (row + 1))
            .copyTo(turned.rowRange(400 - 100 * row, 500 - 100 * row));
    writeImage(studio_ / "top.png", turned);
    const Arguments calibration("-c small.json");
    EXPECT_TRUE(warns(run(calibration + Arguments("web.png a.png")),
                      "the views have the shape 7:5 by their px and are stretched to the panel's, "
                      "3:4, as the file name does not state their shape"));
    EXPECT_TRUE(isDone(run(calibration + Arguments("--fit contain web.png b.png"))));
    EXPECT_NE(slurp(studio_ / "a.png"), slurp(studio_ / "b.png"));
    EXPECT_TRUE(
        fails(run(calibration + Arguments("top.png c.png")), 2,
              "top.png: its rows of views seem to run from the top to the bottom (4 columns "
              "x 5 rows), expected the first view at the bottom left"));
    EXPECT_TRUE(warns(run(calibration + Arguments("-q 5x4 top.png c.png")),
                      "are stretched to the panel's"));
}

TEST_F(Quilt2NativeTool, QuiltsInSubfoldersAndOfOneNameDoNotCollide) {
    fs::create_directories(studio_ / "in/deeper");
    const Arguments calibration("-c small.json --fit stretch");
    for (const char* name : {"in/a.png", "in/a.bmp", "in/a.bmp.tif", "in/deeper/a.png"})
        writeImage(studio_ / name, quiltOfAScene());
    EXPECT_TRUE(
        says(run(calibration + Arguments("--recursive in in/deeper/out")), "\n4 quilts made, in "));
    ASSERT_TRUE(isDone(run(calibration + Arguments("in/a.png alone.png"))));
    for (const char* name :
         {"a.png_native.png", "a.bmp_native.png", "a.bmp.tif_native.png", "deeper/a_native.png"})
        EXPECT_EQ(slurp(studio_ / "in/deeper/out" / name), slurp(studio_ / "alone.png")) << name;
    EXPECT_TRUE(
        fails(run(calibration + Arguments("in in/deeper/out")), 1, "exists, and so do 2 others"));
}

TEST_F(Quilt2NativeTool, ViewsOfAnotherShapeKeepItUnlessAsked) { // how: QuiltShape
    writeImage(studio_ / "q_qs3x2a1.5.png", cv::Mat(80, 90, CV_8UC3, cv::Scalar::all(200)));
    const auto make = [&](const Arguments& more) {
        return run(more + Arguments("-y -c small.json q_qs3x2a1.5.png a.png"));
    };
    EXPECT_TRUE(says(make({}), "each view 30 x 40 px, shown 3:2\nfit: by the file name"));
    const cv::Mat bars = readBack(studio_ / "a.png");
    const Outcome asked = make("--fit contain");
    EXPECT_TRUE(isDone(asked));
    EXPECT_FALSE(holds(asked.out, "fit: "));
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), bars));
}

TEST_F(Quilt2NativeTool, ASwayingVideoIsThatOfQuilt2video) {
    const Arguments fast("--seconds 0.2 --turns 1");
    const auto expect = [&](const std::string& quilt, const Arguments& ofNative,
                            const Arguments& ofVideo) {
        const Arguments display("-y -c small.json -q 2x3");
        EXPECT_TRUE(
            says(run(display + fast + ofNative + Arguments{"--lg", "a.mp4", quilt, "a.png"}),
                 "a.mp4: video, "));
        EXPECT_TRUE(isDone(
            studio_.run("quilt2video", display + fast + ofVideo + Arguments{quilt, "b.mp4"})));
        EXPECT_TRUE(slurp(studio_ / "a.mp4") == slurp(studio_ / "b.mp4")) << quilt;
    };
    expect("quilt.png", {}, {});
    EXPECT_TRUE(isDone(convert("quilt.png plain.png")));
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), readBack(studio_ / "plain.png")));
    const Arguments both("--view-filter linear --fit cover --size 64x32");
    expect("quilt.png", both, both);
    // the views have the shape that the Native shows
    writeImage(studio_ / "q_qs3x2a1.5.png", madePhoto(90, 80));
    expect("q_qs3x2a1.5.png", {}, {});
    expect("q_qs3x2a1.5.png", "--fit stretch", "--fit stretch --aspect 0.75");
}

TEST_F(Quilt2NativeTool, AVideoOfQuiltsBecomesAVideoOfNatives) {
    writeQuiltVideo(studio_ / "q_qs3x2a0.75.mkv", 5);
    for (const char* output : {"a.mkv", "a.mp4"}) {
        const Outcome outcome = run({"-c", "small.json", "q_qs3x2a0.75.mkv", output});
        EXPECT_TRUE(says(outcome, "3 columns x 2 rows, each view 30 x 40 px"));
        EXPECT_TRUE(holds(outcome.out, "Native video, 96 x 128 px, 5 frames"));
        VideoReader reader(studio_ / output);
        EXPECT_EQ(reader.facts().codec, "h264");
        EXPECT_EQ(reader.facts().pixelFormat, "yuv444p");
        const std::vector<VideoFrame> frames = allFrames(reader);
        ASSERT_EQ(frames.size(), 5U);
        for (int i = 0; i < 5; ++i) {
            const VideoFrame& frame = frames[static_cast<std::size_t>(i)];
            EXPECT_NEAR(static_cast<double>(frame.pts) * reader.facts().timeBase.value(),
                        0.1 * i + 0.01 * (i % 2), 1e-3);
            const auto psnrTo = [&](int number) {
                return cv::PSNR(frame.picture, libraryNative(studio_, movingQuilt(number), 3, 2));
            };
            EXPECT_GT(psnrTo(i), kMinPsnr) << output << " " << i;
            EXPECT_GT(psnrTo(i), psnrTo(i + 1) + 3) << output << " " << i;
        }
    }
}

TEST_F(Quilt2NativeTool, TheLayoutOfAVideoIsChosenAsThatOfAPicture) {
    writeQuiltVideo(studio_ / "q.mkv", 1);
    const auto native = [&](const Arguments& arguments) {
        EXPECT_TRUE(isDone(run(arguments + Arguments("-y q.mkv a.mkv"))));
        return allFrames(*std::make_unique<VideoReader>(studio_ / "a.mkv")).at(0).picture;
    };
    const cv::Mat expected = libraryNative(studio_, movingQuilt(0), 3, 2);
    EXPECT_GT(cv::PSNR(native(studio_.display()), expected), kMinPsnr);
    EXPECT_GT(cv::PSNR(native("-c small.json -q 2x3"), expected), kMinPsnr);
    studio_.makeMap();
    EXPECT_GT(cv::PSNR(native("-m a.map"), expected), kMinPsnr);
    const cv::Mat blended =
        libraryNative(studio_, movingQuilt(0), 3, 2, {ViewFilter::Linear, TileSampling::Nearest});
    EXPECT_GT(cv::PSNR(native(studio_.display() + Arguments("--view-filter linear")), blended),
              kMinPsnr);
}

TEST_F(Quilt2NativeTool, WhatCannotBeMadeIsNamedAndLeavesNothing) {
    writeQuiltVideo(studio_ / "q.mkv", 2);
    for (const auto& [from, to] :
         {std::pair("q.mkv", "nameless"), {"quilt.png", "picture"}, {"quilt.png", "q_qs2x3.png"}})
        fs::copy(studio_ / from, studio_ / to);
    for (const char* name : {"precious.mkv", "precious.mp4"})
        spill(studio_ / name, "precious");
    const std::tuple<const char*, int, const char*> cases[] = {
        {"q.mkv a.png", 2, "a.png: is not the name of a video, but q.mkv is a video"},
        {"nameless a.png", 2, "a.png: is not the name of a video"},
        {"q.mkv a.gif", 2, "expected .mp4, .mov or .mkv"},
        {"quilt.png a.mkv", 2, "quilt.png: is a picture, expected a video"},
        {"picture a.mkv", 2, "picture: is a picture, expected a video"},
        {"none.mkv a.mkv", 1, "none.mkv: does not exist"},
        {"small.json a.mkv", 1, "small.json: "},
        {"q.mkv missing/a.mkv", 1, "there is no directory"},
        {"q.mkv precious.mkv", 1, "precious.mkv: exists"},
        {"-y q.mkv ./q.mkv", 2, "is also an input"},
        {"-r 41x30 q.mkv a.mkv", 1, "30 x 40"},
        {"-r 10x10 quilt.png a.png", 1, "-r: says views of 10 x 10"},
        {"-q 100x100 quilt.png a.png", 1, "do not fit"},
        {"-q 2x3 q_qs2x3.png a.png", 1, "-q: says 3 columns x 2 rows"},
        {"--lg= quilt.png a.png", 2, "--lg is empty"},
        {"--lg s.mp4 --fps 0 quilt.png a.png", 2, "--fps"},
        {"--fps 20 quilt.png a.png", 2, "--lg"},
        {"--lg s.gif quilt.png a.png", 2, "s.gif"},
        {"--lg precious.mp4 quilt.png a.png", 1, "precious.mp4"},
        {"--lg no/s.mp4 quilt.png a.png", 1, "no/s.mp4"},
        {"--lg s.mp4 quilt.png no/a.png", 1, "no/a.png"},
        {"--lg s.mp4 quilt.png a.mp4", 2, "a.mp4"},
        {"--lg a.png quilt.png a.png", 2, "a.png"}};
    for (const auto& [call, status, part] : cases) {
        const bool isLayout = std::string(call).rfind("-q", 0) == 0;
        EXPECT_TRUE(
            fails(isLayout ? run(Arguments("-c small.json") + call) : convert(call), status, part));
        for (const char* output : {"a.png", "a.mp4", "a.mkv", "s.mp4", "s.gif"})
            EXPECT_FALSE(fs::exists(studio_ / output)) << call;
    }
    EXPECT_TRUE(fails(studio_.run("quilt2video", "-q 2x3 q_qs2x3.png a.mp4"), 1,
                      "-q: says 3 columns x 2 rows"));
    for (const char* name : {"precious.mkv", "precious.mp4"})
        EXPECT_EQ(slurp(studio_ / name), "precious");
    EXPECT_TRUE(isDone(convert("nameless a.mkv")));
    EXPECT_TRUE(isDone(convert("picture a.png")));
    studio_.limitFiles(1024);
    fs::create_directory(studio_ / "out");
    EXPECT_TRUE(fails(convert("q.mkv out/a.mkv"), 1, "cannot be written: File too large"));
    EXPECT_TRUE(fs::is_empty(studio_ / "out"));
}

TEST_F(Quilt2NativeTool, TheSoundOfAVideoIsCopied) {
    ALTIRO3D_REQUIRE_DATA("videos/derived/chess_lightfield_qs3x3a1.7667.mp4");
    ALTIRO3D_REQUIRE_FFMPEG();
    const fs::path chess = dataPath("videos/derived/chess_lightfield_qs3x3a1.7667.mp4");
    SmallStudio studio;
    EXPECT_TRUE(isDone(
        studio.run(kTool, {"-c", "small.json", "--fit", "stretch", chess.string(), "a.mp4"})));
    EXPECT_EQ(lines(ffprobe(studio / "a.mp4",
                            "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames",
                            "-count_frames -select_streams v")),
              lines("h264|96|128|yuv444p|12/1|32"));
    const auto packets = [](const fs::path& file) {
        return ffprobe(file, "packet=pts,duration,size,data_hash",
                       "-select_streams a -show_data_hash md5");
    };
    EXPECT_EQ(packets(studio / "a.mp4"), packets(chess));
    const cv::Mat quilt = ffmpegFrames(chess, {2544, 1440}, "", 1).at(0);
    VideoReader reader(studio / "a.mp4");
    EXPECT_GT(cv::PSNR(reader.next()->picture, libraryNative(studio, quilt, 3, 3)), kMinPsnr);
}

TEST_F(Quilt2NativeTool, EyesAreTwoOfTheViews) {
    SmallStudio studio;
    cv::Mat quilt(80, 90, CV_8UC3);
    const QuiltLayout layout{3, 2, {30, 40}, 6};
    for (int i = 0; i < 6; ++i)
        randomPhoto({30, 40}, i).copyTo(quilt(layout.tile(i)));
    writeImage(studio / "q_qs3x2a0.75.png", quilt);
    const Outcome outcome =
        studio.run(kTool, "-c small.json --save-stereo e_LRF.png q_qs3x2a0.75.png n.png");
    ASSERT_TRUE(isDone(outcome));
    EXPECT_TRUE(holds(outcome.out, "eyes: views 2 and 3")); // an eighth of 5 to each side
    const cv::Mat eyes = readImage(studio / "e_LRF.png");
    EXPECT_TRUE(samePicture(eyes.colRange(0, 30), quilt(layout.tile(2))));
    EXPECT_TRUE(samePicture(eyes.colRange(30, 60), quilt(layout.tile(3))));
    writeImage(studio / "q3_qs3x1a0.75.png", quilt.rowRange(40, 80)); // an odd number of views
    const Outcome three =
        studio.run(kTool, "-y -c small.json --save-stereo e_LRF.png q3_qs3x1a0.75.png n.png");
    EXPECT_TRUE(holds(three.out, "eyes: views 0 and 2"));
    EXPECT_TRUE(fails(studio.run(kTool, "-c small.json --save-stereo e.png q_qs3x2a0.75.png n.mp4"),
                      2, "--save-stereo is made of one quilt"));
    EXPECT_TRUE(fails(studio.run(kTool, "-c small.json --stereo-swap q_qs3x2a0.75.png m.png"), 2,
                      "describes --save-stereo"));
}

} // namespace altiro3D::test
