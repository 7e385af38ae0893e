#pragma once

#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Peak signal-to-noise ratio of two pictures: 10 log10(255² / mean squared difference), over all
/// channels.
///
/// @param picture [rows x cols, 8-bit, any number of channels]
/// @param truth [as picture]
/// @return dB; +infinity if they are equal
/// @throws Error InvalidArgument (empty, not 8-bit), Mismatch (size or type differ)
ALTIRO3D_EXPORT double psnr(const cv::Mat& picture, const cv::Mat& truth);

/// Structural similarity of two pictures: Wang et al. 2004 with an 11 x 11 Gaussian window (sigma
/// 1.5), K1 = 0.01, K2 = 0.03, range 255, reflected borders. The result is the mean over all pixels
/// and channels.
///
/// @param picture [rows x cols, 8-bit, 1..4 channels]
/// @param truth [as picture]
/// @return -1..1, 1 = equal
/// @throws Error InvalidArgument (empty, not 8-bit, more than 4 channels), Mismatch (size or type
///         differ)
ALTIRO3D_EXPORT double ssim(const cv::Mat& picture, const cv::Mat& truth);

} // namespace altiro3D
