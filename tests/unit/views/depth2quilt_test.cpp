#include "altiro3D/depth2quilt.hpp"

#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
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
            maker(20, 0.4).renderView({photo, depth}, position, view);
            const cv::Mat reference =
                referenceFast(photo, depth, position * 0.2 * size.width / 2, 0.4);
            cv::Mat expected;
            reference.convertTo(expected, CV_8UC3);
            // cv::remap places samples in steps of 1/32 px: up to 1/64 of the largest step of 255
            EXPECT_TRUE(samePicture(view, expected, 255 / 64.0 + 1)) << size << " " << position;
        }
    }
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
    EXPECT_TRUE(holds(errorOf([&] { maker(10, 0.5).renderView(scene, 1, view); }),
                      "shown columns: are 12..80, expected columns of the photo, 0..79"));
    scene.shown = {};
    for (const int width : {-1, 8}) {
        scene.mixedPixels = width;
        EXPECT_TRUE(
            holds(errorOf([&] { maker(10, 0.5).renderView(scene, 1, view); }), "mixed px: is"));
    }
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
            .renderView({photo, depth}, 1, view);
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
    EXPECT_TRUE(holds(errorOf([] {
                          Depth2Quilt({1, 1, {9, 9}, 1}, viewsOf(10, 0.5, 17));
                      }),
                      "refinement: is 17, expected 0..16"));
}

// Views of the tiles' size are made row by row, others whole.
TEST(Depth2Quilt, TellsItsProgressAndStops) {
    for (const cv::Size size : {cv::Size(64, 48), cv::Size(70, 40)}) {
        const altiro3D::Scene scene{randomPhoto(size), randomDepth(size)};
        cv::Mat whole;
        maker(20, 0.4).render(scene, whole);
        cv::Mat quilt;
        std::vector<double> shares;
        EXPECT_TRUE(maker(20, 0.4).render(scene, quilt, [&](double share) {
            shares.push_back(share);
            return true;
        }));
        EXPECT_TRUE(samePicture(quilt, whole));
        EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
        EXPECT_GE(shares.size(), 3U);
        EXPECT_EQ(shares.back(), 1);

        int calls = 0;
        const auto stop = [&](double) { return ++calls < 2; };
        EXPECT_FALSE(maker(20, 0.4).render(scene, quilt, stop));
        EXPECT_EQ(calls, 2);
        const auto fail = [](double) -> bool { throw std::logic_error("mine"); };
        EXPECT_THROW(maker(20, 0.4).render(scene, quilt, fail), std::logic_error);
    }
}

TEST(Depth2Quilt, WrongInputsAreRefusedByName) {
    cv::Mat out;
    const cv::Mat photo(48, 64, CV_8UC3);
    const cv::Mat depth(48, 64, CV_32FC1);
    const auto error = [&](const cv::Mat& p, const cv::Mat& d) {
        return errorOf([&] { maker(10, 0.5).render({p, d}, out); });
    };
    EXPECT_TRUE(holds(error(cv::Mat(), depth), "photo: "));
    EXPECT_TRUE(holds(error(cv::Mat(48, 64, CV_8UC1), depth), "CV_8UC1"));
    EXPECT_TRUE(holds(error(photo, cv::Mat(48, 64, CV_8UC1)), "depth: is 64 x 48 px of CV_8UC1"));
    EXPECT_TRUE(holds(error(photo, cv::Mat(47, 64, CV_32FC1)), "depth: has 64 x 47 px"));
    EXPECT_TRUE(holds(errorOf([&] {
                          maker(10, 0.5).renderView({photo, depth}, std::nan(""), out);
                      }),
                      "position"));
    EXPECT_TRUE(holds(errorOf([] { maker(-1, 0.5); }), "strength: is -1"));
    EXPECT_TRUE(holds(errorOf([] { maker(std::nan(""), 0.5); }), "strength: is nan"));
    EXPECT_TRUE(holds(errorOf([] { maker(10, 1.5); }), "focus: is 1.5, expected a depth"));
}

TEST(Depth2Quilt, ItsInputsAreNoPlaceForTheQuilt) {
    const cv::Size quilt(192, 96);
    for (const cv::Size size : {quilt, cv::Size(400, 300)}) { // fits the quilt, and is reallocated
        cv::Mat photo = randomPhoto(size);
        cv::Mat depth = randomDepth(size);
        EXPECT_EQ(errorOf([&] {
                      maker(10, 0.5).render({photo, depth}, photo);
                  }),
                  "quilt: shares its memory with the photo, expected a picture of its own");
        EXPECT_EQ(errorOf([&] {
                      maker(10, 0.5).render({photo, depth}, depth);
                  }),
                  "quilt: shares its memory with the depth, expected a picture of its own");
        Scene scene{photo, depth};
        scene.hidden = {photo.clone(), depth.clone()};
        EXPECT_EQ(errorOf([&] { maker(10, 0.5).render(scene, scene.hidden.photo); }),
                  "quilt: shares its memory with the hidden layer, expected a picture of its own");
        scene.shown = {50, 40};
        cv::Mat out;
        EXPECT_TRUE(holds(errorOf([&] { maker(10, 0.5).render(scene, out); }),
                          "shown columns: are 50..39, expected columns of the photo"));
        EXPECT_EQ(photo.size(), size);
    }
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
