#pragma once

#include <string_view>

namespace altiro3D {

/// What is used of a picture's EXIF.
struct ExifFacts {
    int orientation = 1;          ///< 1..8; 1 = upright.
    unsigned focalLength35mm = 0; ///< Of a 35 mm camera with the same view, mm; 0 = not given.
};

/// The value if it is an orientation, 1..8, else 1.
int validOrientation(unsigned value);

/// Reads an EXIF blob, with or without its "Exif\0\0" in front. Total: any bytes are fine.
ExifFacts readExif(std::string_view blob);

/// Reads the EXIF that ImageMagick keeps in a text chunk of a PNG file; nothing if the chunk is
/// another one.
/// @param compressed a zTXt chunk instead of a tEXt one
ExifFacts readExifInPngText(std::string_view chunk, bool compressed);

} // namespace altiro3D
