#include "support/eye.hpp"

#include "support/displays.hpp"
#include "support/files.hpp"

#include <cmath>
#include <gtest/gtest.h>

// The measure itself, before anything is measured by it.
namespace altiro3D::test {
namespace {

std::vector<Calibration> panels() {
    Calibration cells = stripePanel(240, 160);
    cells.CellPatternMode = 3;
    cells.subpixelCells = deltaCells();
    Calibration other = stripePanel(240, 160);
    other.slope = 5.2;
    other.invView = 0;
    other.flipSubp = 1;
    other.flipImageX = 1;
    return {stripePanel(240, 160), cells, other};
}

cv::Mat grey(cv::Size size, int value) {
    return lightOf(cv::Mat(size, CV_8UC3, cv::Scalar::all(value)));
}

TEST(EyeTwin, AUniformColourKeepsItsColourOnEveryKindOfPanel) {
    for (const Calibration& c : panels()) {
        const cv::Mat light(c.screenH, c.screenW, CV_32FC3, cv::Scalar(0.1, 0.5, 0.3));
        const LensTwin lens(lensGeometry(c));
        for (const double phase : {0.1, 0.5, 0.77}) {
            const cv::Scalar seen = cv::mean(lens.seen(light, phase));
            // The lenses of the border are cut: some 2 % of all.
            EXPECT_NEAR(seen[0], 0.1, 0.002);
            EXPECT_NEAR(seen[1], 0.5, 0.01);
            EXPECT_NEAR(seen[2], 0.3, 0.006);
        }
    }
}

TEST(EyeTwin, ASubPixelFillsItsLensInItsDirectionAlone) {
    for (const Calibration& c : panels()) {
        const LensGeometry g = lensGeometry(c);
        const LensTwin lens(g);
        for (int channel = 0; channel < 3; ++channel) {
            cv::Mat light(c.screenH, c.screenW, CV_32FC3, cv::Scalar::all(0));
            const cv::Point at(101, 73);
            light.at<cv::Vec3f>(at)[2 - channel] = 1;
            const double phase = g.phase(at.x, at.y, channel);
            const cv::Mat seen = lens.seen(light, phase);
            // The width of a lens, with the light of three sub-pixels; cells have other widths.
            const double width = g.lensPeriodSubpixels;
            EXPECT_NEAR(cv::sum(seen)[2 - channel], width, g.cells.empty() ? 2 : 0.3 * width);
            const int reach = static_cast<int>(g.lensPeriodSubpixels / 6) + 1;
            EXPECT_EQ(cv::sum(seen)[2 - channel],
                      cv::sum(seen(cv::Rect(at.x - reach, at.y, 2 * reach + 1, 1)))[2 - channel]);
            EXPECT_EQ(cv::norm(lens.seen(light, phase + 0.25)), 0);
        }
    }
}

TEST(EyeTwin, AStepStaysWithinALens) {
    const Calibration c = stripePanel(240, 160);
    const LensGeometry g = lensGeometry(c);
    cv::Mat light(c.screenH, c.screenW, CV_32FC3, cv::Scalar::all(0));
    light.colRange(120, 240).setTo(cv::Scalar::all(1));
    const cv::Mat seen = LensTwin(g).seen(light, 0.3);
    cv::Mat sum;
    cv::transform(seen, sum, cv::Matx13f(1, 1, 1));
    const int reach = static_cast<int>(g.lensPeriodSubpixels / 6) + 1;
    EXPECT_EQ(cv::norm(sum.colRange(0, 120 - reach)), 0);
    double least = 0;
    cv::minMaxLoc(sum.colRange(120 + reach, 240), &least);
    EXPECT_EQ(least, 3);
}

// The figures of another program in another language: 38.63 dB and 1.227.
TEST(EyeTwin, PlainGreyHasTheFiguresOfTheMosaic) {
    const Calibration c = readCalibration(sourcePath("calibration/portrait-sample.json"));
    const LensTwin lens(lensGeometry(c));
    const cv::Mat light = grey({c.screenW, c.screenH}, 128);
    const EyeDifference d = eyeDifference(blurredByEye(lens.seen(light, 0.5)), blurredByEye(light));
    EXPECT_NEAR(d.luminancePsnr[1], 38.63, 0.03); // another direction: 0.01
    EXPECT_LT(d.luminancePsnr[0], d.luminancePsnr[1]);
    EXPECT_GT(d.luminancePsnr[2], d.luminancePsnr[1]);
    EXPECT_NEAR(d.chroma, 1.227, 0.003);
}

// Waves far longer than a lens come through as high as they were, in both directions.
TEST(EyeTwin, LongWavesPassUnchanged) {
    const Calibration c = stripePanel(480, 480);
    const LensTwin lens(lensGeometry(c));
    for (const bool across : {true, false}) {
        cv::Mat wave(c.screenH, c.screenW, CV_32FC1);
        for (int y = 0; y < wave.rows; ++y) {
            for (int x = 0; x < wave.cols; ++x) {
                wave.at<float>(y, x) =
                    static_cast<float>(std::sin(2 * CV_PI * (across ? x : y) / 120.0));
            }
        }
        cv::Mat light;
        cv::merge(std::vector<cv::Mat>(3, 0.4 + 0.2 * wave), light);
        for (const double phase : {0.2, 0.5, 0.8}) {
            cv::Mat luminance;
            cv::transform(lens.seen(light, phase), luminance,
                          cv::Matx13f(0.0722F, 0.7152F, 0.2126F));
            EXPECT_NEAR(luminance.dot(wave) / wave.dot(wave), 0.2, 0.002) << across << phase;
        }
    }
}

TEST(EyeTwin, TheCurveOfSrgbGoesThereAndBack) {
    cv::Mat codes(1, 256, CV_8UC3);
    for (int i = 0; i < 256; ++i)
        codes.at<cv::Vec3b>(i) = cv::Vec3b::all(static_cast<uchar>(i));
    const cv::Mat light = lightOf(codes);
    for (int i = 0; i < 256; ++i)
        EXPECT_NEAR(255 * srgbCode(light.at<cv::Vec3f>(i)[0]), i, 0.001);
    EXPECT_NEAR(light.at<cv::Vec3f>(188)[1], 0.5, 0.004); // half the light
}

} // namespace
} // namespace altiro3D::test
