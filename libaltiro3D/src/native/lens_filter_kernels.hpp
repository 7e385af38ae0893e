#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Weighted sums of the px around those of a row, each in the order of the weights.
/// @param rows as many as weights.rows; each starts weights.cols / 2 values left of the first
///        result, and has kRowPadding values after the last that is read
/// @param weights [odd x odd, CV_32FC1]
/// @param count of results @param sums `count` results, and up to kRowPadding more
void weightedSums(const float* const* rows, const cv::Mat& weights, std::size_t count, float* sums);

} // namespace altiro3D
