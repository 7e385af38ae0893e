#include "altiro3D/depth_source.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"
#include "support/stereo_scene.hpp"

#include <filesystem>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::test {
namespace {

// The network of the project.
InstalledNetwork ownNetwork() {
    return standardNetwork(false, {sourcePath("models")}).value();
}

std::unique_ptr<DepthSource> ownSource() {
    const InstalledNetwork network = ownNetwork();
    return depthFromNetwork(DepthNetwork(network.file, network.profile));
}

class DepthSourceTest : public FileTest {};

TEST_F(DepthSourceTest, ANetworkOrdersThePhotoAsItsRunsDo) {
    const InstalledNetwork network = ownNetwork();
    DepthNetwork runs(network.file, network.profile);
    const auto source = ownSource();
    for (const cv::Size size : {cv::Size(300, 200), cv::Size(750, 1000)}) {
        const cv::Mat photo = scenery(size, 3);
        cv::Mat layout;
        runs.estimate(photo, layout);
        cv::Mat mirrored;
        cv::flip(photo, mirrored, 1);
        cv::Mat larger;
        runs.estimate(mirrored, larger, 320);
        cv::flip(larger, larger, 1);
        cv::Mat same;
        cv::Mat raw;
        source->read(photo, same, raw);
        EXPECT_TRUE(samePicture(same, photo));
        EXPECT_EQ(raw.size(), size.height > 512 ? cv::Size(384, 512) : size);
        EXPECT_TRUE(cv::checkRange(raw, true, nullptr, -0.1, 1.1));
        cv::resize(layout, layout, raw.size());
        cv::resize(larger, larger, raw.size());
        const cv::Mat all(raw.size(), CV_8UC1, cv::Scalar(255));
        EXPECT_GT(rankCorrelation(raw, layout + larger, all), 0.97) << size;
        source->readFrame(photo, same, raw);
        EXPECT_EQ(raw.size(), size.height > 320 ? cv::Size(240, 320) : size);
        cv::resize(layout, layout, raw.size());
        EXPECT_GT(rankCorrelation(raw, layout, cv::Mat(raw.size(), CV_8UC1, cv::Scalar(255))), 0.97)
            << size;
    }
    EXPECT_EQ(source->kind(), DepthKind::NearWhite);
    EXPECT_EQ(source->edges(), DepthEdges::Aligned);
    EXPECT_EQ(source->description(), "network altiro3d (" + network.file.string() + ")");
}

TEST_F(DepthSourceTest, ASideThatTheInputCannotHaveIsRefused) {
    const InstalledNetwork network = ownNetwork();
    DepthNetwork own(network.file, network.profile);
    cv::Mat depth;
    for (const int side : {-32, 100, 8192}) {
        EXPECT_EQ(errorOf([&] { own.estimate(randomPhoto(cv::Size(8, 6)), depth, side); }),
                  "longerSide: is " + std::to_string(side) +
                      " px, expected 1..4096 px, a multiple of 32");
    }
}

TEST_F(DepthSourceTest, ANetworkFileIsLoadedWhenAPhotoNeedsIt) {
    const InstalledNetwork own = ownNetwork();
    const auto loaded = ownSource();
    const auto later = depthFromNetworkFile(own.file, own.profile);
    EXPECT_EQ(later->description(), loaded->description());
    EXPECT_EQ(later->kind(), loaded->kind());
    EXPECT_EQ(later->network(), nullptr);
    const cv::Mat photo = randomPhoto({80, 60});
    altiro3D::Scene expected;
    altiro3D::Scene scene;
    loaded->readScene(photo, 0.5, expected);
    later->readScene(photo, 0.5, scene);
    EXPECT_TRUE(samePicture(scene.depth, expected.depth));
    ASSERT_NE(later->network(), nullptr);
    EXPECT_EQ(later->network()->file(), own.file);

    // a photo with depth of its own needs no network, so that a missing file does not matter
    writePhotoWithDepth(directory / "with.jpg", photo, expected.depth);
    writeImage(directory / "without.png", photo);
    const auto inPhoto =
        storedDepthOr(depthFromNetworkFile(directory / "missing.onnx", own.profile));
    inPhoto->readScene(inPhoto->readPhoto(directory / "with.jpg"), 0.5, scene);
    EXPECT_EQ(inPhoto->network(), nullptr);
    const PhotoDepth without = inPhoto->readPhoto(directory / "without.png");
    EXPECT_EQ(errorOf([&] { inPhoto->readScene(without, 0.5, scene); }),
              (directory / "missing.onnx").string() + ": does not exist, expected a file");
}

// Requirements for the default depth of every photo.
TEST_F(DepthSourceTest, TheStandardDepthIsDefinedForEveryPhoto) {
    const auto source = ownSource();
    cv::Mat text(300, 400, CV_8UC3, cv::Scalar::all(255));
    for (int line = 0; line < 14; ++line)
        cv::putText(text, "The quick brown fox jumps over", {5, 20 + 20 * line},
                    cv::FONT_HERSHEY_SIMPLEX, 0.6, cv::Scalar::all(0));
    const cv::Mat photos[] = {cv::Mat(1, 1, CV_8UC3, cv::Scalar(1, 2, 3)),
                              randomPhoto({1, 4000}),
                              randomPhoto({4000, 1}),
                              randomPhoto({320, 240}),
                              cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(0)),
                              cv::Mat(240, 320, CV_8UC3, cv::Scalar(0, 0, 255)),
                              text};
    for (const cv::Mat& photo : photos) {
        altiro3D::Scene scene;
        source->readScene(photo, 0.5, scene);
        EXPECT_FALSE(scene.depth.empty()) << photo.size();
        EXPECT_TRUE(cv::checkRange(scene.depth, true, nullptr, 0, 1.0001)) << photo.size();
    }
}

TEST_F(DepthSourceTest, AMirroredPhotoHasTheMirroredDepthWithinATolerance) {
    ALTIRO3D_TAKES(4);
    const auto source = ownSource();
    std::vector<std::filesystem::path> files{sourcePath("docs/examples/sample.jpg")};
    for (const char* name : {"04", "05", "08", "13", "15", "19", "22", "23"}) {
        const std::filesystem::path file =
            dataPath("photos/kodak/kodim" + std::string(name) + ".png");
        if (std::filesystem::exists(file)) files.push_back(file);
    }
    for (const std::filesystem::path& file : files) {
        const cv::Mat photo = readPhoto(file);
        cv::Mat mirrored;
        cv::flip(photo, mirrored, 1);
        altiro3D::Scene scene;
        altiro3D::Scene other;
        source->readScene(photo, 0.5, scene);
        source->readScene(mirrored, 0.5, other);
        cv::Mat back;
        cv::flip(other.depth, back, 1);
        cv::Mat difference;
        cv::absdiff(scene.depth, back, difference);
        EXPECT_LE(cv::mean(difference)[0], 0.15) << file; // docs/depth.md
    }
}

TEST_F(DepthSourceTest, AFileIsNormalizedByItsKind) {
    cv::Mat samples(2, 4, CV_16UC1);
    for (int i = 0; i < 8; ++i)
        samples.at<std::uint16_t>(i / 4, i % 4) = static_cast<std::uint16_t>(1000 * i);
    writeImage(directory / "depth.png", samples);
    const cv::Mat photo = randomPhoto({40, 20});
    for (const DepthKind kind : {DepthKind::NearWhite, DepthKind::FarWhite}) {
        const auto source = depthFromFile(directory / "depth.png", kind);
        EXPECT_EQ(source->kind(), kind);
        altiro3D::Scene scene;
        source->readScene(photo, 0.5, scene);
        ASSERT_EQ(scene.depth.size(), samples.size());
        for (int i = 0; i < 8; ++i) {
            const float near = static_cast<float>(i) / 7;
            EXPECT_NEAR(scene.depth.at<float>(i / 4, i % 4),
                        kind == DepthKind::NearWhite ? near : 1 - near, 1e-6);
        }
    }
    EXPECT_THROW(
        {
            altiro3D::Scene scene;
            depthFromFile(directory / "none.png")->readScene(photo, 0.5, scene);
        },
        Error);
}

TEST_F(DepthSourceTest, FlatDepthTakesTheGivenValue) {
    writeImage(directory / "flat.png", cv::Mat(3, 3, CV_8UC1, cv::Scalar(77)));
    altiro3D::Scene scene;
    depthFromFile(directory / "flat.png")->readScene(randomPhoto({9, 9}), 0.25, scene);
    EXPECT_TRUE(samePicture(scene.depth, cv::Mat(3, 3, CV_32FC1, cv::Scalar(0.25))));
}

TEST_F(DepthSourceTest, AnRgbdImageIsSplit) {
    const cv::Mat photo = randomPhoto({30, 20});
    const cv::Mat depth = randomDepth({30, 20});
    for (const DepthSide side :
         {DepthSide::Left, DepthSide::Right, DepthSide::Top, DepthSide::Bottom}) {
        cv::Mat image;
        joinRgbd(photo, depth, side, image);
        altiro3D::Scene scene;
        depthFromRgbd(side)->readScene(image, 0.5, scene);
        EXPECT_TRUE(samePicture(scene.photo, photo));
        // 8 bits, and the percentiles cut 0.5 % at both ends of the range
        EXPECT_TRUE(samePicture(scene.depth, depth, 0.02));
    }
}

TEST_F(DepthSourceTest, ReadsFilesAsReadTakesThem) {
    const cv::Mat photo = randomPhoto({30, 20});
    const cv::Mat depth = randomDepth({30, 20});
    writeImage(directory / "photo.png", photo);
    writeImage(directory / "depth.png", depthTo16Bit(depth));
    cv::Mat image;
    joinRgbd(photo, depth, DepthSide::Right, image);
    cv::Mat wide; // 16 bits a channel, which a photo has not
    image.convertTo(wide, CV_16U, 257);
    writeImage(directory / "rgbd.png", wide);

    const auto given = depthFromFile(directory / "depth.png");
    altiro3D::Scene scene;
    const PhotoDepth found = given->readPhoto(directory / "photo.png");
    EXPECT_EQ(found.origin, DepthOrigin::Given);
    std::filesystem::remove(directory / "depth.png"); // read already
    for (int i = 0; i < 2; ++i) {                     // any number of times
        given->readScene(found, 0.5, scene);
        EXPECT_TRUE(samePicture(scene.photo, photo));
        EXPECT_TRUE(samePicture(scene.depth, depth, 0.02));
    }
    EXPECT_THROW(given->readScene(photo, 0.5, scene), Error);
    EXPECT_THROW(static_cast<void>(given->readPhoto(directory / "photo.png")), Error);

    const auto rgbd = depthFromRgbd(DepthSide::Right);
    const PhotoDepth split = rgbd->readPhoto(directory / "rgbd.png");
    EXPECT_EQ(split.origin, DepthOrigin::Given);
    EXPECT_EQ(split.whole, image.size());
    rgbd->readScene(split, 0.5, scene);
    EXPECT_TRUE(samePicture(scene.photo, photo));

    const PhotoDepth plain = ownSource()->readPhoto(directory / "rgbd.png");
    EXPECT_TRUE(samePicture(plain.photo, image));
    EXPECT_TRUE(plain.rawDepth.empty());
    EXPECT_EQ(plain.origin, DepthOrigin::Estimated);
}

// Record3D: metres = 3 x hue, beside the photo; black is unknown.
TEST_F(DepthSourceTest, DistancesThatAreCodedAsHueAreRead) {
    cv::Mat metres(40, 60, CV_32FC1);
    for (int x = 0; x < metres.cols; ++x)
        metres.col(x).setTo(0.5 + 0.04 * x);
    metres(cv::Rect(20, 10, 5, 5)).setTo(0);
    cv::Mat value;
    cv::Mat(metres > 0).convertTo(value, CV_32F, 1 / 255.0);
    const cv::Mat full(metres.size(), CV_32FC1, cv::Scalar(1));
    cv::Mat colours;
    cv::merge(std::vector<cv::Mat>{metres * (360 / 3.0), full, value}, colours);
    cv::cvtColor(colours, colours, cv::COLOR_HSV2BGR);
    colours.convertTo(colours, CV_8U, 255);
    cv::Mat image;
    cv::hconcat(colours, randomPhoto(metres.size()), image);
    altiro3D::Scene scene;
    depthFromRgbd(DepthSide::Left, DepthKind::Metric)->readScene(image, 0.5, scene);
    cv::Mat expected;
    DepthNormalization metric;
    metric.kind = DepthKind::Metric;
    normalizeDepth(metres, expected, metric);
    EXPECT_TRUE(samePicture(scene.depth, expected, 0.02)); // a level is 1/85 m
}

TEST_F(DepthSourceTest, NotesNameTheirFile) {
    writeImage(directory / "photo.png", randomPhoto({30, 20}));
    writeImage(directory / "coloured.png", randomPhoto({30, 20}));
    Notes notes;
    static_cast<void>(
        depthFromFile(directory / "coloured.png")->readPhoto(directory / "photo.png", &notes));
    EXPECT_TRUE(startsWith(only(notes).text, (directory / "coloured.png").string() + ": "));
    notes.clear();
    static_cast<void>(
        depthFromRgbd(DepthSide::Left)->readPhoto(directory / "coloured.png", &notes));
    EXPECT_EQ(only(notes).text, (directory / "coloured.png").string() +
                                    ": the depth half has colours, and depth has none: their grey "
                                    "value is taken");
}

TEST_F(DepthSourceTest, DepthBesideAPhotoIsUsedOrReported) {
    const cv::Mat photo = randomPhoto({64, 48});
    writeImage(directory / "photo.png", photo);
    cv::Mat ramp(48, 64, CV_8UC1);
    for (int x = 0; x < ramp.cols; ++x)
        ramp.col(x).setTo(4 * x);
    writeImage(directory / "photo_depth.png", ramp);
    const auto source = storedDepthOr(ownSource());
    Notes notes;
    const PhotoDepth found = source->readPhoto(directory / "photo.png", &notes);
    EXPECT_TRUE(notes.empty());
    EXPECT_EQ(found.separateFile, directory / "photo_depth.png");
    EXPECT_EQ(found.text,
              "depth image beside the photo (" + (directory / "photo_depth.png").string() + ")");
    Scene scene;
    source->readScene(found, 0.5, scene);
    EXPECT_EQ(scene.depth.at<float>(7, 0), 0);
    EXPECT_EQ(scene.depth.at<float>(7, 63), 1);
    for (const std::string damage : {"", "no picture at all"}) {
        spill(directory / "photo_depth.png", damage);
        notes.clear();
        const PhotoDepth without = source->readPhoto(directory / "photo.png", &notes);
        EXPECT_EQ(without.text, ownSource()->description());
        EXPECT_TRUE(without.separateFile.empty());
        EXPECT_TRUE(without.rawDepth.empty());
        EXPECT_TRUE(samePicture(without.photo, photo));
        EXPECT_EQ(only(notes).code, NoteCode::LeftOut);
        EXPECT_TRUE(
            startsWith(only(notes).text, (directory / "photo_depth.png").string() + ": is "));
        EXPECT_TRUE(holds(only(notes).text, "; it is not used"));
    }
}

TEST_F(DepthSourceTest, APairBringsWhatOnlyTheRightEyeSees) {
    const Eyes eyes = wallAndThing(6, 26);
    writeImage(directory / "left.png", eyes.left);
    writeImage(directory / "right.png", eyes.right);
    StereoInput input;
    input.right = directory / "right.png";
    const auto source = depthFromStereo(input, ownSource());
    Scene scene;
    source->readScene(source->readPhoto(directory / "left.png"), 0.5, scene);
    EXPECT_EQ(scene.edges, DepthEdges::Matched);
    ASSERT_EQ(scene.hidden.photo.size(), eyes.left.size());
    ASSERT_EQ(scene.hidden.depth.size(), eyes.left.size());
    const cv::Rect thing = thingInLeft();
    const cv::Point behind(thing.br().x - 8, thing.y + thing.height / 2);
    const cv::Point beside(thing.br().x + 60, behind.y);
    EXPECT_NEAR(scene.hidden.depth.at<float>(behind), scene.depth.at<float>(beside), 0.02);
    EXPECT_GT(scene.depth.at<float>(behind), scene.depth.at<float>(beside) + 0.5F);
    ownSource()->readScene(eyes.left, 0.5, scene);
    EXPECT_TRUE(scene.hidden.photo.empty());
    EXPECT_EQ(scene.edges, DepthEdges::Aligned);
}

TEST_F(DepthSourceTest, NamesOfBothEyesCountIfTheHalvesResembleEachOther) {
    ALTIRO3D_TAKES(0.8);
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat beside;
    cv::Mat stacked;
    cv::hconcat(eyes.left, eyes.right, beside);
    cv::vconcat(eyes.left, eyes.right, stacked);
    const auto source = storedDepthOr(ownSource());
    for (const char* name : {"cat_LR.png", "cat_lr_2.png", "a_2x1.png", "x_TAB.png", "x_tb.png"}) {
        const bool isStacked = name[0] == 'x';
        writeImage(directory / name, isStacked ? stacked : beside);
        Notes notes;
        const PhotoDepth found = source->readPhoto(directory / name, &notes);
        EXPECT_TRUE(samePicture(found.photo, eyes.left)) << name;
        EXPECT_TRUE(notes.empty()) << notes.front().text;
        EXPECT_EQ(found.origin, DepthOrigin::Matched) << name;
        EXPECT_TRUE(startsWith(found.text, "stereo pair ("));
        altiro3D::Scene scene;
        source->readScene(found, 0.5, scene);
        EXPECT_GT(scene.depth.at<float>(150, 200), scene.depth.at<float>(150, 350) + 0.5F) << name;
        EXPECT_FALSE(scene.hidden.photo.empty());
    }
    const cv::Mat plain = randomPhoto({400, 300}, 8);
    for (const auto& [name, end] :
         {std::pair("p_LR.png", " (LR may mean Lightroom)"), std::pair("p_tab.png", "")}) {
        writeImage(directory / name, plain);
        Notes notes;
        const PhotoDepth found = source->readPhoto(directory / name, &notes);
        EXPECT_TRUE(samePicture(found.photo, plain)) << name;
        EXPECT_EQ(found.origin, DepthOrigin::Estimated);
        const std::string tag = std::string(name).substr(2, std::string(name).size() - 6);
        EXPECT_EQ(only(notes).text, (directory / name).string() + ": its name (" + tag +
                                        ") may mean that it holds both eyes, but its halves do not "
                                        "resemble each other: it is read as an ordinary photo" +
                                        end);
    }
}

TEST_F(DepthSourceTest, NamesOfRgbdCountIfAHalfIsDepth) {
    const cv::Mat photo = randomPhoto({64, 72}, 3); // 16:9 side by side
    cv::Mat ramp(photo.size(), CV_32FC1);
    for (int x = 0; x < ramp.cols; ++x)
        ramp.col(x).setTo(x / 63.0);
    const auto source = storedDepthOr(ownSource());
    for (const DepthSide side : {DepthSide::Right, DepthSide::Left, DepthSide::Bottom}) {
        cv::Mat both;
        joinRgbd(photo, ramp, side, both);
        for (const char* name : {"a_rgbd.png", "a_HRGBD_2.png"}) {
            writeImage(directory / name, both);
            Notes notes;
            const PhotoDepth found = source->readPhoto(directory / name, &notes);
            const cv::Mat& read = found.photo;
            EXPECT_TRUE(notes.empty()) << notes.front().text;
            EXPECT_EQ(found.origin, DepthOrigin::Given);
            if (std::string(name) == "a_rgbd.png") {
                EXPECT_TRUE(samePicture(read, photo));
            } else {
                EXPECT_EQ(read.size(),
                          side == DepthSide::Bottom ? cv::Size(64, 144) : cv::Size(128, 72));
            }
            altiro3D::Scene scene;
            source->readScene(found, 0.5, scene);
            EXPECT_EQ(scene.depth.size(), read.size());
            EXPECT_GT(scene.depth.at<float>(30, read.cols - 5), 0.9F) << name;
            EXPECT_LT(scene.depth.at<float>(30, 5), 0.1F) << name;
        }
    }
    const cv::Mat plain = randomPhoto({64, 48}, 8);
    writeImage(directory / "b_RGBD.png", plain);
    Notes notes;
    EXPECT_TRUE(samePicture(source->readPhoto(directory / "b_RGBD.png", &notes).photo, plain));
    EXPECT_EQ(only(notes).text,
              (directory / "b_RGBD.png").string() +
                  ": its name (RGBD) says that it holds depth, but no half of it is "
                  "clearly depth: it is read as an ordinary photo");
}

TEST_F(DepthSourceTest, PicturesForHeadsetsAreRefusedByName) {
    const auto file = directory / "a_180x180_LR.png";
    writeImage(file, randomPhoto({64, 48}, 8));
    EXPECT_EQ(errorOf([&] { return storedDepthOr(ownSource())->readPhoto(file); }),
              file.string() + ": is made for headsets (VR) by its name (180x180), which is not "
                              "read, expected a flat picture; if it is one, rename it");
    EXPECT_EQ(storedDepthOr(ownSource(), {false, false})->readPhoto(file).photo.cols, 64);
}

TEST_F(DepthSourceTest, APairThatDoesNotMatchTakesItsDepthElsewhere) {
    const cv::Mat left = scenery({320, 240}, 4);
    writeImage(directory / "left.png", left);
    writeImage(directory / "right.png", scenery({320, 240}, 5));
    writeImage(directory / "tall.png", scenery({100, 240}, 5));
    StereoInput input;
    input.right = directory / "right.png";
    const auto source = depthFromStereo(input, ownSource());
    Notes notes;
    const PhotoDepth found = source->readPhoto(directory / "left.png", &notes);
    EXPECT_TRUE(samePicture(found.photo, left));
    EXPECT_EQ(found.text, ownSource()->description());
    EXPECT_TRUE(
        holds(only(notes).text,
              "the stereo pair (two files) is not used, because its pictures do not match"));
    Scene scene;
    source->readScene(found, 0.5, scene);
    altiro3D::Scene expected;
    ownSource()->readScene(left, 0.5, expected);
    EXPECT_TRUE(samePicture(scene.depth, expected.depth));
    cv::Mat both;
    cv::hconcat(left, scenery({320, 240}, 5), both);
    writeImage(directory / "both.png", both);
    Notes ofHalves;
    depthFromStereo({}, ownSource())->readPhoto(directory / "both.png", &ofHalves);
    EXPECT_TRUE(holds(only(ofHalves).text,
                      "the left eye's picture alone is shown; if the file does not hold both eyes, "
                      "all of it is shown without --stereo"));

    input.right = directory / "tall.png";
    const auto read = [&](const StereoInput& pair) {
        static_cast<void>(depthFromStereo(pair, ownSource())->readPhoto(directory / "left.png"));
    };
    const std::string error = errorOf([&] { read(input); });
    EXPECT_TRUE(startsWith(error, (directory / "tall.png").string() + ": right: has 100 x 240 px"));
    EXPECT_TRUE(holds(errorOf([&] { depthFromStereo(input, nullptr); }), "fallback: "));
}

} // namespace
} // namespace altiro3D::test
