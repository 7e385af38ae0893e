// What an eye sees of the test picture, with the faults that it is to tell apart.

#include "viewer/show/presentation.hpp"

#include "altiro3D/altiro3D.hpp"
#include "support/slow.hpp"
#include "viewer_scenes.hpp"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

enum Colour { Blue, Green, Red };

// The shares of the three colours in the middle of the panel, for an eye at an angle.
std::array<double, 3> coloursFrom(double degrees, const cv::Mat& native, const Display& display) {
    cv::Mat seen;
    simulateView(native, display.calibration, eyeAtAngle(display.calibration, degrees), seen,
                 display.invert);
    const cv::Mat middle =
        seen(cv::Rect(seen.cols / 10, seen.rows * 3 / 10, seen.cols * 8 / 10, seen.rows * 4 / 10));
    std::array<double, 3> shares{};
    for (const auto& px : cv::Mat_<cv::Vec3b>(middle)) {
        const auto most = std::max_element(px.val, px.val + 3) - px.val;
        shares[static_cast<std::size_t>(most)] += 1.0 / static_cast<double>(middle.total());
    }
    return shares;
}

cv::Mat scaledAndBack(const cv::Mat& native, double factor) {
    cv::Mat scaled;
    cv::resize(native, scaled, {}, factor, factor, cv::INTER_LINEAR);
    cv::Mat shown;
    cv::resize(scaled, shown, native.size(), 0, 0, cv::INTER_LINEAR);
    return shown;
}

// The light of a part, 0..1 of white, by the sRGB curve.
double lightOf(const cv::Mat& part) {
    double sum = 0;
    for (const auto& px : cv::Mat_<cv::Vec3b>(part)) {
        const double v = px[1] / 255.0;
        sum += v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    }
    return sum / static_cast<double>(part.total());
}

// How much the rows of a part differ in pairs: bands.
double bandsOf(const cv::Mat& part) {
    cv::Mat grey;
    cv::Mat rows;
    cv::cvtColor(part, grey, cv::COLOR_BGR2GRAY);
    cv::reduce(grey, rows, 1, cv::REDUCE_AVG, CV_64F);
    cv::Mat pairs;
    cv::reduce(rows.reshape(1, part.rows / 2), pairs, 1, cv::REDUCE_AVG, CV_64F);
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(pairs, mean, deviation);
    return deviation[0];
}

TEST(ViewerTestPicture, IsRedGreenAndBlueFromTheThreeSides) {
    ALTIRO3D_TAKES(7);
    std::vector<fs::path> files = {sourcePath("calibration/portrait-sample.json")};
    if (fs::is_directory(dataPath("calibrations"))) {
        for (const char* const name :
             {"gen1-8.9in_LKG-2K-04409.json", "gen2-16in_LKG-APW92011.json",
              "gen3-16in-landscape_LKG-J00133.json", "gen3-go_bare-numbers_owner.json",
              "portrait_altiro3D-manual_LKG-PORT-19930.json"})
            files.push_back(dataPath("calibrations") / name);
    }
    for (const fs::path& file : files) {
        const Display display = displayOf(readCalibration(file), file.string());
        const cv::Mat native = makeTestPicture(display);
        const double side = 0.3 * viewConeDegrees(display.calibration);
        ASSERT_EQ(native.size(), display.panelSize());
        EXPECT_GT(coloursFrom(-side, native, display)[Red], 0.99) << file;
        EXPECT_GT(coloursFrom(0, native, display)[Green], 0.99) << file;
        EXPECT_GT(coloursFrom(side, native, display)[Blue], 0.99) << file;
    }
}

TEST(ViewerTestPicture, InvertedViewsExchangeRedAndBlue) {
    const Display display = sampleDisplay();
    Display other = display;
    other.invert = InvertViews::On;
    if (coloursFrom(-12, makeTestPicture(other), display)[Red] > 0.9)
        other.invert = InvertViews::Off;
    const cv::Mat native = makeTestPicture(other);
    EXPECT_GT(coloursFrom(-12, native, display)[Blue], 0.99);
    EXPECT_GT(coloursFrom(0, native, display)[Green], 0.99);
    EXPECT_GT(coloursFrom(12, native, display)[Red], 0.99);
}

TEST(ViewerTestPicture, AnotherCalibrationHasAnotherMiddleOrBands) {
    const Display display = sampleDisplay();
    Display other = display;
    other.calibration.center += 0.3;
    EXPECT_LT(coloursFrom(0, makeTestPicture(other), display)[Green], 0.01);
    const std::pair<double, double> wrong[] = {{1.02, 1}, {1, 1.1}}; // pitch, slope
    for (const auto& [pitch, slope] : wrong) {
        other = display;
        other.calibration.pitch *= pitch;
        other.calibration.slope *= slope;
        for (const double share : coloursFrom(0, makeTestPicture(other), display))
            EXPECT_GT(share, 0.1) << pitch << ' ' << slope;
    }
}

TEST(ViewerTestPicture, ScalingShowsBandsInTheLinesAndTakesTheEdge) {
    const cv::Mat native = makeTestPicture(sampleDisplay());
    const cv::Rect lines = testPictureParts(native.size()).lines;
    EXPECT_EQ(bandsOf(native(lines)), 0);
    for (const double factor : {0.8, 1.25, 1.1})
        EXPECT_GT(bandsOf(scaledAndBack(native, factor)(lines)), 3) << factor;
    const int last = native.cols - 1;
    EXPECT_EQ(native.at<cv::Vec3b>(native.rows / 2, last), cv::Vec3b(255, 255, 255));
    EXPECT_EQ(native.at<cv::Vec3b>(native.rows / 2, last - 1), cv::Vec3b(0, 0, 0));
    EXPECT_EQ(native.at<cv::Vec3b>(0, last / 2), cv::Vec3b(255, 255, 255));
}

TEST(ViewerTestPicture, LinesAndGreyAreEquallyBrightUnlessColoursAreChanged) {
    const cv::Mat native = makeTestPicture(sampleDisplay());
    const TestPictureParts parts = testPictureParts(native.size());
    EXPECT_NEAR(lightOf(native(parts.lines)), lightOf(native(parts.grey)), 0.01);
    for (const double gamma : {0.8, 1.25}) {
        cv::Mat changed;
        native.convertTo(changed, CV_64F, 1 / 255.0);
        cv::pow(changed, gamma, changed);
        changed.convertTo(changed, CV_8U, 255);
        EXPECT_GT(std::abs(lightOf(changed(parts.lines)) - lightOf(changed(parts.grey))), 0.05);
    }
    EXPECT_EQ(parts.steps & cv::Rect({0, 0}, native.size()), parts.steps);
    EXPECT_TRUE((parts.steps & parts.grey).empty());
    EXPECT_EQ(native(parts.steps).at<cv::Vec3b>(1, 0), cv::Vec3b(0, 0, 0));
    EXPECT_EQ(native(parts.steps).at<cv::Vec3b>(1, parts.steps.width - 1),
              cv::Vec3b(255, 255, 255));
}

TEST(ViewerTestPicture, SmallPanelsAndSingleViewsAreNoProblem) {
    Display display = sampleDisplay({16, 16});
    display.quilt = QuiltLayout();
    display.quilt.columns = display.quilt.rows = display.quilt.viewCount = 1;
    display.quilt.tileSize = {8, 8};
    EXPECT_EQ(makeTestPicture(display).size(), cv::Size(16, 16));
}

TEST(ViewerTestPicture, TheEyeSeesNumbersOneByOneWhateverTheOrderUnderTheLens) {
    const auto numbersIn = [](const std::vector<int>& order) {
        BarrierNumbers screen;
        screen.panel = {240, 160};
        screen.pitch = 12;
        screen.order = order;
        const Display display = displayOf(calibrationOf(screen));
        const cv::Mat native = makeTestPicture(display);
        std::vector<cv::Mat> numbers;
        for (int view = 0; view < 4; ++view) {
            cv::Mat seen;
            simulateView(native, display.calibration, eyeAtView(view, 4), seen);
            numbers.push_back(seen(cv::Rect(80, 55, 80, 50))); // without words and strip
        }
        return numbers;
    };
    const std::vector<cv::Mat> plain = numbersIn({0, 1, 2, 3});
    const std::vector<cv::Mat> mixed = numbersIn({2, 0, 3, 1});
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_GT(cv::countNonZero(mixed[i].clone().reshape(1) == 255), 300) << i;
        for (std::size_t k = 1; k < 4; ++k)
            EXPECT_GT(cv::norm(plain[(i + k) % 4], mixed[i], cv::NORM_L1),
                      1.5 * cv::norm(plain[i], mixed[i], cv::NORM_L1));
    }
}

} // namespace
} // namespace altiro3D::test
