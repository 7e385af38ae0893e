#include "altiro3D/image_io.hpp"

#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "image/image_codecs.hpp"
#include "image/image_header.hpp"
#include "image/opencv_codecs.hpp"
#include "image/picture_halves.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

struct Writer {
    const char* extension;
    const char* format;
    bool holds16Bit;
    int channels;    // 0 = grey and colour, else the only supported number
    int longestSide; // px
};

constexpr std::array<Writer, 13> kWriters = {{
    {".png", "PNG", true, 0, 1000000},
    {".jpg", "JPEG", false, 0, 65500},
    {".jpeg", "JPEG", false, 0, 65500},
    {".jpe", "JPEG", false, 0, 65500},
    {".tif", "TIFF", true, 0, 1000000},
    {".tiff", "TIFF", true, 0, 1000000},
    {".webp", "WebP", false, 0, 16383},
    {".bmp", "BMP", false, 0, 1000000},
    {".dib", "BMP", false, 0, 1000000},
    {".ppm", "PPM", true, 3, 1000000},
    {".pgm", "PGM", true, 1, 1000000},
    {".pnm", "PNM", true, 0, 1000000},
    {".jp2", "JPEG 2000", true, 0, 1000000},
}};

const Writer* writerFor(const fs::path& path) {
    const std::string extension = lowerExtension(path);
    const auto* const found =
        std::find_if(kWriters.begin(), kWriters.end(),
                     [&](const Writer& writer) { return extension == writer.extension; });
    return found == kWriters.end() ? nullptr : found;
}

// Empty if it cannot be encoded.
std::vector<unsigned char> encode(const cv::Mat& picture, const Writer& writer,
                                  const FileMark& mark) {
    const std::string format = writer.format;
    if (format == "PNG") return encodePng(picture, mark.text);
    cv::Mat suited = picture;
    if (picture.depth() == CV_16U && !writer.holds16Bit) suited = toEightBits(picture);
    if (writer.channels == 3 && suited.channels() == 1) {
        cv::cvtColor(suited, suited, cv::COLOR_GRAY2BGR);
    }
    std::vector<unsigned char> bytes;
    if (format != "JPEG") {
        if (!openCvCodecs().encode(writer.extension, suited, bytes)) bytes.clear();
        return bytes;
    }
    std::vector<unsigned char> jpeg = encodeJpeg(suited, mark.isUnmixed);
    if (jpeg.size() > 6) // after the start of the image and the JFIF segment
        jpeg.insert(jpeg.begin() + 4 + 256 * jpeg[4] + jpeg[5], mark.segment.begin(),
                    mark.segment.end());
    return jpeg;
}

// The file's bytes. @param path as the user wrote it, for errors
std::vector<unsigned char> fileOf(const fs::path& path, const Writer& writer,
                                  const cv::Mat& picture, const FileMark& mark) {
    checkType(picture, {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}, "picture",
              "8 or 16 bits and 1 or 3 channels");
    if (std::max(picture.cols, picture.rows) > writer.longestSide) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    sizeText(picture.size()) + " are too many for " + writer.format +
                        ", expected sides of at most " + std::to_string(writer.longestSide) +
                        " px; write a .png");
    }
    if (writer.channels == 1 && picture.channels() == 3) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    std::string(writer.format) +
                        " holds no colours, expected .ppm or .png for a colour picture");
    }
    const std::string cannot = std::string("cannot be encoded as ") + writer.format;
    std::vector<unsigned char> file;
    try {
        file = orOutOfMemory(path.string(),
                             std::string("does not fit into memory as ") + writer.format +
                                 ", expected a smaller picture or more memory to be free",
                             [&] { return encode(picture, writer, mark); });
    } catch (const cv::Exception& exception) {
        throw Error(ErrorCode::WriteFailed, path.string(),
                    cannot + ": " + exception.err + "; write a .png");
    }
    if (file.empty()) {
        throw Error(ErrorCode::WriteFailed, path.string(), cannot + "; write a .png");
    }
    return file;
}

FileMark markOf(ImageMark mark) {
    if (mark == ImageMark::Native) return {std::string(kNativeMark), {}, true};
    return {};
}

std::vector<unsigned char> fileNamed(const fs::path& name, const cv::Mat& picture,
                                     const FileMark& mark) {
    const Writer* const writer = writerFor(name);
    if (writer == nullptr) {
        throw Error(ErrorCode::Unsupported, name.string(),
                    "its extension names no picture format that is written, expected .png, .jpg, "
                    ".tif, .webp, .bmp, .ppm, .pgm or .jp2");
    }
    return fileOf(name, *writer, picture, mark);
}

} // namespace

void writeImage(const fs::path& path, const cv::Mat& picture, ImageMark mark) {
    const std::vector<unsigned char> file = encodePicture(picture, path, mark);
    writeFile(path, {Bytes{file.data(), file.size()}});
}

void writeEyes(const fs::path& path, const cv::Mat& picture, EyesPicture kind, bool swapped) {
    const std::vector<unsigned char> file = fileNamed(path, picture, eyesMark(kind, swapped));
    writeFile(path, {Bytes{file.data(), file.size()}});
}

std::vector<unsigned char> encodePicture(const cv::Mat& picture, const fs::path& name,
                                         ImageMark mark) {
    return fileNamed(name, picture, markOf(mark));
}

std::vector<unsigned char> encodePicture(const cv::Mat& picture, ImageMark mark) {
    return fileOf("picture", kWriters.front(), picture, markOf(mark));
}

bool canWriteImage(const fs::path& path) {
    return writerFor(path) != nullptr;
}

} // namespace altiro3D
