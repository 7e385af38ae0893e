#pragma once

#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Estimates depth from one photo without any network or download.
///
/// Monocular cues of the picture itself (see docs/depth.md for which, and what they are worth) are
/// combined and smoothed along the photo's edges. It is the embedded default when no depth network
/// is found: always defined, deterministic for any number of threads, and no match for a trained
/// network.
///
/// @param photo [rows x cols, CV_8UC3, BGR], any size from 1 x 1
/// @param depth [smaller or equal size of the same shape, at most 320 px a side, CV_32FC1, 0..1,
///        1 = nearest]; bring it to the photo with fitDepth()
/// @throws Error InvalidArgument (empty or wrong type)
ALTIRO3D_EXPORT void estimateDepthFromCues(const cv::Mat& photo, cv::Mat& depth);

} // namespace altiro3D
