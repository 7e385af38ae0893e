#pragma once

#include "base/image_format.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace altiro3D {

/// OpenCV accepts encoded pictures as one row of at most 2^31 - 1 bytes. Two bytes are reserved.
constexpr std::uintmax_t kMaxImageFileBytes = 0x7ffffff0u;
constexpr int kMaxImageSide = 65500; ///< The longest side of a JPEG.

/// The colour that means "transparent" (PNG's tRNS chunk), in the file's sample values.
struct ColorKey {
    unsigned red = 0;   ///< The grey value for grey pictures.
    unsigned green = 0; ///< The grey value for grey pictures.
    unsigned blue = 0;  ///< The grey value for grey pictures.
};

/// Properties of a picture file, read without decoding.
struct ImageHeader {
    ImageFormat format = ImageFormat::Unknown;
    std::string otherFormat;      ///< For Unknown: an unsupported format ("GIF"), or empty.
    std::string unreadable;       ///< An unsupported feature ("XYZE HDR"), or empty.
    std::string decoderMessage;   ///< HEIC, AVIF, TIFF: why the header could not be read, or empty.
    bool isText = false;          ///< For Unknown: the file holds text.
    std::uint64_t columns = 0;    ///< 0 if the header could not be read.
    std::uint64_t rows = 0;       ///< 0 if the header could not be read.
    int orientation = 1;          ///< EXIF and TIFF orientation, 1..8.
    unsigned focalLength35mm = 0; ///< EXIF focal length of a 35 mm camera, mm; 0 = not given.
    int bitsPerSample = 8;        ///< PNG: bits of a channel.
    AlphaKind alpha = AlphaKind::Straight;
    std::optional<ColorKey> transparentColor; ///< PNG grey and RGB without alpha.
    /// PNM, TIFF, JPEG 2000: sample value of white; 0 = the largest of the decoded type, or 1 for
    /// floats.
    unsigned largestSample = 0;
    bool isSigned = false;       ///< TIFF: whole numbers with sign.
    unsigned unusedChannels = 0; ///< TIFF: channels that are neither colours nor alpha.
    bool isCutOff = false;       ///< The file ends before the picture does.
    std::size_t usableBytes = 0; ///< JPEG: bytes before a last, incomplete segment.
    bool hasWholeScan = false;   ///< JPEG: progressive, and at least its first pass is complete.
    bool isCmyk = false;         ///< JPEG, TIFF: four components, which are inks.
    bool isUnmarkedCmyk = false; ///< JPEG: CMYK without Adobe's marker.
    bool isAnimated = false;     ///< WebP: its pictures are those of an animation.
    bool isNative = false;       ///< PNG: marked as a Native by writeImage().
    unsigned pictures = 1;       ///< Pages or frames in the file; more than 1 is a remark.
};

/// The text chunk of a PNG file that marks a Native: its keyword, a zero byte and its text.
constexpr std::string_view kNativeMark("altiro3D\0Native", 15);

/// Reads the header of a picture file without decoding or allocating for its pixels.
///
/// Any bytes give a result, at worst Unknown. The contents decide the format. The name helps only
/// for formats whose contents look like another format (raw photos are TIFF files).
///
/// @param bytes the whole file
/// @param extension extension of the file name, lower case with its dot; may be empty
ImageHeader readImageHeader(std::string_view bytes, const std::string& extension);

} // namespace altiro3D
