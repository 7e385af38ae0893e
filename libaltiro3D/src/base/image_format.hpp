#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
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

/// The colour that means "transparent" (PNG's tRNS chunk), in the file's sample values. In grey
/// pictures all three hold the grey value.
struct ColorKey {
    unsigned red = 0;
    unsigned green = 0;
    unsigned blue = 0;
};

/// Properties of a picture file, read without decoding.
struct ImageHeader {
    ImageFormat format = ImageFormat::Unknown;
    std::string otherFormat;    ///< For Unknown: an unsupported format ("GIF"), or empty.
    std::string unreadable;     ///< An unsupported feature ("XYZE HDR"), or empty.
    std::string decoderMessage; ///< HEIC, AVIF, TIFF: why the header could not be read, or empty.
    bool isText = false;        ///< For Unknown: the file holds text.
    std::uint64_t columns = 0;  ///< 0, as are the rows, if the header could not be read.
    std::uint64_t rows = 0;
    int orientation = 1;   ///< EXIF and TIFF orientation, 1..8.
    std::string exif;      ///< EXIF, as exifText() reads it; empty: none. TIFF files are EXIF.
    int bitsPerSample = 8; ///< PNG: bits of a channel.
    AlphaKind alpha = AlphaKind::Straight;
    std::optional<ColorKey> transparentColor; ///< PNG grey and RGB without alpha.
    /// PNM, TIFF, JPEG 2000: value of white; 0 = the largest of the decoded type, or 1 for floats.
    unsigned largestSample = 0;
    bool isSigned = false;       ///< TIFF: whole numbers with sign.
    unsigned unusedChannels = 0; ///< TIFF: channels that are neither colours nor alpha.
    bool isCutOff = false;       ///< The file ends before the picture does.
    std::size_t usableBytes = 0; ///< JPEG: bytes before a last, incomplete segment.
    bool hasWholeScan = false;   ///< JPEG: progressive, and at least its first pass is complete.
    bool isCmyk = false;         ///< JPEG, TIFF: four components, which are inks.
    bool isUnmarkedCmyk = false; ///< JPEG: CMYK without Adobe's marker.
    bool isAnimated = false;     ///< WebP: an animation.
    bool isNative = false;       ///< PNG: marked as a Native by writeImage().
    unsigned pictures = 1;       ///< Pages or frames in the file; more than 1 is a remark.
};

/// Why a picture file cannot be read: part of a sentence, without the name of the file.
class PictureFailure : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Whether libheif reads a format.
inline bool isHeif(ImageFormat format) {
    return format == ImageFormat::Heic || format == ImageFormat::Avif;
}

/// Whether a file is a raw picture of a camera, by its extension in lower case.
inline bool isRawExtension(std::string_view extension) {
    constexpr std::string_view kAll[] = {".dng", ".nef", ".nrw", ".arw", ".sr2", ".pef",
                                         ".srw", ".erf", ".3fr", ".iiq", ".cr2", ".cr3",
                                         ".crw", ".raf", ".orf", ".rw2", ".raw", ".x3f"};
    return std::find(std::begin(kAll), std::end(kAll), extension) != std::end(kAll);
}

/// The format by the first bytes of a file. Any bytes give a result, at worst Unknown.
ImageFormat imageFormat(std::string_view bytes);

/// The name of a known format that is not supported ("GIF", "PSD", "MP4 video"), or empty.
std::string otherFormatName(std::string_view bytes);

/// Whether the beginning of a file is text.
bool containsOnlyText(std::string_view bytes);

} // namespace altiro3D
