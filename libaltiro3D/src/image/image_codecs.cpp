#include "image/image_codecs.hpp"

#include "base/byte_reader.hpp"
#include "base/owned.hpp"
#include "image/file_walk.hpp"
#include "image/image_header.hpp"
#include "image/opencv_codecs.hpp"

#include <algorithm>
#include <csetjmp>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <png.h>
#include <turbojpeg.h>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kJpegQuality = 95;
constexpr std::int64_t kMaxPixels = std::int64_t{1} << 30; // as OpenCV

using TurboJpeg = std::unique_ptr<void, Free<tjDestroy>>;

// Whether libjpeg's warning is about padding: bytes before a segment of the head, or equal bytes
// before the end. A damaged scan may also end early, but leaves other bytes.
bool isPadding(const std::string& warning, std::string_view bytes) {
    constexpr std::uint64_t kFew = 4;
    constexpr std::string_view kText = " extraneous bytes before marker 0x";
    const std::size_t text = warning.find(kText);
    if (text == std::string::npos || text == 0) return false;
    const std::size_t number = warning.rfind(' ', text - 1) + 1;
    const std::uint64_t count = std::strtoull(warning.c_str() + number, nullptr, 10);
    const auto marker = std::strtoul(warning.c_str() + text + kText.size(), nullptr, 16);
    if (count <= kFew || marker >= 0xdb || marker == 0xc0 || marker == 0xc2) return true;
    const JpegEnd end =
        walkJpeg(bytes, [](unsigned, std::size_t, std::string_view) { return true; });
    if (marker != 0xd9 || !end.hasEnd || end.after < count + 2) return false;
    const std::string_view before = bytes.substr(end.after - 2 - count, count);
    return before.find_first_not_of(before.front()) == std::string_view::npos;
}

} // namespace

cv::Mat decodeJpeg(std::string_view bytes, ImageChannels channels, std::string* damage, bool cmyk) {
    const TurboJpeg jpeg(tjInitDecompress());
    const auto* const from = reinterpret_cast<const unsigned char*>(bytes.data());
    const auto size = static_cast<unsigned long>(bytes.size());
    int columns = 0;
    int rows = 0;
    int subsampling = 0;
    int colours = 0;
    if (jpeg == nullptr ||
        tjDecompressHeader3(jpeg.get(), from, size, &columns, &rows, &subsampling, &colours) != 0) {
        return {};
    }
    if ((colours == TJCS_CMYK || colours == TJCS_YCCK) != cmyk) return {};
    if (std::int64_t{columns} * rows > kMaxPixels) return {};
    const bool isGrey = colours == TJCS_GRAY && channels == ImageChannels::AsStored;
    const int format = cmyk ? TJPF_CMYK : isGrey ? TJPF_GRAY : TJPF_BGR;
    cv::Mat image(rows, columns, CV_8UC(tjPixelSize[format]));
    const int status = tjDecompress2(jpeg.get(), from, size, image.data, columns,
                                     static_cast<int>(image.step), rows, format, 0);
    if (status == 0) return image;
    if (tjGetErrorCode(jpeg.get()) != TJERR_WARNING) return {};
    const std::string warning = tjGetErrorStr2(jpeg.get());
    if (isPadding(warning, bytes)) return image;
    if (damage != nullptr) *damage = warning;
    return {};
}

namespace {

void readPngBytes(png_structp png, png_bytep to, std::size_t count) {
    auto& left = *static_cast<std::string_view*>(png_get_io_ptr(png));
    if (count > left.size()) png_error(png, "cut off");
    left.copy(reinterpret_cast<char*>(to), count);
    left.remove_prefix(count);
}

void failPng(png_structp png, png_const_charp /*message*/) {
    png_longjmp(png, 1);
}

struct PngReader {
    png_structp png =
        png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, failPng,
                               [](png_structp, png_const_charp) {}); // ignores warnings
    png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;

    PngReader() = default;
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;
    ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

// libpng leaves the next two functions by longjmp, so they create no object that has a destructor.

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
    png_set_read_fn(reader.png, &bytes, readPngBytes);
    if (!readPngHeader(reader)) return {};
    const int bits = png_get_bit_depth(reader.png, reader.info);
    const bool isTransparent = png_get_valid(reader.png, reader.info, PNG_INFO_tRNS) != 0;
    const int colours = png_get_color_type(reader.png, reader.info);
    const int channels = colours == PNG_COLOR_TYPE_GRAY        ? 1
                         : colours == PNG_COLOR_TYPE_RGB       ? 3
                         : colours == PNG_COLOR_TYPE_RGB_ALPHA ? 4
                                                               : 0;
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

std::string littleEndian(std::uint64_t value, int size) {
    std::string bytes;
    for (int i = 0; i < size; ++i)
        bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
    return bytes;
}

// The first picture of an animated WebP file.
struct WebPFrame {
    std::string file; // the picture as a WebP file of its own; empty if there is none
    cv::Rect area;    // its place in the animation; not checked
};

WebPFrame firstWebPFrame(std::string_view bytes) {
    constexpr std::uint64_t kFrameHeader = 16;
    const ByteReader reader(bytes, true);
    WebPFrame frame;
    walkWebP(bytes, [&](std::string_view name, std::uint64_t data, std::uint64_t size) {
        if (name != "ANMF" || size < kFrameHeader || !reader.holds(data, size)) return true;
        const auto number = [&](std::uint64_t offset) {
            return static_cast<int>(reader.number(data + offset, 3));
        };
        frame.area = {2 * number(0), 2 * number(3), number(6) + 1, number(9) + 1};
        const std::string_view chunks = reader.text(data + kFrameHeader, size - kFrameHeader);
        std::string body = "WEBP";
        if (chunks.substr(0, 4) == "ALPH") { // needs the header of an extended file
            body += "VP8X" + littleEndian(10, 4) + littleEndian(0x10, 4) +
                    std::string(reader.text(data + 6, 6));
        }
        body += chunks;
        frame.file = "RIFF" + littleEndian(body.size(), 4) + body;
        return false;
    });
    return frame;
}

// a * b / largest, rounded; 8 and 16 bits.
template <typename T>
T scaled(T color, T alpha) {
    constexpr unsigned kLargest = sizeof(T) == 1 ? 255u : 65535u;
    return static_cast<T>((static_cast<unsigned>(color) * alpha + kLargest / 2) / kLargest);
}
template <>
float scaled(float color, float alpha) {
    return alpha > 0 ? color * std::min(alpha, 1.0f) : 0.0f;
}

template <typename T>
bool hasColorAboveAlpha(const cv::Mat& picture) {
    const int colors = picture.channels() - 1;
    for (int y = 0; y < picture.rows; ++y) {
        const T* from = picture.ptr<T>(y);
        for (int x = 0; x < picture.cols; ++x, from += colors + 1) {
            if (*std::max_element(from, from + colors) > from[colors]) return true;
        }
    }
    return false;
}

// Composes the picture over black. The last of 2 or 4 channels is alpha.
template <typename T>
cv::Mat compositeOver(const cv::Mat& picture, AlphaKind kind) {
    // A colour brighter than its alpha shows that the picture is not premultiplied.
    const bool premultiplied = kind == AlphaKind::Premultiplied ||
                               (kind == AlphaKind::Unstated && !hasColorAboveAlpha<T>(picture));
    const int colors = picture.channels() - 1;
    cv::Mat result(picture.size(), CV_MAKETYPE(picture.depth(), colors));
    for (int y = 0; y < picture.rows; ++y) {
        const T* from = picture.ptr<T>(y);
        T* to = result.ptr<T>(y);
        for (int x = 0; x < picture.cols; ++x, from += colors + 1, to += colors) {
            for (int c = 0; c < colors; ++c)
                to[c] = premultiplied ? from[c] : scaled(from[c], from[colors]);
        }
    }
    return result;
}

template <typename T>
void blackenColor(cv::Mat& picture, const ColorKey& color, int bits) {
    const unsigned mask = (1u << bits) - 1;
    const unsigned factor = bits < 8 ? 255u / mask : 1u; // OpenCV scales fewer bits to 0..255
    const T blue = static_cast<T>((color.blue & mask) * factor);
    const T green = static_cast<T>((color.green & mask) * factor);
    const T red = static_cast<T>((color.red & mask) * factor);
    const int channels = picture.channels();
    for (int y = 0; y < picture.rows; ++y) {
        T* row = picture.ptr<T>(y);
        for (int x = 0; x < picture.cols; ++x, row += channels) {
            if (row[0] != blue) continue;
            if (channels == 3 && (row[1] != green || row[2] != red)) continue;
            std::fill_n(row, channels, T{0});
        }
    }
}

} // namespace

cv::Mat decodeImage(std::string_view bytes, ImageFormat format, ImageChannels channels,
                    std::string* damage) {
    cv::Mat image;
    if (format == ImageFormat::Jpeg) image = decodeJpeg(bytes, channels, damage);
    if (format == ImageFormat::Png && channels == ImageChannels::AsStored) image = decodePng(bytes);
    if (!image.empty()) return image;
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<char*>(bytes.data()));
    return openCvCodecs().decode(encoded, channels == ImageChannels::Colour
                                              ? cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION
                                              : cv::IMREAD_UNCHANGED);
}

std::vector<unsigned char> encodeJpeg(const cv::Mat& image, bool unmixed, int quality) {
    const TurboJpeg jpeg(tjInitCompress());
    if (jpeg == nullptr) return {};
    const bool isGrey = image.channels() == 1;
    unsigned char* encoded = nullptr;
    unsigned long size = 0;
    const int status = tjCompress2(jpeg.get(), image.data, image.cols, static_cast<int>(image.step),
                                   image.rows, isGrey ? TJPF_GRAY : TJPF_BGR, &encoded, &size,
                                   isGrey    ? TJSAMP_GRAY
                                   : unmixed ? TJSAMP_444
                                             : TJSAMP_420,
                                   quality > 0 ? quality
                                   : unmixed   ? 100
                                               : kJpegQuality,
                                   TJFLAG_ACCURATEDCT);
    const std::unique_ptr<unsigned char, Free<tjFree>> owner(encoded);
    if (status != 0) return {};
    return {encoded, encoded + size};
}

cv::Mat decodePart(std::string_view bytes, double maxPixels, ImageChannels channels) {
    const ImageHeader header = readImageHeader(bytes, "");
    const double pixels = static_cast<double>(header.columns) * static_cast<double>(header.rows);
    const bool isKnown = header.format == ImageFormat::Jpeg || header.format == ImageFormat::Png;
    if (!isKnown || !header.unreadable.empty() || header.isCutOff || pixels < 1 ||
        pixels > maxPixels || std::max(header.columns, header.rows) > kMaxImageSide) {
        return {};
    }
    try {
        return decodeImage(bytes, header.format, channels);
    } catch (const cv::Exception& exception) {
        if (exception.code == cv::Error::StsNoMem) throw;
        return {};
    }
}

// The first picture in its place; empty if it is damaged.
cv::Mat decodeFirstFrame(const ImageHeader& header, const std::string& bytes) {
    const WebPFrame frame = firstWebPFrame(bytes);
    const cv::Rect whole(0, 0, static_cast<int>(header.columns), static_cast<int>(header.rows));
    const ImageHeader own = readImageHeader(frame.file, {}); // decoders allocate what it states
    if ((frame.area & whole) != frame.area ||
        own.columns != static_cast<std::uint64_t>(frame.area.width) ||
        own.rows != static_cast<std::uint64_t>(frame.area.height))
        return {};
    cv::Mat part = decodeImage(frame.file, ImageFormat::WebP, ImageChannels::AsStored);
    if (part.size() == whole.size() || part.size() != frame.area.size()) return part;
    cv::Mat picture = cv::Mat::zeros(whole.size(), part.type());
    part.copyTo(picture(frame.area));
    return picture;
}

cv::Mat withoutAlpha(const cv::Mat& picture, const ImageHeader& header) {
    if (picture.channels() != 2 && picture.channels() != 4) return picture;
    AlphaKind kind = header.alpha;
    if (header.format == ImageFormat::Bmp && kind == AlphaKind::Unstated) {
        kind = AlphaKind::Premultiplied; // the fourth byte is padding and ignored
    }
    if (picture.depth() == CV_8U) return compositeOver<std::uint8_t>(picture, kind);
    if (picture.depth() == CV_16U) return compositeOver<std::uint16_t>(picture, kind);
    if (picture.depth() == CV_32F) return compositeOver<float>(picture, kind);
    return picture;
}

void blackenTransparent(cv::Mat& picture, const ImageHeader& header) {
    if (!header.transparentColor || picture.channels() == 2 || picture.channels() > 3) return;
    const int bits = header.bitsPerSample;
    if (picture.depth() == CV_8U && bits <= 8) {
        blackenColor<std::uint8_t>(picture, *header.transparentColor, bits);
    } else if (picture.depth() == CV_16U && bits == 16) {
        blackenColor<std::uint16_t>(picture, *header.transparentColor, bits);
    }
}

} // namespace altiro3D
