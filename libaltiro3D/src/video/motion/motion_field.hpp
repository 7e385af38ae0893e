#pragma once

#include <algorithm>
#include <opencv2/core/mat.hpp>

/// Motion fields, and resampling of images by them.
namespace altiro3D {

/// The two px around a position, with the border repeated.
struct Between {
    int low = 0;
    int high = 0;
    float share = 0; ///< Share of `high`.
};

inline Between between(float place, int count) {
    // NaN becomes 0; distant positions are clamped before the conversion to a whole number
    const float inside = place > 0 ? std::min(place, static_cast<float>(count - 1)) : 0.0F;
    Between result;
    result.low = static_cast<int>(inside);
    result.high = std::min(result.low + 1, count - 1);
    result.share = inside - static_cast<float>(result.low);
    return result;
}

/// Whether a px did not move: no interpolation is needed.
inline bool isStill(const cv::Vec2f& motion) {
    return motion[0] == 0 && motion[1] == 0;
}

/// Interpolates linearly between two values. @param share share of b, 0..1
template <class T>
T mixed(const T& a, const T& b, float share) {
    return a + (b - a) * share;
}

/// Interpolates bilinearly between four px.
template <class T>
T sampled(const cv::Mat& values, const Between& x, const Between& y) {
    const T* above = values.ptr<T>(y.low);
    const T* below = values.ptr<T>(y.high);
    return mixed(mixed(above[x.low], above[x.high], x.share),
                 mixed(below[x.low], below[x.high], x.share), y.share);
}

/// Joins two motions: x was at x + later + earlier in the first picture. Linear between px, border
/// repeated.
/// @param earlier from the middle to the first picture
/// @param later from the last to the middle picture, of the same size
/// @return from the last to the first picture [CV_32FC2, px]
cv::Mat joinMotion(const cv::Mat& earlier, const cv::Mat& later);

/// Moves values along with motion: each px takes the value where it was before. Linear between px,
/// border repeated.
/// @param before [any size, CV_32FC1]
/// @param motion [any size, CV_32FC2, px of its own size]
/// @param moved [as before, CV_32FC1]; px that did not move are copied
void carry(const cv::Mat& before, const cv::Mat& motion, cv::Mat& moved);

/// Resamples an image of one channel, linear between px, border repeated.
/// @param values [CV_32FC1]
/// @param rows, cols size of the result
/// @return [rows x cols, CV_32FC1]
cv::Mat stretched(const cv::Mat& values, int rows, int cols);

} // namespace altiro3D
