#include "image/exif.hpp"

#include "base/byte_reader.hpp"
#include "base/pixel_rows.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <charconv>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace altiro3D {

namespace {

using std::string_view;

constexpr std::size_t kMaxExifBytes = std::size_t{1} << 20;

// ImageMagick's format for EXIF in a text chunk: "\nexif\n <length>\n<hexadecimal digits>".
std::string rawProfile(string_view text) {
    std::string bytes;
    if (text.empty() || text[0] != '\n') return bytes;
    const std::size_t name = text.find('\n', 1);
    if (name == string_view::npos) return bytes;
    const std::size_t length = text.find('\n', name + 1);
    if (length == string_view::npos) return bytes;
    std::string digits;
    for (const char c : text.substr(length + 1)) {
        if (string_view("0123456789abcdefABCDEF").find(c) != string_view::npos) digits += c;
    }
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
        unsigned char byte = 0;
        std::from_chars(digits.data() + i, digits.data() + i + 2, byte, 16);
        bytes.push_back(static_cast<char>(byte));
    }
    return bytes;
}

// cv::rotate() by a quarter turn, in bands that fit into the cache and on all threads.
void turn(const cv::Mat& picture, bool clockwise, cv::Mat& result) {
    constexpr int kBandRows = 64;
    result.create(picture.cols, picture.rows, picture.type());
    const int bands = (result.rows + kBandRows - 1) / kBandRows;
    overRows(bands, [&](int band) {
        const cv::Range to(band * kBandRows, std::min((band + 1) * kBandRows, result.rows));
        const cv::Range from =
            clockwise ? to : cv::Range(picture.cols - to.end, picture.cols - to.start);
        cv::Mat rows = result.rowRange(to);
        cv::rotate(picture.colRange(from), rows,
                   clockwise ? cv::ROTATE_90_CLOCKWISE : cv::ROTATE_90_COUNTERCLOCKWISE);
    });
}

} // namespace

int validOrientation(unsigned value) {
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
}

namespace {

// The blob from its TIFF header on.
string_view withoutPrefix(string_view blob) {
    constexpr string_view kPrefix("Exif\0\0", 6);
    if (startsWith(blob, kPrefix)) blob.remove_prefix(kPrefix.size());
    return blob;
}

// The whole number of an EXIF blob with a tag, in the main directory or that of the photo.
std::optional<std::uint64_t> exifNumber(string_view blob, unsigned tag, bool isOfPhoto) {
    constexpr unsigned kSizes[] = {0, 1, 0, 2, 4, 0, 1, 0, 2, 4}; // bytes of whole numbers, by type
    constexpr unsigned kPhotoDirectory = 0x8769;
    blob = withoutPrefix(blob);
    const bool isLittle = startsWith(blob, "II");
    if (!isLittle && !startsWith(blob, "MM")) return std::nullopt;
    const ByteReader reader(blob, isLittle);
    const auto find = [&](std::uint64_t directory,
                          unsigned wanted) -> std::optional<std::uint64_t> {
        const unsigned entries = reader.u16(directory);
        for (unsigned i = 0; i < entries; ++i) { // 12 bytes each: tag, type, count, value
            const std::uint64_t entry = directory + 2 + std::uint64_t{12} * i;
            if (reader.u16(entry) != wanted) continue;
            const unsigned type = reader.u16(entry + 2);
            const unsigned size = type < std::size(kSizes) ? kSizes[type] : 0;
            if (reader.u32(entry + 4) != 1) return std::nullopt;
            return reader.number(entry + 8, size);
        }
        return std::nullopt;
    };
    if (!isOfPhoto) return find(reader.u32(4), tag);
    const auto photo = find(reader.u32(4), kPhotoDirectory);
    return photo ? find(*photo, tag) : std::nullopt;
}

} // namespace

std::string exifText(string_view blob, unsigned tag) {
    blob = withoutPrefix(blob);
    const ByteReader reader(blob, startsWith(blob, "II"));
    const std::uint64_t directory = reader.u32(4);
    for (unsigned i = 0; i < reader.u16(directory); ++i) {
        const std::uint64_t entry = directory + 2 + std::uint64_t{12} * i;
        constexpr unsigned kText = 2;
        if (reader.u16(entry) != tag || reader.u16(entry + 2) != kText) continue;
        const std::uint64_t size = reader.u32(entry + 4);
        const string_view text = reader.text(size > 4 ? reader.u32(entry + 8) : entry + 8, size);
        return std::string(text.substr(0, text.find('\0')));
    }
    return {};
}

int exifOrientation(string_view blob) {
    return validOrientation(static_cast<unsigned>(exifNumber(blob, 0x112, false).value_or(1)));
}

int exifFocalLength(string_view blob) {
    constexpr std::uint64_t kLongest = 5000;
    const std::uint64_t millimetres = exifNumber(blob, 0xA405, true).value_or(0);
    return millimetres <= kLongest ? static_cast<int>(millimetres) : 0;
}

std::optional<int> exifOrientationInPngText(string_view chunk, bool compressed) {
    const std::size_t end = chunk.find('\0');
    if (end == string_view::npos) return std::nullopt;
    const string_view keyword = chunk.substr(0, end);
    if (keyword != "Raw profile type exif" && keyword != "Raw profile type APP1")
        return std::nullopt;
    if (!compressed) return exifOrientation(rawProfile(chunk.substr(end + 1)));
    if (chunk.size() < end + 2 || chunk[end + 1] != 0) // 0: deflate, the only method
        return std::nullopt;
    return exifOrientation(rawProfile(inflated(chunk.substr(end + 2), 2 * kMaxExifBytes + 1024)));
}

// The sides on which row 0 and column 0 of the file appear: 2 top, right; 3 bottom, right; 4
// bottom, left; 5 left, top; 6 right, top; 7 right, bottom; 8 left, bottom.
cv::Mat upright(const cv::Mat& picture, int orientation) {
    if (orientation < 2 || orientation > 8) return picture;
    cv::Mat result;
    if (orientation == 6 || orientation == 8) {
        turn(picture, orientation == 6, result);
        return result;
    }
    constexpr int kFlips[] = {1, -1, 0}; // 2, 3, 4
    if (orientation <= 4) {
        cv::flip(picture, result, kFlips[orientation - 2]);
    } else {
        cv::transpose(picture, result);
    }
    if (orientation == 7) cv::flip(result, result, -1);
    return result;
}

} // namespace altiro3D
