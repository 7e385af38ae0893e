#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Px between the places where motion is searched.
constexpr int kMotionCell = 4;

/// Where each px of `now` was in `before`: x was at x + motion(x). What stood still has exactly 0.
/// @param before, now [equal sizes, CV_8UC1] @param motion [as now, CV_32FC2, px]
void findMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion);

/// Sets a motion right that is nearly right already, such as one that joinMotion() gave.
/// @param motion in and out [as now, CV_32FC2, px]
void refineMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion);

} // namespace altiro3D
