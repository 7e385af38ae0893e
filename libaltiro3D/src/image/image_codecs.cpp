#include "image/image_codecs.hpp"

#include "image/opencv_codecs.hpp"

#include <csetjmp>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <png.h>
#include <turbojpeg.h>
#include <type_traits>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kJpegQuality = 95;
constexpr std::int64_t kMaxPixels = std::int64_t{1} << 30; // as OpenCV

struct CloseTurboJpeg {
    void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpeg = std::unique_ptr<std::remove_pointer_t<tjhandle>, CloseTurboJpeg>;

// Empty if the file is unusual or damaged: OpenCV shows more of some.
// @param cmyk inks are wanted, else grey or colours
cv::Mat decodeJpeg(std::string_view bytes, ImageChannels channels, bool cmyk = false) {
    const TurboJpeg jpeg(tjInitDecompress());
    const auto* const from = reinterpret_cast<const unsigned char*>(bytes.data());
    int columns = 0;
    int rows = 0;
    int subsampling = 0;
    int colours = 0;
    if (jpeg == nullptr || tjDecompressHeader3(jpeg.get(), from, bytes.size(), &columns, &rows,
                                               &subsampling, &colours) != 0) {
        return {};
    }
    if ((colours == TJCS_CMYK || colours == TJCS_YCCK) != cmyk) return {};
    if (std::int64_t{columns} * rows > kMaxPixels) return {};
    const bool isGrey = colours == TJCS_GRAY && channels == ImageChannels::AsStored;
    const int format = cmyk ? TJPF_CMYK : isGrey ? TJPF_GRAY : TJPF_BGR;
    cv::Mat image(rows, columns, CV_8UC(tjPixelSize[format]));
    const int status = tjDecompress2(jpeg.get(), from, bytes.size(), image.data, columns,
                                     static_cast<int>(image.step), rows, format, 0);
    if (status != 0) return {};
    return image;
}

struct PngSource {
    std::string_view left;
};

void readPngBytes(png_structp png, png_bytep to, std::size_t count) {
    auto& source = *static_cast<PngSource*>(png_get_io_ptr(png));
    if (count > source.left.size()) png_error(png, "cut off");
    source.left.copy(reinterpret_cast<char*>(to), count);
    source.left.remove_prefix(count);
}

void failPng(png_structp png, png_const_charp /*message*/) {
    png_longjmp(png, 1);
}

void ignorePngWarning(png_structp /*png*/, png_const_charp /*message*/) {}

struct PngReader {
    png_structp png =
        png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, failPng, ignorePngWarning);
    png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;

    PngReader() = default;
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;
    ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

// libpng leaves the next two functions by longjmp: they make no object that has a destructor.

bool readPngHeader(const PngReader& reader) {
    if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
    png_read_info(reader.png, reader.info);
    return true;
}

bool readPngRows(const PngReader& reader, unsigned char** rows) {
    if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
    png_set_bgr(reader.png);
    png_set_swap(reader.png); // samples of 16 bits; no others are swapped
    png_read_image(reader.png, rows);
    png_read_end(reader.png, nullptr);
    return true;
}

// Empty if the file is unusual (with a palette or fewer than 8 bits, for instance) or damaged.
cv::Mat decodePng(std::string_view bytes) {
    const PngReader reader;
    if (reader.info == nullptr) return {};
    PngSource source{bytes};
    png_set_read_fn(reader.png, &source, readPngBytes);
    if (!readPngHeader(reader)) return {};
    const int bits = png_get_bit_depth(reader.png, reader.info);
    const bool isTransparent = png_get_valid(reader.png, reader.info, PNG_INFO_tRNS) != 0;
    int channels = 0;
    switch (png_get_color_type(reader.png, reader.info)) {
    case PNG_COLOR_TYPE_GRAY:
        channels = 1;
        break;
    case PNG_COLOR_TYPE_RGB:
        channels = 3;
        break;
    case PNG_COLOR_TYPE_RGB_ALPHA:
        channels = 4;
        break;
    default:
        break;
    }
    if (channels == 0 || bits < 8 || isTransparent) return {};
    const auto columns = static_cast<int>(png_get_image_width(reader.png, reader.info));
    const auto height = static_cast<int>(png_get_image_height(reader.png, reader.info));
    if (std::int64_t{columns} * height > kMaxPixels) return {};
    cv::Mat image(height, columns, CV_MAKETYPE(bits == 16 ? CV_16U : CV_8U, channels));
    std::vector<unsigned char*> rows(static_cast<std::size_t>(image.rows));
    for (int y = 0; y < image.rows; ++y)
        rows[static_cast<std::size_t>(y)] = image.ptr(y);
    return readPngRows(reader, rows.data()) ? image : cv::Mat();
}

} // namespace

cv::Mat decodeImage(std::string_view bytes, ImageFormat format, ImageChannels channels) {
    cv::Mat image;
    if (format == ImageFormat::Jpeg) image = decodeJpeg(bytes, channels);
    if (format == ImageFormat::Png && channels == ImageChannels::AsStored) image = decodePng(bytes);
    if (!image.empty()) return image;
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<char*>(bytes.data()));
    return openCvCodecs().decode(encoded, channels == ImageChannels::Colour
                                              ? cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION
                                              : cv::IMREAD_UNCHANGED);
}

cv::Mat decodeCmykJpeg(std::string_view bytes) {
    return decodeJpeg(bytes, ImageChannels::AsStored, true);
}

std::vector<unsigned char> encodeJpeg(const cv::Mat& image) {
    const TurboJpeg jpeg(tjInitCompress());
    if (jpeg == nullptr) return {};
    const bool isGrey = image.channels() == 1;
    unsigned char* encoded = nullptr;
    unsigned long size = 0;
    const int status =
        tjCompress2(jpeg.get(), image.data, image.cols, static_cast<int>(image.step), image.rows,
                    isGrey ? TJPF_GRAY : TJPF_BGR, &encoded, &size,
                    isGrey ? TJSAMP_GRAY : TJSAMP_420, kJpegQuality, TJFLAG_ACCURATEDCT);
    const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(encoded, tjFree);
    if (status != 0) return {};
    return {encoded, encoded + size};
}

std::vector<unsigned char> encodeImage(const cv::Mat& image, const std::string& extension) {
    std::vector<unsigned char> bytes;
    if (!openCvCodecs().encode(extension, image, bytes)) bytes.clear();
    return bytes;
}

} // namespace altiro3D
