#pragma once

#include "altiro3D/depth_map.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Turns the soft steps of a depth map into hard ones where the photo has an edge. Each px of a
/// step takes the side to which its depth and its colour belong. Contours are smoothed by a median.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param flaws softness (> 0 px) and blur of the steps, which are equally soft
/// @param depth [as photo, CV_32FC1, 0..1], changed in place; the same bytes for any number of
///        threads
void sharpenSteps(const cv::Mat& photo, const DepthFlaws& flaws, cv::Mat& depth);

} // namespace altiro3D
