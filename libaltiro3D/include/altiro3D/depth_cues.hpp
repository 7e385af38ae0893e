#pragma once

#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Estimates depth from one photo without any network or download.
///
/// The function combines monocular cues of the picture and smooths the result along the photo's
/// edges; docs/depth.md lists the cues and their accuracy. It is the built-in default if no depth
/// network is found. It is always defined and gives the same result for any number of threads. A
/// trained network is much more accurate.
///
/// @param photo [rows x cols, CV_8UC3, BGR], any size from 1 x 1
/// @param depth [smaller or equal size of the same shape, at most 320 px a side, CV_32FC1, 0..1, 1
///        = nearest]; fitDepth() brings it to the photo's size
/// @throws Error InvalidArgument (empty or wrong type)
ALTIRO3D_EXPORT void estimateDepthFromCues(const cv::Mat& photo, cv::Mat& depth);

} // namespace altiro3D
