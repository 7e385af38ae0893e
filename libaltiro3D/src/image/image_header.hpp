#pragma once

#include "base/image_format.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace altiro3D {

/// OpenCV accepts encoded pictures as one row of at most 2^31 - 1 bytes. Two bytes are reserved.
constexpr std::uintmax_t kMaxImageFileBytes = 0x7ffffff0u;
constexpr int kMaxImageSide = 65500; ///< The longest side of a JPEG.

/// The text chunk of a PNG file that marks a Native: its keyword, a zero byte and its text.
constexpr std::string_view kNativeMark("altiro3D\0Native", 15);

/// Reads the header of a picture file without decoding or allocating for its pixels.
///
/// Any bytes give a result, at worst Unknown. The contents decide the format. The name helps only
/// for formats whose contents look like another format (raw photos are TIFF files).
/// @param bytes the whole file, or a beginning that holds all that is asked for
/// @param extension extension of the file name, lower case with its dot; may be empty
ImageHeader readImageHeader(std::string_view bytes, const std::string& extension);

} // namespace altiro3D
