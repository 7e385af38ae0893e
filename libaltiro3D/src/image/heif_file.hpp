#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace altiro3D {

/// Whether this build reads HEIC and AVIF files: whether libheif was there when it was built.
bool hasHeif();

/// Why a HEIC or AVIF file cannot be read: half a sentence, without the name of the file.
class HeifFailure : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Colours as ITU-T H.273 numbers them.
struct ColourCode {
    int primaries = 2; ///< 1 = Rec. 709 and sRGB, 9 = Rec. 2020, 12 = Display P3, 2 = not stated.
    int transfer = 2;  ///< 13 = sRGB, 16 = PQ, 18 = HLG, 2 = not stated.
};

/// The depth image of a HEIC or AVIF file.
struct HeifDepth {
    cv::Mat samples;         ///< [rows x cols, CV_8UC1 or CV_16UC1, whole range], upright.
    bool isDistance = false; ///< The samples grow with the distance, from zNear to zFar.
    double zNear = 0;        ///< Distance of the smallest sample; 0 = not stated.
    double zFar = 0;         ///< Distance of the largest sample; 0 = not stated.
};

/// A HEIC or AVIF file in memory, read by libheif. Its turns, mirroring and crops are applied. One
/// thread at a time.
///
/// Files of iOS 18 refer to their depth from several pictures, which libheif before 1.19 refuses.
/// The references that are too many are then taken out of a copy (repairedHeif()).
class HeifFile {
  public:
    /// Reads the structure of the file, and decodes nothing.
    /// @param bytes the whole file; must outlive the object
    /// @throws HeifFailure
    explicit HeifFile(std::string_view bytes);
    ~HeifFile();
    HeifFile(HeifFile&&) noexcept;
    HeifFile& operator=(HeifFile&&) noexcept;

    /// Size of the upright main picture; it is not checked.
    cv::Size size() const;
    /// How many pictures there are, without thumbnails, depth and mattes; at least 1.
    unsigned pictures() const;
    /// The EXIF data as a TIFF file; empty if there is none.
    std::string exif() const;
    /// The ICC profile of a picture; empty if there is none.
    /// @param item its number; not given: the main picture
    /// @throws HeifFailure (no such picture)
    std::string iccProfile(std::optional<std::uint32_t> item = std::nullopt) const;
    /// The colours of a picture if the file states them as numbers. @param item as iccProfile()
    std::optional<ColourCode> colours(std::optional<std::uint32_t> item = std::nullopt) const;
    /// Whether the colours are multiplied by alpha.
    bool isPremultiplied() const;
    /// Whether there is a depth image.
    bool hasDepth() const;

    /// Decodes the main picture, upright.
    /// @return [rows x cols, CV_8UC3, CV_8UC4, CV_16UC3 or CV_16UC4, BGR and alpha]; samples of 9
    ///         to 15 bits are scaled to 16
    /// @throws HeifFailure; std::bad_alloc
    cv::Mat decode() const;

    /// Decodes another picture of the file, upright.
    /// @param item its number
    /// @param maxPixels larger ones are refused before allocation
    /// @return as decode()
    /// @throws HeifFailure (also without such a picture); std::bad_alloc
    cv::Mat decodeItem(std::uint32_t item, double maxPixels) const;

    /// Decodes the depth image, upright.
    /// @param maxPixels larger ones are refused before allocation
    /// @throws HeifFailure (also without a depth image); std::bad_alloc
    HeifDepth decodeDepth(double maxPixels) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
