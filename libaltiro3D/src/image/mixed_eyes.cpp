#include "altiro3D/image_io.hpp"

#include "base/checks.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

constexpr int kMinSide = 128; // px

// How much a row differs from the next one, relative to the one after that: below 1 for photos,
// which are smooth.
double combOf(const cv::Mat& picture) {
    const auto differenceAt = [&](int distance) {
        const int count = picture.rows - 2;
        return cv::norm(picture.rowRange(0, count), picture.rowRange(distance, distance + count),
                        cv::NORM_L1);
    };
    return differenceAt(1) / std::max(1.0, differenceAt(2));
}

// Share of the px with detail whose red is shifted against green.
double shiftedShare(const cv::Mat& picture) {
    constexpr int kWidth = 640;     // px to which the picture is shrunk
    const cv::Size kBlock(48, 16);  // px
    constexpr double kDetail = 6;   // grey levels
    constexpr double kAlike = 0.75; // correlation
    constexpr double kClear = 0.25; // above that of unshifted px
    cv::Mat small = picture;
    if (picture.cols > kWidth)
        cv::resize(picture, small, {kWidth, std::max(1, picture.rows * kWidth / picture.cols)}, 0,
                   0, cv::INTER_AREA);
    const int reach = small.cols / 12;
    const auto edgesOf = [&](int channel) {
        cv::Mat plane;
        cv::extractChannel(small, plane, channel);
        cv::Mat edges;
        cv::Sobel(plane, edges, CV_32F, 1, 0, 3, 0.25);
        return edges;
    };
    const cv::Mat red = edgesOf(2);
    const cv::Mat green = edgesOf(1);
    int shifted = 0;
    int aligned = 0;
    for (int y = 0; y + kBlock.height <= small.rows; y += kBlock.height) {
        for (int x = reach; x + kBlock.width + reach <= small.cols; x += kBlock.width) {
            const cv::Mat block = red(cv::Rect({x, y}, kBlock));
            if (cv::norm(block) < kDetail * std::sqrt(kBlock.area())) continue;
            cv::Mat fit; // by shift
            cv::matchTemplate(
                green(cv::Rect(x - reach, y, kBlock.width + 2 * reach, kBlock.height)), block, fit,
                cv::TM_CCORR_NORMED);
            double best = 0;
            double still = 0;
            cv::Point at;
            cv::minMaxLoc(fit, nullptr, &best, nullptr, &at);
            cv::minMaxLoc(fit.colRange(reach - 1, reach + 2), nullptr, &still);
            if (best < kAlike) continue;
            if (std::abs(at.x - reach) > 1 && best - still > kClear) ++shifted;
            if (std::abs(at.x - reach) <= 1) ++aligned;
        }
    }
    constexpr int kFewest = 4;
    return shifted < kFewest ? 0 : static_cast<double>(shifted) / (shifted + aligned);
}

} // namespace

std::string mixedEyes(const cv::Mat& picture) try {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
    constexpr double kComb = 1.2;
    constexpr double kShifted = 0.15;
    if (std::min(picture.cols, picture.rows) < kMinSide) return {};
    cv::Mat turned;
    cv::transpose(picture, turned);
    const double rows = combOf(picture);
    const double columns = combOf(turned);
    // dots of printed and of dithered pictures differ in both directions
    const char* lines = nullptr;
    if (rows > kComb && columns < 1) lines = "row";
    if (columns > kComb && rows < 1) lines = "column";
    const std::string instead =
        " is read as one picture, whose depth is wrong, expected the pictures "
        "of both eyes beside or above each other, or that of one eye";
    if (lines != nullptr)
        return std::string("looks interlaced, as every second ") + lines +
               " is of another picture, and" + instead;
    if (shiftedShare(picture) <= kShifted) return {};
    return "looks like a red-cyan anaglyph, as its red is shifted against its green, and" + instead;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
