#pragma once

// Resampling of depth without a picture.

#include <opencv2/core.hpp>

namespace altiro3D {

// As fitDepth() without a guide: enlarges by linear interpolation, without regard to edges. Method
// Fast makes views of the same accuracy from it (docs/lab/edges.md), in less time. The same bytes
// on all processors, and in a quarter of the time of cv::warpAffine().
// @param size of the result
// @throws Error as fitDepth()
void interpolateDepth(const cv::Mat& depth, const cv::Rect2d& part, cv::Size size, cv::Mat& fitted);

} // namespace altiro3D
