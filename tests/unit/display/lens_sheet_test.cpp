#include "altiro3D/lens_sheet.hpp"

#include "altiro3D/lens_view.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/quilt2native.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"
#include "support/slow.hpp"

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
int wrongPlaces(const LensNumbers& numbers) {
    const Calibration c = calibrationOf(numbers);
    const double dpiDown = numbers.dpiDown > 0 ? numbers.dpiDown : numbers.dpi;
    return wrongViews(c, {4, 3, {8, 8}, 12}, [&](int x, int y, int /*colour*/) {
        return viewByPlace(numbers, (x + 0.5) / numbers.dpi, (c.screenH - y - 0.5) / dpiDown, 12);
    });
}

TEST(LensSheet, ViewsAreThoseOfThePlaceOnPaper) {
    LensNumbers numbers = smallPrint();
    EXPECT_EQ(wrongPlaces(numbers), 0) << "vertical";
    numbers.dpiDown = 360;
    EXPECT_EQ(wrongPlaces(numbers), 0) << "unequal dpi";
    for (const double angle : {-45.0, -11.0, 7.5, 45.0}) {
        numbers.angle = angle;
        EXPECT_EQ(wrongPlaces(numbers), 0) << angle;
    }
    numbers.isHorizontal = true;
    for (const double angle : {-3.0, 0.0, 20.0}) {
        numbers.angle = angle;
        EXPECT_EQ(wrongPlaces(numbers), 0) << "lying, " << angle;
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
    EXPECT_EQ(calibrationText(read), text);
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

// An eye in the direction of a view sees that view alone.
void expectViewsInTheirDirections(const Calibration& c, int views) {
    const LensGeometry g = lensGeometry(c);
    const cv::Mat native = pictureOf<cv::Vec3b>({c.screenW, c.screenH}, [&](int x, int y) {
        cv::Vec3b px;
        for (int k = 0; k < 3; ++k)
            px[2 - k] = static_cast<uchar>(30 * g.view(x, y, k, views));
        return px;
    });
    for (int view = 0; view < views; ++view) {
        cv::Mat seen;
        simulateView(native, c, eyeAtView(view, views), seen);
        EXPECT_TRUE(samePicture(seen, cv::Mat(native.size(), CV_8UC3, cv::Scalar::all(30 * view))))
            << view;
    }
}

// A lens that lies is one that stands, of the turned picture.
TEST(LensSheet, TheSimulatorSeesLensesThatLie) {
    LensNumbers numbers = smallPrint();
    numbers.isHorizontal = true;
    for (const double angle : {0.0, 2.0, -2.0}) {
        numbers.angle = angle;
        expectViewsInTheirDirections(calibrationOf(numbers), 8);
    }
}

Calibration read(const std::string& text) {
    return parseCalibrations(text, "c1.json").front();
}

std::string cubeVi(double interval, double slope, double x0) {
    return "{\"lineNumber\":" + std::to_string(interval) +
           ",\"obliquity\":" + std::to_string(slope) + ",\"deviation\":" + std::to_string(x0) + "}";
}

BarrierNumbers barrier(cv::Size panel, double pitch, double slope, double offset,
                       const std::vector<int>& order) {
    return {panel, 100, pitch, slope, offset, false, 0, order};
}

// By the table of the default quilt, whose columns and rows are those of the published formula.
TEST(CubeVi, EverySubpixelHasTheViewOfThePublishedFormula) {
    ALTIRO3D_TAKES(4);
    const double known[][3] = {{19.6138, .09878, -1.951725},
                               {19.625, .1057, 8.89},
                               {10, -.49, 100},
                               {40, .49, -100},
                               {19.5, 0, 0},
                               {12.34567, -.09878, -33.3}};
    for (const auto& [interval, slope, x0] : known) {
        const Display display = displayOf(read(cubeVi(interval, slope, x0)));
        EXPECT_EQ(findDisplayModel(display.calibration)->name, "CubeVi C1");
        EXPECT_EQ(display.panelSize(), cv::Size(1440, 2560));
        EXPECT_EQ(display.quilt, (QuiltLayout{8, 5, {540, 960}, 40}));
        const auto published = [i = interval, s = slope, o = x0](int x, int y, int k) {
            return 39 - referenceCubeViView(i, s, o, x, y, k); // view 0 is our leftmost camera
        };
        EXPECT_EQ(wrongViews(display.calibration, display.quilt, published), 0) << interval;
        Calibration plain = display.calibration; // pitch, slope and centre say the same: (1.15)
        plain.lens.reset();
        for (const cv::Point at : {cv::Point(0, 0), {1439, 0}, {0, 2559}, {700, 1300}}) {
            const double off = lensGeometry(plain).phase(at.x, at.y, 1) -
                               lensGeometry(display.calibration).phase(at.x, at.y, 1);
            EXPECT_NEAR(off, std::round(off), 1e-6) << at; // a vertical lens has slope 1e9
        }
    }
}

TEST(CubeVi, BothSpellingsAreReadAndWrittenAgain) {
    const Calibration c = read(cubeVi(19.625, .1057, 8.89));
    const Calibration nested = read(
        R"({"response_data":{"config":{"interval":19.625,"slope":0.1057,"x0":8.89,"y":"?"}}})");
    EXPECT_EQ(fingerprint(nested), fingerprint(c));
    EXPECT_EQ(nested.serial, "cubevi-c1");
    EXPECT_EQ(fingerprint(read(calibrationText(c))), fingerprint(c));
    EXPECT_EQ(parseQuiltName("a_CV.png")->grid.columns, 8);
    EXPECT_FALSE(parseQuiltName("cv.png"));
    const std::pair<std::string, const char*> wrong[] = {
        {cubeVi(9.99, .1, 0), "lineNumber is 9.99, expected sub-pixels across a lens, 10..40"},
        {cubeVi(20, .5, 0), "obliquity is 0.5, expected px per row"},
        {cubeVi(20, .1, -100.5), "deviation is -100.5, expected sub-pixels, -100..100"},
        {R"({"lineNumber":20,"obliquity":0.1})", "deviation is missing"},
        {R"({"deviation":20})", "lineNumber is missing"},
        {R"({"interval":20,"slope":"NaN","x0":0})", "slope is \"NaN\", expected"},
        {R"({"interval":1e999,"slope":0.1,"x0":0})", "c1.json"}};
    for (const auto& [text, message] : wrong)
        EXPECT_TRUE(holds(errorOf([text = text] { read(text); }), message)) << text;
}

// Three made panels; in the second one many sub-pixels lie exactly between two views.
TEST(Barrier, EverySubpixelHasItsViewInOrder) {
    ALTIRO3D_TAKES(2.4);
    for (BarrierNumbers n : {barrier({1920, 1080}, 4.6667, 1, 0, {0, 2, 1, 3}),
                             barrier({1366, 768}, 4.5, -1, 2.25, {8, 6, 4, 2, 0, 1, 3, 5, 7}),
                             barrier({2560, 1440}, 17.9213, .3333, -7.1, {})}) {
        const int views = n.order.empty() ? 48 : static_cast<int>(n.order.size());
        for (const bool isBgr : {false, views == 4}) {
            n.isBgr = isBgr;
            const Display display = displayOf(calibrationOf(n));
            ASSERT_EQ(display.quilt.viewCount, views);
            const auto twin = [&](int x, int y, int k) {
                return referenceBarrierView(n.pitch, n.slope, n.offset, n.order, views,
                                            3 * x + (n.isBgr ? 2 - k : k), y);
            };
            EXPECT_EQ(wrongViews(display.calibration, display.quilt, twin), 0) << n.pitch;
        }
    }
}

// Table, .map file, quilt with and without blending, and other numbers of views agree.
TEST(Barrier, EveryPathHasTheOrder) {
    const BarrierNumbers n = barrier({96, 64}, 4.5, 1, .3, {0, 2, 1, 3});
    const Calibration c = calibrationOf(n);
    TemporaryDirectory directory;
    for (const int views : {4, 8, 48}) {
        const QuiltLayout layout{views / 4, 4, {11, 7}, views};
        const cv::Mat quilt = randomPhoto(layout.size());
        NativeLut(c, layout).save(directory / "a.map");
        cv::Mat expected;
        cv::Mat native;
        Quilt2Native(NativeLut::load(directory / "a.map")).render(quilt, expected);
        for (const auto& sampling : {QuiltSampling(), QuiltSampling{ViewFilter::Linear, {}}}) {
            Quilt2Native(c, layout, sampling).render(quilt, native);
            EXPECT_TRUE(samePicture(native, expected)) << views;
        }
        forPixels(native.size(), [&, g = lensGeometry(c)](int x, int y) {
            EXPECT_EQ(g.view(x, y, 1, views) * 4 / views,
                      referenceBarrierView(n.pitch, n.slope, n.offset, n.order, 4, 3 * x + 1, y));
        });
    }
}

TEST(Barrier, ViewsInAnotherOrderAreSeenInTheirDirections) {
    expectViewsInTheirDirections(calibrationOf(barrier({160, 90}, 12, 1, 0, {0, 2, 1, 3})), 4);
}

TEST(Barrier, WhatIsOutOfRangeIsNamed) {
    std::pair<BarrierNumbers, const char*> wrong[] = {
        {barrier({96, 64}, 1.9, 1, 0, {}), "pitch: is 1.9, expected 2..1000 sub-pixels"},
        {barrier({96, 64}, NAN, 1, 0, {}), "pitch: is nan"},
        {barrier({96, 64}, 4, 3.5, 0, {}), "slope: is 3.5, expected -3..3 sub-pixels per row"},
        {barrier({96, 64}, 4, 3, -2e4, {}), "offset: is -20000, expected -10000..10000 sub-pixels"},
        {barrier({9, 64}, 4, 0, 0, {}), "lens: screenW is 9"},
        {barrier({96, 64}, 4, 1, 0, {1, 0}), "views: is 4, expected as many as in order"}};
    std::end(wrong)[-1].first.views = 4;
    for (const auto& [numbers, message] : wrong)
        EXPECT_TRUE(holds(errorOf([n = numbers] { calibrationOf(n); }), message)) << message;
    for (const std::vector<int>& order :
         {std::vector<int>{0}, {0, 0}, {0, 2}, {-1, 0}, std::vector<int>(65, 0)})
        EXPECT_TRUE(holds(errorOf([&] {
                              calibrationOf(barrier({96, 64}, 4, 1, 0, order));
                          }),
                          "the order of views repeats a view or lacks one"));
}

// Seen through the lenses, an eye on either side of the viewer sees its own picture alone. With
// views in another order, the border stays in the middle.
TEST(EyesToNative, TheBorderBetweenTheEyesFollowsTheViewer) {
    ALTIRO3D_TAKES(1.2);
    for (const Calibration& c : {read(cubeVi(19.6138, .09878, -1.951725)), stripePanel(192, 128),
                                 calibrationOf(barrier({160, 90}, 8.97, 1, 0, {})),
                                 calibrationOf(barrier({160, 90}, 12, 1, 0, {0, 2, 1, 3}))}) {
        const Display display = displayOf(c);
        const cv::Mat left(display.panelSize(), CV_8UC3, cv::Scalar(10, 20, 30));
        const cv::Mat right(display.panelSize(), CV_8UC3, cv::Scalar(210, 220, 230));
        cv::Mat native;
        cv::Mat seen;
        for (const double position : {-.8, 0.0, .6}) {
            eyesToNative(left, right, display, position, native);
            const double border = c.viewOrder.empty() ? .5 + position / 2 : .5;
            for (const auto& [eye, picture] : {std::pair(-.2, &left), {.2, &right}}) {
                simulateView(native, c, {border + eye, .1}, seen);
                EXPECT_TRUE(samePicture(seen, *picture)) << position << ' ' << eye;
            }
        }
        EXPECT_TRUE(holds(errorOf([&] { eyesToNative(left, right, display, NAN, native); }),
                          "position: is nan"));
    }
}

} // namespace
} // namespace altiro3D::test
