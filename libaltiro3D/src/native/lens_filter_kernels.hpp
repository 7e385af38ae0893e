#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Weighted sums of values: result x sums values x, x + 1, ... of each row, in the weights' order.
/// @param rows as many as weights.rows; each has kRowPadding values after the last that is read
/// @param weights [CV_32FC1]
/// @param count of results @param sums `count` results, and up to kRowPadding more
void weightedSums(const float* const* rows, const cv::Mat& weights, std::size_t count, float* sums);

} // namespace altiro3D
