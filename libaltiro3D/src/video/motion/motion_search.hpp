#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Distance of the cells for which motion is searched, px.
constexpr int kMotionCell = 4;

/// Finds where each px of `now` was in `before`: x was at x + motion(x). Still px have exactly 0.
/// @param before, now [equal sizes, CV_8UC1]
/// @param motion [as now, CV_32FC2, px]
void findMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion);

/// Refines an approximate motion, for example from joinMotion().
/// @param motion in and out [as now, CV_32FC2, px]
void refineMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion);

} // namespace altiro3D
