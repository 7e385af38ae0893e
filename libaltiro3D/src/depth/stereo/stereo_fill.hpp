#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Fills the unknown disparities of a pair. Each takes the farther of the nearest known values to
/// its left and right in the row, as what one eye misses lies behind. Then each filled px takes the
/// median of its surroundings, weighted by the likeness of the colours (bilateral weights, as in
/// Hosni et al. 2013), twice, which removes streaks along the rows.
///
/// @param disparity [rows x cols, CV_32FC1, NaN = unknown], at least one known; filled in place
/// @param photo [as disparity, CV_8UC3, BGR]
void fillFromBehind(cv::Mat& disparity, const cv::Mat& photo);

} // namespace altiro3D
