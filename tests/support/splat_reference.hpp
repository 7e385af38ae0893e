#pragma once

#include "altiro3D/splats.hpp"

namespace altiro3D::test {

/// Splats of all shapes, near and far, with harmonics; some are behind a camera at the origin.
SplatScene randomSplats(int count, int degree);

/// A view of splats by the published formula (Kerbl et al. 2023), in double precision, splat by
/// splat: the slow twin of SplatRenderer.
/// @param shift, focusDistance as for SplatRenderer::render()
/// @param nearest nearer splats are not drawn
/// @param alpha if given, receives the opacity [CV_64FC1]
/// @return [rows x cols, CV_64FC3, BGR, 0..255]
cv::Mat slowSplats(const SplatScene& scene, const SplatCamera& camera, double shift,
                   double focusDistance, double nearest, cv::Mat* alpha = nullptr);

/// Peak signal-to-noise ratio of 8-bit pictures, dB. @param largest receives the largest difference
double psnrOf(const cv::Mat& picture, const cv::Mat& expected, double* largest = nullptr);

} // namespace altiro3D::test
