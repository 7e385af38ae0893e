#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

/// What a sensor or a match does not see is behind what it sees.
namespace altiro3D {

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

} // namespace altiro3D
