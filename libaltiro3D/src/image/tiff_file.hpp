#pragma once

#include "base/image_format.hpp"

#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

/// TIFF files, read by libtiff. Their picture is the first page that is neither a reduced copy nor
/// a mask; if there is none, the first such directory below the first page, or the first page. All
/// functions take the whole file and throw PictureFailure.
namespace altiro3D {

/// Sets what the directories say: sizes, orientation, samples, pages except copies and masks.
void describeTiff(std::string_view bytes, ImageHeader& header);

/// What a file states about the light of its samples.
struct TiffLight {
    std::string icc;       ///< The ICC profile; empty if there is none.
    bool isLinear = false; ///< The samples are linear light, not encoded for a screen.
};
TiffLight tiffLight(std::string_view bytes);

/// What the samples of a TIFF picture mean.
enum class TiffColours {
    GreyOrRgb, ///< One channel, or three (BGR; also from palettes and YCbCr); one more if there is
               ///< alpha.
    Inks,      ///< Four channels: cyan, magenta, yellow, black; the largest value is all of an ink.
    Lab,       ///< Three channels: L* 0..100, a*, b*, relative to D50.
    LightXyz   ///< Three channels: light as X, Y, Z.
};

/// A decoded picture, not turned. Whole numbers keep their values; 0 is black.
struct TiffPicture {
    cv::Mat samples; ///< [rows x cols, CV_8U, CV_16U or CV_32F], channels as the colours.
    TiffColours colours = TiffColours::GreyOrRgb;
};
/// @throws also std::bad_alloc
TiffPicture decodeTiff(std::string_view bytes);

} // namespace altiro3D
