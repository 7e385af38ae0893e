#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace altiro3D {

/// The supported picture formats, and one value for all others.
enum class ImageFormat {
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
    Jpeg2000,
    Heic, ///< HEIF with HEVC, also of other brands.
    Avif
};

/// How the colours of a picture with alpha are stored.
enum class AlphaKind {
    Straight,      ///< Colours are independent of alpha.
    Premultiplied, ///< Colours are already multiplied by alpha.
    Unstated       ///< The file does not state it.
};

/// Why a picture file cannot be read: half a sentence, without the name of the file.
class PictureFailure : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Whether libheif reads a format.
inline bool isHeif(ImageFormat format) {
    return format == ImageFormat::Heic || format == ImageFormat::Avif;
}

/// The format by the first bytes of a file. Any bytes give a result, at worst Unknown.
ImageFormat imageFormat(std::string_view bytes);

/// The name of a known format that is not supported ("GIF", "PSD", "MP4 video"), or empty.
std::string otherFormatName(std::string_view bytes);

/// Whether the beginning of a file is text.
bool containsOnlyText(std::string_view bytes);

} // namespace altiro3D
