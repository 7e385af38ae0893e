#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Smooths the surfaces of a depth map and keeps its steps: a bilateral filter of about 12 px and
/// two standard deviations of the noise, over a coarse grid of place and depth (Paris and Durand
/// 2006; docs/mathematics.md, 4a.1).
///
/// @param noise standard deviation of the noise, > 0
/// @param depth [CV_32FC1, 0..1], changed in place; the same bytes for any number of threads
void smoothSurfaces(double noise, cv::Mat& depth);

} // namespace altiro3D
