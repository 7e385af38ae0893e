// Videos whose frames hold both eyes' pictures.

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/stereo_views.hpp"
#include "altiro3D/video_conversion.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/onnx.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"
#include "support/stereo_scene.hpp"
#include "support/video.hpp"

#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr int kWall = 4;   // px of disparity
constexpr int kThing = 16; // px of disparity

cv::Mat joined(const Eyes& eyes, EyesPicture picture = EyesPicture::SideBySide) {
    cv::Mat both;
    joinEyes(eyes.left, eyes.right, picture, both);
    return both;
}

class StereoVideoTest : public FileTest {
  protected:
    fs::path clip(const std::string& name, const std::vector<cv::Mat>& frames) const {
        writeClip(directory / name, frames);
        return directory / name;
    }

    // With a network that says how bright a px is.
    VideoConversion conversion(const fs::path& input, const std::string& output) const {
        NetworkProfile profile;
        profile.name = "bright";
        profile.inputWidth = 64;
        profile.inputHeight = 48;
        profile.multipleOf = 8;
        if (!fs::exists(directory / "bright.onnx"))
            spill(directory / "bright.onnx", onnx::mixModel({0.3F, 0.3F, 0.3F}, {64, 48}));
        VideoConversion all;
        all.input = input;
        all.output = directory / output;
        all.encoding.codec = VideoCodec::Ffv1;
        all.depth = depthFromNetwork(DepthNetwork(directory / "bright.onnx", profile));
        all.stereo = StereoVideo();
        return all;
    }

    VideoConversionResult run(const fs::path& input, const std::string& output,
                              const std::function<void(VideoConversion&)>& change) const {
        VideoConversion all = conversion(input, output);
        change(all);
        return VideoConverter(std::move(all)).run();
    }
    VideoConversionResult toRgbd(const fs::path& input, int every) const {
        return run(input, "rgbd.mkv", [&](VideoConversion& all) {
            all.product = VideoProduct::Rgbd;
            all.depthOptions.every = every;
        });
    }

    std::vector<cv::Mat> frames(const std::string& name) const {
        std::vector<cv::Mat> all;
        for (const VideoFrame& frame : allFrames(directory / name))
            all.push_back(frame.picture);
        return all;
    }
};

TEST_F(StereoVideoTest, DepthIsThatOfThePairAndSteady) {
    ALTIRO3D_TAKES(0.7);
    const Eyes eyes = wallAndThing(kWall, kThing);
    const fs::path input = clip("clip.mkv", {4, joined(eyes)});
    for (const int every : {0, 1}) {
        const VideoConversionResult result = toRgbd(input, every);
        EXPECT_EQ(result.frames, 4);
        EXPECT_TRUE(result.notes.empty()) << result.notes.front().text;
        const std::vector<cv::Mat> made = frames("rgbd.mkv");
        cv::Mat photo;
        cv::Mat depth;
        splitRgbd(made.front(), DepthSide::Right, photo, depth);
        EXPECT_TRUE(samePicture(photo, eyes.left));
        // the truth, but for the px around the thing that only one eye sees
        cv::Mat truth(depth.size(), CV_32FC1, cv::Scalar(0));
        truth(thingInLeft()) = 1;
        cv::Mat isSure(depth.size(), CV_8UC1, cv::Scalar(255));
        isSure(thingInLeft() + cv::Size(2 * kThing, 8) - cv::Point(kThing, 4)) = 0;
        isSure(cv::Rect(thingInLeft().tl() + cv::Point(4, 4),
                        thingInLeft().size() - cv::Size(8, 8))) = 255;
        cv::Mat disparity;
        static_cast<void>(matchStereo(eyes.left, eyes.right, disparity));
        const double ofPair = rankCorrelation(disparity, truth, isSure);
        EXPECT_GT(ofPair, 0.85);
        EXPECT_GT(rankCorrelation(depth, truth, isSure), ofPair - 0.01);
        for (const cv::Mat& frame : made)
            EXPECT_TRUE(samePicture(frame, made.front()));
    }
}

TEST_F(StereoVideoTest, NativesAreThoseOfThePairAsAPhoto) {
    const Eyes eyes = wallAndThing(kWall, kThing);
    const Display display = sixViewDisplay(150, 98, {50, 32});
    altiro3D::Scene scene{eyes.left, {}};
    cv::Mat disparity;
    static_cast<void>(matchStereo(eyes.left, eyes.right, disparity, &scene.hidden));
    normalizeDepth(disparity, scene.depth);
    scaleHiddenDepth(disparity, scene.depth, scene.hidden);
    scene.edges = DepthEdges::Matched;
    for (const bool isFilled : {true, false}) {
        run(clip("clip.mkv", {joined(eyes)}), "native.mkv", [&](VideoConversion& made) {
            made.display = display;
            made.depthOptions.every = isFilled ? 1 : 0;
        });
        if (!isFilled) scene.hidden = {};
        cv::Mat native;
        NativeMaker(display).makeNative(scene, native);
        EXPECT_TRUE(samePicture(frames("native.mkv").front(), native)) << isFilled;
    }
}

TEST_F(StereoVideoTest, FramesWithoutMatchHaveEstimatedDepthAndAreSaid) {
    ALTIRO3D_TAKES(1);
    const Eyes eyes = wallAndThing(kWall, kThing);
    const auto notesOf = [&](const std::vector<cv::Mat>& all) {
        return textOf(toRgbd(clip("clip.mkv", all), 1).notes);
    };
    const cv::Mat black(eyesSize(), CV_8UC3, cv::Scalar::all(0));
    const Eyes unlike{randomPhoto(eyesSize(), 1), randomPhoto(eyesSize(), 2)};
    EXPECT_TRUE(holds(notesOf({joined(eyes), joined(unlike), joined({unlike.right, black})}),
                      "in 2 of 3 frames"));
    EXPECT_TRUE(holds(notesOf({joined({eyes.left, eyes.left})}), "flat (2D)"));
    const Eyes far = wallAndThing(kWall, 40);
    EXPECT_TRUE(holds(notesOf({joined({far.right, far.left})}), "look swapped"));
    EXPECT_TRUE(holds(notesOf({joined({eyes.left, black})}), "depth is estimated"));

    // the bright thing is near by the network as well
    cv::Mat photo;
    cv::Mat depth;
    splitRgbd(frames("rgbd.mkv").front(), DepthSide::Right, photo, depth);
    EXPECT_GT(cv::mean(depth(thingInLeft()))[0], cv::mean(depth)[0] + 50);
}

TEST_F(StereoVideoTest, EyesAreLaidOutAnewAsTheyWereFilmed) {
    const Eyes eyes = wallAndThing(kWall, kThing);
    const fs::path input = clip("clip.mkv", {joined(eyes)});
    const auto made = [&](const VideoEyes& wanted) {
        run(input, "out.mkv", [&](VideoConversion& stereo) {
            stereo.depth.reset();
            stereo.product = VideoProduct::Stereo;
            stereo.eyes = wanted;
        });
        return frames("out.mkv").front();
    };
    for (const EyesPicture picture : {EyesPicture::TopBottom, EyesPicture::Crossed,
                                      EyesPicture::Anaglyph, EyesPicture::SideBySideHalf}) {
        EXPECT_TRUE(
            samePicture(made({picture, EyesFrom::Both, false, true}), joined(eyes, picture)));
    }
    EXPECT_TRUE(samePicture(made({EyesPicture::SideBySide, EyesFrom::Both, true, true}),
                            joined({eyes.right, eyes.left})));
    EXPECT_TRUE(holds(errorOf([&] {
                          made({EyesPicture::SideBySide, EyesFrom::Both, false, true});
                      }),
                      "is side by side already"));
}

TEST_F(StereoVideoTest, WhereColoursTellTheEyesApartTheyAreWhole) {
    const fs::path input = clip("clip.mkv", {joined(wallAndThing(kWall, kThing))});
    for (const auto& [picture, format] : {std::pair(EyesPicture::Anaglyph, "yuv444p"),
                                          {EyesPicture::AnaglyphGrey, "yuv444p"},
                                          {EyesPicture::Rows, "yuv444p"},
                                          {EyesPicture::TopBottom, "yuv420p"}}) {
        run(input, "out.mkv", [wanted = picture](VideoConversion& stereo) {
            stereo.encoding.codec = VideoCodec::H264;
            stereo.product = VideoProduct::Stereo;
            stereo.eyes = {wanted, EyesFrom::Both, false, true};
        });
        EXPECT_EQ(VideoReader(directory / "out.mkv").facts().pixelFormat, format);
    }
}

TEST_F(StereoVideoTest, AResumedRunOfAStillPairMakesTheSameFrames) {
    ALTIRO3D_TAKES(3);
    const fs::path input =
        clip("clip.mkv", std::vector<cv::Mat>(48, joined(wallAndThing(kWall, kThing))));
    const auto converted = [&](const std::string& name, int most, UnfinishedRun unfinished) {
        VideoConversion stereo = conversion(input, name);
        stereo.product = VideoProduct::Stereo;
        stereo.recipe.views.strengthPercent = 8;
        stereo.depthOptions.every = 1;
        stereo.unfinished = unfinished;
        VideoConverter(std::move(stereo)).run([most](const VideoProgress& progress) {
            return progress.frames < most;
        });
        return allFrames(directory / name);
    };
    const auto whole = converted("whole.mkv", 1000, UnfinishedRun::Refuse);
    // a cancelled run still converts what was read, about a dozen frames
    ASSERT_LT(converted("parts.mkv", 13, UnfinishedRun::Refuse).size(), whole.size());
    EXPECT_TRUE(sameFrames(converted("parts.mkv", 1000, UnfinishedRun::Resume), whole));
}

TEST_F(StereoVideoTest, WhatTheRightEyeAloneSeesChangeIsSeen) {
    const Eyes eyes = wallAndThing(kWall, kThing);
    const cv::Mat black(eyesSize(), CV_8UC3, cv::Scalar::all(0));
    const cv::Mat one = joined({eyes.left, black});
    const VideoConversionResult result = toRgbd(clip("clip.mkv", {one, one, joined(eyes)}), 0);
    EXPECT_EQ(result.inferences, 2);
    EXPECT_EQ(result.repeated, 1);
    const std::vector<cv::Mat> made = frames("rgbd.mkv");
    EXPECT_TRUE(samePicture(made[1], made[0]));
    EXPECT_FALSE(samePicture(made[2], made[0]));
}

TEST_F(StereoVideoTest, ContradictionsAreRefused) {
    const fs::path input = clip("clip.mkv", {joined(wallAndThing(kWall, kThing))});
    const auto error = [&](const auto& change) {
        VideoConversion made = conversion(input, "out.mkv");
        made.display = sixViewDisplay(150, 98, {50, 32});
        change(made);
        return errorOf([&] { VideoConverter(std::move(made)).run(); });
    };
    EXPECT_TRUE(holds(error([](VideoConversion& c) {
                          c.given = GivenVideoDepth();
                          c.given->rgbd = DepthSide::Right;
                      }),
                      "stereo: is set"));
    EXPECT_TRUE(holds(error([](VideoConversion& c) { c.eyes.filmed = true; }), "filmed: is set"));
}

class FindEyes : public StereoVideoTest {
  protected:
    static FoundEyes found(const fs::path& file) {
        VideoReader reader(file);
        static_cast<void>(reader.next());
        return findEyes(file, reader.facts());
    }
};

TEST_F(FindEyes, WhatFilesStateOfEyesIsReadBack) {
    const Eyes eyes = wallAndThing(kWall, kThing);
    const std::pair<EyesPicture, StereoLayout> all[] = {
        {EyesPicture::SideBySide, StereoLayout::LeftRight},
        {EyesPicture::SideBySideHalf, StereoLayout::LeftRight},
        {EyesPicture::Crossed, StereoLayout::RightLeft},
        {EyesPicture::TopBottom, StereoLayout::TopBottom},
        {EyesPicture::TopBottomHalf, StereoLayout::TopBottom}};
    for (const auto& [picture, layout] : all) {
        for (const char* const name : {"clip.mkv", "clip.mp4"}) {
            if (picture == EyesPicture::Crossed && fs::path(name).extension() == ".mp4") continue;
            VideoWriterOptions options;
            const cv::Mat frame = joined(eyes, picture);
            options.size = frame.size();
            options.eyes = picture;
            VideoWriter writer(directory / name, options);
            writer.write({frame, 0, 1000});
            writer.finish();
            const FoundEyes eyesFound = found(directory / name);
            ASSERT_TRUE(eyesFound.eyes) << name;
            EXPECT_EQ(eyesFound.eyes->layout, layout) << name;
            EXPECT_TRUE(holds(eyesFound.evidence, "the file states it")) << name;
        }
    }
}

TEST_F(FindEyes, HalfLayoutsKeepTheShapeOfTheEyes) {
    const Eyes eyes = wallAndThing(kWall, kThing); // 4:3
    const fs::path input = clip("clip.mkv", {joined(eyes)});
    for (const EyesPicture picture : {EyesPicture::SideBySideHalf, EyesPicture::TopBottomHalf}) {
        for (const char* const name : {"half.mkv", "half.mp4"}) {
            const fs::path file = directory / name;
            run(input, name, [&](VideoConversion& half) {
                half.product = VideoProduct::Stereo;
                half.encoding.codec = VideoCodec::H264;
                half.eyes = {picture, EyesFrom::Both, false, true};
            });
            VideoReader reader(file);
            EXPECT_EQ(reader.facts().size, eyesSize());
            VideoConversion again = conversion(file, "again.mkv");
            const FoundEyes eyesFound = findEyes(file, reader.facts());
            EXPECT_EQ(textOf(eyesFound.notes), "") << name;
            again.stereo = eyesFound.eyes;
            ASSERT_TRUE(again.stereo) << name;
            again.product = VideoProduct::Stereo;
            again.eyes = {EyesPicture::Anaglyph, EyesFrom::Both, false, true};
            EXPECT_NEAR(VideoConverter(std::move(again)).size().aspectRatio(), 4.0 / 3, 0.01)
                << name;
        }
    }
    // by the tag alone
    const FoundEyes tagged =
        found(clip("film_LR.mkv", {3, joined(eyes, EyesPicture::SideBySideHalf)}));
    ASSERT_TRUE(tagged.eyes);
    EXPECT_EQ(tagged.eyes->halves, StereoHalves::Squeezed);
}

TEST_F(FindEyes, MatroskaMayStateTheSizeOfAnEyeOrOfTheFrame) {
    ALTIRO3D_REQUIRE_FFMPEG();
    struct Case {
        const char* size;
        const char* mode;
        const char* stretched; // shape of the frame if the stated size is the frame's
        double eye;            // width : height
        bool isSure;
    };
    for (const auto& [size, mode, stretched, eye, isSure] :
         {Case{"128x48", "left_right", "16:3", 4.0 / 3, true},
          Case{"256x72", "right_left", "64:9", 16.0 / 9, true},
          Case{"64x96", "top_bottom", "1:3", 4.0 / 3, true},
          Case{"128x72", "left_right", "32:9", 16.0 / 9, true},
          Case{"192x80", "left_right", "24:5", 2.4, true},
          Case{"128x72", "top_bottom", "8:9", 16.0 / 9, true},
          Case{"96x48", "left_right", nullptr, 1, false}}) {
        const fs::path files[] = {directory / "eye.mkv", directory / "frame.mkv"};
        ffmpeg("-f lavfi -i testsrc2=rate=5:duration=0.4:size=" + std::string(size) +
               " -c:v libx264 -metadata:s:v stereo_mode=" + mode + " " + arg(files[0]));
        if (stretched != nullptr)
            ffmpeg("-i " + arg(files[0]) + " -c copy -aspect " + stretched + " " + arg(files[1]));
        for (const fs::path& file : {files[0], files[stretched == nullptr ? 0 : 1]}) {
            const VideoFacts facts = VideoReader(file).facts();
            const FoundEyes eyesFound = findEyes(file, facts);
            ASSERT_TRUE(eyesFound.eyes) << size;
            EXPECT_NEAR(photoSize(*eyesFound.eyes, facts.size).aspectRatio() *
                            facts.sampleAspect.value(),
                        eye, 0.01)
                << size << ' ' << file;
            EXPECT_EQ(eyesFound.notes.empty(), isSure) << size << textOf(eyesFound.notes);
        }
    }
}

TEST_F(FindEyes, StripsAreFlatAndEyesByTurnsArePairs) {
    EXPECT_FALSE(found(clip("strip.mkv", {3, randomPhoto({4096, 16})})).eyes);
    if (!haveFfmpeg()) GTEST_SKIP() << "needs ffmpeg";
    const auto stated = [&](const char* name, const std::string& options) {
        ffmpeg("-f lavfi -i testsrc2=size=96x64:rate=5:duration=0.6 -c:v libx264 " + options + " " +
               arg(directory / name));
        return findEyes(directory / name, VideoReader(directory / name).facts());
    };
    const fs::path turns = directory / "turns.mkv";
    EXPECT_FALSE(stated("turns.mkv", "-metadata:s:v stereo_mode=block_lr").eyes); // the left alone
    VideoReaderOptions both;
    both.bothEyes = true;
    VideoFacts facts = VideoReader(turns, both).facts();
    const FoundEyes pairs = findEyes(turns, facts, both);
    ASSERT_TRUE(pairs.eyes);
    EXPECT_EQ(pairs.eyes->halves, StereoHalves::Full);
    facts.eyesLayout.reset(); // frames that say so later
    EXPECT_TRUE(holds(errorOf([&] { return findEyes(turns, facts); }),
                      "turns.mkv -vf stereo3d=al:sbsl,sidedata=delete:STEREO3D eyes_LRF.mp4"));
    ffmpeg("-f lavfi -i testsrc2=size=96x64:rate=5:duration=0.8 -c:v libx264 -x264opts "
           "frame-packing=5 " +
           arg(directory / "sei5.mp4"));
    ffmpeg("-i " + arg(directory / "sei5.mp4") + " -vf stereo3d=al:sbsl,sidedata=delete:STEREO3D " +
           arg(directory / "eyes_LRF.mp4"));
    VideoReader joined(directory / "eyes_LRF.mp4", both);
    EXPECT_EQ(joined.facts().size, cv::Size(192, 64));
    EXPECT_EQ(allFrames(joined).size(), 2U);
    EXPECT_TRUE(joined.facts().eyes.empty()); // FFmpeg would mark it as frames by turns again
    const FoundEyes sei = stated("sei.mp4", "-x264opts frame-packing=4"); // in frames alone
    ASSERT_TRUE(sei.eyes);
    EXPECT_EQ(sei.eyes->layout, StereoLayout::TopBottom);
}

TEST_F(FindEyes, NamesCountIfHalvesMatch) {
    ALTIRO3D_TAKES(1.3);
    const std::vector<cv::Mat> pair(3, joined(wallAndThing(kWall, kThing)));
    const FoundEyes named = found(clip("film_LR.mkv", pair));
    ASSERT_TRUE(named.eyes);
    EXPECT_EQ(named.eyes->layout, StereoLayout::LeftRight);
    EXPECT_TRUE(holds(named.evidence, "LR"));
    const FoundEyes full = found(clip("film_LRF.mkv", pair));
    ASSERT_TRUE(full.eyes);
    EXPECT_EQ(full.eyes->halves, StereoHalves::Full);

    constexpr int kFar = 30; // px: in small the halves differ
    const FoundEyes wide = found(clip("wide_LRF.mkv", {3, joined(wallAndThing(kFar, 2 * kFar))}));
    EXPECT_TRUE(wide.eyes);

    const FoundEyes flat = found(clip("film_SBS.mkv", {3, randomPhoto({800, 300}, 3)}));
    EXPECT_FALSE(flat.eyes);
    EXPECT_TRUE(holds(textOf(flat.notes), "its halves do not match"));
}

TEST_F(FindEyes, FlatVideosGetAHintAtMost) {
    ALTIRO3D_TAKES(0.9);
    const Eyes eyes = wallAndThing(kWall, kThing);
    const FoundEyes beside = found(clip("film.mkv", {3, joined(eyes)}));
    EXPECT_FALSE(beside.eyes);
    EXPECT_TRUE(holds(textOf(beside.notes), "left and right half look like"));
    const FoundEyes above = found(clip("film.mkv", {3, joined(eyes, EyesPicture::TopBottom)}));
    EXPECT_FALSE(above.eyes);
    EXPECT_TRUE(holds(textOf(above.notes), "upper and lower half look like"));
    const FoundEyes flat = found(clip("film.mkv", {3, randomPhoto({640, 360}, 3)}));
    EXPECT_FALSE(flat.eyes);
    EXPECT_TRUE(flat.notes.empty());
}

TEST_F(FindEyes, WhatIsNotReadIsRefusedByName) {
    const fs::path vr = clip("film_180_LR.mkv", {randomPhoto({64, 32})});
    EXPECT_TRUE(holds(errorOf([&] { return found(vr); }), "for headsets"));
    VideoWriterOptions options;
    options.size = {64, 32};
    options.eyes = EyesPicture::Rows;
    VideoWriter writer(directory / "rows.mkv", options);
    writer.write({randomPhoto({64, 32}), 0, 1000});
    writer.finish();
    EXPECT_TRUE(holds(errorOf([&] { return found(directory / "rows.mkv"); }), "interleaved lines"));
}

} // namespace
} // namespace altiro3D::test
