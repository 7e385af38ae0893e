#include "altiro3D/depth_source.hpp"

#include "depth/stereo/stereo_parts.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/middlebury.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"
#include "support/stereo_scene.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D::test {
namespace {

const cv::Size kSize = eyesSize();
const cv::Rect kThing = thingInLeft();

// Share of the px of a part whose disparity is within a tolerance in px.
double shareWithin(const cv::Mat& disparity, const cv::Rect& part, double px, double tolerance) {
    int within = 0;
    for (int y = part.y; y < part.y + part.height; ++y) {
        for (int x = part.x; x < part.x + part.width; ++x) {
            const double value = double(disparity.at<float>(y, x)) * disparity.cols;
            if (std::abs(value - px) <= tolerance) ++within;
        }
    }
    return static_cast<double>(within) / part.area();
}

const cv::Rect kInThing(160, 100, 100, 90);
const cv::Rect kWall(276, 20, 52, 260); // right of the thing, where both eyes see it

TEST(MatchStereo, FindsBothDepthsAndWhatOnlyOneEyeSees) {
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat disparity;
    const StereoMatch match = matchStereo(eyes.left, eyes.right, disparity);
    EXPECT_EQ(disparity.size(), kSize);
    EXPECT_TRUE(match.isReliable);
    EXPECT_FALSE(match.isFlat);
    EXPECT_FALSE(match.looksSwapped);
    EXPECT_GT(match.matchedShare, 0.85);
    EXPECT_NEAR(match.shift * kSize.width, 6, 0.1);
    EXPECT_NEAR(match.farthest * kSize.width, 6, 0.25);
    EXPECT_NEAR(match.nearest * kSize.width, 26, 0.25);
    EXPECT_GT(shareWithin(disparity, kInThing, 26, 0.25), 0.98);
    EXPECT_GT(shareWithin(disparity, kWall, 6, 0.25), 0.98);

    // the right eye does not see 20 columns of the wall at the left of the thing
    const cv::Rect hidden(kThing.x - 18, kInThing.y, 16, kInThing.height);
    EXPECT_GT(shareWithin(disparity, hidden, 6, 0.25), 0.95);
    // nor the first columns of the left picture
    EXPECT_GT(shareWithin(disparity, {0, 20, 6, 260}, 6, 0.25), 0.98);
}

struct Turned {
    int wall;
    int thing;
    double rows;    // px
    double degrees; // clockwise
    double gain;
    double offset;
};

TEST(MatchStereo, TheRightEyeShowsWhatIsHiddenFromTheLeftOne) {
    const int kWallShift = 6;
    const Eyes eyes = wallAndThing(kWallShift, 26);
    cv::Mat disparity;
    HiddenLayer hidden;
    ASSERT_TRUE(matchStereo(eyes.left, eyes.right, disparity, &hidden).isReliable);
    ASSERT_EQ(hidden.photo.size(), kSize);
    ASSERT_EQ(hidden.depth.size(), kSize);
    // behind the last 20 columns of the thing, without the px that the matcher smears
    const cv::Rect seen(kThing.br().x - 17, kInThing.y, 14, kInThing.height);
    EXPECT_GT(shareWithin(hidden.depth, seen, kWallShift, 0.25), 0.95);
    double difference = 0;
    for (int y = seen.y; y < seen.br().y; ++y) {
        for (int x = seen.x; x < seen.br().x; ++x) {
            for (int c = 0; c < 3; ++c)
                difference += std::abs(hidden.photo.at<cv::Vec3b>(y, x)[c] -
                                       eyes.right.at<cv::Vec3b>(y, x - kWallShift)[c]);
        }
    }
    EXPECT_LT(difference / (3 * seen.area()), 3); // the light of both pictures is made equal
    // nothing is known elsewhere
    cv::Mat known;
    cv::compare(hidden.depth, hidden.depth, known, cv::CMP_EQ); // NaN differs from itself
    known(cv::Rect(kThing.br().x - 22, kThing.y - 4, 26, kThing.height + 8)).setTo(0);
    EXPECT_LT(cv::countNonZero(known), kSize.area() / 200);

    matchStereo(eyes.left, eyes.left, disparity, &hidden);
    EXPECT_TRUE(hidden.photo.empty()); // flat
}

TEST(ScaleHiddenDepth, FollowsTheScaleOfTheDepth) {
    cv::Mat disparity(2, 5, CV_32FC1);
    for (int i = 0; i < 10; ++i)
        disparity.at<float>(i / 5, i % 5) = 0.01F * static_cast<float>(i) - 0.02F;
    cv::Mat depth = (disparity + 0.01F) / 0.05; // clamped at both ends
    depth = cv::min(cv::max(depth, 0), 1);
    const float unknown = std::numeric_limits<float>::quiet_NaN();
    HiddenLayer hidden{cv::Mat(1, 3, CV_8UC3, cv::Scalar::all(7)),
                       (cv::Mat_<float>(1, 3) << -0.06F, unknown, 0.015F)};
    scaleHiddenDepth(disparity, depth, hidden);
    EXPECT_NEAR(hidden.depth.at<float>(0, 0), -1, 1e-5);
    EXPECT_TRUE(std::isnan(hidden.depth.at<float>(0, 1)));
    EXPECT_NEAR(hidden.depth.at<float>(0, 2), 0.5, 1e-5);

    depth.setTo(0.5);
    disparity.setTo(0.01);
    scaleHiddenDepth(disparity, depth, hidden);
    EXPECT_TRUE(hidden.photo.empty());
    hidden.photo.create(1, 3, CV_8UC3);
    EXPECT_TRUE(holds(errorOf([&] { scaleHiddenDepth(disparity, depth.row(0), hidden); }),
                      "depth: has 5 x 1 px, expected the disparity's 5 x 2 px"));
}

class MatchStereoOf3dCamera : public testing::TestWithParam<Turned> {};

TEST_P(MatchStereoOf3dCamera, UndoesShiftRowsRotationAndExposure) {
    const Turned& turned = GetParam();
    Eyes eyes = wallAndThing(turned.wall, turned.thing);
    const cv::Point2d middle(0.5 * (kSize.width - 1), 0.5 * (kSize.height - 1));
    cv::Mat turn = cv::getRotationMatrix2D(middle, -turned.degrees, 1);
    turn.at<double>(1, 2) += turned.rows;
    cv::warpAffine(eyes.right, eyes.right, turn, kSize, cv::INTER_CUBIC, cv::BORDER_REFLECT);
    eyes.right.convertTo(eyes.right, -1, turned.gain, turned.offset);
    cv::Mat disparity;
    const StereoMatch match = matchStereo(eyes.left, eyes.right, disparity);
    EXPECT_TRUE(match.isReliable) << match.text();
    EXPECT_FALSE(match.looksSwapped);
    EXPECT_NEAR(match.verticalOffset * kSize.width, turned.rows, 0.3);
    EXPECT_NEAR(match.rollDegrees, turned.degrees, 0.1);
    EXPECT_GT(shareWithin(disparity, kInThing, turned.thing, 0.75), 0.95) << match.text();
    EXPECT_GT(shareWithin(disparity, kWall, turned.wall, 0.75), 0.95) << match.text();
}

INSTANTIATE_TEST_SUITE_P(All, MatchStereoOf3dCamera,
                         testing::Values(Turned{-64, -44, 0, 0, 1, 0}, // -16 % of the width
                                         Turned{-10, 12, 0, 0, 1, 0},  // around zero
                                         Turned{90, 110, 0, 0, 1, 0},  // all near
                                         Turned{4, 24, 5, 0, 1, 0},    // right one lower
                                         Turned{4, 24, -7, 0, 1, 0},   // right one higher
                                         Turned{4, 24, 2, 1.5, 1, 0},  // turned
                                         Turned{4, 24, 0, 0, 0.6, 10}, // darker
                                         Turned{-64, -44, -3, -1, 0.8, 30}));

TEST(MatchStereo, EqualPicturesAreFlat) {
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat disparity;
    const StereoMatch match = matchStereo(eyes.left, eyes.left, disparity);
    EXPECT_TRUE(match.isFlat);
    EXPECT_TRUE(match.isReliable);
    EXPECT_EQ(match.shift, 0);
    EXPECT_EQ(cv::countNonZero(disparity), 0);
    EXPECT_EQ(match.text(), "shift 0.0 %, 100 % matched, flat");
}

TEST(MatchStereo, SwappedEyesAreNoticed) {
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat disparity;
    const StereoMatch match = matchStereo(eyes.right, eyes.left, disparity);
    EXPECT_TRUE(match.looksSwapped);
    EXPECT_NEAR(match.shift * kSize.width, -6, 0.1);
}

TEST(MatchStereo, UnrelatedPicturesDoNotMatch) {
    ALTIRO3D_TAKES(5);
    const std::vector<cv::Mat> pictures = {randomPhoto(kSize, 1, 0),
                                           randomPhoto(kSize, 77, 0),
                                           randomPhoto(kSize, 3, 3),
                                           scenery(kSize, 4),
                                           scenery(kSize, 5),
                                           cv::Mat(kSize, CV_8UC3, cv::Scalar(9, 99, 200)),
                                           cv::Mat(kSize, CV_8UC3, cv::Scalar::all(0))};
    for (std::size_t a = 0; a < pictures.size(); ++a) {
        for (std::size_t b = 0; b < pictures.size(); ++b) {
            const bool isPlain = a >= 5;
            if (a == b && !isPlain) continue;
            cv::Mat disparity;
            const StereoMatch match = matchStereo(pictures[a], pictures[b], disparity);
            EXPECT_FALSE(match.isReliable)
                << a << ' ' << b << ' ' << match.text() << ' ' << match.likeness;
            EXPECT_LT(match.matchedShare, 0.22);
            ASSERT_FALSE(disparity.empty());
        }
    }
}

TEST(MatchStereo, TinyPicturesAreFlatAndNotReliable) {
    for (const cv::Size size :
         {cv::Size(1, 1), cv::Size(2, 1), cv::Size(1, 37), cv::Size(15, 200), cv::Size(3000, 2)}) {
        cv::Mat disparity;
        const StereoMatch match =
            matchStereo(randomPhoto(size, 1, 0), randomPhoto(size, 77, 0), disparity);
        EXPECT_FALSE(match.isReliable);
        EXPECT_TRUE(match.isFlat);
        EXPECT_EQ(cv::countNonZero(disparity), 0);
    }
    for (const cv::Size size : {cv::Size(16, 16), cv::Size(17, 61), cv::Size(97, 31)}) {
        const cv::Mat photo = randomPhoto(size, 1);
        cv::Mat disparity;
        EXPECT_LE(matchStereo(photo, photo, disparity).matchedShare, 1);
        EXPECT_EQ(disparity.size(), size);
    }
}

TEST(MatchStereo, ASlightlyLargerRightPictureIsFitted) {
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat larger;
    cv::resize(eyes.right, larger, {}, 2.5, 2.52, cv::INTER_CUBIC);
    cv::Mat disparity;
    EXPECT_TRUE(matchStereo(eyes.left, larger, disparity).isReliable);
    EXPECT_GT(shareWithin(disparity, kInThing, 26, 0.5), 0.95);
    EXPECT_EQ(errorOf([&] {
                  static_cast<void>(matchStereo(eyes.left, eyes.right.rowRange(0, 200), disparity));
              }),
              "right: has 400 x 200 px, expected the shape of the left 400 x 300 px");
    EXPECT_EQ(errorOf([&] { return matchStereo({}, eyes.right, disparity); }),
              "left: is empty, expected CV_8UC3 (8-bit BGR)");
}

TEST(MatchStereo, LargePicturesAreMatchedSmall) {
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat left;
    cv::Mat right;
    cv::resize(eyes.left, left, {}, 8, 8, cv::INTER_CUBIC);
    cv::resize(eyes.right, right, {}, 8, 8, cv::INTER_CUBIC);
    cv::Mat disparity;
    const StereoMatch match = matchStereo(left, right, disparity);
    EXPECT_EQ(disparity.size(), cv::Size(1000, 750));
    EXPECT_TRUE(match.isReliable);
    EXPECT_NEAR(match.nearest, 26.0 / kSize.width, 0.001);
    EXPECT_NEAR(match.farthest, 6.0 / kSize.width, 0.001);
}

TEST(MatchStereo, HalvesOfOnePictureAreReadAlone) {
    const Eyes eyes = wallAndThing(-20, 13);
    cv::Mat expected;
    matchStereo(eyes.left, eyes.right, expected);
    cv::Mat both;
    cv::hconcat(eyes.left, eyes.right, both);
    cv::Mat disparity;
    matchStereo(both.colRange(0, kSize.width), both.colRange(kSize.width, both.cols), disparity);
    EXPECT_TRUE(samePicture(disparity, expected));
}

TEST(MatchStereo, ThreadsDoNotChangeTheResult) {
    Eyes eyes = wallAndThing(-20, 13);
    cv::warpAffine(eyes.right, eyes.right, cv::Matx23d(1, 0.001, 0, 0.01, 1, 3), kSize,
                   cv::INTER_LINEAR, cv::BORDER_REFLECT);
    const int threads = cv::getNumThreads();
    cv::setNumThreads(1);
    cv::Mat one;
    const StereoMatch serial = matchStereo(eyes.left, eyes.right, one);
    cv::setNumThreads(4);
    cv::Mat four;
    const StereoMatch parallel = matchStereo(eyes.left, eyes.right, four);
    cv::setNumThreads(threads);
    EXPECT_TRUE(samePicture(four, one));
    EXPECT_EQ(parallel.verticalOffset, serial.verticalOffset);
    EXPECT_EQ(parallel.rollDegrees, serial.rollDegrees);
    EXPECT_EQ(parallel.matchedShare, serial.matchedShare);
}

TEST(FitRows, FindsOffsetSlopeAndStretch) {
    cv::Mat left;
    cv::cvtColor(randomPhoto({640, 480}, 8), left, cv::COLOR_BGR2GRAY);
    const double x = 0.5 * (left.cols - 1);
    const double y = 0.5 * (left.rows - 1);
    constexpr double kOffset = 4.5;
    constexpr double kSlope = 0.012;
    constexpr double kStretch = -0.01;
    // right(x, row + offset + slope x + stretch row) = left(x, row), so right(x, r) = left(x, row)
    // with row = (r - offset - slope x) / (1 + stretch)
    cv::Mat right;
    const double factor = 1 / (1 + kStretch);
    const cv::Matx23d from(1, 0, 0, -kSlope * factor, factor,
                           y + factor * (kSlope * x - kOffset - y));
    cv::warpAffine(left, right, from, left.size(), cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                   cv::BORDER_REFLECT);
    const RowFit fit = fitRows(left, right);
    EXPECT_NEAR(fit.offset, kOffset, 0.05);
    EXPECT_NEAR(fit.slope, kSlope, 0.0005);
    EXPECT_NEAR(fit.stretch, kStretch, 0.0005);
    const RowFit none = fitRows(left, left);
    EXPECT_NEAR(none.offset, 0, 0.01); // of a parabola through three correlations
    EXPECT_NEAR(none.slope, 0, 0.0001);
}

TEST(FitRows, UprightStripesSayNothingAboutRows) {
    cv::Mat stripes(480, 640, CV_8UC1);
    for (int x = 0; x < stripes.cols; ++x)
        stripes.col(x).setTo(cv::Scalar((x * 37 + x * x) % 251));
    const RowFit fit = fitRows(stripes, stripes);
    EXPECT_EQ(fit.offset, 0);
    EXPECT_EQ(fit.blocks, 0);
    EXPECT_GT(fit.textured, 100);
}

TEST(MatchStereo, RealPairsComeCloseToTheTruth) {
    ALTIRO3D_TAKES(3);
    ALTIRO3D_REQUIRE_DATA("middlebury/scenes.csv");
    int scenes = 0;
    for (const MiddleburyFiles& files : listMiddlebury(dataPath("middlebury"))) {
        const cv::Mat left = cv::imread(files.left.string());
        const cv::Mat right = cv::imread(files.right.string());
        cv::Mat truth = cv::imread(files.disparity.string(), cv::IMREAD_UNCHANGED);
        if (left.empty() || right.empty() || truth.empty()) continue;
        truth.convertTo(truth, CV_32F, 1 / files.scale);
        cv::Mat disparity;
        const StereoMatch match = matchStereo(left, right, disparity);
        EXPECT_TRUE(match.isReliable) << files.name << ' ' << match.text();
        EXPECT_GT(match.likeness, 0.6) << files.name;
        EXPECT_FALSE(match.looksSwapped) << files.name;
        ASSERT_EQ(disparity.size(), left.size());
        int known = 0;
        int right1px = 0;
        forPixels(left.size(), [&](int x, int y) {
            const float real = truth.at<float>(y, x);
            const float found = disparity.at<float>(y, x) * static_cast<float>(left.cols);
            if (!std::isfinite(real) || real <= 0) return;
            ++known;
            if (std::abs(found - real) <= 1) ++right1px;
        });
        EXPECT_GT(right1px, 0.72 * known) << files.name; // hidden px included
        const StereoMatch swapped = matchStereo(right, left, disparity);
        EXPECT_TRUE(swapped.looksSwapped) << files.name;
        ++scenes;
    }
    EXPECT_GE(scenes, 1);
}

} // namespace
} // namespace altiro3D::test
