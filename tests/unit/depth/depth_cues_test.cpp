#include "altiro3D/depth_source.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/trade.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/middlebury.hpp"
#include "support/processors.hpp"
#include "support/reference.hpp"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

using altiro3D::estimateDepthFromCues;
using altiro3D::rankCorrelation;
using altiro3D::test::dataPath;
using altiro3D::test::errorOf;
using altiro3D::test::forEachInstructionSet;
using altiro3D::test::referenceDepthFromCues;
using altiro3D::test::RestoredThreads;
using altiro3D::test::samePicture;
using altiro3D::test::sourcePath;

namespace {

cv::Mat depthOf(const cv::Mat& photo) {
    cv::Mat depth;
    estimateDepthFromCues(photo, depth);
    return depth;
}

// Every sample a number within 0..1, the type and shape of the contract.
void expectValidDepth(const cv::Mat& depth, const cv::Mat& photo) {
    ASSERT_EQ(depth.type(), CV_32FC1);
    ASSERT_GE(depth.cols, 1);
    ASSERT_GE(depth.rows, 1);
    EXPECT_LE(depth.cols, photo.cols);
    EXPECT_LE(depth.rows, photo.rows);
    int bad = 0;
    for (int y = 0; y < depth.rows; ++y)
        for (int x = 0; x < depth.cols; ++x)
            if (!(depth.at<float>(y, x) >= 0 && depth.at<float>(y, x) <= 1)) ++bad;
    EXPECT_EQ(bad, 0);
}

// Deterministic noise, 0..range-1.
int noise(int x, int y, int range) {
    std::uint32_t h =
        static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U;
    h = (h ^ (h >> 13)) * 1274126177U;
    return static_cast<int>((h ^ (h >> 16)) % static_cast<std::uint32_t>(range));
}

cv::Mat noisePhoto(const cv::Size& size) {
    cv::Mat photo(size, CV_8UC3);
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x)
            photo.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<uchar>(noise(x, y, 256)),
                                                  static_cast<uchar>(noise(x + 1000, y, 256)),
                                                  static_cast<uchar>(noise(x, y + 1000, 256)));
    return photo;
}

// A meadow below a pale, hazy and blurred backdrop, and on it a sharp, red, speckled post:
//
//    ~~~~~~~~~~~~~~~   sky
//    ~~~~~~#~~~~~~~~   hills
//    ......#........   meadow
//    ......#........
//    ...............
cv::Mat meadow(const cv::Size& size) {
    cv::Mat photo(size, CV_8UC3);
    const int horizon = size.height * 45 / 100;
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            cv::Vec3b& pixel = photo.at<cv::Vec3b>(y, x);
            if (y < horizon / 2) {
                pixel = cv::Vec3b(235, 215, 200);
            } else if (y < horizon) {
                pixel = cv::Vec3b(200, 195, 180);
            } else {
                const int speckle = noise(x / 2, y / 2, 30);
                pixel =
                    cv::Vec3b(static_cast<uchar>(40 + speckle), static_cast<uchar>(120 + speckle),
                              static_cast<uchar>(60 + speckle));
            }
        }
    }
    cv::Mat backdrop = photo.rowRange(0, horizon);
    cv::blur(backdrop, backdrop, cv::Size(15, 15));
    for (int y = size.height * 25 / 100; y < size.height * 80 / 100; ++y)
        for (int x = size.width * 40 / 100; x < size.width * 52 / 100; ++x)
            photo.at<cv::Vec3b>(y, x) = cv::Vec3b(30, static_cast<uchar>(30 + noise(x, y, 30)),
                                                  static_cast<uchar>(190 + noise(y, x, 50)));
    return photo;
}

double meanOf(const cv::Mat& depth, double left, double top, double right, double bottom) {
    const cv::Rect part(
        cv::Point(static_cast<int>(left * depth.cols), static_cast<int>(top * depth.rows)),
        cv::Point(static_cast<int>(right * depth.cols), static_cast<int>(bottom * depth.rows)));
    return cv::mean(depth(part))[0];
}

cv::Mat verticalGradient(const cv::Size& size) {
    cv::Mat gradient(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y)
        gradient.row(y).setTo(y);
    return gradient;
}

struct Score {
    double builtIn = 0;
    double gradient = 0;
};

// Rank correlation with what is known of the truth (larger = nearer, 0 and inf = unknown).
Score score(const cv::Mat& photo, const cv::Mat& nearness) {
    cv::Mat truth;
    nearness.convertTo(truth, CV_32F);
    cv::Mat known(truth.size(), CV_8UC1);
    for (int y = 0; y < truth.rows; ++y)
        for (int x = 0; x < truth.cols; ++x) {
            float& value = truth.at<float>(y, x);
            const bool valid = std::isfinite(value) && value > 0;
            known.at<uchar>(y, x) = valid ? 255 : 0;
            if (!valid) value = 0;
        }
    cv::Mat depth = depthOf(photo);
    cv::resize(depth, depth, photo.size(), 0, 0, cv::INTER_LINEAR);
    return {rankCorrelation(depth, truth, known),
            rankCorrelation(verticalGradient(photo.size()), truth, known)};
}

} // namespace

TEST(DepthCues, EverySizeAndContentGivesADefinedDepth) {
    const std::vector<cv::Size> sizes{{1, 1},   {2, 1},   {1, 2},   {2, 2},     {3, 5},    {1, 700},
                                      {700, 1}, {7, 331}, {331, 7}, {320, 320}, {321, 319}};
    const std::vector<cv::Scalar> colours{{0, 0, 0}, {255, 255, 255}, {255, 0, 0}, {90, 120, 130}};
    for (const cv::Size& size : sizes) {
        for (const cv::Scalar& colour : colours) {
            const cv::Mat photo(size, CV_8UC3, colour);
            expectValidDepth(depthOf(photo), photo);
        }
        const cv::Mat photo = noisePhoto(size);
        expectValidDepth(depthOf(photo), photo);
        cv::Mat extremes;
        cv::compare(photo, cv::Scalar(128, 128, 128), extremes, cv::CMP_GT); // only 0 and 255
        expectValidDepth(depthOf(extremes), extremes);
    }
}

TEST(DepthCues, OnePixelIsInTheMiddle) {
    EXPECT_TRUE(samePicture(depthOf(cv::Mat(1, 1, CV_8UC3, cv::Scalar(10, 20, 30))),
                            cv::Mat(1, 1, CV_32FC1, cv::Scalar(0.5))));
}

TEST(DepthCues, AnUnstructuredPhotoComesNearerDownwards) {
    const cv::Mat depth = depthOf(cv::Mat(90, 120, CV_8UC3, cv::Scalar(100, 100, 100)));
    for (int y = 1; y < depth.rows; ++y)
        EXPECT_GE(meanOf(depth.row(y), 0, 0, 1, 1), meanOf(depth.row(y - 1), 0, 0, 1, 1));
    EXPECT_LT(meanOf(depth.row(0), 0, 0, 1, 1), 0.2);
    EXPECT_GT(meanOf(depth.row(depth.rows - 1), 0, 0, 1, 1), 0.9);
}

TEST(DepthCues, ALargePhotoGivesASmallDepthOfTheSameShape) {
    const cv::Mat depth = depthOf(noisePhoto(cv::Size(1600, 1200)));
    EXPECT_LE(depth.cols, 640);
    EXPECT_NEAR(static_cast<double>(depth.cols) / depth.rows, 4.0 / 3, 0.02);
}

TEST(DepthCues, TheNumberOfThreadsDoesNotChangeABit) {
    const RestoredThreads restored;
    for (const cv::Mat& photo :
         {meadow(cv::Size(641, 479)), noisePhoto(cv::Size(97, 53)), meadow(cv::Size(1500, 2003))}) {
        cv::setNumThreads(1);
        const cv::Mat expected = depthOf(photo);
        for (const int threads : {2, 3, 5}) {
            cv::setNumThreads(threads);
            EXPECT_TRUE(samePicture(depthOf(photo), expected)) << threads << " threads";
        }
    }
}

// Few colours and flat parts have many equal differences, where the order of the scans matters.
TEST(DepthCues, TheResultIsThatOfTheSlowTwinOnAllInstructionSets) {
    std::vector<cv::Mat> photos;
    for (const cv::Size& size : {cv::Size(1, 1), cv::Size(2, 3), cv::Size(1, 47), cv::Size(53, 1),
                                 cv::Size(17, 16), cv::Size(97, 53), cv::Size(331, 239)}) {
        photos.push_back(noisePhoto(size));
        photos.emplace_back(photos.back() & cv::Scalar::all(0xC0));
        photos.emplace_back();
        cv::GaussianBlur(noisePhoto(size), photos.back(), {}, 4);
    }
    photos.push_back(meadow(cv::Size(1203, 902)));
    photos.push_back(cv::imread(sourcePath("docs/examples/sample.jpg").string()));
    for (const cv::Mat& photo : photos) {
        const cv::Mat expected = referenceDepthFromCues(photo);
        forEachInstructionSet([&](const char* name) {
            EXPECT_TRUE(samePicture(depthOf(photo), expected)) << name << ", " << photo.size();
        });
    }
}

TEST(DepthCues, ASubMatrixIsReadWithItsStep) {
    const cv::Mat frame = noisePhoto(cv::Size(211, 173));
    const cv::Mat part = frame(cv::Rect(31, 17, 101, 89));
    EXPECT_TRUE(samePicture(depthOf(part), depthOf(part.clone())));
}

TEST(DepthCues, TheResultIsWrittenIntoAReusedMatrix) {
    const cv::Mat photo = meadow(cv::Size(160, 120));
    cv::Mat depth;
    estimateDepthFromCues(photo, depth);
    const uchar* memory = depth.data;
    estimateDepthFromCues(photo, depth);
    EXPECT_EQ(depth.data, memory);
}

// No tolerance: the estimate is the mean of the photo's and its mirror image's, and x + y = y + x.
TEST(DepthCues, AMirroredPhotoHasTheMirroredDepth) {
    for (const cv::Mat& photo :
         {meadow(cv::Size(640, 480)), noisePhoto(cv::Size(101, 67)), meadow(cv::Size(997, 601))}) {
        cv::Mat mirrored;
        cv::flip(photo, mirrored, 1);
        cv::Mat expected;
        cv::flip(depthOf(photo), expected, 1);
        EXPECT_TRUE(samePicture(depthOf(mirrored), expected));
    }
}

TEST(DepthCues, InAMeadowTheSkyIsFarAndTheGroundIsNear) {
    const cv::Mat depth = depthOf(meadow(cv::Size(640, 480)));
    const double sky = meanOf(depth, 0, 0, 0.3, 0.18);
    const double hills = meanOf(depth, 0, 0.28, 0.3, 0.42);
    const double ground = meanOf(depth, 0, 0.85, 1, 1);
    EXPECT_LT(sky, hills);
    EXPECT_LT(hills + 0.2, ground);
}

TEST(DepthCues, AnUprightThingStandsBeforeItsBackdropAsNearAsItsFoot) {
    const cv::Mat depth = depthOf(meadow(cv::Size(640, 480)));
    const double head = meanOf(depth, 0.43, 0.28, 0.49, 0.42);
    const double foot = meanOf(depth, 0.43, 0.62, 0.49, 0.76);
    const double backdrop = meanOf(depth, 0.05, 0.28, 0.30, 0.42);
    EXPECT_GT(head, backdrop + 0.15);
    EXPECT_LT(std::abs(head - foot), 0.5 * (head - backdrop));
}

TEST(DepthCues, SpeckleOnASurfaceDoesNotShowInItsDepth) {
    const cv::Mat depth = depthOf(meadow(cv::Size(320, 240)));
    // Along a row of the meadow, clear of the post; the photo varies by 30 of 255 there.
    const cv::Mat row = depth.row(220).colRange(20, 300);
    double low = 0;
    double high = 0;
    cv::minMaxLoc(row, &low, &high);
    EXPECT_LT(high - low, 0.06);
}

TEST(DepthCues, AnEmptyOrWrongPhotoIsRefused) {
    cv::Mat depth;
    EXPECT_EQ(errorOf([&] { estimateDepthFromCues(cv::Mat(), depth); }),
              "photo: is empty, expected CV_8UC3 (8-bit BGR)");
    EXPECT_EQ(errorOf([&] { estimateDepthFromCues(cv::Mat(4, 4, CV_8UC1, cv::Scalar(0)), depth); }),
              "photo: is 4 x 4 px of CV_8UC1, expected CV_8UC3 (8-bit BGR)");
    EXPECT_EQ(
        errorOf([&] { estimateDepthFromCues(cv::Mat(4, 4, CV_32FC3, cv::Scalar(0)), depth); }),
        "photo: is 4 x 4 px of CV_32FC3, expected CV_8UC3 (8-bit BGR)");
}

TEST(DepthCues, OnTrueDepthItBeatsAVerticalGradient) {
    ALTIRO3D_REQUIRE_DATA("middlebury");
    const std::vector<altiro3D::test::MiddleburyFiles> scenes =
        altiro3D::test::listMiddlebury(dataPath("middlebury"));
    ASSERT_FALSE(scenes.empty());
    double gain = 0;
    for (const altiro3D::test::MiddleburyFiles& scene : scenes) {
        const cv::Mat photo = cv::imread(scene.left.string());
        const cv::Mat disparity = cv::imread(scene.disparity.string(), cv::IMREAD_UNCHANGED);
        ASSERT_FALSE(photo.empty() || disparity.empty()) << scene.name;
        const Score scored = score(photo, disparity);
        EXPECT_GT(scored.builtIn, scored.gradient - 0.02) << scene.name;
        gain += scored.builtIn - scored.gradient;
    }
    EXPECT_GT(gain / static_cast<double>(scenes.size()), 0.02);
}

TEST(DepthCues, InRoomsItBeatsAVerticalGradient) {
    ALTIRO3D_REQUIRE_DATA("rgbd/slambook2");
    double gain = 0;
    int count = 0;
    for (int i = 1; i <= 5; ++i) {
        for (const auto& [set, extension] : std::vector<std::pair<std::string, std::string>>{
                 {"ch5_rgbd", ".pgm"}, {"ch12_dense_rgbd", ".png"}}) {
            const std::filesystem::path folder = dataPath("rgbd/slambook2") / set;
            const std::string number = std::to_string(i);
            const cv::Mat photo = cv::imread((folder / "color" / (number + ".png")).string());
            const cv::Mat distance = cv::imread((folder / "depth" / (number + extension)).string(),
                                                cv::IMREAD_UNCHANGED);
            ASSERT_FALSE(photo.empty() || distance.empty()) << set << " " << number;
            cv::Mat inverse;
            distance.convertTo(inverse, CV_32F);
            cv::divide(1.0, inverse, inverse); // 1 / 0 stays unknown: 0 or infinite
            const Score scored = score(photo, inverse);
            gain += scored.builtIn - scored.gradient;
            ++count;
        }
    }
    EXPECT_GT(gain / count, 0.02);
}
