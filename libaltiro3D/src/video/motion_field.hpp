#pragma once

#include <algorithm>
#include <opencv2/core/mat.hpp>

/// Motion fields and images that are resampled by them.
namespace altiro3D {

/// Where between two px a place falls, with the border repeated.
struct Between {
    int low = 0;
    int high = 0;
    float share = 0; ///< Of `high`.
};

inline Between between(float place, int count) {
    // NaN ends up at 0; places far out do, before they become whole numbers, at the border
    const float inside = place > 0 ? std::min(place, static_cast<float>(count - 1)) : 0.0F;
    Between result;
    result.low = static_cast<int>(inside);
    result.high = std::min(result.low + 1, count - 1);
    result.share = inside - static_cast<float>(result.low);
    return result;
}

/// Linear between two values. @param share of b, 0..1
template <class T>
T mixed(const T& a, const T& b, float share) {
    return a + (b - a) * share;
}

/// Linear between four px.
template <class T>
T sampled(const cv::Mat& values, const Between& x, const Between& y) {
    const T* above = values.ptr<T>(y.low);
    const T* below = values.ptr<T>(y.high);
    return mixed(mixed(above[x.low], above[x.high], x.share),
                 mixed(below[x.low], below[x.high], x.share), y.share);
}

/// Motion over two steps: x was at x + first + second there. Linear between px, border repeated.
/// @param earlier from the middle to the start @param later from the end to the middle
/// @return from the end to the start [CV_32FC2, px]
cv::Mat joinMotion(const cv::Mat& earlier, const cv::Mat& later);

/// Picture values where px were before, linear between px, the border repeated.
/// @param before [any size, CV_32FC1] @param motion [any size, CV_32FC2, px of its own size]
/// @param moved [as before, CV_32FC1]; px that did not move are copied
void carry(const cv::Mat& before, const cv::Mat& motion, cv::Mat& moved);

/// Enlarges or shrinks a picture of single numbers, linear between px, the border repeated.
/// @param values [CV_32FC1] @param rows, cols of the result @return [rows x cols, CV_32FC1]
cv::Mat stretched(const cv::Mat& values, int rows, int cols);

} // namespace altiro3D
