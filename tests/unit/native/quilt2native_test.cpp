#include "altiro3D/quilt2native.hpp"

#include "altiro3D/display.hpp"
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
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

// Colour of a view that no other view and no other channel has.
cv::Vec3b colourOf(int view) {
    return {static_cast<uchar>(view + 1), static_cast<uchar>(view + 81),
            static_cast<uchar>(view + 161)};
}

cv::Mat constantTiles(const QuiltLayout& layout) {
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(0));
    for (int i = 0; i < layout.viewCount; ++i)
        quilt(layout.tile(i)).setTo(colourOf(i));
    return quilt;
}

// Constant tiles give, at every sub-pixel, the predicted view's colour in its own channel.
void expectPredictedViews(const Calibration& c, const QuiltLayout& layout) {
    cv::Mat native;
    Quilt2Native(NativeLut(c, layout)).render(constantTiles(layout), native);
    const LensGeometry g = lensGeometry(c);
    std::size_t wrong = 0;
    for (int y = 0; y<c.screenH; y += c.screenH> 500 ? 7 : 1) {
        for (int x = 0; x < c.screenW; ++x) {
            for (int k = 0; k < 3; ++k) {
                const int view = LensGeometry::viewOfPhase(g.phase(x, y, k), layout.viewCount);
                wrong += native.at<cv::Vec3b>(y, x)[2 - k] != colourOf(view)[2 - k] ? 1U : 0U;
            }
        }
    }
    EXPECT_EQ(wrong, 0U);
}

TEST(Quilt2Native, ThePredictionHoldsForEveryRealCalibration) {
    ALTIRO3D_TAKES(8);
    ALTIRO3D_REQUIRE_DATA("calibrations");
    for (const std::filesystem::path& file : realCalibrations()) {
        SCOPED_TRACE(file);
        const Calibration c = readCalibration(file);
        QuiltLayout layout = defaultQuilt(c);
        layout.tileSize = {4, 3}; // constant tiles look alike at any size
        expectPredictedViews(c, layout);
    }
}

TEST(Quilt2Native, TakesTheReferencesQuiltPixel) {
    const Calibration c = stripePanel();
    const QuiltLayout layout{5, 9, {37, 23}, 45};
    const cv::Mat quilt = randomPicture(layout.size(), CV_8UC3);
    cv::Mat native;
    Quilt2Native(c, layout, {}).render(quilt, native);
    cv::Mat expected(c.screenH, c.screenW, CV_8UC3);
    forPixels(expected.size(), [&](int x, int y) {
        for (int k = 0; k < 3; ++k)
            expected.at<cv::Vec3b>(y, x)[2 - k] =
                quilt.at<cv::Vec3b>(referenceQuiltPixel(c, true, layout, x, y, k))[2 - k];
    });
    EXPECT_TRUE(samePicture(native, expected));
}

// A value that is linear in the view index must come out linear in the phase.
TEST(Quilt2Native, LinearViewFilterBlendsTheTwoNearestViews) {
    const Calibration c = stripePanel();
    const QuiltLayout layout{8, 6, {2, 2}, 48};
    cv::Mat quilt(layout.size(), CV_8UC3);
    for (int i = 0; i < 48; ++i)
        quilt(layout.tile(i)).setTo(cv::Scalar::all(5 * i));
    cv::Mat native;
    Quilt2Native(c, layout, {ViewFilter::Linear, TileSampling::Nearest}).render(quilt, native);
    for (int y = 0; y < c.screenH; ++y) {
        for (int x = 0; x < c.screenW; ++x) {
            for (int k = 0; k < 3; ++k) {
                const double phase = static_cast<double>(referencePhase(c, true, x, y, k));
                const double view = std::min(std::max(phase * 48 - 0.5, 0.0), 47.0);
                EXPECT_NEAR(native.at<cv::Vec3b>(y, x)[2 - k], 5 * view, 0.501); // rounding
            }
        }
    }
}

// A ramp inside each tile must come out as the same ramp over the panel, clamped at the borders.
TEST(Quilt2Native, LinearSamplingInterpolatesInsideTheTileOnly) {
    const Calibration c = stripePanel();
    const QuiltLayout layout{3, 2, {20, 10}, 6};
    const cv::Mat quilt = pictureOf<cv::Vec3b>(layout.size(), [&](int x, int y) {
        return cv::Vec3b::all(static_cast<uchar>(8 * (x % 20) + 9 * (y % 10)));
    });
    cv::Mat native;
    Quilt2Native(c, layout, {ViewFilter::Nearest, TileSampling::Linear}).render(quilt, native);
    for (int y = 0; y < c.screenH; ++y) {
        for (int x = 0; x < c.screenW; ++x) {
            const double tx = std::min(std::max((x + 0.5) / c.screenW * 20 - 0.5, 0.0), 19.0);
            const double ty = std::min(std::max((y + 0.5) / c.screenH * 10 - 0.5, 0.0), 9.0);
            for (int k = 0; k < 3; ++k)
                EXPECT_NEAR(native.at<cv::Vec3b>(y, x)[k], 8 * tx + 9 * ty, 0.501); // rounding
        }
    }
}

TEST(Quilt2Native, WhiteTilesDoNotBleedIntoBlackNeighbours) {
    const Calibration c = stripePanel();
    const QuiltLayout layout{2, 1, {16, 16}, 2};
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(0));
    quilt(layout.tile(1)).setTo(cv::Scalar::all(255));
    cv::Mat native;
    Quilt2Native(c, layout, {ViewFilter::Nearest, TileSampling::Linear}).render(quilt, native);
    cv::Mat extremes = (native == 0) | (native == 255);
    EXPECT_EQ(cv::countNonZero(extremes.reshape(1)), native.rows * native.cols * 3);
}

TEST(Quilt2Native, SubMatricesReusedOutputsAndThreadsChangeNothing) {
    const Calibration c = stripePanel();
    const QuiltLayout layout{4, 3, {17, 13}, 12};
    const cv::Mat big = randomPicture({100, 60}, CV_8UC3);
    const cv::Rect part({9, 5}, layout.size());
    const QuiltSampling samplings[] = {{}, {ViewFilter::Linear, TileSampling::Linear}};
    const RestoredThreads restored;
    for (const QuiltSampling sampling : samplings) {
        const Quilt2Native renderer(c, layout, sampling);
        cv::setNumThreads(1);
        cv::Mat expected;
        renderer.render(big(part).clone(), expected);
        for (int threads : {2, 5}) {
            cv::setNumThreads(threads);
            cv::Mat frame(c.screenH + 6, c.screenW + 4, CV_8UC3, cv::Scalar::all(7));
            cv::Mat native = frame(cv::Rect(3, 2, c.screenW, c.screenH));
            renderer.render(big(part), native);
            EXPECT_TRUE(samePicture(frame(cv::Rect(3, 2, c.screenW, c.screenH)), expected));
            EXPECT_EQ(frame.at<cv::Vec3b>(1, 1), cv::Vec3b(7, 7, 7));
            EXPECT_EQ(frame.at<cv::Vec3b>(frame.rows - 1, frame.cols - 1), cv::Vec3b(7, 7, 7));
        }
    }
}

TEST(Quilt2Native, QuiltsWithRedFirstGiveNativesWithRedFirst) {
    const QuiltLayout layout{4, 3, {17, 13}, 12};
    const cv::Mat quilt = randomPicture(layout.size(), CV_8UC3);
    cv::Mat redFirst;
    cv::cvtColor(quilt, redFirst, cv::COLOR_BGR2RGB);
    for (const TileSampling inTile : {TileSampling::Nearest, TileSampling::Linear}) {
        const Quilt2Native renderer(stripePanel(), layout, {ViewFilter::Nearest, inTile});
        cv::Mat expected;
        renderer.render(quilt, expected);
        cv::Mat native;
        renderer.render(redFirst, native, ChannelOrder::Rgb);
        cv::cvtColor(native, native, cv::COLOR_RGB2BGR);
        EXPECT_TRUE(samePicture(native, expected));
    }
}

TEST(Quilt2Native, ViewsOfFractionalSizeAreSampledWhereTheyLie) {
    const QuiltLayout layout{5, 9, {8, 5}, 45}; // of 8.8 x 5.22 px
    const cv::Mat quilt = randomPhoto({44, 47});
    const cv::Mat whole = fitQuilt(quilt, layout);
    ASSERT_EQ(whole.size(), layout.size());
    for (int view = 0; view < 45; ++view) {
        const cv::Mat tile = whole(layout.tile(view));
        const cv::Point at(view % 5, view / 5);
        const double left = at.x * 44 / 5.0; // of the view in the quilt
        const double top = 47 - (at.y + 1) * 47 / 9.0;
        for (int y = 0; y < 5; ++y) {
            for (int x = 0; x < 8; ++x) {
                // px on the border of two views show both: the view's own next to it is taken.
                // a ten-thousandth: px whose centres are on a border of px may lie on its one side
                const int column =
                    std::clamp(static_cast<int>(left + (x + 0.5) / 8 * 44 / 5.0 + 1e-4),
                               static_cast<int>(std::ceil(left - 1e-4)),
                               static_cast<int>(std::floor(left + 44 / 5.0 + 1e-4)) - 1);
                const int row = std::clamp(static_cast<int>(top + (y + 0.5) / 5 * 47 / 9.0 + 1e-4),
                                           static_cast<int>(std::ceil(top - 1e-4)),
                                           static_cast<int>(std::floor(top + 47 / 9.0 + 1e-4)) - 1);
                ASSERT_EQ(tile.at<cv::Vec3b>(y, x), quilt.at<cv::Vec3b>(row, column))
                    << view << " " << x << " " << y;
            }
        }
    }
    cv::Mat native;
    cv::Mat expected;
    const Quilt2Native renderer{NativeLut(stripePanel(), layout)};
    renderer.render(quilt, native);
    renderer.render(whole, expected);
    EXPECT_TRUE(samePicture(native, expected));
    EXPECT_TRUE(holds(errorOf([&] { return fitQuilt(randomPhoto(cv::Size(45, 47)), layout); }),
                      "has 45 x 47 px, expected 40 x 45 px"));
}

TEST(Quilt2Native, ViewsOfFractionalSizeShowNothingOfTheirNeighbours) {
    const QuiltLayout layout{5, 4, {40, 30}, 20};
    cv::Mat quilt(layout.size(), CV_8UC3);
    for (int view = 0; view < 20; ++view)
        quilt(layout.tile(view)).setTo(cv::Scalar::all(view % 5 % 2 == view / 5 % 2 ? 20 : 220));
    cv::Mat scaled; // views of 33.4 x 23.25 px, whose borders are mixed
    cv::resize(quilt, scaled, {167, 93}, 0, 0, cv::INTER_AREA);
    const QuiltLayout small{5, 4, {33, 23}, 20};
    const cv::Mat whole = fitQuilt(scaled, small);
    for (int view = 0; view < 20; ++view) {
        const int grey = view % 5 % 2 == view / 5 % 2 ? 20 : 220;
        EXPECT_EQ(cv::norm(whole(small.tile(view)),
                           cv::Mat(small.tileSize, CV_8UC3, cv::Scalar::all(grey)), cv::NORM_INF),
                  0)
            << view;
    }
}

TEST(Quilt2Native, ForAMapUnusedColumnsAtTheRightAndRowsAtTheTopAreCutOff) {
    const QuiltLayout layout{5, 9, {8, 4}, 45};
    const cv::Mat large = randomPhoto({43, 38}); // 40 x 36 and 3 columns, 2 rows more
    Notes notes;
    EXPECT_TRUE(samePicture(cropQuilt(large, layout, &notes), large(cv::Rect(0, 2, 40, 36))));
    EXPECT_TRUE(holds(only(notes).text, "3 columns at the right and 2 rows at the top"));
    EXPECT_TRUE(samePicture(cropQuilt(large(cv::Rect(0, 2, 40, 36)), layout, &notes),
                            large(cv::Rect(0, 2, 40, 36))));
    EXPECT_EQ(notes.size(), 1U);
}

TEST(Quilt2Native, ALayoutWithoutTilesIsRefused) {
    const cv::Mat picture(30, 40, CV_8UC3, cv::Scalar::all(0));
    EXPECT_EQ(errorOf([&] {
                  fitQuilt(picture, {0, 6, {9, 9}, 1});
              }),
              "quilt layout: 0 columns x 6 rows, expected 1..1024 of each");
    EXPECT_EQ(errorOf([&] {
                  fitQuilt(picture, {8, 0, {9, 9}, 1});
              }),
              "quilt layout: 8 columns x 0 rows, expected 1..1024 of each");
}

TEST(Quilt2Native, WrongSizesTypesAndSharedMemoryAreRefused) {
    const QuiltLayout layout{2, 2, {60, 40}, 4};
    const Quilt2Native renderer{NativeLut(stripePanel(120, 80), layout)};
    cv::Mat native;
    EXPECT_TRUE(holds(errorOf([&] { renderer.render(cv::Mat(80, 118, CV_8UC3), native); }),
                      "quilt: has 118 x 80 px, expected 120 x 80 px for 2 columns x 2 rows"));
    EXPECT_TRUE(holds(errorOf([&] { renderer.render(cv::Mat(80, 120, CV_16UC3), native); }),
                      "quilt: is 120 x 80 px of CV_16UC3"));
    EXPECT_NE(errorOf([&] { renderer.render(cv::Mat(), native); }), "(no error)");
    cv::Mat same(80, 120, CV_8UC3);
    EXPECT_TRUE(holds(errorOf([&] { renderer.render(same, same); }), "shares its memory"));
}

} // namespace
} // namespace altiro3D::test
