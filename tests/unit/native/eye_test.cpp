#include "support/eye.hpp"

#include "altiro3D/lens_view.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"
#include "support/slow.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

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

// The figures of another program in another language: 38.63 dB and 1.227.
TEST(EyeTwin, PlainGreyHasTheFiguresOfTheMosaic) {
    ALTIRO3D_TAKES(0.7);
    const Calibration c = readCalibration(sourcePath("calibration/portrait-sample.json"));
    const LensTwin lens(lensGeometry(c));
    const cv::Mat light = lightOf(cv::Mat(c.screenH, c.screenW, CV_8UC3, cv::Scalar::all(128)));
    const EyeDifference d = eyeDifference(blurredByEye(lens.seen(light, 0.5)), blurredByEye(light));
    EXPECT_NEAR(d.luminancePsnr[1], 38.63, 0.03); // another direction: 0.01
    EXPECT_LT(d.luminancePsnr[0], d.luminancePsnr[1]);
    EXPECT_GT(d.luminancePsnr[2], d.luminancePsnr[1]);
    EXPECT_NEAR(d.chroma, 1.227, 0.003);
}

// The picture of LensEye::blur: colour of one blur, luminance of another.
cv::Mat referenceBlurred(const cv::Mat& native, const Calibration& c, const LensEye& eye) {
    const cv::Mat light = LensTwin(lensGeometry(c)).seen(lightOf(native), eye.phase);
    const cv::Matx13f weights(0.0722F, 0.7152F, 0.2126F);
    cv::Mat colour;
    cv::Mat luminance;
    cv::GaussianBlur(light, colour, {}, 2 * eye.blur, 0, cv::BORDER_REFLECT);
    cv::transform(light, luminance, weights);
    cv::GaussianBlur(luminance, luminance, {}, eye.blur, 0, cv::BORDER_REFLECT);
    cv::Mat seen(native.size(), CV_8UC3);
    seen.forEach<cv::Vec3b>([&](cv::Vec3b& to, const int* at) {
        const cv::Vec3f& own = colour.at<cv::Vec3f>(at[0], at[1]);
        const float scale = luminance.at<float>(at[0], at[1]) /
                            (weights(0) * own[0] + weights(1) * own[1] + weights(2) * own[2]);
        for (int i = 0; i < 3; ++i)
            to[i] = cv::saturate_cast<uchar>(
                255 * srgbCode(std::min(1.0, static_cast<double>(scale * own[i]))));
    });
    return seen;
}

TEST(EyeBlur, IsThePictureOfTheTwinOnEveryKindOfPanel) {
    for (Calibration c : panels()) {
        c.flipImageX = 0; // the twin's pictures stay mirrored
        const cv::Mat native = randomPhoto({c.screenW, c.screenH}, 1, 0);
        for (const LensEye& eye :
             {LensEye{0.5, 0, 3}, LensEye{-3.2, 0.3, 1.25}, LensEye{0.98, 0, 9}}) {
            cv::Mat seen;
            simulateView(native, c, eye, seen);
            // 1: weights in float and light by a table of 4096 steps, rounded to codes.
            EXPECT_TRUE(samePicture(seen, referenceBlurred(native, c, eye), 1));
        }
    }
}

TEST(EyeBlur, MirroredPanelsAreSeenUnmirrored) {
    Calibration c = panels().back();
    ASSERT_EQ(c.flipImageX, 1);
    const cv::Mat native = randomPhoto({c.screenW, c.screenH}, 1, 0);
    const LensEye eye{0.5, 0, 3};
    cv::Mat seen;
    simulateView(native, c, eye, seen);
    cv::flip(seen, seen, 1);
    EXPECT_TRUE(samePicture(seen, referenceBlurred(native, c, eye), 1)); // as above
}

TEST(EyeBlur, SmallPanelsThreadsAndWorkingInPlaceChangeNothing) {
    const Calibration c = stripePanel(31, 147); // reflected more than once
    const cv::Mat native = randomPhoto({31, 147}, 1, 0);
    const LensEye eye{0.4, 0, 12};
    const RestoredThreads restored;
    cv::setNumThreads(1);
    cv::Mat expected;
    simulateView(native, c, eye, expected);
    for (const int count : {2, 3, 5}) {
        cv::setNumThreads(count);
        cv::Mat seen = native.clone();
        simulateView(seen, c, eye, seen);
        EXPECT_TRUE(samePicture(seen, expected)) << count;
    }
}

TEST(EyeBlur, IsThreePixelsOfAPortraitAtHalfAMetre) {
    Calibration c = stripePanel(64, 48);
    EXPECT_DOUBLE_EQ(eyeBlur(c), 3);
    EXPECT_DOUBLE_EQ(eyeBlur(c, 25), 1.5);
    // 1.6 arc minutes
    EXPECT_NEAR(std::atan(3 * 25.4 / 324 / 500) * 180 * 60 / CV_PI, 1.6, 0.02);
    c.DPI = 162;
    EXPECT_DOUBLE_EQ(eyeBlur(c), 1.5);
    EXPECT_EQ(errorOf([&] { (void)eyeBlur(c, 9); }),
              "distanceCentimetres: is 9, expected 10..1000");
    cv::Mat seen;
    const cv::Mat native = randomPhoto({64, 48}, 1, 0);
    for (const double blur : {-1.0, 64.5, std::nan("")}) {
        const LensEye eye{0.5, 0, blur};
        EXPECT_TRUE(holds(errorOf([&] { simulateView(native, c, eye, seen); }), "expected 0..64"));
    }
}

} // namespace
} // namespace altiro3D::test
