#pragma once

#include "base/image_format.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace altiro3D {

/// How the colours of a picture with alpha are stored.
enum class AlphaKind {
    Straight,      ///< Colours are independent of alpha.
    Premultiplied, ///< Colours are already multiplied by alpha.
    Unstated       ///< The file does not say.
};

/// A colour that stands for "transparent" (PNG's tRNS chunk), in the file's own samples.
struct ColorKey {
    unsigned red = 0;   ///< The grey value for grey pictures.
    unsigned green = 0; ///< The grey value for grey pictures.
    unsigned blue = 0;  ///< The grey value for grey pictures.
};

/// What a picture file says about itself before anything is decoded.
struct PictureHeader {
    PictureFormat format = PictureFormat::Unknown;
    std::string otherFormat;         ///< For Unknown: a format without a reader ("GIF"), or empty.
    std::string unreadable;          ///< A feature without a reader ("animated WebP"), or empty.
    bool isText = false;             ///< For Unknown: the file holds text.
    std::uint64_t columns = 0;       ///< 0 if the header could not be read.
    std::uint64_t rows = 0;          ///< 0 if the header could not be read.
    int orientation = 1;             ///< EXIF and TIFF orientation, 1..8.
    unsigned focalLength35mm = 0;    ///< EXIF focal length of a 35 mm camera, mm; 0 = not given.
    std::size_t orientationAt = 0;   ///< TIFF: where the orientation's number stands, 0 if nowhere.
    std::size_t orientationSize = 0; ///< TIFF: its length in bytes.
    bool isLittleEndian = false;     ///< TIFF: its byte order.
    int bitsPerSample = 8;           ///< PNG, TIFF: bits of a channel.
    AlphaKind alpha = AlphaKind::Straight;
    std::optional<ColorKey> transparentColor; ///< PNG grey and RGB without alpha.
    bool isWhiteZero = false;                 ///< TIFF: grey with 0 = white.
    bool isPalette = false;      ///< TIFF: colours from a table, which OpenCV would make grey.
    unsigned largestSample = 0;  ///< PNM: the sample that means white; else 0.
    bool isCutOff = false;       ///< The file ends before the picture does.
    std::size_t usableBytes = 0; ///< JPEG: all but a last segment that the cut has halved.
    bool hasWholeScan = false;   ///< JPEG: progressive and at least its first pass is complete.
    bool isUnmarkedCmyk = false; ///< JPEG: CMYK without Adobe's mark.
    bool isNative = false;       ///< PNG: writePicture() has marked it as a Native.
    unsigned pictures = 1;       ///< Pages or frames in the file; more than 1 is a remark.
};

/// The text chunk of a PNG file that marks a Native: its keyword, a zero byte and its text.
constexpr std::string_view kNativeMark("altiro3D\0Native", 15);

/// Reads the header of a picture file without decoding or allocating for its pixels.
///
/// Total: any bytes give a result, at worst Unknown. Format is told by contents; the name only
/// helps for formats whose contents look like another's (raw photos are TIFF files).
///
/// @param bytes the whole file
/// @param extension the file name's, lower case with its dot; may be empty
PictureHeader readPictureHeader(std::string_view bytes, const std::string& extension);

} // namespace altiro3D
