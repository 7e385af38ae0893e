#pragma once

#include <cstdint>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>
#include <zlib.h>

/// Skips the test where OpenCV was built without a format, as EXR and JPEG 2000 on Windows.
#define ALTIRO3D_REQUIRE_WRITER(extension)                                                         \
    if (!cv::haveImageWriter(extension)) GTEST_SKIP() << "OpenCV does not write " << (extension)

/// Files of pictures, byte by byte.
namespace altiro3D::test {

inline std::string bigEndian(std::uint64_t value, unsigned bytes = 4) {
    std::string text;
    for (unsigned i = bytes; i-- > 0;)
        text.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
    return text;
}

inline std::string littleEndian(std::uint64_t value, unsigned bytes = 4) {
    const std::string text = bigEndian(value, bytes);
    return {text.rbegin(), text.rend()};
}

/// The number in four bytes of a text.
inline std::uint32_t bigEndianAt(const std::string& text, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value = value << 8 | static_cast<uchar>(text.at(at + i));
    return value;
}

/// A file as OpenCV writes it.
inline std::string encoded(const std::string& extension, const cv::Mat& picture,
                           const std::vector<int>& settings = {}) {
    std::vector<uchar> bytes;
    cv::imencode(extension, picture, bytes, settings);
    return {bytes.begin(), bytes.end()};
}

/// As OpenCV reads it, without a turn. Empty if it cannot.
inline cv::Mat decoded(const std::string& bytes, int flags = cv::IMREAD_COLOR) {
    try {
        return cv::imdecode(std::vector<uchar>(bytes.begin(), bytes.end()),
                            flags | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
        return {};
    }
}

/// The picture after JPEG's losses.
inline cv::Mat compressed(const cv::Mat& picture, int quality) {
    return decoded(encoded(".jpg", picture, {cv::IMWRITE_JPEG_QUALITY, quality}));
}

inline std::string pngChunk(const std::string& name, const std::string& data) {
    const std::string body = name + data;
    return bigEndian(data.size()) + body +
           bigEndian(crc32_z(0, reinterpret_cast<const Bytef*>(body.data()), body.size()));
}

/// The PNG with chunks after its header.
inline std::string withPngChunks(std::string png, const std::string& chunks) {
    return png.insert(33, chunks);
}

/// The bytes as zlib packs them.
inline std::string deflated(const std::string& bytes) {
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    std::string packed(size, '\0');
    compress(reinterpret_cast<Bytef*>(packed.data()), &size,
             reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
    return packed.substr(0, size);
}

} // namespace altiro3D::test
