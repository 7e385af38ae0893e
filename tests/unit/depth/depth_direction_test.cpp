#include "altiro3D/depth_map.hpp"

#include "altiro3D/depth_source.hpp"
#include "altiro3D/image_io.hpp"
#include "support/files.hpp"
#include "support/middlebury.hpp"
#include "support/pixels.hpp"
#include "support/slow.hpp"

#include <cmath>
#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <string>

using altiro3D::DepthKind;
using altiro3D::Scene;
using altiro3D::test::dataPath;
using altiro3D::test::errorOf;
using altiro3D::test::holds;

namespace fs = std::filesystem;

namespace {

// Depth by a formula of the place, x and y in 0..1.
cv::Mat depthBy(const std::function<double(double, double)>& formula, cv::Size size = {160, 120}) {
    return altiro3D::test::pictureOf<float>(size, [&](int x, int y) {
        return formula((x + 0.5) / size.width, (y + 0.5) / size.height);
    });
}

// The bottom is near.
cv::Mat floorDepth(cv::Size size = {160, 120}) {
    return depthBy([](double, double y) { return y; }, size);
}

cv::Mat turned(const cv::Mat& depth) {
    return 1.0 - depth;
}

bool looksInverted(const cv::Mat& depth, int typeOfEstimate = CV_32FC1) {
    return altiro3D::looksInverted(depth, [=] {
        cv::Mat estimate;
        floorDepth({64, 48}).convertTo(estimate, typeOfEstimate);
        return estimate;
    });
}

struct Count {
    int asItIs = 0;
    int turnedRound = 0;
    int all = 0;
};

// Judges by the network of the project.
void count(const Scene& scene, Count& counts) {
    const auto own = altiro3D::standardNetwork(false, {altiro3D::test::sourcePath("models")});
    Scene estimated;
    altiro3D::depthFromNetworkFile(own.value().file, own.value().profile)
        ->readScene(scene.photo, 0.5, estimated);
    const auto estimate = [&] { return estimated.depth; };
    ++counts.all;
    counts.asItIs += altiro3D::looksInverted(scene.depth, estimate) ? 1 : 0;
    counts.turnedRound += altiro3D::looksInverted(turned(scene.depth), estimate) ? 1 : 0;
}

Count countPair(const std::string& photo, const std::string& depth, DepthKind kind, Count counts) {
    Scene scene;
    altiro3D::DepthNormalization normalization;
    normalization.kind = kind;
    scene.photo = altiro3D::readPhoto(dataPath(photo));
    altiro3D::normalizeDepth(altiro3D::readDepthSamples(dataPath(depth)), scene.depth,
                             normalization);
    count(scene, counts);
    return counts;
}

} // namespace

TEST(DepthDirection, TellsAFloorFromAFloorTurnedRoundOfAnySizeAndRange) {
    for (const cv::Size size :
         {cv::Size(160, 120), cv::Size(64, 64), cv::Size(97, 301), cv::Size(7, 5)}) {
        const cv::Mat floor = floorDepth(size);
        for (const cv::Mat& depth : {floor, cv::Mat(0.4 + 0.1 * floor)}) { // spread 0.029
            EXPECT_FALSE(looksInverted(depth)) << size;
            EXPECT_TRUE(looksInverted(turned(depth))) << size;
        }
    }
}

TEST(DepthDirection, SaysNothingAboutDepthWithoutDirection) {
    const double faint = 0.06; // 0.06 / sqrt(12) = 0.017 is the spread of this ramp
    for (const cv::Mat& depth :
         {cv::Mat(cv::Mat::zeros(120, 160, CV_32FC1)), cv::Mat(cv::Mat::ones(120, 160, CV_32FC1)),
          cv::Mat(120, 160, CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN())),
          cv::Mat(1, 1, CV_32FC1, cv::Scalar(0.5)),
          depthBy([&](double, double y) { return 0.5 - faint * y; }),
          depthBy([](double x, double) { return x; })}) {
        EXPECT_FALSE(looksInverted(depth));
        EXPECT_FALSE(looksInverted(turned(depth)));
    }
}

TEST(DepthDirection, DoubtsOnlyIfTheBorderIsNearToo) {
    // a lamp that hangs from above, before everything: the top is nearer, but not the border
    const auto lamp = [](double x, double y) {
        return std::abs(x - 0.5) < 0.25 && y < 0.75 ? 1.0 : 0.2;
    };
    EXPECT_FALSE(looksInverted(depthBy(lamp)));
}

TEST(DepthDirection, ClampsAndCountsNanAsFar) {
    cv::Mat depth = depthBy([](double, double y) { return y < 0.5 ? 1e30 : -1e30; });
    EXPECT_TRUE(looksInverted(depth));
    depth = depthBy([](double, double y) { return y < 0.5 ? 1.0 : std::nan(""); });
    EXPECT_TRUE(looksInverted(depth));
}

TEST(DepthDirection, AsksForAnEstimateOnlyIfTheOtherSignsAgree) {
    int calls = 0;
    const auto agrees = [&] {
        ++calls;
        return turned(floorDepth());
    };
    EXPECT_FALSE(altiro3D::looksInverted(floorDepth(), agrees));
    EXPECT_EQ(calls, 0);
    EXPECT_FALSE(altiro3D::looksInverted(turned(floorDepth()), agrees));
    EXPECT_EQ(calls, 1);
    EXPECT_FALSE(altiro3D::looksInverted(turned(floorDepth()), [] { return cv::Mat(); }));
}

TEST(DepthDirection, RefusesOtherTypes) {
    const cv::Mat bytes(4, 4, CV_8UC1, cv::Scalar(0));
    const auto call = [](const cv::Mat& map) { return errorOf([&] { looksInverted(map); }); };
    for (const int type : {CV_8UC1, CV_64FC1})
        EXPECT_TRUE(
            holds(errorOf([&] { looksInverted(turned(floorDepth()), type); }), "estimate: "));
    EXPECT_EQ(call(bytes), "depth: is 4 x 4 px of CV_8UC1, expected CV_32FC1");
    EXPECT_EQ(call({}), "depth: is empty, expected CV_32FC1");
}

TEST(DepthDirection, KnowsTheTruthOfMiddlebury) {
    ALTIRO3D_REQUIRE_DATA("middlebury/scenes.csv");
    Count counts;
    for (const auto& files : altiro3D::test::listMiddlebury(dataPath("middlebury"))) {
        Scene scene;
        scene.photo = altiro3D::readPhoto(files.left);
        altiro3D::normalizeDepth(altiro3D::readDepthSamples(files.disparity), scene.depth);
        count(scene, counts);
    }
    ASSERT_GE(counts.all, 6);
    EXPECT_EQ(counts.asItIs, 0);
    EXPECT_EQ(counts.turnedRound, counts.all);
}

TEST(DepthDirection, RaisesNoFalseAlarmOnMeasuredDepth) {
    ALTIRO3D_TAKES(3);
    ALTIRO3D_REQUIRE_DATA("rgbd/slambook2");
    ALTIRO3D_REQUIRE_DATA("rgbd/moon_3dphoto/depth/moon.png");
    Count counts;
    for (const std::string i : {"1", "2", "3", "4", "5"}) {
        const std::string kinect = "rgbd/slambook2/ch5_rgbd/";
        const std::string room = "rgbd/slambook2/ch12_dense_rgbd/";
        counts = countPair(kinect + "color/" + i + ".png", kinect + "depth/" + i + ".pgm",
                           DepthKind::Metric, counts);
        counts = countPair(room + "color/" + i + ".png", room + "depth/" + i + ".png",
                           DepthKind::Metric, counts);
    }
    counts = countPair("rgbd/moon_3dphoto/image/moon.jpg", "rgbd/moon_3dphoto/depth/moon.png",
                       DepthKind::NearWhite, counts);
    EXPECT_EQ(counts.asItIs, 0) << "of " << counts.all;
    EXPECT_GE(counts.turnedRound, 4) << "of " << counts.all; // the camera looks level in most
    RecordProperty("turnedRound", counts.turnedRound);
}
