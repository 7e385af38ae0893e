#include "altiro3D/video_conversion.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/video_io.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/slow.hpp"
#include "support/video.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <future>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 30;
constexpr int kSegmentFrames = 12; // of a clip of 2 frames a second

Display smallDisplay() {
    return sixViewDisplay(150, 98, {50, 32});
}

std::vector<cv::Mat> movingPictures(cv::Size size, int count, int first = 0) {
    std::vector<cv::Mat> pictures;
    for (int i = 0; i < count; ++i)
        pictures.push_back(movingPicture(size, first + i));
    return pictures;
}

// clip.mkv and depth.mkv that goes with it.
class VideoConverterTest : public FileTest {
  protected:
    void SetUp() override {
        writeClip(directory / "clip.mkv", movingPictures({64, 48}, kFrames));
        writeClip(directory / "depth.mkv", movingPictures({32, 24}, kFrames, 100));
    }

    VideoConversion conversion(const std::string& output) const {
        VideoConversion all;
        all.input = directory / "clip.mkv";
        if (!output.empty()) all.output = directory / output;
        all.display = smallDisplay();
        all.given = GivenVideoDepth();
        all.given->source = directory / "depth.mkv";
        all.encoding.codec = VideoCodec::Ffv1;
        return all;
    }

    // The run with changes of the conversion.
    VideoConversionResult run(const std::string& output,
                              const std::function<void(VideoConversion&)>& change = {}) const {
        VideoConversion all = conversion(output);
        if (change) change(all);
        return VideoConverter(std::move(all)).run();
    }

    // The Native of a frame.
    static cv::Mat nativeOf(const NativeMaker& maker, const altiro3D::Scene& scene) {
        cv::Mat native;
        maker.makeNative(scene, native);
        return native;
    }

    std::vector<cv::Mat> pictures(const std::string& name) const {
        std::vector<cv::Mat> all;
        for (const VideoFrame& frame : allFrames(directory / name))
            all.push_back(frame.picture);
        return all;
    }

    // The frames and their depth, one by one.
    std::vector<altiro3D::Scene> scenes() const {
        std::vector<altiro3D::Scene> all;
        for (const cv::Mat& photo : pictures("clip.mkv"))
            all.push_back({photo, {}});
        std::size_t i = 0;
        for (const cv::Mat& picture : pictures("depth.mkv")) {
            cv::Mat grey;
            cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
            grey.convertTo(all.at(i++).depth, CV_32F, 1 / 255.0);
        }
        return all;
    }

    // In a video the flaws of the depth are those of the first frame.
    NativeOptions withFlaws(NativeOptions options) const {
        const altiro3D::Scene first = scenes().front();
        const cv::Size size = NativeMaker(smallDisplay(), options).workSize();
        NativeOptions asItIs = options;
        asItIs.refine.flaws = DepthFlaws();
        const Placement placed = placeScene(first, smallDisplay().aspect(), size, asItIs);
        const cv::Rect part = placed.fit.filled();
        options.refine.flaws =
            measureDepthFlaws(placed.scene.photo(part), placed.scene.depth(part));
        return options;
    }
};

TEST_F(VideoConverterTest, FramesAreTheNativesOfThePhotosAndTheirDepth) {
    NativeOptions options[3];
    options[0].views.strengthPercent = 40;
    options[1].detail = Detail::Panel;
    options[1].positions = ViewPositions::Continuous;
    options[2].views.method = ViewMethod::Real;
    options[2].fit = FitMode::Contain;
    int number = 0;
    for (const NativeOptions& option : options) {
        const std::string name = "native" + std::to_string(number++) + ".mkv";
        VideoConversion made = conversion(name);
        made.recipe = {option, {}};
        VideoConverter converter(std::move(made));
        EXPECT_EQ(converter.size(), cv::Size(150, 98));
        EXPECT_EQ(converter.facts().size, cv::Size(64, 48));
        std::vector<VideoProgress> seen;
        const VideoConversionResult result = converter.run([&](const VideoProgress& progress) {
            seen.push_back(progress);
            return true;
        });
        EXPECT_EQ(result.frames, kFrames);
        EXPECT_EQ(result.made(), kFrames);
        EXPECT_EQ(result.inferences, 0);
        EXPECT_NEAR(result.end, kFrames / 2.0, 1e-9);
        EXPECT_FALSE(result.cancelled);
        EXPECT_FALSE(result.keepsWork);
        EXPECT_EQ(result.pipeline.stages.size(), 4U);
        ASSERT_FALSE(seen.empty());
        EXPECT_EQ(seen.front().frames, 0);
        EXPECT_TRUE(seen.back().finishing);
        EXPECT_EQ(seen.back().frames, kFrames);
        const NativeMaker maker(smallDisplay(), withFlaws(option));
        const std::vector<cv::Mat> natives = pictures(name);
        const std::vector<altiro3D::Scene> expected = scenes();
        ASSERT_EQ(natives.size(), expected.size());
        for (std::size_t i = 0; i < natives.size(); ++i)
            ASSERT_TRUE(samePicture(natives[i], nativeOf(maker, expected[i]))) << name << " " << i;
    }
}

TEST_F(VideoConverterTest, TheFramesOfAPartAreEstimatedFromItsLength) {
    VideoConversion made = conversion("part.mkv");
    made.part.from = 3;
    made.part.to = 7;
    VideoConverter converter(std::move(made));
    EXPECT_EQ(converter.progress().framesInAll, 8); // 4 s at 2 per second
    EXPECT_EQ(converter.run().frames, 8);
}

TEST_F(VideoConverterTest, ChoicesAreThoseOfTheFirstFrameAndSurviveAnInterruption) {
    const auto of = [&](const char* name, UnfinishedRun unfinished) {
        VideoConversion made = conversion(name);
        made.recipe.choices = {true, true, true};
        made.unfinished = unfinished;
        return made;
    };
    const VideoConversionResult result =
        VideoConverter(of("whole.mkv", UnfinishedRun::Refuse)).run();
    ASSERT_EQ(result.choices.size(), 1U);
    const altiro3D::Scene first = scenes().front();
    const Display display = smallDisplay();
    NativeOptions options;
    PlacementOptions& placement = options;
    placement = chooseFromScene(first, display.aspect(), display.quilt, options,
                                {true, true, true, false, true})
                    .options;
    EXPECT_LE(options.views.strengthPercent, // for any depth of a later frame
              kMaxAutoParallax / std::max(options.views.focus, 1 - options.views.focus) + 1e-9);
    EXPECT_EQ(result.choices.front().framing, options.framing);
    EXPECT_EQ(result.choices.front().focus, options.views.focus);
    EXPECT_EQ(result.choices.front().strengthPercent, options.views.strengthPercent);
    EXPECT_NE(options.views.focus, 0.5);
    const NativeMaker maker(display, withFlaws(options));
    const std::vector<cv::Mat> natives = pictures("whole.mkv");
    const std::vector<altiro3D::Scene> expected = scenes();
    for (const std::size_t i : {std::size_t{0}, natives.size() - 1})
        EXPECT_TRUE(samePicture(natives[i], nativeOf(maker, expected[i]))) << i;
    VideoConverter(of("out.mkv", UnfinishedRun::Refuse)).run([](const VideoProgress& progress) {
        return progress.frames < kSegmentFrames + 2;
    });
    const VideoConversionResult rest = VideoConverter(of("out.mkv", UnfinishedRun::Resume)).run();
    EXPECT_GT(rest.keptFrames, 0);
    const std::vector<cv::Mat> resumed = pictures("out.mkv");
    ASSERT_EQ(resumed.size(), natives.size());
    for (std::size_t i = 0; i < natives.size(); ++i)
        EXPECT_TRUE(samePicture(resumed[i], natives[i])) << i;
}

TEST_F(VideoConverterTest, AMapGivesTheNativesOverTheQuilt) {
    const Display display = smallDisplay();
    run("native.mkv", [&](VideoConversion& made) {
        made.map = NativeLut(display.calibration, display.quilt);
        made.display.reset();
    });
    EXPECT_TRUE(samePicture(pictures("native.mkv").front(),
                            nativeOf(NativeMaker(display), scenes().front())));
}

TEST_F(VideoConverterTest, QuiltsAndRgbdAreOtherProducts) {
    const Display display = smallDisplay();
    const std::vector<altiro3D::Scene> expected = scenes();
    const auto quilts = run("quilt.mkv", [](auto& all) { all.product = VideoProduct::Quilt; });
    EXPECT_EQ(quilts.frames, kFrames);
    const std::vector<cv::Mat> made = pictures("quilt.mkv");
    const NativeMaker maker(display);
    const NativeOptions known = withFlaws({});
    for (const std::size_t i : {std::size_t{0}, made.size() - 1}) {
        cv::Mat quilt;
        maker.makeQuilt(placeScene(expected[i], display.aspect(), maker.quiltSize(), known).scene,
                        quilt);
        EXPECT_TRUE(samePicture(made[i], quilt));
    }
    const auto rgbd = run("rgbd.mkv", [](auto& all) {
        all.product = VideoProduct::Rgbd;
        all.display.reset();
    });
    EXPECT_EQ(rgbd.frames, kFrames);
    const cv::Mat both = pictures("rgbd.mkv").back();
    ASSERT_EQ(both.size(), cv::Size(128, 48));
    EXPECT_TRUE(samePicture(both.colRange(0, 64), expected.back().photo));

    // and both are read again: photo and depth are halves, views are tiles
    NativeOptions exact;
    exact.refine.flaws = DepthFlaws();
    run("again.mkv", [&](VideoConversion& all) {
        all.input = directory / "rgbd.mkv";
        all.given = GivenVideoDepth();
        all.given->rgbd = DepthSide::Right;
        all.recipe = {exact, {}};
    });
    altiro3D::Scene scene;
    splitRgbd(both, DepthSide::Right, scene.photo, scene.depth);
    scene.depth.convertTo(scene.depth, CV_32F, 1 / 255.0);
    EXPECT_TRUE(
        samePicture(pictures("again.mkv").back(), nativeOf(NativeMaker(display, exact), scene)));
    run("fromQuilt.mkv", [&](VideoConversion& all) {
        all.input = directory / "quilt.mkv";
        all.fromQuilt = true;
        all.given.reset();
    });
    cv::Mat native;
    Quilt2Native(NativeLut(display.calibration, display.quilt)).render(made.back(), native);
    EXPECT_TRUE(samePicture(pictures("fromQuilt.mkv").back(), native));
}

TEST_F(VideoConverterTest, StereoHasBothEyesOfWholeFramesAndIsMarked) {
    ALTIRO3D_TAKES(0.6);
    const std::vector<altiro3D::Scene> expected = scenes();
    PlacementOptions options;
    options.views.strengthPercent = kEyesStrength;
    options.fit = FitMode::Stretch;
    options.refine.flaws = placeScene(expected.front(), 64.0 / 48, {64, 48}, options).flaws;
    const auto made = [&](const VideoEyes& eyes, const std::string& name) {
        const auto result = run(name, [&](VideoConversion& stereo) {
            stereo.product = VideoProduct::Stereo;
            stereo.eyes = eyes;
            stereo.display.reset();
            stereo.recipe.views.strengthPercent = kEyesStrength;
        });
        EXPECT_EQ(result.frames, kFrames);
        return pictures(name).back();
    };
    const altiro3D::Scene scene = placeScene(expected.back(), 64.0 / 48, {64, 48}, options).scene;
    for (const EyesFrom from : {EyesFrom::Both, EyesFrom::KeepLeft}) {
        const StereoPair pair = renderEyes(scene, options.views, from);
        EXPECT_FALSE(samePicture(pair.left, pair.right));
        cv::Mat joined;
        joinEyes(pair.left, pair.right, EyesPicture::SideBySide, joined);
        EXPECT_TRUE(samePicture(made({EyesPicture::SideBySide, from}, "sbs.mkv"), joined));
        joinEyes(pair.right, pair.left, EyesPicture::Anaglyph, joined);
        EXPECT_TRUE(samePicture(made({EyesPicture::Anaglyph, from, true}, "red.mkv"), joined));
    }
    EXPECT_EQ(made({EyesPicture::TopBottomHalf}, "tb.mkv").size(), cv::Size(64, 48));
    if (!haveFfmpeg()) GTEST_SKIP() << "needs ffprobe";
    const auto mark = [&](const char* name) {
        return ffprobe(directory / name, "stream_side_data=type", "-select_streams v:0");
    };
    EXPECT_TRUE(holds(mark("sbs.mkv"), "side by side"));
    EXPECT_TRUE(holds(mark("tb.mkv"), "top and bottom"));
    EXPECT_EQ(mark("red.mkv"), "\n");
}

TEST_F(VideoConverterTest, DepthOfAnotherShapeIsRefusedOrSaid) {
    const auto made = [&](cv::Size depth) {
        writeClip(directory / "depth.mkv", {cv::Mat(depth, CV_8UC3, cv::Scalar::all(90))});
        return textOf(run("out.mkv", [](auto& all) { all.product = VideoProduct::Rgbd; }).notes);
    };
    EXPECT_FALSE(holds(made({32, 24}), "shape"));
    EXPECT_TRUE(holds(made({48, 24}), "depth.mkv: its shape differs from the video's (48 x 24 and "
                                      "64 x 48); it is stretched to fit"));
    EXPECT_TRUE(holds(made({32, 32}), "stretched"));
    EXPECT_EQ(codeOf([&] { made({24, 32}); }), ErrorCode::Mismatch);
    fs::remove(directory / "depth.mkv");
    fs::create_directory(directory / "depth.mkv");
    writeImage(directory / "depth.mkv" / "1.png", cv::Mat(32, 24, CV_8UC1, cv::Scalar(90)));
    EXPECT_EQ(codeOf([&] { run("out.mkv"); }), ErrorCode::Mismatch);
}

TEST_F(VideoConverterTest, TheRotationOfAVideoHoldsForItsDepth) {
    // a bright corner, at the top left as stored
    cv::Mat corner(24, 32, CV_8UC3, cv::Scalar::all(50));
    corner(cv::Rect(0, 0, 16, 12)).setTo(cv::Scalar::all(200));
    const std::vector<cv::Mat> pictures(2, corner);
    writeClip(directory / "stored.mkv", pictures);
    VideoWriterOptions options;
    options.size = corner.size();
    VideoWriter writer(directory / "clip.mp4", options);
    writer.write({corner, 0, 500});
    writer.write({corner, 500, 500});
    writer.finish();
    const std::string bytes = slurp(directory / "clip.mp4");
    const cv::Point corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}; // by quarter turns
    for (const int degrees : {0, 90, 180, 270}) {
        const std::string turned = turnedClockwise(bytes, degrees);
        spill(directory / "turned.mp4", turned);
        // depth without a rotation, depth that states its own, and upright depth of its own shape
        std::vector<std::string> depths = {"stored.mkv", "turned.mp4"};
        if (degrees % 180 != 0) {
            cv::Mat upright;
            cv::rotate(corner, upright,
                       degrees == 90 ? cv::ROTATE_90_CLOCKWISE : cv::ROTATE_90_COUNTERCLOCKWISE);
            writeClip(directory / "upright.mkv", {upright, upright});
            depths.emplace_back("upright.mkv");
        }
        for (const std::string& depth : depths) {
            const auto result = run("rgbd.mkv", [&](VideoConversion& made) {
                made.input = directory / "turned.mp4";
                made.given->source = directory / depth;
                made.product = VideoProduct::Rgbd;
            });
            EXPECT_EQ(bool(holds(textOf(result.notes), "is turned as the video is")),
                      depth == "stored.mkv" && degrees != 0);
            const cv::Mat both = this->pictures("rgbd.mkv").front();
            const cv::Mat right = both.colRange(both.cols / 2, both.cols);
            for (const cv::Point& at : corners) {
                const cv::Point px((2 * at.x + 1) * right.cols / 4,
                                   (2 * at.y + 1) * right.rows / 4);
                EXPECT_NEAR(right.at<cv::Vec3b>(px)[0], at == corners[degrees / 90] ? 200 : 50, 8)
                    << depth << " " << degrees << " " << at;
            }
        }
    }
}

// A white disc, round if px have the shape `aspect`.
cv::Mat discPicture(cv::Size size, double aspect) {
    cv::Mat picture(size, CV_8UC3, cv::Scalar(40, 60, 160));
    const double radius = std::min(size.width * aspect, 1.0 * size.height) / 3;
    cv::ellipse(picture, cv::Point(size.width / 2, size.height / 2),
                cv::Size(static_cast<int>(std::lround(radius / aspect)),
                         static_cast<int>(std::lround(radius))),
                0, 0, 360, cv::Scalar::all(255), cv::FILLED);
    return picture;
}

// Streams as of a broadcast or a phone that is turned: the shape changes after the first half.
TEST_F(VideoConverterTest, FramesKeepTheirOwnShape) {
    ALTIRO3D_REQUIRE_FFMPEG();
    const struct {
        cv::Size size;
        double aspect;
    } shapes[] = {{{320, 240}, 1}, {{180, 320}, 1}, {{320, 240}, 1.5}};
    std::string parts[3];
    for (int i = 0; i < 3; ++i) {
        const fs::path file = directory / "part.h264";
        writeImage(directory / "disc.png", discPicture(shapes[i].size, shapes[i].aspect));
        ffmpeg("-framerate 5 -loop 1 -i " + arg(directory / "disc.png") +
               " -frames:v 4 -vf setsar=" + std::to_string(shapes[i].aspect) +
               " -c:v libx264 -pix_fmt yuv420p -crf 8 " + arg(file));
        parts[i] = slurp(file);
    }
    const auto roundness = [](const cv::Mat& picture) {
        cv::Mat grey;
        cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
        const cv::Rect disc = cv::boundingRect(grey > 172);
        return static_cast<double>(disc.width) / disc.height;
    };
    for (int later : {1, 2}) {
        spill(directory / "clip.h264", parts[0] + parts[later]);
        VideoReader reader(directory / "clip.h264");
        const std::vector<VideoFrame> frames = allFrames(reader);
        ASSERT_EQ(frames.size(), 8U);
        EXPECT_EQ(frames.back().picture.size(), shapes[later].size);
        EXPECT_NEAR(frames.back().sampleAspect.value(), shapes[later].aspect, 1e-3);
        EXPECT_TRUE(holds(textOf(reader.notes()), "its frames changes"));
        // colours that are not stated do not change with the number of lines
        EXPECT_LE(cv::norm(frames.back().picture.at<cv::Vec3b>(2, 2),
                           frames.front().picture.at<cv::Vec3b>(2, 2), cv::NORM_INF),
                  3);

        run("rgbd.mkv", [&](VideoConversion& rgbd) {
            rgbd.input = directory / "clip.h264";
            rgbd.product = VideoProduct::Rgbd;
        });
        run("native.mkv", [&](VideoConversion& all) {
            all.input = directory / "clip.h264";
            all.display = displayOf(stripePanel(300, 400), "large.json");
            all.recipe.views.strengthPercent = 0;
            all.recipe.fit = FitMode::Contain;
            all.recipe.detail = Detail::Panel;
        });
        for (const char* const name : {"rgbd.mkv", "native.mkv"}) {
            const std::vector<cv::Mat> made = pictures(name);
            const int columns = made.front().cols / (name[0] == 'r' ? 2 : 1);
            ASSERT_EQ(made.size(), 8U);
            EXPECT_NEAR(roundness(made.front().colRange(0, columns)), 1, 0.02) << name;
            EXPECT_NEAR(roundness(made.back().colRange(0, columns)), 1, 0.02) << name << later;
        }
    }
}

TEST_F(VideoConverterTest, DepthDrawnInColoursIsUndone) {
    std::vector<cv::Mat> levels;
    std::vector<cv::Mat> colours;
    std::vector<cv::Mat> rgbd;
    const std::vector<cv::Mat> photos = pictures("clip.mkv");
    for (int i = 0; i < 3; ++i) {
        cv::Mat level(48, 64, CV_8UC1);
        for (int x = 0; x < level.cols; ++x)
            level.col(x).setTo(20 + 3 * x + 10 * i);
        cv::Mat colour;
        cv::applyColorMap(level, colour, cv::COLORMAP_TURBO);
        cv::Mat both;
        cv::hconcat(photos[static_cast<std::size_t>(i)], colour, both);
        levels.push_back(level);
        colours.push_back(colour);
        rgbd.push_back(both);
    }
    writeClip(directory / "clip.mkv", movingPictures({64, 48}, 3));
    writeClip(directory / "depth.mkv", colours);
    writeClip(directory / "rgbd.mkv", rgbd);
    for (const bool isRgbd : {false, true}) {
        const VideoConversionResult result = run("made.mkv", [&](VideoConversion& made) {
            made.product = VideoProduct::Rgbd;
            made.display.reset();
            made.recipe.refine.flaws = DepthFlaws();
            if (!isRgbd) return;
            made.input = directory / "rgbd.mkv";
            made.given = GivenVideoDepth();
            made.given->rgbd = DepthSide::Right;
        });
        EXPECT_TRUE(holds(only(result.notes).text, "colour map turbo"));
        const std::vector<cv::Mat> found = pictures("made.mkv");
        ASSERT_EQ(found.size(), levels.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
            cv::Mat depth;
            cv::extractChannel(found[i].colRange(64, 128), depth, 1);
            EXPECT_TRUE(samePicture(depth, levels[i], 3)) << isRgbd; // FFV1 stores YUV
        }
    }
}

TEST_F(VideoConverterTest, GivenDepthIsReadForPicturesInAnyOrder) {
    std::vector<cv::Mat> greys;
    for (int i = 0; i < 40; ++i)
        greys.emplace_back(32, 48, CV_8UC3, cv::Scalar::all(6 * i));
    GivenVideoDepth given;
    given.source = directory / "depth.mkv";
    writeClip(given.source, greys, 4);
    VideoFacts video;
    video.size = {48, 32};
    video.timeBase = {1, 1000};
    GivenDepthReader reader(given, video);
    for (const auto& [number, isCut] : std::initializer_list<std::pair<int, bool>>{
             {0, true}, {1, false}, {4, false}, {20, true}, {21, false}, {7, true}, {60, true}}) {
        cv::Mat depth;
        const VideoDepthStep step = reader.next(movingPicture(video.size, 3), number / 4.0, depth);
        EXPECT_NEAR(depth.at<float>(5, 5), 6 * std::min(number, 39) / 255.0, 1e-6) << number;
        EXPECT_EQ(step.cut, isCut) << number;
    }
    cv::Mat depth;
    EXPECT_EQ(codeOf([&] { (void)reader.next(cv::Mat(video.size, CV_8UC1), 1, depth); }),
              ErrorCode::InvalidArgument);
    given.source = directory.path();
    EXPECT_TRUE(holds(errorOf([&] { GivenDepthReader(given, video); }), "is not a file"));
}

TEST_F(VideoConverterTest, RgbdFramesWithAGapAreRefused) {
    const cv::Mat half(48, 40, CV_8UC3, cv::Scalar::all(90));
    cv::Mat frame;
    cv::hconcat(std::vector<cv::Mat>{half, cv::Mat(48, 20, CV_8UC3, cv::Scalar::all(255)), half},
                frame);
    writeClip(directory / "clip.mkv", {frame});
    const auto make = [&] {
        run("made.mkv",
            [](auto& all) { (all.given = GivenVideoDepth())->rgbd = DepthSide::Right; });
    };
    EXPECT_EQ(codeOf(make), ErrorCode::Unsupported);
}

TEST_F(VideoConverterTest, DepthIsEstimatedIfNoneIsGiven) {
    writeClip(directory / "clip.mkv", movingPictures({64, 48}, 5));
    const VideoConversionResult result = run("native.mkv", [](VideoConversion& made) {
        made.given.reset();
        made.depthOptions.every = 1;
    });
    EXPECT_EQ(result.frames, 5);
    EXPECT_EQ(result.inferences, 5);
    // a scene's first depth is that of its first picture alone
    altiro3D::Scene scene{pictures("clip.mkv").front(), {}};
    cv::Mat photo;
    cv::Mat raw;
    estimatedDepth()->readFrame(scene.photo, photo, raw);
    normalizeDepth(raw, scene.depth);
    scene.edges = DepthEdges::Aligned;
    EXPECT_TRUE(
        samePicture(pictures("native.mkv").front(), nativeOf(NativeMaker(smallDisplay()), scene)));
}

TEST_F(VideoConverterTest, KnownFlawsOfEstimatedDepthAreCorrected) {
    ALTIRO3D_TAKES(0.6);
    writeClip(directory / "clip.mkv", movingPictures({480, 640}, 1));
    const auto first = [this](ViewMethod method, const DepthRefineOptions& refine) {
        run("native.mkv", [&](VideoConversion& made) {
            made.given.reset();
            made.recipe.views.method = method;
            made.recipe.refine = refine;
        });
        return pictures("native.mkv").front();
    };
    const DepthRefineOptions asItIs{DepthFlaws()};
    EXPECT_TRUE(samePicture(first(ViewMethod::Fast, {}), first(ViewMethod::Fast, asItIs)));
    DepthFlaws large; // what the caller knows of the depth is corrected for every method
    large.growthPixels = 3;
    for (const ViewMethod method : {ViewMethod::Fast, ViewMethod::Layered})
        EXPECT_FALSE(samePicture(first(method, {large}), first(method, asItIs)));
}

TEST_F(VideoConverterTest, ACancelledRunEndsTheFileAndCanContinueToTheSameBytes) {
    for (const DepthKind kind : {DepthKind::NearWhite, DepthKind::Metric}) {
        fs::remove(directory / "out.mkv");
        fs::remove(directory / "whole.mkv");
        const auto of = [&](const char* name, UnfinishedRun unfinished) {
            VideoConversion made = conversion(name);
            made.given->kind = kind;
            made.unfinished = unfinished;
            return made;
        };
        VideoConverter(of("whole.mkv", UnfinishedRun::Refuse)).run();
        const auto result =
            VideoConverter(of("out.mkv", UnfinishedRun::Resume)).run([](const VideoProgress& now) {
                return now.frames < kSegmentFrames + 2;
            });
        EXPECT_TRUE(result.cancelled);
        EXPECT_TRUE(result.keepsWork);
        EXPECT_GE(result.frames, kSegmentFrames + 2);
        EXPECT_LT(result.frames, kFrames);
        EXPECT_EQ(pictures("out.mkv").size(), static_cast<std::size_t>(result.frames));

        EXPECT_EQ(codeOf([&] { VideoConverter again(of("out.mkv", UnfinishedRun::Refuse)); }),
                  ErrorCode::WriteFailed);
        VideoConversion other = of("out.mkv", UnfinishedRun::Resume);
        other.recipe.views.focus = 0.4;
        EXPECT_EQ(codeOf([&] { VideoConverter again(std::move(other)); }), ErrorCode::Mismatch);

        VideoConverter resumed(of("out.mkv", UnfinishedRun::Resume));
        EXPECT_GE(resumed.progress().keptFrames, kSegmentFrames);
        EXPECT_EQ(resumed.progress().frames, resumed.progress().keptFrames);
        const VideoConversionResult rest = resumed.run();
        EXPECT_EQ(rest.frames, kFrames);
        EXPECT_LT(rest.made(), kFrames);
        EXPECT_TRUE(slurp(directory / "out.mkv") == slurp(directory / "whole.mkv"));
        EXPECT_FALSE(fs::exists(unfinishedVideoDirectory(directory / "out.mkv")));
    }
}

// The state ends with what is known of the depth (6 numbers) and the choices (4 numbers), a flag
// before each.
TEST_F(VideoConverterTest, ADamagedStateIsRefused) {
    const auto of = [&](UnfinishedRun unfinished) {
        VideoConversion made = conversion("out.mkv");
        made.recipe.choices = {true, true, true};
        made.unfinished = unfinished;
        return made;
    };
    VideoConverter(of(UnfinishedRun::Refuse)).run([](const VideoProgress& now) {
        return now.frames < kSegmentFrames + 2;
    });
    const fs::path parts = unfinishedVideoDirectory(directory / "out.mkv");
    fs::path file; // the state after the last segment
    for (const auto& entry : fs::directory_iterator(parts))
        if (entry.path().extension() == ".state") file = entry.path();
    ASSERT_FALSE(file.empty());
    const std::string good = slurp(file);
    constexpr std::size_t kWord = sizeof(double);
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    std::vector<std::string> damaged;
    for (const std::size_t size : {std::size_t{1}, 5 * kWord, 12 * kWord, 13 * kWord})
        damaged.push_back(good.substr(0, size));
    for (std::size_t word = 3; word < 15; ++word) { // the first two are a size, the third a flag
        if (word == 10) continue;                   // a flag
        for (const double value : {1e300, -1e300, kNaN, 10001.0})
            std::memcpy(&damaged.emplace_back(good)[word * kWord], &value, kWord);
    }
    for (std::size_t i = 0; i < damaged.size(); ++i) {
        spill(file, damaged[i]);
        EXPECT_EQ(errorOf([&] { VideoConverter(of(UnfinishedRun::Resume)).run(); }),
                  "state: is damaged, expected the state of an earlier run")
            << i;
    }
    spill(file, good);
    EXPECT_EQ(VideoConverter(of(UnfinishedRun::Resume)).run().frames, kFrames);
}

TEST_F(VideoConverterTest, WhatTheCallerThrowsEndsTheRunAndKeepsWholeSegments) {
    VideoConverter converter(conversion("out.mkv"));
    EXPECT_THROW(converter.run([](const VideoProgress& now) -> bool {
        if (now.frames > kSegmentFrames + 2) throw std::runtime_error("caller");
        return true;
    }),
                 std::runtime_error);
    EXPECT_TRUE(converter.keepsWork());
    EXPECT_FALSE(fs::exists(directory / "out.mkv"));
}

TEST_F(VideoConverterTest, ARunThatIsCancelledAtOnceLeavesNothing) {
    {
        VideoConverter converter(conversion("out.mkv"));
        const auto result = converter.run([](const VideoProgress&) { return false; });
        EXPECT_TRUE(result.cancelled);
        EXPECT_EQ(result.frames, 0);
        EXPECT_THROW(converter.run(), Error);
    }
    EXPECT_FALSE(fs::exists(directory / "out.mkv"));
    EXPECT_FALSE(fs::exists(unfinishedVideoDirectory(directory / "out.mkv")));
}

TEST_F(VideoConverterTest, PicturesAreShownInTheirOrderUntilTheCallerHasSeenEnough) {
    writeClip(directory / "clip.mkv", movingPictures({64, 48}, kFrames), 20);
    writeClip(directory / "depth.mkv", movingPictures({32, 24}, kFrames, 100), 20);
    const NativeMaker maker(smallDisplay(), withFlaws({}));
    std::vector<cv::Mat> natives;
    for (const altiro3D::Scene& scene : scenes())
        natives.push_back(nativeOf(maker, scene));
    VideoConversion made = conversion("");
    std::size_t shown = 0;
    std::size_t next = 0;
    made.show = [&](const cv::Mat& picture) {
        while (next < natives.size() && !samePicture(picture, natives[next]))
            ++next; // dropped
        EXPECT_LT(next, natives.size());
        return ++shown < 3;
    };
    const VideoConversionResult result = VideoConverter(std::move(made)).run();
    EXPECT_EQ(shown, 3U);
    EXPECT_EQ(result.frames, 3);
    EXPECT_TRUE(result.cancelled);
}

// 100 pictures whose grey says their number, from a device that gives them as fast as they are
// read.
constexpr int kGreySteps = 100;
constexpr const char* kGreys =
    "nullsrc=size=32x32:rate=1:duration=100,format=yuv420p,geq=lum=16+2*N:cb=128:cr=128";

VideoConversion shownDevice(const std::string& device, std::vector<int>& numbers) {
    VideoConversion made;
    made.input = device;
    made.part.format = "lavfi";
    made.product = VideoProduct::Rgbd; // the picture itself, beside its depth
    made.show = [&numbers](const cv::Mat& picture) {
        const double grey = cv::mean(picture(cv::Rect(8, 8, 16, 16)))[1];
        numbers.push_back(static_cast<int>(std::lround(grey * 219 / 255 / 2)));
        return true;
    };
    return made;
}

bool isRising(const std::vector<int>& numbers) {
    return std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) ==
           numbers.end();
}

// While the first picture is shown, all others arrive: a device sets its own pace, although the
// times of these are 100 s. Only those on their way to the display and the newest one are kept.
TEST(LiveVideo, PicturesThatAreLateAreDroppedNotQueued) {
    ALTIRO3D_REQUIRE_FFMPEG(); // whole, with the device lavfi
    std::vector<int> numbers;
    VideoConversion made = shownDevice(kGreys, numbers);
    std::promise<void> allRead;
    std::atomic<int> reads{0};
    bool heldUp = false;
    made.show = [&, show = made.show](const cv::Mat& picture) {
        if (numbers.empty())
            heldUp = allRead.get_future().wait_for(std::chrono::seconds(60)) !=
                     std::future_status::ready;
        return show(picture);
    };
    // called before each read and after each picture; the last read finds the end
    const VideoConversionResult result = VideoConverter(std::move(made)).run([&](const auto&) {
        if (++reads == kGreySteps + 1) allRead.set_value();
        return true;
    });
    EXPECT_FALSE(heldUp);
    EXPECT_TRUE(isRising(numbers));
    ASSERT_FALSE(numbers.empty());
    EXPECT_EQ(numbers.back(), kGreySteps - 1);
    EXPECT_LE(numbers.size(), 7U); // one in each of three stages, one in each of three queues
    EXPECT_EQ(result.frames, static_cast<std::int64_t>(numbers.size()));
    EXPECT_EQ(result.pipeline.dropped, kGreySteps - result.frames);
}

// Its times are made up: 25 per second. That pictures in a pipe are live is tested with the reader.
TEST(LiveVideo, AFileIsPacedByItsTimes) {
    const TemporaryDirectory directory;
    std::string pictures;
    for (int k = 0; k < 10; ++k)
        pictures += "P6\n32 32\n255\n" + std::string(3072, static_cast<char>(2 * k * 255 / 219));
    spill(directory / "pictures", pictures);
    std::vector<int> numbers;
    VideoConversion made = shownDevice((directory / "pictures").string(), numbers);
    made.part.format = "ppm_pipe";
    const auto start = std::chrono::steady_clock::now();
    VideoConverter(std::move(made)).run();
    EXPECT_GT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(350));
    EXPECT_TRUE(isRising(numbers));
    EXPECT_FALSE(numbers.empty());
}

TEST_F(VideoConverterTest, PartsWithoutFramesAndFieldsThatDoNotGoTogetherAreErrors) {
    VideoConversion late = conversion("out.mkv");
    late.part.from = 100;
    late.given.reset();
    VideoConverter converter(std::move(late));
    EXPECT_EQ(errorOf([&] { converter.run(); }),
              (directory / "clip.mkv").string() +
                  ": holds no frames in this part, expected at least one (it ends at 0:15.0)");
    const std::pair<std::function<void(VideoConversion&)>, const char*> wrong[] = {
        {[](VideoConversion& c) { c.output.clear(); }, "output: is empty"},
        {[](VideoConversion& c) { c.show = [](const cv::Mat&) { return true; }; },
         "output: is set"},
        {[](VideoConversion& c) { c.display.reset(); }, "display: is not set"},
        {[](VideoConversion& c) { c.given->rgbd = DepthSide::Left; }, "given: depth has"},
        {[](VideoConversion& c) { c.given->source.clear(); }, "given: depth has"},
        {[](VideoConversion& c) { c.fromQuilt = true; }, "depth: is set"},
        {[](VideoConversion& c) {
             c.fromQuilt = true;
             c.given.reset();
             c.map = NativeLut(c.display->calibration, c.display->quilt);
             c.recipe.sampling.views = ViewFilter::Linear;
         },
         "sampling: is linear"},
        {[](VideoConversion& c) {
             c.fromQuilt = true;
             c.given.reset();
             c.viewAspect = -1;
         },
         "viewAspect: is -1"}};
    for (const auto& [change, message] : wrong) {
        VideoConversion made = conversion("out.mkv");
        change(made);
        EXPECT_TRUE(startsWith(errorOf([&] { VideoConverter another(std::move(made)); }), message))
            << message;
    }
    EXPECT_FALSE(fs::exists(directory / "out.mkv"));
}

TEST(ClockText, ShowsHoursOnlyWhereThereAreSome) {
    EXPECT_EQ(clockText(-1), "0:00.0");
    EXPECT_EQ(clockText(std::nan("")), "0:00.0");
    EXPECT_EQ(clockText(HUGE_VAL), "277777777777:46:40.0");
    EXPECT_EQ(clockText(5.24), "0:05.2");
    EXPECT_EQ(clockText(59.96), "1:00.0");
    EXPECT_EQ(clockText(3723.4), "1:02:03.4");
}

TEST_F(VideoConverterTest, AnOutputThatIsAnInputIsRefusedAndKept) {
    std::error_code noLinks; // on Windows
    fs::create_symlink(directory / "clip.mkv", directory / "link.mkv", noLinks);
    for (const char* name : {"clip.mkv", "depth.mkv", noLinks ? "clip.mkv" : "link.mkv"}) {
        const std::string before = slurp(directory / name);
        EXPECT_EQ(codeOf([&] { VideoConverter(conversion(name)); }), ErrorCode::InvalidArgument)
            << name;
        EXPECT_TRUE(slurp(directory / name) == before) << name;
    }
}

} // namespace
} // namespace altiro3D::test
