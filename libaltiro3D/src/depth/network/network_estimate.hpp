#pragma once

#include "altiro3D/depth_network.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Depth of a photo. Networks that follow the photo's shape run twice, on the photo and on a larger
/// mirrored copy, whose edges the result takes. Then straight lines become straight, and steps for
/// which there is evidence become hard (depth_lines.hpp, depth_contours.hpp).
///
/// @param network its inputSize() is that of the larger copy, if it is larger than the profile's;
///        if it is smaller, the network runs once
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @return [photo's shape, longer side at most 512 px, CV_32FC1, about 0..1, 1 = nearest]
/// @throws Error as DepthNetwork::estimate()
[[nodiscard]] cv::Mat estimatePhoto(DepthNetwork& network, const cv::Mat& photo);

/// Depth of a frame of a video: one run, without work on lines, at most 320 px.
[[nodiscard]] cv::Mat estimateFrame(DepthNetwork& network, const cv::Mat& frame);

} // namespace altiro3D
