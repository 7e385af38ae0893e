#pragma once

#include "base/pixel_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

/// A value of a depth map within 0..1; NaN becomes 0.
inline float withinRange(float value) {
    return value > 0 ? (value < 1 ? value : 1.0F) : 0.0F;
}

/// Number of px with 65535 in distances of 16 bits, if 65535 means unknown; 0 if distances reach up
/// to it, so that it is the farthest that fits.
/// @param raw any type; others than CV_16UC1 have none
int unknownFarthest(const cv::Mat& raw);

/// A copy of a depth map with all values in 0..1; NaN becomes 0.
inline cv::Mat withinRange(const cv::Mat& depth) {
    return mapped<float, float>(depth, [](float value) { return withinRange(value); });
}

/// A depth map at another size: the values at the centres of its px, in 0..1; NaN becomes 0.
inline cv::Mat sampledDepth(const cv::Mat& depth, cv::Size size) {
    cv::Mat result(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y) {
        const float* const from = depth.ptr<float>(nearestSample(y, size.height, depth.rows));
        float* const to = result.ptr<float>(y);
        for (int x = 0; x < size.width; ++x)
            to[x] = withinRange(from[nearestSample(x, size.width, depth.cols)]);
    }
    return result;
}

/// NaN in a row takes the smaller (farther) of the known values beside it.
/// @return false if no value is known; the row is then unchanged
inline bool fillUnknown(float* row, int columns) {
    constexpr float kNone = std::numeric_limits<float>::infinity();
    for (int x = 0; x < columns; ++x) {
        if (!std::isnan(row[x])) continue;
        const int begin = x;
        while (x < columns && std::isnan(row[x]))
            ++x;
        const float behind =
            std::min(begin > 0 ? row[begin - 1] : kNone, x < columns ? row[x] : kNone);
        if (begin == 0 && x == columns) return false;
        std::fill(row + begin, row + x, behind);
    }
    return true;
}

/// Rows without known values become copies of the nearest row that has some (of two, the upper).
/// @param known for each row, whether it has some
inline void fillUnknownRows(cv::Mat& depth, const std::vector<char>& known) {
    const int rows = depth.rows;
    std::vector<int> below(static_cast<std::size_t>(rows), -1);
    for (int y = rows - 1, next = -1; y >= 0; --y) {
        if (known[static_cast<std::size_t>(y)] != 0) next = y;
        below[static_cast<std::size_t>(y)] = next;
    }
    for (int y = 0, above = -1; y < rows; ++y) {
        if (known[static_cast<std::size_t>(y)] != 0) {
            above = y;
            continue;
        }
        const int next = below[static_cast<std::size_t>(y)];
        if (above < 0 && next < 0) return;
        const bool takeAbove = next < 0 || (above >= 0 && y - above <= next - y);
        depth.row(takeAbove ? above : next).copyTo(depth.row(y));
    }
}

/// All unknown values of a map take those of their row or, in rows without any, of the nearest row.
inline void fillUnknown(cv::Mat& depth) {
    std::vector<char> known(static_cast<std::size_t>(depth.rows));
    for (int y = 0; y < depth.rows; ++y)
        known[static_cast<std::size_t>(y)] =
            static_cast<char>(fillUnknown(depth.ptr<float>(y), depth.cols));
    fillUnknownRows(depth, known);
}

/// The photo as pathCosts() needs it, with less noise. @param photo [CV_8UC3] @return the same size
cv::Mat withoutGrain(const cv::Mat& photo);

/// Finds the cost of the cheapest path to each px from the px that have a cost already. A step
/// costs the difference of the colours (largest channel, less 3 for noise; docs/mathematics.md,
/// 4b). Approximate: two rounds over the picture.
/// @param photo [rows x cols, CV_8UC3], from withoutGrain()
/// @param perPixel what a step costs in addition
/// @param costs [as photo, CV_32FC1]: 0 or more where paths begin, kFarAway elsewhere
void pathCosts(const cv::Mat& photo, float perPixel, cv::Mat& costs);

/// The cost of a px that no path has reached.
constexpr float kFarAway = 1e9F;

} // namespace altiro3D
