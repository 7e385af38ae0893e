#pragma once

#include "base/image_format.hpp"

#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

enum class ImageChannels {
    AsStored, ///< Number of channels and depth of the file.
    Colour    ///< CV_8UC3.
};

/// Decodes an image file as cv::imdecode() does, to the same bits, without turning it.
/// JPEG and PNG are read by libjpeg-turbo and libpng; what is unusual or damaged, and all other
/// formats, by OpenCV.
///
/// @param bytes at most 2^31 - 1
/// @return BGR; empty if it is damaged
/// @throws cv::Exception
cv::Mat decodeImage(std::string_view bytes, ImageFormat format, ImageChannels channels);

/// Decodes the inks of a CMYK JPEG.
/// @return CV_8UC4, 0..255 as stored; empty if the JPEG is not CMYK, or damaged
cv::Mat decodeCmykJpeg(std::string_view bytes);

/// Quality 95, colours at half resolution (4:2:0), as OpenCV writes it.
/// @param image CV_8UC1 or CV_8UC3
/// @return the file; empty if it cannot be encoded
std::vector<unsigned char> encodeJpeg(const cv::Mat& image);

/// Formats other than JPEG and PNG.
/// @param extension with its dot
/// @return the file; empty if it cannot be encoded
/// @throws cv::Exception
std::vector<unsigned char> encodeImage(const cv::Mat& image, const std::string& extension);

} // namespace altiro3D
