#include "altiro3D/lens_sheet.hpp"

#include "altiro3D/lens_view.hpp"
#include "altiro3D/native_lut.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

LensNumbers smallPrint() {
    LensNumbers numbers;
    numbers.lpi = 61.3;
    numbers.dpi = 720;
    numbers.width = 8;
    numbers.height = 5;
    return numbers;
}

// The view of a px by its place on paper, in inches from the bottom left corner.
int viewByPlace(const LensNumbers& n, double right, double up, int views) {
    const double turn = n.angle * kDegree;
    // across the lenses: their direction is (sin, cos), of lying ones (cos, sin)
    const double place = n.isHorizontal ? (up * std::cos(turn) - right * std::sin(turn)) * n.lpi
                                        : (right * std::cos(turn) - up * std::sin(turn)) * n.lpi;
    // the last view is at the near side of the lens: what a lens has at its left is seen from right
    const double sign = n.isHorizontal && n.angle > 0 ? -1 : 1;
    const double under = sign * place - std::floor(sign * place);
    return std::min(static_cast<int>((1 - under) * views), views - 1);
}

// Number of sub-pixels of the table whose view is another one than by their place on paper.
int wrongViews(const LensNumbers& numbers) {
    const Calibration c = calibrationOf(numbers);
    constexpr int kViews = 12;
    const QuiltLayout layout{4, 3, {8, 8}, kViews};
    const NativeLut lut(c, layout);
    const double dpiDown = numbers.dpiDown > 0 ? numbers.dpiDown : numbers.dpi;
    int wrong = 0;
    forPixels({c.screenW, c.screenH}, [&](int x, int y) {
        const double right = (x + 0.5) / numbers.dpi;
        const double up = (c.screenH - y - 0.5) / dpiDown;
        const int view = viewByPlace(numbers, right, up, kViews);
        for (int k = 0; k < 3; ++k) {
            const auto at = lut.channel(k).at<cv::Vec<std::uint16_t, 2>>(y, x);
            wrong += layout.tile(view).contains({at[0], at[1]}) ? 0 : 1;
        }
    });
    return wrong;
}

TEST(LensSheet, ViewsAreThoseOfThePlaceOnPaper) {
    LensNumbers numbers = smallPrint();
    EXPECT_EQ(wrongViews(numbers), 0) << "vertical";
    numbers.dpiDown = 360;
    EXPECT_EQ(wrongViews(numbers), 0) << "unequal dpi";
    for (const double angle : {-45.0, -11.0, 7.5, 45.0}) {
        numbers.angle = angle;
        EXPECT_EQ(wrongViews(numbers), 0) << angle;
    }
    numbers.isHorizontal = true;
    for (const double angle : {-3.0, 0.0, 20.0}) {
        numbers.angle = angle;
        EXPECT_EQ(wrongViews(numbers), 0) << "lying, " << angle;
    }
}

TEST(LensSheet, SizesAreExactAndAVerticalLensHasAFiniteSlope) {
    LensNumbers numbers = smallPrint();
    numbers.width = 297;
    numbers.height = 420;
    Calibration c = calibrationOf(numbers);
    EXPECT_EQ(cv::Size(c.screenW, c.screenH), cv::Size(8419, 11906));
    EXPECT_EQ(c.slope, 1e9);
    EXPECT_LT(std::abs(lensGeometry(c).tilt), 1.5e-9);
    numbers.dpi = 1440;
    c = calibrationOf(numbers);
    EXPECT_EQ(cv::Size(c.screenW, c.screenH), cv::Size(16838, 23811));
    const QuiltLayout layout{4, 3, {8, 8}, 12};
    EXPECT_EQ(
        errorOf([&] { const NativeLut lut(c, layout); }),
        "look-up table: would have 16838 x 23811 px, expected at most 16384 px a side; larger "
        "prints are made without");
}

TEST(LensSheet, APrintHasAsManyViewsAsAreUseful) {
    LensNumbers numbers = smallPrint();
    numbers.lpi = 60;
    EXPECT_EQ(displayOf(calibrationOf(numbers)).quilt.viewCount, 12);
    EXPECT_DOUBLE_EQ(lensFacts(calibrationOf(numbers)).usefulViews, 12);
    numbers.views = 7;
    EXPECT_EQ(displayOf(calibrationOf(numbers)).quilt.viewCount, 7);
    numbers.views = 0;
    numbers.dpiDown = 360;
    const Display unequal = displayOf(calibrationOf(numbers));
    EXPECT_EQ(unequal.quilt.viewCount, 12);
    EXPECT_NEAR(unequal.aspect(), 8.0 / 5, 0.01);
    numbers.isHorizontal = true;
    EXPECT_EQ(displayOf(calibrationOf(numbers)).quilt.viewCount, 6);
    numbers = smallPrint();
    numbers.width = 1536 * 25.4 / 720; // px of a Portrait
    numbers.height = 2048 * 25.4 / 720;
    EXPECT_EQ(findDisplayModel(calibrationOf(numbers)), nullptr);
}

TEST(LensSheet, ScreensHaveTheirStripes) {
    LensNumbers numbers = smallPrint();
    numbers.dpi = 326;
    numbers.width = numbers.height = 50;
    numbers.angle = 9;
    numbers.subpixels = SubpixelOrder::Rgb;
    const LensGeometry rgb = lensGeometry(calibrationOf(numbers));
    numbers.subpixels = SubpixelOrder::Bgr;
    const LensGeometry bgr = lensGeometry(calibrationOf(numbers));
    EXPECT_DOUBLE_EQ(rgb.phase(5, 6, 0), bgr.phase(5, 6, 2));
    EXPECT_NE(rgb.phase(5, 6, 0), rgb.phase(5, 6, 2));
    numbers.subpixels = SubpixelOrder::VerticalRgb;
    const Calibration c = calibrationOf(numbers);
    const LensGeometry down = lensGeometry(c);
    // red is two thirds of a px above blue: the lens is to the right there, by this much
    const double shift = 2.0 / 3 * std::sin(9 * kDegree) * 61.3 / 326;
    EXPECT_NEAR(down.phase(5, 6, 0) - down.phase(5, 6, 2), shift, 1e-12);
    EXPECT_FALSE(c.sheet->isPrint);
    EXPECT_EQ(displayOf(c).quilt.viewCount, 48);
}

TEST(LensSheet, FactsFollowFromThicknessAndIndex) {
    LensNumbers numbers = smallPrint();
    numbers.lpi = 60;
    EXPECT_EQ(lensFacts(calibrationOf(numbers)).viewCone, 0);
    EXPECT_EQ(lensFacts(calibrationOf(numbers)).sharpDepth, 0);
    numbers.thickness = 0.6;
    numbers.index = 1.5;
    EXPECT_EQ(lensFacts(calibrationOf(numbers)).visualLpi, 0);
    numbers.distance = 400;
    const Calibration c = calibrationOf(numbers);
    const LensFacts facts = lensFacts(c);
    const double inside = std::atan(25.4 / 60 / 2 / 0.6);
    EXPECT_NEAR(std::sin(facts.viewCone / 2 * kDegree), 1.5 * std::sin(inside), 1e-12);
    EXPECT_EQ(c.viewCone, facts.viewCone);
    EXPECT_NEAR(facts.visualLpi, 60 / (1 + 0.6 / (1.5 * 400)), 1e-12);
    EXPECT_NEAR(facts.sharpDepth, 2 * 12 * 0.6 / 1.5, 1e-12);
    // at small angles, planes this far apart move by two lenses from view to view
    const double toEdge = 25.4 / 60 / 2 / 0.6 * 1.5; // tangent of half the cone
    numbers.width = 200;
    EXPECT_NEAR(lensFacts(calibrationOf(numbers)).sharpStrength,
                100 * 2 * facts.sharpDepth * toEdge / 200, 0.01);
    EXPECT_EQ(facts.sharpStrength, 100);
    EXPECT_NEAR(facts.width, 8, 0.02);
}

TEST(LensSheet, TheFileIsReadAsItWasWritten) {
    LensNumbers numbers = smallPrint();
    numbers.angle = 3;
    numbers.dpiDown = 1440;
    numbers.views = 5;
    numbers.thickness = 0.9;
    numbers.index = 1.56;
    numbers.distance = 500;
    const Calibration written = calibrationOf(numbers);
    const std::string text = calibrationText(written);
    const Calibration read = parseCalibrations(text, "lens.json").front();
    EXPECT_EQ(fingerprint(read), fingerprint(written));
    EXPECT_EQ(read.viewCone, written.viewCone);
    ASSERT_TRUE(read.sheet);
    EXPECT_TRUE(read.sheet->isPrint);
    EXPECT_EQ(read.sheet->dpiDown, 1440);
    EXPECT_EQ(read.sheet->views, 5);
    EXPECT_EQ(read.sheet->thickness, 0.9);
    EXPECT_EQ(read.sheet->index, 1.56);
    EXPECT_EQ(read.sheet->distance, 500);

    const auto error = [&](const std::string& from, const std::string& to) {
        std::string changed = text;
        changed.replace(changed.find(from), from.size(), to);
        return errorOf([&] { (void)parseCalibrations(changed, "lens.json"); });
    };
    EXPECT_EQ(error("\"views\": 5", "\"views\": 1"),
              "lens.json: lensSheet: views is 1, expected a whole number, 2..1024, or 0");
    EXPECT_EQ(error("\"index\": 1.56", "\"index\": 9"),
              "lens.json: lensSheet: index is 9, expected a number, 1..3, or 0");
    EXPECT_EQ(error("\"index\": 1.56", "\"index\": 0"),
              "lens.json: lensSheet: index is 0, expected thickness and index together");
    EXPECT_EQ(error("\"dpiDown\": 1440.0", "\"dpiDown\": -1"),
              "lens.json: lensSheet: dpiDown is -1, expected px per inch, 10..10000");
    EXPECT_EQ(error("\"distance\": 500.0", "\"distance\": [2]"),
              "lens.json: lensSheet: distance is a list, expected mm, 1..1e6, or 0");
    EXPECT_EQ(error("\"lensSheet\": {", "\"lensSheet\": 3, \"x\": {"),
              "lens.json: lensSheet is 3, expected an object");
}

TEST(LensSheet, BadNumbersAreNamed) {
    const auto error = [](const auto& change) {
        LensNumbers numbers = smallPrint();
        change(numbers);
        return errorOf([&] { (void)calibrationOf(numbers); });
    };
    EXPECT_EQ(error([](LensNumbers& n) { n.lpi = 400; }),
              "lpi: is 400, expected at most 360, with two px under a lens");
    EXPECT_EQ(error([](LensNumbers& n) { n.lpi = 0; }),
              "lpi: is 0, expected lenses per inch, above 0");
    EXPECT_EQ(error([](LensNumbers& n) { n.lpi = std::nan(""); }),
              "lpi: is nan, expected lenses per inch, above 0");
    EXPECT_EQ(error([](LensNumbers& n) { n.width = 0; }),
              "width: is 0, expected 0.5644..1411.11 mm, which are 16..40000 px");
    EXPECT_EQ(error([](LensNumbers& n) {
                  n.subpixels = SubpixelOrder::Rgb;
                  n.height = 1e9;
              }),
              "height: is 1e+09, expected 0.5644..577.991 mm, which are 16..16384 px");
    EXPECT_EQ(error([](LensNumbers& n) { n.angle = 90; }),
              "angle: is 90, expected -45..45 degrees from the vertical; lying lenses are "
              "horizontal=yes");
    EXPECT_EQ(error([](LensNumbers& n) { n.thickness = 0.5; }),
              "index: is missing, expected thickness and index together");
    EXPECT_EQ(error([](LensNumbers& n) { n.dpiDown = 5; }), "dpi: is 5, expected 10..10000");
    EXPECT_EQ(error([](LensNumbers& n) { n.views = 1; }), "views: is 1, expected 2..1024");
}

// A lens that lies is one that stands, of the turned picture.
TEST(LensSheet, TheSimulatorSeesLensesThatLie) {
    LensNumbers numbers = smallPrint();
    numbers.isHorizontal = true;
    for (const double angle : {0.0, 2.0, -2.0}) {
        numbers.angle = angle;
        const Calibration c = calibrationOf(numbers);
        const LensGeometry g = lensGeometry(c);
        constexpr int kViews = 8;
        cv::Mat native(c.screenH, c.screenW, CV_8UC3);
        native.forEach<cv::Vec3b>([&](cv::Vec3b& px, const int* at) {
            const int view = LensGeometry::viewOfPhase(g.phase(at[1], at[0], 0), kViews);
            px = cv::Vec3b::all(static_cast<uchar>(30 * view));
        });
        for (int view = 0; view < kViews; ++view) {
            cv::Mat seen;
            simulateView(native, c, eyeAtView(view, kViews), seen);
            EXPECT_TRUE(
                samePicture(seen, cv::Mat(native.size(), CV_8UC3, cv::Scalar::all(30 * view))))
                << angle << ", view " << view;
        }
    }
}

} // namespace
} // namespace altiro3D::test
