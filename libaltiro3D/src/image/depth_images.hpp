#pragma once

#include <opencv2/core.hpp>

namespace altiro3D {

/// A colour picture as grey of at most 256 px per side; values without a number count as 0.
/// @param picture [rows x cols, three channels]
/// @return [CV_32FC1]
cv::Mat smallGrey(const cv::Mat& picture);

} // namespace altiro3D
