#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Smooths the surfaces of a depth map by planes through the px that have a similar place, smoothed
/// depth and colour, with returnDetail() (docs/mathematics.md, 4a.1).
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param noise standard deviation of the noise, > 0
/// @param measured depth [as photo, CV_32FC1, 0..1]
/// @param depth smoothSurfaces() of it, changed in place; the same bytes for any number of threads
///        and all instruction sets
void fitPlanes(const cv::Mat& photo, double noise, const cv::Mat& measured, cv::Mat& depth);

} // namespace altiro3D
