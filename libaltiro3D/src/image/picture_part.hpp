#pragma once

#include "image/image_codecs.hpp"

#include <opencv2/core/mat.hpp>
#include <string_view>

namespace altiro3D {

/// Decodes a JPEG or PNG inside a file, as stored: neither turned nor in other colours.
/// @param maxPixels larger ones are refused before allocation
/// @return the picture; empty if it is damaged, cut off or too large
cv::Mat decodePart(std::string_view bytes, double maxPixels, ImageChannels channels);

} // namespace altiro3D
