#pragma once

#include "altiro3D/image_io.hpp"

#include <functional>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// As readImage(), but only the colours of a part are converted to sRGB: other parts hold depth.
/// @param photoPart the part of an upright picture of a given size
/// @throws Error as readImage()
cv::Mat readImageParts(const PhotoFile& file, const std::function<cv::Rect(cv::Size)>& photoPart,
                       Notes* notes);

} // namespace altiro3D
