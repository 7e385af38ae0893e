#pragma once

#include <string>
#include <string_view>

namespace altiro3D {

/// The picture formats that are read, and one value for all others.
enum class PictureFormat {
    Unknown,
    Png,
    Jpeg,
    Tiff,
    WebP,
    Bmp,
    Pnm, ///< Portable bitmap, graymap and pixmap, P1..P6.
    Pfm,
    Exr,
    Hdr,
    Jpeg2000
};

/// The format that a file's first bytes tell. Total: any bytes give a result, at worst Unknown.
PictureFormat pictureFormat(std::string_view bytes);

/// A known format without a reader, "GIF", "HEIC", "MP4 video", or empty.
/// @param extension the file name's, lower case with its dot; may be empty
std::string otherFormatName(std::string_view bytes, const std::string& extension);

/// Whether the file's beginning is text.
bool containsOnlyText(std::string_view bytes);

} // namespace altiro3D
