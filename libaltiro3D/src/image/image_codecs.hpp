#pragma once

#include "image/image_header.hpp"

#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

enum class ImageChannels {
    AsStored, ///< Number of channels and depth of the file.
    Colour    ///< CV_8UC3.
};

/// Decodes an image file as cv::imdecode() does, to the same bits, without turning it. JPEG and PNG
/// are read by libjpeg-turbo and libpng; unusual, damaged and other files by OpenCV.
/// @param bytes at most 2^31 - 1
/// @param damage if given, receives what libjpeg says of a JPEG that it decodes nevertheless; the
///        padding of some cameras between the picture and its end is not damage
/// @return BGR; empty if it is damaged
/// @throws cv::Exception
cv::Mat decodeImage(std::string_view bytes, ImageFormat format, ImageChannels channels,
                    std::string* damage = nullptr);

/// The same for a JPEG that is neither unusual nor damaged: OpenCV shows more of some.
/// @param cmyk the inks are wanted [CV_8UC4, 0..255 as stored], else grey or colours
/// @return empty if the JPEG is another one
cv::Mat decodeJpeg(std::string_view bytes, ImageChannels channels, std::string* damage = nullptr,
                   bool cmyk = false);

/// Encodes a JPEG with quality 95 and chroma at half resolution (4:2:0), as OpenCV does.
/// @param image CV_8UC1 or CV_8UC3
/// @param unmixed quality 100 with full chroma (4:4:4)
/// @param quality another quality, 1..100; 0: these
/// @return the file; empty if it cannot be encoded
std::vector<unsigned char> encodeJpeg(const cv::Mat& image, bool unmixed = false, int quality = 0);

/// Encodes a picture as PNG (png_encode.cpp) on all threads, to the same bytes for any number.
///
/// libpng takes 127 ms for a Native of the Portrait on one thread, of a run of 0.37 s. This takes
/// 113 ms, which the threads share.
/// @param picture [rows x cols, CV_8UC1, CV_8UC3, CV_16UC1 or CV_16UC3, BGR], not empty
/// @param text contents of a text chunk: keyword, a zero byte, text; empty = no chunk
std::vector<unsigned char> encodePng(const cv::Mat& picture, std::string_view text = {});

/// The rows of a PNG: pngHead(), an IDAT for each part of deflated() and one for end(), IEND.
class PngRows {
  public:
    /// @param size of the whole picture
    explicit PngRows(cv::Size size);
    /// The next rows, filtered and deflated on all threads.
    std::vector<std::vector<unsigned char>> deflated(const cv::Mat& rows);
    /// The end of the deflated stream, after all rows.
    std::vector<unsigned char> end() const;

  private:
    cv::Size size_;
    cv::Mat above_;         // the row before the next one
    int done_ = 0;          // rows
    unsigned long sum_ = 1; // Adler-32 of them
};

/// The beginning of a PNG: signature, header and a text, see encodePng().
std::vector<unsigned char> pngHead(cv::Size size, int type, std::string_view text);
/// Appends chunks that state the printed size and sRGB colours.
/// @param dpi px per inch across and down
void appendPngSize(cv::Size2d dpi, std::vector<unsigned char>& to);
void appendPngChunk(std::string_view name, const std::vector<unsigned char>& contents,
                    std::vector<unsigned char>& to);

/// Decodes a JPEG or PNG inside a file, as stored: neither turned nor in other colours.
/// @param maxPixels larger ones are refused before allocation
/// @return the picture; empty if it is damaged, cut off or too large
cv::Mat decodePart(std::string_view bytes, double maxPixels, ImageChannels channels);

/// Decodes the first picture of an animated WebP file, in its place; empty if it is damaged.
/// @param bytes the whole file
cv::Mat decodeFirstFrame(const ImageHeader& header, const std::string& bytes);

/// Composes a decoded picture with alpha over black; others are returned as they are.
/// @param picture its last channel of 2 or 4 is alpha
cv::Mat withoutAlpha(const cv::Mat& picture, const ImageHeader& header);

/// Px of the transparent colour become black; OpenCV does not do this.
void blackenTransparent(cv::Mat& picture, const ImageHeader& header);

} // namespace altiro3D
