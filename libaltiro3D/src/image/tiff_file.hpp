#pragma once

#include "base/image_format.hpp"

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace altiro3D {

/// What the samples of a TIFF picture mean.
enum class TiffColours {
    Grey,    ///< One channel.
    Rgb,     ///< Three channels, BGR; also from palettes and YCbCr.
    Inks,    ///< Four channels: cyan, magenta, yellow, black; the largest value is all of an ink.
    Lab,     ///< Three channels: L* 0..100, a*, b*, relative to D50.
    LightXyz ///< Three channels: light as X, Y, Z.
};

/// A TIFF file in memory, read by libtiff. Its picture is the first page that is neither a reduced
/// copy nor a mask; if there is none, the first such directory below the first page, or the first
/// page. One thread at a time.
class TiffFile {
  public:
    /// Reads the directories, and decodes nothing.
    /// @param bytes the whole file; must outlive the object
    /// @throws PictureFailure
    explicit TiffFile(std::string_view bytes);
    ~TiffFile();
    TiffFile(const TiffFile&) = delete;
    TiffFile& operator=(const TiffFile&) = delete;

    /// Sets what the directories say: sizes, orientation, samples, pages except copies and masks.
    void describe(ImageHeader& header) const;
    TiffColours colours() const;
    /// Whether the samples are linear light, not encoded for a screen.
    bool isLight() const;
    /// The ICC profile; empty if there is none.
    std::string iccProfile() const;

    /// Decodes the picture, not turned. Whole numbers keep their values; 0 is black.
    /// @return [rows x cols, CV_8U, CV_16U or CV_32F], channels as the colours; Grey and Rgb have
    ///         one more if there is alpha
    /// @throws PictureFailure; std::bad_alloc
    cv::Mat decode();

  private:
    struct Page;
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
