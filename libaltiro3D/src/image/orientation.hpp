#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Turns and mirrors a picture upright.
/// @param picture any type @param orientation of EXIF and TIFF, 1..8; others count as 1 (upright)
/// @return the upright picture; shares the memory of `picture` if that is upright
cv::Mat upright(const cv::Mat& picture, int orientation);

} // namespace altiro3D
