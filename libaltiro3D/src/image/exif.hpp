#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace altiro3D {

/// Returns the value if it is an orientation, 1..8, else 1.
int validOrientation(unsigned value);

/// The orientation of an EXIF blob, with or without the prefix "Exif\0\0". Safe for any bytes.
/// @return 1..8; 1 (upright) if it states none
int exifOrientation(std::string_view blob);

/// The focal length of an EXIF blob, as for film of 36 x 24 mm. @return mm; 0 if it states none
int exifFocalLength(std::string_view blob);

constexpr unsigned kExifArtist = 0x13B;
constexpr unsigned kExifCopyright = 0x8298;
/// A text of an EXIF blob, by its tag in the main directory. @return empty if it states none
std::string exifText(std::string_view blob, unsigned tag);

/// The orientation of the EXIF data that ImageMagick stores in a text chunk of a PNG file.
/// @param compressed a zTXt chunk instead of a tEXt one
/// @return nothing for chunks with other text
std::optional<int> exifOrientationInPngText(std::string_view chunk, bool compressed);

/// Turns and mirrors a picture upright.
/// @param picture any type @param orientation of EXIF and TIFF, 1..8; others count as 1 (upright)
/// @return the upright picture; shares the memory of `picture` if that is upright
cv::Mat upright(const cv::Mat& picture, int orientation);

} // namespace altiro3D
