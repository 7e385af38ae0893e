#include "depth/network/network_estimate.hpp"

#include "support/compare.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D::test {
namespace {

const cv::Size kSize(320, 240);

cv::Mat depthOf(cv::Size size, const std::function<double(double x, double y)>& value) {
    cv::Mat depth(size, CV_32FC1);
    forPixels(size, [&](int x, int y) { depth.at<float>(y, x) = static_cast<float>(value(x, y)); });
    return depth;
}

// A plane in space.
double plane(double x, double y) {
    return 0.2 + 0.001 * x + 0.0005 * y;
}

// What a network adds to a plane.
double waver(double x, double y) {
    return 0.03 * std::sin(x / 14 + y / 50);
}

cv::Mat straightened(const std::vector<cv::Vec4f>& lines, const cv::Mat& depth) {
    cv::Mat result = depth.clone();
    straightenLines(lines, result);
    return result;
}

double rms(const cv::Mat& depth, const cv::Mat& truth) {
    return cv::norm(depth, truth) / std::sqrt(static_cast<double>(truth.total()));
}

// Level lines over a plane, as of a facade.
std::vector<cv::Vec4f> facade() {
    std::vector<cv::Vec4f> lines;
    for (int y = 20; y < 230; y += 24)
        lines.emplace_back(cv::Vec4i(10, y, 310, y + 5));
    return lines;
}

TEST(DepthLines, TheLongEdgesOfAQuadrilateralAreFoundAndTheFrameIsNot) {
    const std::array<cv::Point, 4> corners{cv::Point(60, 50), {270, 30}, {250, 200}, {40, 170}};
    for (const int frame : {0, 1, 3}) { // px
        cv::Mat photo(kSize, CV_8UC3, cv::Scalar(90, 130, 60));
        cv::fillConvexPoly(photo, corners, {200, 220, 230});
        cv::rectangle(photo, {120, 90, 15, 15}, {20, 30, 40}, cv::FILLED); // of short edges
        if (frame > 0) cv::rectangle(photo, cv::Rect({}, kSize), {250, 250, 250}, 2 * frame - 1);
        const std::vector<cv::Vec4f> lines = findLines(photo);
        EXPECT_EQ(lines.size(), corners.size()) << frame;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const cv::Point2f a = corners[i];
            const cv::Point2f b = corners[(i + 1) % corners.size()];
            const auto isSide = [&](const cv::Vec4f& line) {
                const cv::Point2f c(line[0], line[1]);
                const cv::Point2f d(line[2], line[3]);
                return std::min(std::max(cv::norm(a - c), cv::norm(b - d)),
                                std::max(cv::norm(a - d), cv::norm(b - c))) < 4; // px
            };
            EXPECT_EQ(std::count_if(lines.begin(), lines.end(), isSide), 1) << frame << " " << i;
        }
    }
}

TEST(DepthLines, AffineDepthStays) {
    const cv::Mat depth = depthOf(kSize, plane);
    const std::vector<cv::Vec4f> lines{
        {10, 20, 300, 20}, {200, 230, 200, 9}, {13.4F, 200.2F, 290.7F, 33.3F}};
    // px lie up to half a px beside an oblique line
    EXPECT_TRUE(samePicture(straightened(lines, depth), depth, 0.5 * (0.001 + 0.0005)));
}

TEST(DepthLines, DepthThatWaversAlongEdgesComesCloseToItsPlane) {
    const cv::Mat truth = depthOf(kSize, plane);
    const cv::Mat wrong =
        depthOf(kSize, [](double x, double y) { return plane(x, y) + waver(x, y); });
    const cv::Mat result = straightened(facade(), wrong);
    for (const cv::Vec4f& line : facade()) {
        const cv::Rect at(10, cvRound(line[1]), 301, 5);
        EXPECT_LT(rms(result(at), truth(at)), rms(wrong(at), truth(at)) / 3) << at;
    }
    EXPECT_LT(rms(result, truth), 0.6 * rms(wrong, truth)); // also between them; measured: 0.45
}

// The px of `depth` above a border that falls slowly.
cv::Mat pixelsAbove(double middle) {
    return depthOf(kSize, [&](double x, double y) { return y < middle + x / 60 ? 1 : 0; }) > 0;
}

TEST(DepthLines, StepsBesideLinesAreNotBridged) {
    const cv::Mat isNear = pixelsAbove(120);
    for (const double height : {0.08, 0.15, 0.4}) {
        cv::Mat truth = depthOf(kSize, plane) * 0.5;
        cv::Mat wrong = truth + depthOf(kSize, waver);
        cv::Mat(truth + height).copyTo(truth, isNear);
        truth.copyTo(wrong, isNear);
        for (const float aside : {0.0F, 2.0F, 4.0F}) { // the line is at the border, and below it
            const cv::Mat result = straightened({{0, 120 + aside, 319, 125.3F + aside}}, wrong);
            EXPECT_LT(cv::norm(result, truth, cv::NORM_INF, isNear), 5e-4) << height << aside;
            EXPECT_LT(cv::norm(result, truth, cv::NORM_INF, ~isNear), 0.0301) << height << aside;
            const cv::Mat below = pixelsAbove(120 + aside + 3) & ~isNear;
            EXPECT_LT(cv::norm(result, truth, cv::NORM_L2, below),
                      0.5 * cv::norm(wrong, truth, cv::NORM_L2, below))
                << height << aside;
        }
    }
}

TEST(DepthLines, ALineOverTwoThingsStaysOnBoth) {
    for (const double height : {0.05, 0.15, 0.3, 0.6}) {
        for (const double part : {0.5, 0.6, 0.7}) {
            const cv::Mat truth = depthOf(kSize, [&](double x, double y) {
                return plane(x, y) / 2 + (x < 20 + 280 * part ? 0 : height);
            });
            const std::vector<cv::Vec4f> lines{{20, 120, 300, 120}};
            // float against double
            EXPECT_TRUE(samePicture(straightened(lines, truth), truth, 1e-6)) << height << part;
            const cv::Mat wrong = truth + depthOf(kSize, waver);
            const cv::Rect at(20, 118, 281, 5);
            EXPECT_LT(rms(straightened(lines, wrong)(at), truth(at)),
                      rms(wrong(at), truth(at)) * 0.6)
                << height << part;
        }
    }
}

TEST(DepthLines, AnEdgeThatIsNotStraightInSpaceStays) {
    const cv::Mat depth = depthOf(kSize, [](double x, double) {
        const double along = (x - 20) / 280;
        return 0.2 + 2.4 * along * (1 - along);
    });
    EXPECT_TRUE(samePicture(straightened({{20, 120, 300, 120}}, depth), depth));
}

TEST(DepthLines, TheyAreThoseOfTheFormulas) {
    for (const cv::Size size : {cv::Size(61, 47), {131, 97}, {1, 40}, {23, 1}, {1, 1}}) {
        const cv::Mat depth = depthOf(size, [&](double x, double y) {
            return plane(x, y) + waver(x, y) + (x > 70 ? 0.3 : 0) + (y > 60 && y < 80 ? 0.015 : 0);
        });
        const auto right = static_cast<float>(size.width);
        const auto down = static_cast<float>(size.height);
        const std::vector<cv::Vec4f> lines{{0, down / 2, right, down / 2},
                                           {0, 2, right / 2, down - 3},
                                           {right * 0.7F, -9, right * 0.75F, down + 9}};
        const cv::Mat result = straightened(lines, depth);
        // float against double
        EXPECT_TRUE(samePicture(result, referenceStraightenLines(lines, depth), 1e-6)) << size;
        if (size.area() > 1000) {
            EXPECT_GT(compare(result, depth, 0.01).count, 100U) << size;
        }
    }
}

TEST(DepthLines, TheMembraneIsNearlyAtRest) {
    const cv::Size size(61, 47);
    const cv::Mat depth =
        depthOf(size, [](double x, double y) { return plane(x, y) + waver(x, y); });
    const std::vector<cv::Vec4f> lines{{0, 23, 60, 20}, {3, 2, 30, 44}};
    const cv::Mat rest = referenceStraightenLines(lines, depth, 2000);
    const double change = cv::norm(rest, depth, cv::NORM_INF);
    EXPECT_GT(change, 0.02);
    // it has passes for the px near the lines
    EXPECT_TRUE(samePicture(straightened(lines, depth), rest, change / 5));
}

TEST(DepthLines, TheyDoNotDependOnTheNumberOfThreads) {
    const cv::Mat wrong =
        depthOf(kSize, [](double x, double y) { return plane(x, y) + waver(x, y); });
    expectSameForAnyThreads([&] { return straightened(facade(), wrong); });
}

TEST(DepthLines, WithoutLinesDepthStays) {
    const cv::Mat depth = randomDepth({97, 61});
    EXPECT_TRUE(samePicture(straightened({}, depth), depth));
    const cv::Mat plain(depth.size(), CV_8UC3, cv::Scalar(90, 130, 60));
    EXPECT_TRUE(findLines(plain).empty());
}

TEST(DepthLines, SmallPicturesAndLinesBeyondThemAreDefined) {
    for (const cv::Size size : {cv::Size(1, 1), {2, 1}, {1, 40}, {40, 1}, {17, 3}}) {
        const cv::Mat photo = randomPhoto(size, 1, 0);
        EXPECT_TRUE(findLines(photo).empty()) << size;
        const cv::Mat depth(size, CV_32FC1, cv::Scalar(0.5));
        const std::vector<cv::Vec4f> lines{
            {0, 0, 1, 0}, {-50, -50, 90, 90}, {500, 0, 600, 0}, {0, 0, 0, 0}};
        // the fit rounds
        EXPECT_TRUE(samePicture(straightened(lines, depth), depth, 1e-6)) << size;
    }
}

} // namespace
} // namespace altiro3D::test
