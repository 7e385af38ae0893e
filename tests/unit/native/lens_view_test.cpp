#include "altiro3D/lens_view.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/quilt2native.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"
#include "support/slow.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

// A piece of a display: the same lenses over fewer px.
Calibration piece(Calibration calibration, int width, int height) {
    calibration.screenW = width;
    calibration.screenH = height;
    return calibration;
}

// The sample calibration and, where they are, those of all known displays.
std::vector<std::filesystem::path> allCalibrations() {
    std::vector<std::filesystem::path> files = realCalibrations();
    files.push_back(sourcePath("calibration/portrait-sample.json"));
    return files;
}

std::vector<Calibration> oddPanels() {
    std::vector<Calibration> panels{stripePanel(47, 61)};
    Calibration cells = stripePanel(48, 31);
    cells.CellPatternMode = 3;
    cells.subpixelCells = deltaCells();
    panels.push_back(cells);
    Calibration other = stripePanel(37, 53);
    other.slope = 5.2;
    other.invView = 0;
    other.flipSubp = 1;
    panels.push_back(other);
    return panels;
}

cv::Mat seenBy(const LensEye& eye, const cv::Mat& native, const Calibration& calibration) {
    cv::Mat seen;
    simulateView(native, calibration, eye, seen);
    return seen;
}

// Waves of at most `steepest` grey levels a px, each view with a place of its own.
cv::Mat wavyQuilt(const QuiltLayout& layout, double steepest) {
    cv::Mat quilt(layout.size(), CV_8UC3);
    const double amplitude = 100;
    const double k = steepest / amplitude / std::sqrt(2.0); // |gradient| <= amplitude k sqrt(2)
    for (int view = 0; view < layout.viewCount; ++view) {
        cv::Mat tile = quilt(layout.tile(view));
        forPixels(tile.size(), [&](int x, int y) {
            for (int c = 0; c < 3; ++c)
                tile.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<uchar>(
                    128 + amplitude * std::sin(k * x + 0.35 * view + c) * std::cos(k * y + c));
        });
    }
    return quilt;
}

// Root mean square distance between the px where content is seen and its true px, over all px and
// colours. The Native's colours encode columns and rows.
double outOfPlace(const Calibration& c, const LensEye& eye) {
    cv::Mat places[2];
    for (cv::Mat& place : places)
        place.create(c.screenH, c.screenW, CV_8UC3);
    for (int y = 0; y < c.screenH; ++y) {
        for (int x = 0; x < c.screenW; ++x) {
            places[0].at<cv::Vec3b>(y, x) = cv::Vec3b::all(static_cast<uchar>(x));
            places[1].at<cv::Vec3b>(y, x) = cv::Vec3b::all(static_cast<uchar>(y));
        }
    }
    const cv::Mat column = seenBy(eye, places[0], c);
    const cv::Mat row = seenBy(eye, places[1], c);
    double sum = 0;
    for (int y = 0; y < c.screenH; ++y) {
        for (int x = 0; x < c.screenW; ++x) {
            for (int k = 0; k < 3; ++k) {
                sum += std::pow(column.at<cv::Vec3b>(y, x)[k] - x, 2) +
                       std::pow(row.at<cv::Vec3b>(y, x)[k] - y, 2);
            }
        }
    }
    return std::sqrt(sum / (3.0 * c.screenW * c.screenH));
}

TEST(LensView, IsTheReferencesPictureOnEveryKindOfPanel) {
    for (const Calibration& c : oddPanels()) {
        const cv::Mat native = randomPhoto({c.screenW, c.screenH}, 1, 0);
        const bool inverted = lensGeometry(c).inverted;
        for (const LensEye& eye : {LensEye{0.5, 0.05}, LensEye{0.01, 0.1}, LensEye{-3.2, 0.013},
                                   LensEye{0.77, 1}, eyeAtView(3, 7)}) {
            const cv::Mat seen = seenBy(eye, native, c);
            EXPECT_TRUE(
                samePicture(seen, referenceLensView(native, c, inverted, eye.phase, eye.spot)));
        }
    }
}

TEST(LensView, NoSpotIsTheWidthOfOneSubPixel) {
    const Calibration c = stripePanel(64, 48);
    const cv::Mat native = randomPhoto({64, 48}, 1, 0);
    const double width = 1 / lensGeometry(c).lensPeriodSubpixels;
    EXPECT_TRUE(samePicture(seenBy({0.3, 0}, native, c), seenBy({0.3, width}, native, c)));
}

TEST(LensView, MirroredPanelsAreSeenUnmirrored) {
    Calibration c = stripePanel(64, 48);
    const QuiltLayout layout{3, 2, {64, 48}, 6};
    const cv::Mat quilt = wavyQuilt(layout, 3);
    cv::Mat plain;
    Quilt2Native(c, layout, {}).render(quilt, plain);
    for (int flips = 0; flips < 4; ++flips) {
        c.flipImageX = flips & 1;
        c.flipImageY = flips >> 1;
        cv::Mat native;
        Quilt2Native(c, layout, {}).render(quilt, native);
        EXPECT_GT(psnr(seenBy(eyeAtView(2, 6), native, c), quilt(layout.tile(2))), 35) << flips;
    }
}

// Where each view has one colour the eye sees that colour alone: not one px of another view.
TEST(LensView, AViewIsSeenWithoutAnyOtherOnEveryDisplay) {
    ALTIRO3D_TAKES(4);
    for (const auto& file : allCalibrations()) {
        SCOPED_TRACE(file.filename());
        const Calibration whole = readCalibration(file);
        const Calibration c = piece(whole, 240, 160);
        QuiltLayout layout = defaultQuilt(whole);
        layout.tileSize = {1, 1};
        cv::Mat quilt(layout.size(), CV_8UC3);
        for (int i = 0; i < layout.viewCount; ++i)
            quilt(layout.tile(i)).setTo(cv::Scalar(3 * i + 1, 255 - 3 * i, 50 + 3 * i));
        cv::Mat native;
        Quilt2Native(NativeLut(c, layout)).render(quilt, native);
        for (int i = 0; i < layout.viewCount; ++i) {
            const cv::Mat view(c.screenH, c.screenW, CV_8UC3,
                               cv::Scalar(3 * i + 1, 255 - 3 * i, 50 + 3 * i));
            EXPECT_TRUE(samePicture(seenBy(eyeAtView(i, layout.viewCount), native, c), view)) << i;
        }
    }
}

// What is seen at a px belongs r px away, so its colour is off by at most r times the steepest
// gradient of the view, and the whole by the root mean square r times it (and 1 for rounding, twice
// 0.5). r follows from the display: a view owns one N-th of the sub-pixels of each colour, and r is
// at most that of places at random, sqrt(N / pi), as lenses sample evenly.
TEST(LensView, AViewIsAsGoodAsTheLensSamplesItOnEveryDisplay) {
    ALTIRO3D_TAKES(5);
    for (const auto& file : allCalibrations()) {
        SCOPED_TRACE(file.filename());
        const Calibration whole = readCalibration(file);
        const Calibration c = piece(whole, 150, 180);
        QuiltLayout layout = defaultQuilt(whole);
        layout.tileSize = {c.screenW, c.screenH};
        const double steepest = 2;
        const cv::Mat quilt = wavyQuilt(layout, steepest);
        cv::Mat native;
        Quilt2Native(c, layout, {}).render(quilt, native);
        for (const int view : {0, layout.viewCount / 3, layout.viewCount - 1}) {
            const LensEye eye = eyeAtView(view, layout.viewCount);
            const double r = outOfPlace(c, eye);
            EXPECT_LT(r, std::sqrt(layout.viewCount / CV_PI)) << view;
            EXPECT_GT(psnr(seenBy(eye, native, c), quilt(layout.tile(view))),
                      20 * std::log10(255 / (steepest * r + 1)))
                << view;
        }
    }
}

// A centre that is off by three views shows the view three further; a wrong pitch mixes all views.
TEST(LensView, TheWrongCalibrationShowsTheWrongViewOrGhosts) {
    const Calibration c = stripePanel(300, 200);
    const QuiltLayout layout{8, 6, {300, 200}, 48};
    const cv::Mat quilt = wavyQuilt(layout, 2);
    cv::Mat native;
    Quilt2Native(c, layout, {}).render(quilt, native);
    const LensEye eye = eyeAtView(20, 48);
    const double right = psnr(seenBy(eye, native, c), quilt(layout.tile(20)));
    Calibration shifted = c;
    shifted.center += 3.0 / 48; // the views are inverted: the phase grows with the centre
    EXPECT_NEAR(psnr(seenBy(eye, native, shifted), quilt(layout.tile(17))), right, 1);
    Calibration stretched = c;
    stretched.pitch *= 1.02;
    for (int view = 0; view < 48; ++view) {
        EXPECT_LT(psnr(seenBy(eye, native, stretched), quilt(layout.tile(view))), right - 10)
            << view;
    }
}

TEST(LensView, AnglesRunOverTheConeFromTheLeftmostView) {
    Calibration c = stripePanel(64, 48);
    c.viewCone = 50;
    EXPECT_DOUBLE_EQ(eyeAtAngle(c, 0).phase, 0.5);
    EXPECT_DOUBLE_EQ(eyeAtAngle(c, -25).phase, 0);
    EXPECT_DOUBLE_EQ(eyeAtAngle(c, 10).phase, 0.7);
    c.viewCone = 0;
    EXPECT_EQ(viewConeDegrees(c), 40);
    c.serial = "LKG-E05304";
    EXPECT_EQ(viewConeDegrees(c), 54);
    EXPECT_DOUBLE_EQ(eyeAtView(0, 4).phase, 0.125);
    EXPECT_DOUBLE_EQ(eyeAtView(3, 4).spot, 0.25);
}

TEST(LensView, ThreadsSubMatricesAndWorkingInPlaceChangeNothing) {
    const Calibration c = stripePanel(101, 67);
    const cv::Mat big = randomPhoto({140, 90}, 1, 0);
    const cv::Mat part = big(cv::Rect(7, 5, 101, 67));
    const RestoredThreads restored;
    cv::setNumThreads(1);
    const cv::Mat expected = seenBy({0.4, 0}, part.clone(), c);
    for (const int count : {2, 3, 5}) {
        cv::setNumThreads(count);
        EXPECT_TRUE(samePicture(seenBy({0.4, 0}, part, c), expected)) << count;
    }
    cv::Mat native = part.clone();
    simulateView(native, c, {0.4, 0}, native);
    EXPECT_TRUE(samePicture(native, expected));
    const cv::Mat shifted = big(cv::Rect(10, 9, 101, 67)); // shares most of the Native's px
    native = big(cv::Rect(7, 5, 101, 67));
    cv::Mat seen = shifted;
    simulateView(native, c, {0.4, 0}, seen);
    EXPECT_EQ(seen.data, shifted.data);
    EXPECT_TRUE(samePicture(seen, expected));
}

// Lenses so wide and steep that the phase grows with the row alone: a narrow spot lights a few rows
// or none.
TEST(LensView, RowsWithoutALitColumnAreFilledFromTheNearestThatHasOne) {
    Calibration c = stripePanel(47, 61);
    c.slope = 61 / (47 * 1000.0);
    c.pitch = 1e-3 * std::sqrt(1 + 1 / (c.slope * c.slope)) * c.DPI / c.screenW;
    c.center = 0.2;
    const cv::Mat native = randomPhoto({47, 61}, 1, 0);
    const bool inverted = lensGeometry(c).inverted;
    for (const double spot : {0.3, 0.02, 0.001}) {
        for (const double phase : {0.0, 0.3, 0.55, 0.8, 0.99}) {
            EXPECT_TRUE(samePicture(seenBy({phase, spot}, native, c),
                                    referenceLensView(native, c, inverted, phase, spot)))
                << spot << " " << phase;
        }
    }
}

TEST(LensView, APanelThatLightsNothingIsBlackAtOnce) { // not after 16384^2 rows
    Calibration c = stripePanel(256, 16384);
    c.slope = 1e6;
    c.pitch = 2e-3 * c.DPI / c.screenW;
    c.center = 0;
    const cv::Mat native(16384, 256, CV_8UC3, cv::Scalar::all(200));
    const cv::Mat seen = seenBy({0.5, 0.01}, native, c);
    EXPECT_EQ(cv::countNonZero(seen.reshape(1)), 0);
}

TEST(LensView, WhatIsWrongIsNamed) {
    const Calibration c = stripePanel(64, 48);
    const cv::Mat native(48, 64, CV_8UC3);
    cv::Mat seen;
    const auto error = [&](const cv::Mat& picture, const LensEye& eye) {
        return errorOf([&] { simulateView(picture, c, eye, seen); });
    };
    EXPECT_EQ(error(cv::Mat(48, 63, CV_8UC3), {}),
              "native: has 63 x 48 px, expected the panel's 64 x 48 px");
    EXPECT_EQ(error(cv::Mat(48, 64, CV_8UC1), {}),
              "native: is 64 x 48 px of CV_8UC1, expected 8-bit BGR");
    EXPECT_EQ(error(native, {NAN, 0}), "phase: is nan, expected a finite number");
    EXPECT_EQ(error(native, {0, 1.5}), "spot: is 1.5, expected 0 or 1/4096..1");
    EXPECT_EQ(error(native, {0, -1}), "spot: is -1, expected 0 or 1/4096..1");
    EXPECT_EQ(errorOf([&] { eyeAtView(4, 4); }), "view: is 4, expected 0..3");
    EXPECT_EQ(errorOf([&] { eyeAtView(0, 0); }), "viewCount: is 0, expected 1..4096");
    EXPECT_EQ(errorOf([&] { eyeAtAngle(c, INFINITY); }),
              "angleDegrees: is inf, expected a finite number");
}

} // namespace
} // namespace altiro3D::test
