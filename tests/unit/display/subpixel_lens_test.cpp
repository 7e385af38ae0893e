#include "display/lens_phase.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include "altiro3D/lens_sheet.hpp"
#include "altiro3D/lens_view.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/quilt2native.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

std::string cubeVi(double interval, double slope, double x0) {
    char text[200];
    std::snprintf(text, sizeof text, R"({"lineNumber":%.9g,"obliquity":%.9g,"deviation":%.9g})",
                  interval, slope, x0);
    return text;
}

Calibration read(const std::string& text) {
    return parseCalibrations(text, "c1.json").front();
}

// Sub-pixels of the panel whose view is not that of `twin(x, y, colour)`.
template <class Twin>
int wrongViews(const Calibration& c, int views, const Twin& twin) {
    const LensPhases phases(lensGeometry(c));
    int wrong = 0;
    std::vector<std::uint16_t> row(static_cast<std::size_t>(c.screenW) + 64);
    for (int y = 0; y < c.screenH; ++y) {
        for (int k = 0; k < 3; ++k) {
            phases.viewsOfRow(y, k, views, row.data());
            for (int x = 0; x < c.screenW; ++x)
                wrong += row[static_cast<std::size_t>(x)] == twin(x, y, k) ? 0 : 1;
        }
    }
    return wrong;
}

TEST(CubeVi, EverySubpixelHasTheViewOfThePublishedFormula) {
    const double known[][3] = {{19.6138, .09878, -1.951725},
                               {19.625, .1057, 8.89},
                               {10, -.49, 100},
                               {40, .49, -100},
                               {19.5, 0, 0},
                               {12.34567, -.09878, -33.3}};
    for (const auto& [interval, slope, x0] : known) {
        const Calibration c = read(cubeVi(interval, slope, x0));
        EXPECT_EQ(cv::Size(c.screenW, c.screenH), cv::Size(1440, 2560));
        const auto published = [i = interval, s = slope, o = x0](int x, int y, int k) {
            return 39 - referenceCubeViView(i, s, o, x, y, k); // view 0 is our leftmost camera
        };
        EXPECT_EQ(wrongViews(c, 40, published), 0) << interval;
    }
}

// The same through the table of the default quilt, whose columns are those of the formula.
TEST(CubeVi, TheDefaultQuiltHasTheColumnsOfThePublishedFormula) {
    const Display display = displayOf(read(cubeVi(19.6138, .09878, -1.951725)));
    EXPECT_EQ(display.quilt, (QuiltLayout{8, 5, {540, 960}, 40}));
    EXPECT_EQ(findDisplayModel(display.calibration)->name, "CubeVi C1");
    const NativeLut lut(display.calibration, display.quilt);
    int wrong = 0;
    forPixels({1440, 2560}, [&](int x, int y) {
        for (int k = 0; k < 3; ++k) {
            const auto at = lut.channel(k).at<cv::Vec<std::uint16_t, 2>>(y, x);
            const int view = referenceCubeViView(19.6138, .09878, -1.951725, x, y, k);
            wrong += at[0] / 540 == 7 - view % 8 && at[1] / 960 == view / 8 ? 0 : 1;
        }
    });
    EXPECT_EQ(wrong, 0);
}

// Pitch, slope and centre alone, for what needs no exact borders: (1.15).
TEST(CubeVi, PitchSlopeAndCentreSayTheSame) {
    const Calibration c = read(cubeVi(19.6138, .09878, -1.951725));
    Calibration plain = c;
    plain.lens.reset();
    forPixels({1440, 2560},
              [&, exact = lensGeometry(c), derived = lensGeometry(plain)](int x, int y) {
                  const double off = exact.phase(x, y, x % 3) - derived.phase(x, y, x % 3);
                  ASSERT_NEAR(off, std::round(off), 1e-9);
              });
}

TEST(CubeVi, BothSpellingsAreReadAndWrittenAgain) {
    const Calibration c = read(cubeVi(19.625, .1057, 8.89));
    const Calibration nested = read(
        R"({"response_data":{"config":{"interval":19.625,"slope":0.1057,"x0":8.89,"y":"?"}}})");
    EXPECT_EQ(fingerprint(nested), fingerprint(c));
    EXPECT_EQ(nested.serial, "cubevi-c1");
    const Calibration again = read(calibrationText(c));
    EXPECT_EQ(fingerprint(again), fingerprint(c));
    EXPECT_EQ(again.lens->offset, 8.89);
    EXPECT_EQ(parseQuiltName("a_CV.png")->grid.columns, 8);
    EXPECT_FALSE(parseQuiltName("cv.png"));
}

TEST(CubeVi, WhatIsOutOfRangeIsNamed) {
    const std::pair<std::string, const char*> wrong[] = {
        {cubeVi(9.99, .1, 0), "lineNumber is 9.99, expected sub-pixels across a lens, 10..40"},
        {cubeVi(20, .5, 0), "obliquity is 0.5, expected px per row"},
        {cubeVi(20, .1, -100.5), "deviation is -100.5, expected sub-pixels, -100..100"},
        {R"({"lineNumber":20,"obliquity":0.1})", "deviation is missing"},
        {R"({"deviation":20})", "lineNumber is missing"},
        {R"({"interval":"20","slope":0.1,"x0":0})", "interval is \"20\", expected"},
        {R"({"interval":20,"slope":"NaN","x0":0})", "slope is \"NaN\", expected"},
        {R"({"interval":20,"slope":0.1,"x0":null})", "x0 is missing"},
        {R"({"interval":1e999,"slope":0.1,"x0":0})", "c1.json"}};
    for (const auto& [text, message] : wrong)
        EXPECT_TRUE(contains(errorOf([text = text] { read(text); }), message)) << text;
}

BarrierNumbers panelOf(cv::Size size, double pitch, double slope, double offset,
                       std::vector<int> order) {
    BarrierNumbers n;
    n.panel = size;
    n.pitch = pitch;
    n.slope = slope;
    n.offset = offset;
    n.order = std::move(order);
    return n;
}

// Three made panels; in the second one many sub-pixels lie exactly between two views.
const BarrierNumbers kPanels[] = {panelOf({1920, 1080}, 4.6667, 1, 0, {0, 2, 1, 3}),
                                  panelOf({1366, 768}, 4.5, -1, 2.25, {8, 6, 4, 2, 0, 1, 3, 5, 7}),
                                  panelOf({2560, 1440}, 17.9213, .3333, -7.1, {})};

TEST(Barrier, EverySubpixelHasItsViewInOrder) {
    for (const BarrierNumbers& n : kPanels) {
        for (const bool isBgr : {false, n.order.size() == 4}) {
            BarrierNumbers numbers = n;
            numbers.isBgr = isBgr;
            const Calibration c = calibrationOf(numbers);
            const int views = n.order.empty() ? 48 : static_cast<int>(n.order.size());
            EXPECT_EQ(displayOf(c).quilt.viewCount, views);
            const auto twin = [&](int x, int y, int k) {
                return referenceBarrierView(n.pitch, n.slope, n.offset, n.order, views,
                                            3 * x + (isBgr ? 2 - k : k), y);
            };
            EXPECT_EQ(wrongViews(c, views, twin), 0) << n.pitch;
        }
    }
}

// Table, .map file, quilt with and without blending, and other numbers of views agree.
TEST(Barrier, EveryPathHasTheOrder) {
    const Calibration c = calibrationOf(panelOf({96, 64}, 4.5, 1, .3, {0, 2, 1, 3}));
    TemporaryDirectory directory;
    for (const int views : {4, 8, 48}) {
        const QuiltLayout layout{views / 4, 4, {11, 7}, views};
        const cv::Mat quilt = randomPhoto(layout.size());
        const NativeLut lut(c, layout);
        lut.save(directory / "a.map");
        cv::Mat expected;
        cv::Mat native;
        Quilt2Native(NativeLut::load(directory / "a.map")).render(quilt, expected);
        for (const auto& sampling : {QuiltSampling(), QuiltSampling{ViewFilter::Linear, {}}}) {
            Quilt2Native(c, layout, sampling).render(quilt, native);
            EXPECT_TRUE(samePicture(native, expected)) << views;
        }
        const LensGeometry g = lensGeometry(c);
        forPixels(native.size(), [&](int x, int y) {
            const int slot = g.slot(x, y, 1, 4);
            EXPECT_EQ(g.view(x, y, 1, views) * 4 / views, c.viewOrder[std::size_t(slot)]);
        });
    }
}

TEST(Barrier, WhatIsNoOrderIsRefused) {
    const auto error = [](const BarrierNumbers& n) { return errorOf([&] { calibrationOf(n); }); };
    for (const std::vector<int>& order :
         {std::vector<int>{0}, {0, 0}, {0, 2}, {-1, 0}, std::vector<int>(65, 0)})
        EXPECT_TRUE(contains(error(panelOf({96, 64}, 4, 1, 0, order)),
                             "the order of views repeats a view or lacks one"));
    EXPECT_TRUE(contains(error(panelOf({96, 64}, 1.9, 1, 0, {})), "period of the lens is 1.9"));
    EXPECT_TRUE(contains(error(panelOf({96, 64}, NAN, 1, 0, {})), "period of the lens is nan"));
    EXPECT_TRUE(contains(error(panelOf({96, 64}, 4, 3.5, 0, {})), "slope of the lens is"));
    EXPECT_TRUE(contains(error(panelOf({9, 64}, 4, 0, 0, {})), "screenW is 9"));
    BarrierNumbers views = panelOf({96, 64}, 4, 1, 0, {1, 0});
    views.views = 4;
    EXPECT_TRUE(contains(error(views), "views is 4, expected as many as in order"));
}

// Seen through the lenses, an eye on either side of the viewer sees its own picture alone.
TEST(EyesToNative, TheBorderBetweenTheEyesFollowsTheViewer) {
    const Calibration ofC1 = read(cubeVi(19.6138, .09878, -1.951725));
    for (const Calibration& c :
         {ofC1, stripePanel(192, 128), calibrationOf(panelOf({160, 90}, 8.97, 1, 0, {}))}) {
        const Display display = displayOf(c);
        const cv::Mat left(display.panelSize(), CV_8UC3, cv::Scalar(10, 20, 30));
        const cv::Mat right(display.panelSize(), CV_8UC3, cv::Scalar(210, 220, 230));
        cv::Mat native;
        cv::Mat seen;
        for (const double position : {-.8, 0.0, .6}) {
            eyesToNative(left, right, display, position, native);
            for (const auto& [eye, picture] : {std::pair(-.25, &left), {.25, &right}}) {
                simulateView(native, c, {.5 + position / 2 + eye, .1}, seen);
                EXPECT_TRUE(samePicture(seen, *picture)) << position << ' ' << eye;
            }
        }
        EXPECT_TRUE(contains(errorOf([&] { eyesToNative(left, right, display, NAN, native); }),
                             "position: is nan"));
    }
}

// The eye in the direction of a view sees that view, whatever the order under the lens.
TEST(EyesToNative, ViewsInAnotherOrderAreSeenInTheirDirections) {
    const Calibration c = calibrationOf(panelOf({160, 90}, 12, 1, 0, {0, 2, 1, 3}));
    const Display display = displayOf(c);
    cv::Mat quilt(display.quilt.size(), CV_8UC3);
    for (int i = 0; i < 4; ++i)
        quilt(display.quilt.tile(i)).setTo(cv::Scalar::all(50 * i));
    cv::Mat native;
    Quilt2Native(NativeLut(c, display.quilt)).render(quilt, native);
    for (int i = 0; i < 4; ++i) {
        cv::Mat seen;
        simulateView(native, c, eyeAtView(i, 4), seen);
        EXPECT_EQ(cv::mean(seen), cv::Scalar(50 * i, 50 * i, 50 * i)) << i;
    }
    const cv::Mat left(native.size(), CV_8UC3, cv::Scalar::all(0));
    const cv::Mat right(native.size(), CV_8UC3, cv::Scalar::all(255));
    cv::Mat halves;
    eyesToNative(left, right, display, 0, halves);
    EXPECT_TRUE(samePicture(halves, native > 75));
}

} // namespace
} // namespace altiro3D::test
