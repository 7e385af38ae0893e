#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// The size of downscale()'s result. @param size >= 1 px a side @param longestSide >= 1
cv::Size downscaledSize(cv::Size size, int longestSide);

/// The photo's area average with at most `longestSide` px per side; a copy if it is small enough.
/// It uses whole numbers only, so the result is exact on any processor and for any number of
/// threads. The mirrored photo gives the mirrored result.
/// @param photo [rows x cols, CV_8UC3] @param longestSide >= 1 @return [CV_8UC3]
cv::Mat downscale(const cv::Mat& photo, int longestSide);

} // namespace altiro3D
