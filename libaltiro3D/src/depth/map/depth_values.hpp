#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace altiro3D {

/// A value of a depth map within 0..1; NaN becomes 0.
inline float withinRange(float value) {
    return value > 0 ? (value < 1 ? value : 1.0F) : 0.0F;
}

/// A copy of a depth map with all values in 0..1; NaN becomes 0.
inline cv::Mat withinRange(const cv::Mat& depth) {
    cv::Mat result(depth.size(), CV_32FC1);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const float* const from = depth.ptr<float>(y);
            float* const to = result.ptr<float>(y);
            for (int x = 0; x < depth.cols; ++x)
                to[x] = withinRange(from[x]);
        }
    });
    return result;
}

/// A depth map at another size: the values at the centres of its px, in 0..1; NaN becomes 0.
inline cv::Mat sampledDepth(const cv::Mat& depth, cv::Size size) {
    const auto placeOf = [](int i, int from, int to) {
        return static_cast<int>((2 * std::int64_t{i} + 1) * from / (2 * std::int64_t{to}));
    };
    cv::Mat result(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y) {
        const float* const from = depth.ptr<float>(placeOf(y, depth.rows, size.height));
        float* const to = result.ptr<float>(y);
        for (int x = 0; x < size.width; ++x)
            to[x] = withinRange(from[placeOf(x, depth.cols, size.width)]);
    }
    return result;
}

} // namespace altiro3D
