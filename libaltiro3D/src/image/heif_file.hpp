#pragma once

#include "image/depth_parts.hpp"

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <string_view>

struct heif_context;
struct heif_image_handle;

namespace altiro3D {

/// Whether this build reads HEIC and AVIF files: whether libheif was there when it was built.
bool hasHeif();

/// Colours as ITU-T H.273 numbers them.
struct ColourCode {
    int primaries = 2; ///< 1 = Rec. 709 and sRGB, 9 = Rec. 2020, 12 = Display P3, 2 = not stated.
    int transfer = 2;  ///< 13 = sRGB, 16 = PQ, 18 = HLG, 2 = not stated.
};

/// The depth image of a HEIC or AVIF file.
struct HeifDepth {
    cv::Mat samples; ///< [rows x cols, CV_8UC1 or CV_16UC1, whole range], upright.
    DepthPart part;  ///< What they mean, without form and bytes.
};

/// A HEIC or AVIF file in memory, read by libheif. Its turns, mirroring and crops are applied. One
/// thread at a time.
///
/// Files of iOS 18 refer to their depth from several pictures, which libheif before 1.19 refuses.
/// The surplus references are then removed from a copy (repairedHeif()).
class HeifFile {
  public:
    /// Reads the structure of the file, and decodes nothing.
    /// @param bytes the whole file; must outlive the object
    /// @throws PictureFailure
    explicit HeifFile(std::string_view bytes);
    HeifFile(const HeifFile&) = delete;
    HeifFile& operator=(const HeifFile&) = delete;

    /// Size of the upright main picture; it is not checked.
    cv::Size size() const;
    /// How many pictures there are, without thumbnails, depth and mattes; at least 1.
    unsigned pictures() const;
    /// The ICC profile of a picture; empty if there is none.
    /// @param item its number; not given: the main picture
    /// @throws PictureFailure (no such picture)
    std::string iccProfile(std::optional<std::uint32_t> item = std::nullopt) const;
    /// The colours of a picture if the file states them as numbers. @param item as iccProfile()
    std::optional<ColourCode> colours(std::optional<std::uint32_t> item = std::nullopt) const;
    /// The EXIF of the main picture; empty if there is none.
    std::string exif() const;
    /// Whether the colours are multiplied by alpha.
    bool isPremultiplied() const;

    /// Decodes a picture, upright.
    /// @param item as iccProfile(); more than kMaxImagePixels are refused before allocation
    /// @return [rows x cols, CV_8UC3, CV_8UC4, CV_16UC3 or CV_16UC4, BGR and alpha]; samples of 9
    ///         to 15 bits are scaled to 16
    /// @throws PictureFailure (also without such a picture); std::bad_alloc
    cv::Mat decode(std::optional<std::uint32_t> item = std::nullopt) const;

    /// Decodes the depth image, upright.
    /// @param maxPixels larger ones are refused before allocation
    /// @return nothing if there is none
    /// @throws PictureFailure; std::bad_alloc
    std::optional<HeifDepth> decodeDepth(double maxPixels) const;

  private:
    using Handle = std::shared_ptr<const heif_image_handle>;
    Handle handleOf(std::optional<std::uint32_t> item) const;

    std::string repaired_; // copy of a file of iOS 18
    std::shared_ptr<heif_context> context_;
    Handle handle_; // the main picture
};

/// Repairs a HEIC file of iOS 18 for libheif before 1.19, which accepts one target per reference
/// of an auxiliary picture ("Too many auxiliary image references").
///
///     iref  auxl: depth -> primary, tone-mapped      becomes  depth -> primary
///           cdsc: XMP   -> primary, tone-mapped      becomes  XMP   -> primary
///           dimg: tone-mapped -> primary, gain map   is left out
///
/// A `free` box takes the place of the bytes that are left over, so no other offset changes.
/// @param bytes the whole file, as for the functions below
/// @return the repaired file; empty if there is nothing to repair or the file is malformed
std::string repairedHeif(std::string_view bytes);

/// Why a HEIC or AVIF file must not be decoded: a decoder allocates what the file says in these
/// places, whatever size it states elsewhere.
/// - HEVC settings (sequence parameter sets, H.265 7.3.2.2) and AV1 sequence headers of more px
///   than allowed.
/// - Grids and overlays whose size no picture of the file states.
/// @return a part of a sentence; empty if nothing was found
std::string heifProblem(std::string_view bytes, double maxPixels);

/// Pictures of an animation (AVIF, HEIC sequence): samples of the longest track; 0 without tracks.
unsigned heifFrames(std::string_view bytes);

/// The items of the two pictures of a stereo pair.
struct HeifEyes {
    std::uint32_t left = 0;
    std::uint32_t right = 0;
};

/// The first stereo pair of a HEIC or AVIF file: the group `ster` in the box `grpl` (ISO/IEC
/// 23008-12), whose first entity is the left eye's.
/// @return the pair; nothing if the file has none
std::optional<HeifEyes> findHeifEyes(std::string_view bytes);

} // namespace altiro3D
