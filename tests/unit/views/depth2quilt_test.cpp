#include "altiro3D/depth2quilt.hpp"

#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

ViewOptions viewsOf(double strength, double focus, int refinement = 0) {
    ViewOptions options;
    options.method = ViewMethod::Fast;
    options.strengthPercent = strength;
    options.focus = focus;
    options.refinement = refinement;
    return options;
}

Depth2Quilt maker(double strength, double focus) {
    return Depth2Quilt({3, 2, {64, 48}, 6}, viewsOf(strength, focus));
}

// What holds for all methods is in view_methods_test.cpp.

TEST(Depth2Quilt, FastIsTheFormulaUpToRemapsFixedPoint) {
    const cv::Size sizes[] = {{1, 1}, {2, 3}, {61, 37}, {64, 48}, {128, 5}, {1, 40}, {40, 1}};
    for (const cv::Size size : sizes) {
        const cv::Mat photo = randomPhoto(size);
        const cv::Mat depth = randomDepth(size);
        for (double position : {-1.0, -0.4, 0.3, 1.0}) {
            cv::Mat view;
            maker(20, 0.4).renderView(photo, depth, position, view);
            const cv::Mat reference =
                referenceFast(photo, depth, position * 0.2 * size.width / 2, 0.4);
            cv::Mat expected;
            reference.convertTo(expected, CV_8UC3);
            // cv::remap places samples in steps of 1/32 px: up to 1/64 of the largest step of 255
            EXPECT_TRUE(samePicture(view, expected, 255 / 64.0 + 1)) << size << " " << position;
        }
    }
}

// Of a photo that is a ramp of 4 levels per px, a view tells the places it was sampled at.
TEST(Depth2Quilt, FastTakesPlacesToTheNearestOf32PerPixelAlmostAlways) {
    const cv::Size size(60, 40);
    cv::Mat photo(size, CV_8UC3);
    for (int x = 0; x < size.width; ++x)
        photo.col(x).setTo(cv::Scalar::all(4 * x));
    const cv::Mat depth = randomDepth(size);
    int unlike = 0;
    int all = 0;
    for (const double position : {-1.0, -0.37, 0.011, 0.7, 1.0}) {
        for (const double halfParallax : {0.5, 7.3, 63.9}) {
            const double strength = 200 * halfParallax / size.width;
            cv::Mat view;
            maker(strength, 0.4).renderView(photo, depth, position, view);
            for (int y = 0; y < size.height; ++y) {
                for (int x = 0; x < size.width; ++x) {
                    const long double exact =
                        std::clamp(x + static_cast<long double>(position) * halfParallax *
                                           (static_cast<long double>(depth.at<float>(y, x)) - 0.4L),
                                   0.0L, 59.0L);
                    // a place and the rounding of its level
                    const long double level = 4 * exact;
                    ASSERT_NEAR(view.at<cv::Vec3b>(y, x)[0], static_cast<double>(level),
                                4 * (1 / 64.0 + 1 / 128.0) + 0.5)
                        << x << " " << y << " " << position << " " << halfParallax;
                    const auto nearest = std::lround(std::round(exact * 32) / 8);
                    if (view.at<cv::Vec3b>(y, x)[0] != nearest) ++unlike;
                    ++all;
                }
            }
        }
    }
    EXPECT_LT(unlike, all / 20); // halves, and places that steps of shift and offset move
}

// A photo with margins, and the whole photo with the same shifts in px: the same views, cut.
TEST(Depth2Quilt, ViewsShowTheMarginsOfThePhoto) {
    const cv::Size whole(80, 48);
    const cv::Range shown(12, 72);
    const altiro3D::Scene all{randomPhoto(whole), randomDepth(whole)};
    altiro3D::Scene scene = all;
    scene.shown = shown;
    for (const ViewMethod method : {ViewMethod::Fast, ViewMethod::Real, ViewMethod::Layered}) {
        ViewOptions options = viewsOf(20, 0.4); // 6 px of 60
        options.method = method;
        ViewOptions same = options;
        same.strengthPercent = 15; // 6 px of 80
        for (const cv::Size tile : {cv::Size(60, 48), cv::Size(25, 20)}) {
            const QuiltLayout layout{3, 2, tile, 5};
            cv::Mat quilt;
            Depth2Quilt(layout, options).render(scene, quilt);
            ASSERT_EQ(quilt.size(), layout.size());
            for (int i = 0; i < layout.viewCount; ++i) {
                const double position = -1 + 0.5 * i;
                cv::Mat view;
                cv::Mat expected;
                Depth2Quilt(layout, options).renderView(scene, position, view);
                Depth2Quilt(layout, same).renderView(all, position, expected);
                EXPECT_TRUE(samePicture(view, expected.colRange(shown))) << position;
                cv::resize(view, view, tile, 0, 0, cv::INTER_AREA);
                EXPECT_TRUE(samePicture(quilt(layout.tile(i)), view)) << position;
            }
        }
    }
    scene.shown = {12, 81};
    cv::Mat view;
    EXPECT_NE(errorOf([&] {
                  maker(10, 0.5).renderView(scene, 1, view);
              }).find("shown columns: are 12..80, expected columns of the photo, 0..79"),
              std::string::npos);
    scene.shown = {};
    for (const int width : {-1, 8}) {
        scene.mixedPixels = width;
        EXPECT_NE(errorOf([&] { maker(10, 0.5).renderView(scene, 1, view); }).find("mixed px: is"),
                  std::string::npos);
    }
}

// The rule of signs: nearer things move against the camera.
TEST(Depth2Quilt, NearThingsMoveAgainstTheCamera) {
    cv::Mat photo(9, 200, CV_8UC3, cv::Scalar::all(0));
    photo.colRange(100, 104).setTo(cv::Scalar::all(255)); // a bright bar
    const cv::Mat near(photo.size(), CV_32FC1, cv::Scalar::all(1));
    const cv::Mat far(photo.size(), CV_32FC1, cv::Scalar::all(0));
    const auto barAt = [&](const cv::Mat& depth, double position) {
        cv::Mat view;
        Depth2Quilt({1, 1, {9, 9}, 1}, viewsOf(10, 0.5)).renderView(photo, depth, position, view);
        cv::Mat grey;
        cv::cvtColor(view, grey, cv::COLOR_BGR2GRAY);
        const cv::Moments moments = cv::moments(grey);
        return moments.m10 / moments.m00;
    };
    // S = 10 % of 200 = 20 px; shift = -p (d - f) S/2 = -p * 0.5 * 10 = 5 px against the camera
    EXPECT_NEAR(barAt(near, 1), 101.5 - 5, 0.01);
    EXPECT_NEAR(barAt(near, -1), 101.5 + 5, 0.01);
    EXPECT_NEAR(barAt(far, 1), 101.5 + 5, 0.01);
    EXPECT_NEAR(barAt(far, -1), 101.5 - 5, 0.01);
}

// On a slanted plane the place that a px comes from has a closed form: x' = x - s (a + b x - f).
TEST(Depth2Quilt, RefinementReadsDepthWhereThePixelComesFrom) {
    const cv::Size size(200, 3);
    cv::Mat photo(size, CV_8UC3);
    cv::Mat depth(size, CV_32FC1);
    for (int x = 0; x < size.width; ++x) {
        photo.col(x).setTo(cv::Scalar::all(x));
        depth.col(x).setTo(0.1 + 0.004 * x);
    }
    const double shift = 40; // S = 80 px
    const auto largestError = [&](int refinement) {
        cv::Mat view;
        Depth2Quilt({1, 1, {9, 9}, 1}, viewsOf(40, 0.5, refinement))
            .renderView(photo, depth, 1, view);
        double largest = 0;
        for (int x = 0; x < size.width; ++x) {
            const double from = (x + shift * (0.1 - 0.5)) / (1 - shift * 0.004);
            if (from < 1 || from > 198) continue;
            largest = std::max(largest, std::abs(view.at<cv::Vec3b>(1, x)[0] - from));
        }
        return largest;
    };
    // the error falls by shift * slope = 0.16 with each step, down to 8-bit rounding
    EXPECT_GT(largestError(0), 2);
    EXPECT_LT(largestError(1), 0.16 * largestError(0) + 1);
    EXPECT_LT(largestError(4), 0.6);
    EXPECT_NE(errorOf([] {
                  Depth2Quilt({1, 1, {9, 9}, 1}, viewsOf(10, 0.5, 17));
              }).find("refinement: is 17, expected 0..16"),
              std::string::npos);
}

TEST(Depth2Quilt, UnusedTilesAreBlackEvenInAReusedQuilt) {
    const cv::Mat photo = randomPhoto({8, 8});
    cv::Mat quilt(16, 24, CV_8UC3, cv::Scalar::all(99));
    const Depth2Quilt five({3, 2, {8, 8}, 5});
    const uchar* memory = quilt.data;
    five.render(photo, randomDepth({8, 8}), quilt);
    EXPECT_EQ(quilt.data, memory);
    EXPECT_EQ(cv::countNonZero(quilt(five.layout().tile(4)).clone().reshape(1)) > 0, true);
    EXPECT_EQ(cv::countNonZero(quilt(cv::Rect(16, 0, 8, 8)).clone().reshape(1)), 0);
}

TEST(Depth2Quilt, WildDepthIsClampedAndNanIsFar) {
    const cv::Size size(33, 9);
    const cv::Mat photo = randomPhoto(size);
    const float kWild[] = {std::numeric_limits<float>::infinity(), 7.0F, 1e38F};
    cv::Mat expected;
    cv::Mat view;
    maker(40, 0.5).renderView(photo, cv::Mat(size, CV_32FC1, cv::Scalar::all(1)), 1, expected);
    for (float value : kWild) {
        maker(40, 0.5).renderView(photo, cv::Mat(size, CV_32FC1, cv::Scalar::all(value)), 1, view);
        EXPECT_TRUE(samePicture(view, expected)) << value;
    }
    maker(40, 0.5).renderView(photo, cv::Mat(size, CV_32FC1, cv::Scalar::all(0)), 1, expected);
    for (float value : {std::nanf(""), -3.0F, -std::numeric_limits<float>::infinity(), 1e-42F}) {
        maker(40, 0.5).renderView(photo, cv::Mat(size, CV_32FC1, cv::Scalar::all(value)), 1, view);
        EXPECT_TRUE(samePicture(view, expected)) << value;
    }
}

TEST(Depth2Quilt, OffsetsOfManyWidthsRepeatTheBorder) {
    const cv::Mat photo = randomPhoto({50, 7});
    const cv::Mat near(photo.size(), CV_32FC1, cv::Scalar::all(1));
    cv::Mat view;
    maker(10000, 0).renderView(photo, near, 1, view);
    EXPECT_TRUE(samePicture(view, cv::repeat(photo.col(49), 1, 50)));
    maker(10000, 0).renderView(photo, near, -1e300, view);
    EXPECT_TRUE(samePicture(view, cv::repeat(photo.col(0), 1, 50)));
}

TEST(Depth2Quilt, WrongInputsAreRefusedByName) {
    cv::Mat out;
    const cv::Mat photo(48, 64, CV_8UC3);
    const cv::Mat depth(48, 64, CV_32FC1);
    const auto error = [&](const cv::Mat& p, const cv::Mat& d) {
        return errorOf([&] { maker(10, 0.5).render(p, d, out); });
    };
    EXPECT_NE(error(cv::Mat(), depth).find("photo: "), std::string::npos);
    EXPECT_NE(error(cv::Mat(48, 64, CV_8UC1), depth).find("CV_8UC1"), std::string::npos);
    EXPECT_NE(error(photo, cv::Mat(48, 64, CV_8UC1)).find("depth: is 64 x 48 px of CV_8UC1"),
              std::string::npos);
    EXPECT_NE(error(photo, cv::Mat(47, 64, CV_32FC1)).find("depth: has 64 x 47 px"),
              std::string::npos);
    EXPECT_NE(errorOf([&] {
                  maker(10, 0.5).renderView(photo, depth, std::nan(""), out);
              }).find("position"),
              std::string::npos);
    EXPECT_NE(errorOf([] { maker(-1, 0.5); }).find("strength: is -1"), std::string::npos);
    EXPECT_NE(errorOf([] { maker(std::nan(""), 0.5); }).find("strength: is nan"),
              std::string::npos);
    EXPECT_NE(errorOf([] { maker(10, 1.5); }).find("focus: is 1.5, expected a depth"),
              std::string::npos);
}

TEST(Depth2Quilt, ItsInputsAreNoPlaceForTheQuilt) {
    const cv::Size quilt(192, 96);
    for (const cv::Size size : {quilt, cv::Size(400, 300)}) { // fits the quilt, and is reallocated
        cv::Mat photo = randomPhoto(size);
        cv::Mat depth = randomDepth(size);
        EXPECT_EQ(errorOf([&] { maker(10, 0.5).render(photo, depth, photo); }),
                  "quilt: shares its memory with the photo, expected a picture of its own");
        EXPECT_EQ(errorOf([&] { maker(10, 0.5).render(photo, depth, depth); }),
                  "quilt: shares its memory with the depth, expected a picture of its own");
        EXPECT_EQ(photo.size(), size);
    }
}

TEST(Depth2Quilt, PartsOfOneCanvasThatLieApartArePicturesOfTheirOwn) {
    cv::Mat canvas(200, 300, CV_8UC3, cv::Scalar::all(7));
    const cv::Mat depth = randomDepth({64, 48});
    cv::Mat photo = canvas(cv::Rect(200, 60, 64, 48)); // to the right of the quilt, in its rows
    randomPhoto({64, 48}).copyTo(photo);
    cv::Mat expected;
    maker(20, 0.5).render(photo.clone(), depth, expected);
    cv::Mat quilt = canvas(cv::Rect(8, 40, 192, 96));
    maker(20, 0.5).render(photo, depth, quilt);
    EXPECT_TRUE(samePicture(canvas(cv::Rect(8, 40, 192, 96)), expected));
    EXPECT_TRUE(samePicture(photo, randomPhoto({64, 48})));
    cv::Mat touching = canvas(cv::Rect(9, 107, 192, 93)); // the photo's last row, one column
    EXPECT_NE(errorOf([&] { maker(20, 0.5).render(photo, depth, touching); }), "(no error)");
}

TEST(AdjacentParallax, IsTheFormulaInBothUnits) {
    const QuiltLayout portrait;
    const AdjacentParallax p = adjacentParallax(viewsOf(10, 0.5), portrait, {1536, 2048}, {0, 1});
    EXPECT_NEAR(p.viewPixels, 0.1 * 420 * 0.5 / 47, 1e-12);
    EXPECT_NEAR(p.panelPixels, 0.1 * 1536 * 0.5 / 47, 1e-12);
    EXPECT_EQ(adjacentParallax({}, {1, 1, {10, 10}, 1}, {16, 16}).viewPixels, 0);
    EXPECT_NEAR(adjacentParallax(viewsOf(10, 0.5), portrait, {1536, 2048}, {0.5, 0.6}).viewPixels,
                0.1 * 420 * 0.1 / 47, 1e-12);
}

} // namespace
} // namespace altiro3D::test
