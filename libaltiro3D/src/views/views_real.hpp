#pragma once

#include "altiro3D/camera.hpp"
#include "views/view_renderer.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Method Real for cameras on one horizontal line. Photo and depth must live as long as the
/// renderer.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1], clamped to 0..1, NaN counts as 0
/// @param focus depth of zero parallax, 0..1
std::unique_ptr<ViewRenderer> makeRealRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               double focus, const RealOptions& options);

} // namespace altiro3D
