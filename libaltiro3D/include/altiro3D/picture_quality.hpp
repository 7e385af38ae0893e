#pragma once

#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Peak signal-to-noise ratio of two pictures in dB, over all channels; +infinity if they are
/// equal.
///
/// @param picture [rows x cols, 8-bit, any number of channels]
/// @param truth [as picture]
/// @throws Error InvalidArgument, Mismatch
ALTIRO3D_EXPORT double psnr(const cv::Mat& picture, const cv::Mat& truth);

/// Structural similarity of two pictures, -1..1, 1 = equal: Wang et al. 2004 with an 11 x 11
/// Gaussian window (sigma 1.5), K1 = 0.01, K2 = 0.03, range 255, borders reflected, the mean over
/// all pixels and channels.
///
/// @param picture [rows x cols, 8-bit, any number of channels]
/// @param truth [as picture]
/// @throws Error InvalidArgument, Mismatch
ALTIRO3D_EXPORT double ssim(const cv::Mat& picture, const cv::Mat& truth);

} // namespace altiro3D
