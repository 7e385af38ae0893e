#pragma once

#include "altiro3D/depth_map.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// measureDepthFlaws() of depth_map.hpp, which keeps what it smooths.
///
/// @param depth [as photo, CV_32FC1, 0..1]
/// @param smooth result: smoothSurfaces() of the depth for the noise found; `depth` itself if there
///        is none
DepthFlaws measureFlaws(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& smooth);

} // namespace altiro3D
