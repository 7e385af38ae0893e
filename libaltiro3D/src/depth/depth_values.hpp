#pragma once

#include <opencv2/core.hpp>

namespace altiro3D {

/// A copy of a depth map with all values in 0..1; NaN becomes 0.
inline cv::Mat withinRange(const cv::Mat& depth) {
    cv::Mat result(depth.size(), CV_32FC1);
    for (int y = 0; y < depth.rows; ++y) {
        const float* const from = depth.ptr<float>(y);
        float* const to = result.ptr<float>(y);
        for (int x = 0; x < depth.cols; ++x)
            to[x] = from[x] > 0 ? (from[x] < 1 ? from[x] : 1.0F) : 0.0F;
    }
    return result;
}

} // namespace altiro3D
