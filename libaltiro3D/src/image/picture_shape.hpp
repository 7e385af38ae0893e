#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// Whether two pictures can be those of two eyes: shapes within 5 %, or 1 px of small pictures.
inline bool canBeEyes(cv::Size left, cv::Size right) {
    constexpr double kTolerance = 0.05;
    const double ratio = static_cast<double>(left.width) * right.height /
                         (static_cast<double>(right.width) * left.height);
    return std::abs(ratio - 1) <= kTolerance ||
           std::max(std::abs(left.width - right.width), std::abs(left.height - right.height)) <= 1;
}

/// Whether two pictures have the same shape within 2 %, as a photo and its depth.
inline bool haveOneShape(cv::Size a, cv::Size b) {
    constexpr double kTolerance = 0.02;
    const double ratio =
        static_cast<double>(a.width) * b.height / (static_cast<double>(a.height) * b.width);
    return std::abs(ratio - 1) <= kTolerance;
}

} // namespace altiro3D
