#include "depth/refine/depth_steps.hpp"

#include "support/compare.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"
#include "support/slow.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

struct World {
    cv::Mat photo;
    cv::Mat depth;
};

// A texture of a few levels.
cv::Mat textured(cv::Size size, const cv::Scalar& color, int seed = 1) {
    return cv::Mat(size, CV_8UC3, color) + randomPicture(size, CV_8UC3, seed, 0, 16);
}

// The depth of two surfaces, and the px of the near one.
constexpr double kFar = 0.3;
constexpr double kNear = 0.7;
const cv::Size kSize(512, 160);

// A near thing in the right half, with a wavy border.
cv::Mat nearPixels() {
    cv::Mat isNear(kSize, CV_8UC1, cv::Scalar(0));
    for (int y = 0; y < kSize.height; ++y) {
        const int border = 256 + cvRound(10 * std::sin(y / 25.0));
        isNear.row(y).colRange(border, kSize.width).setTo(255);
    }
    return isNear;
}

cv::Mat depthOf(const cv::Mat& isNear) {
    cv::Mat depth(isNear.size(), CV_32FC1, cv::Scalar(kFar));
    depth.setTo(kNear, isNear);
    return depth;
}

// As networks leave it: blurred, and beside its place.
cv::Mat softened(const cv::Mat& depth, double sigma, int right) {
    const cv::Mat by = (cv::Mat_<double>(2, 3) << 1, 0, right, 0, 1, 0);
    cv::Mat result;
    cv::warpAffine(depth, result, by, depth.size(), cv::INTER_NEAREST, cv::BORDER_REPLICATE);
    cv::GaussianBlur(result, result, {}, sigma);
    return result;
}

cv::Mat decided(const cv::Mat& photo, const cv::Mat& depth) {
    cv::Mat result = depth.clone();
    decideContours(photo, result);
    return result;
}

// Px that are on the wrong side. Those at the border belong to the near side, because photos mix
// both there, so the next px may be on either side.
int wrongSides(const cv::Mat& depth, const cv::Mat& isNear) {
    const cv::Mat result = depth > (kNear + kFar) / 2;
    cv::Mat wide;
    cv::dilate(isNear, wide, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
    return cv::countNonZero((isNear & ~result) | (result & ~wide));
}

// Px that are on neither side: a tenth of the step and more from both depths.
int softPixels(const cv::Mat& depth) {
    return cv::countNonZero((depth > kFar + 0.04) & (depth < kNear - 0.04));
}

// Blobs of several depths and softnesses under a photo that has some of their borders.
World randomWorld(cv::Size size, int seed) {
    World made{randomPhoto(size, seed), cv::Mat(size, CV_32FC1, cv::Scalar(0.3))};
    cv::RNG random(static_cast<std::uint64_t>(seed));
    const int unit = std::max(size.width, size.height);
    for (int i = 0; i < 6; ++i) {
        const cv::Point centre(random.uniform(0, size.width), random.uniform(0, size.height));
        const int radius = random.uniform(2, 3 + unit / 8);
        cv::circle(made.depth, centre, radius, cv::Scalar(random.uniform(0.0, 1.0)), cv::FILLED);
        cv::circle(made.photo, centre, radius + random.uniform(0, 1 + unit / 150),
                   cv::Scalar(random.uniform(0, 256), random.uniform(0, 256), 90), cv::FILLED);
        cv::GaussianBlur(made.depth, made.depth, {}, 0.3 + 0.001 * unit);
    }
    return made;
}

TEST(DepthContours, TheyAreThoseOfTheFormulas) {
    ALTIRO3D_TAKES(0.6);
    // the longest give lengths of 1 and 2 px per px of the formulas
    for (const cv::Size size :
         {cv::Size(61, 47), {131, 97}, {23, 521}, {1030, 13}, {1, 521}, {300, 1}, {2, 5}, {1, 1}}) {
        for (const int seed : {1, 2, 3}) {
            const World made = randomWorld(size, seed);
            const cv::Mat expected = referenceDecideContours(made.photo, made.depth);
            const cv::Mat result = decided(made.photo, made.depth);
            // float against double: a px at a threshold may fall on either side
            const Difference difference = compare(result, expected, 1e-4);
            EXPECT_LE(difference.count, difference.samples / 500)
                << size << " " << seed << difference.report;
            if (size.area() > 10000) { // in small pictures, hardly any step is steep enough
                EXPECT_GT(compare(result, made.depth, 0.02).count, 10U) << size << " " << seed;
            }
        }
    }
}

TEST(DepthContours, ASoftStepBesideItsPlaceBecomesHardAtTheBorderOfTheSurfaces) {
    const cv::Mat isNear = nearPixels();
    cv::Mat photo = textured(kSize, {90, 130, 60});
    textured(kSize, {40, 60, 180}, 2).copyTo(photo, isNear);
    for (const int right : {-3, 0, 3}) {
        for (const double sigma : {2.5, 4.0}) {
            const cv::Mat soft = softened(depthOf(isNear), sigma, right);
            const cv::Mat result = decided(photo, soft);
            if (right != 0) {
                EXPECT_GT(wrongSides(soft, isNear), 300) << right << " " << sigma;
            }
            EXPECT_LE(wrongSides(result, isNear), 5) << right << " " << sigma;
            EXPECT_GT(softPixels(soft), 1000) << right << " " << sigma;
            EXPECT_LE(softPixels(result), 5) << right << " " << sigma;
        }
    }
}

// Letters and stripes of other colours, some of them at the border of the thing.
TEST(DepthContours, PrintOnANearThingStaysNearAtItsBorder) {
    const cv::Mat isNear = nearPixels();
    cv::Mat photo = textured(kSize, {90, 130, 60});
    cv::Mat thing = textured(kSize, {40, 60, 180}, 2);
    for (int y = 0; y < kSize.height; y += 40)
        cv::putText(thing, "ALTIRO3D", {236, y + 20}, cv::FONT_HERSHEY_SIMPLEX, 0.9,
                    {230, 230, 230}, 4);
    for (int y = 30; y < kSize.height; y += 40)
        thing.rowRange(y, y + 8).setTo(cv::Scalar(200, 40, 30));
    thing.copyTo(photo, isNear);
    const cv::Mat soft = softened(depthOf(isNear), 3, 3);
    const cv::Mat result = decided(photo, soft);
    EXPECT_GT(wrongSides(soft, isNear), 300);
    EXPECT_LE(wrongSides(result, isNear), 5); // decided within the width of the step: 34 to 71
    EXPECT_LE(softPixels(result), 5);         // and 280 to 513
}

// Steep enough to be torn, but only the colours say where.
TEST(DepthContours, StepsBecomeHardOnlyWithEvidence) {
    const cv::Mat isNear = nearPixels();
    const cv::Mat plain = textured(kSize, {90, 130, 60});
    cv::Mat colored = plain.clone();
    textured(kSize, {40, 60, 180}, 2).copyTo(colored, isNear);
    const cv::Mat steep = softened(depthOf(isNear), 4, 0);
    EXPECT_TRUE(samePicture(decided(plain, steep), steep));
    EXPECT_LE(softPixels(decided(colored, steep)), 5);
    // a low step, like that of a fold
    const cv::Mat low = kFar + (softened(depthOf(isNear), 5, 0) - kFar) / 4;
    EXPECT_TRUE(samePicture(decided(plain, low), low));
    EXPECT_TRUE(samePicture(decided(colored, low), low));
}

TEST(DepthContours, SlopesStaySlopes) {
    const cv::Mat photo = randomPhoto(kSize, 1, 4);
    for (const double slope : {0.001, 0.004, 0.012}) { // in units of depth per px
        const cv::Mat depth = pictureOf<float>(kSize, [&](int x, int y) {
            return std::clamp(0.5 + slope * (x - 256 + (y - 80) / 3.0), 0.0, 1.0);
        });
        EXPECT_TRUE(samePicture(decided(photo, depth), depth)) << slope;
    }
}

TEST(DepthContours, FlatDepthStaysFlat) {
    for (const cv::Size size : {cv::Size(1, 1), {1, 40}, {40, 1}, {17, 3}, {97, 61}}) {
        const cv::Mat flat(size, CV_32FC1, cv::Scalar(0.4));
        EXPECT_TRUE(samePicture(decided(randomPhoto(size), flat), flat)) << size;
    }
}

TEST(DepthContours, TheyAreTheSameOnAllProcessorsAndThreads) {
    const World made = randomWorld({523, 97}, 1);
    cv::Mat first;
    const RestoredThreads restored;
    forEachInstructionSet([&](const char* name) {
        for (const int threads : {1, 2, 7}) {
            cv::setNumThreads(threads);
            const cv::Mat result = decided(made.photo, made.depth);
            if (first.empty()) first = result;
            EXPECT_TRUE(samePicture(result, first)) << name << " " << threads;
        }
    });
}

TEST(DepthContours, AMirroredSceneGivesTheMirroredResult) {
    const World made = randomWorld({523, 97}, 1);
    const cv::Mat result = decided(made.photo, made.depth);
    for (const int axis : {0, 1}) {
        World mirrored;
        cv::flip(made.photo, mirrored.photo, axis);
        cv::flip(made.depth, mirrored.depth, axis);
        cv::Mat expected;
        cv::flip(result, expected, axis);
        // the sums have another order
        EXPECT_TRUE(samePicture(decided(mirrored.photo, mirrored.depth), expected, 2e-5)) << axis;
    }
}

TEST(DepthContours, PartsOfPicturesAreWholePictures) {
    const World made = randomWorld({523, 97}, 1);
    const cv::Rect part(41, 13, 301, 67);
    cv::Mat depth = made.depth.clone();
    cv::Mat inside = depth(part);
    decideContours(made.photo(part), inside);
    EXPECT_TRUE(samePicture(inside, decided(made.photo(part).clone(), made.depth(part).clone())));
    EXPECT_GT(compare(inside, made.depth(part), 0.02).count, 10U);
    made.depth(part).copyTo(inside); // the rest has not changed
    EXPECT_TRUE(samePicture(depth, made.depth));
}

} // namespace
} // namespace altiro3D::test
