#include "image/image_header.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/image_io.hpp"
#include "base/byte_reader.hpp"
#include "base/text.hpp"
#include "image/exif.hpp"
#include "image/file_walk.hpp"
#include "image/heif_file.hpp"
#include "image/tiff_file.hpp"

#include <algorithm>

namespace altiro3D {

namespace {

using std::string_view;

constexpr unsigned kMaxTextProfiles = 4; // limit for a PNG; each may have to be inflated

void readPng(string_view bytes, ImageHeader& header) {
    const ByteReader reader(bytes, false);
    unsigned colorType = 0;
    bool hasStart = false;
    bool hasEnd = false;
    // The EXIF chunk overrides text chunks, in any order.
    int exif = 1;
    int text = 1;
    unsigned textProfiles = 0;
    walkPng(bytes, [&](string_view name, std::uint64_t data, std::uint64_t size) {
        const string_view chunk = reader.text(data, size);
        if (name == "IHDR" && size >= 13 && !hasStart) { // decoders also use the first one
            hasStart = true;
            header.columns = reader.u32(data);
            header.rows = reader.u32(data + 4);
            header.bitsPerSample = static_cast<int>(reader.u8(data + 8));
            colorType = reader.u8(data + 9);
        } else if (name == "tRNS" && colorType == 0 && size >= 2) {
            const unsigned grey = reader.u16(data);
            header.transparentColor = ColorKey{grey, grey, grey};
        } else if (name == "tRNS" && colorType == 2 && size >= 6) {
            header.transparentColor =
                ColorKey{reader.u16(data), reader.u16(data + 2), reader.u16(data + 4)};
        } else if (name == "acTL") {
            header.pictures = std::max(1u, reader.u32(data));
        } else if (name == "eXIf") {
            exif = exifOrientation(chunk);
            header.exif = chunk;
        } else if (name == "tEXt" && chunk == kNativeMark) {
            header.isNative = true;
        } else if ((name == "tEXt" || name == "zTXt") && textProfiles < kMaxTextProfiles) {
            if (const auto found = exifOrientationInPngText(chunk, name == "zTXt")) {
                ++textProfiles;
                if (text == 1) text = *found;
            }
        }
        hasEnd = name == "IEND";
        return !hasEnd;
    });
    header.orientation = exif == 1 ? text : exif;
    header.isCutOff = !hasEnd;
}

void readJpegFrame(const ByteReader& reader, std::uint64_t data, unsigned marker,
                   ImageHeader& header) {
    header.bitsPerSample = static_cast<int>(reader.u8(data));
    header.rows = reader.u16(data + 1);
    header.columns = reader.u16(data + 3);
    if (header.bitsPerSample != 8) {
        header.unreadable = std::to_string(header.bitsPerSample) + "-bit JPEG";
    } else if (marker == 0xc3 || (marker >= 0xc5 && marker <= 0xc7) || marker == 0xcb ||
               marker >= 0xcd) {
        header.unreadable = "lossless or hierarchical JPEG";
    }
}

void readJpeg(string_view bytes, ImageHeader& header) {
    const ByteReader reader(bytes, false);
    bool hasExif = false;
    bool hasAdobe = false;
    bool progressive = false;
    unsigned components = 0;
    const JpegEnd end = walkJpeg(bytes, [&](unsigned marker, std::size_t data, string_view body) {
        const bool isFrame =
            marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (isFrame && header.columns == 0) {
            readJpegFrame(reader, data, marker, header);
            components = reader.u8(data + 5);
            progressive = marker == 0xc2 || marker == 0xca;
        } else if (marker == 0xe1 && !hasExif && startsWith(body, string_view("Exif\0\0", 6))) {
            header.orientation = exifOrientation(body);
            header.exif = body;
            hasExif = true;
        } else if (marker == 0xee && startsWith(body, "Adobe")) {
            hasAdobe = true;
        }
        return true;
    });
    header.usableBytes = end.usableBytes;
    header.isCutOff = !end.hasEnd;
    header.hasWholeScan = progressive && end.scans > 0;
    header.isCmyk = components == 4;
    header.isUnmarkedCmyk = header.isCmyk && !hasAdobe;
}

void readWebP(string_view bytes, ImageHeader& header) {
    const ByteReader reader(bytes, true);
    bool hasPicture = false;
    unsigned frames = 0;
    const auto setSize = [&](std::uint64_t columns, std::uint64_t rows) { // the first one counts
        if (header.columns != 0) return;
        header.columns = columns;
        header.rows = rows;
    };
    walkWebP(bytes, [&](string_view name, std::uint64_t data, std::uint64_t size) {
        hasPicture = hasPicture || name == "VP8 " || name == "VP8L";
        if (name == "VP8X") {
            header.isAnimated = (reader.u8(data) & 2u) != 0;
            setSize(reader.number(data + 4, 3) + 1, reader.number(data + 7, 3) + 1);
        } else if (name == "VP8 ") {
            setSize(reader.u16(data + 6) & 0x3fffu, reader.u16(data + 8) & 0x3fffu);
        } else if (name == "VP8L") {
            const std::uint32_t sizes = reader.u32(data + 1);
            setSize((sizes & 0x3fffu) + 1, (sizes >> 14 & 0x3fffu) + 1);
        } else if (name == "ANMF") {
            ++frames;
        } else if (name == "EXIF") {
            header.orientation = exifOrientation(reader.text(data, size));
            header.exif = reader.text(data, size);
        }
        if (!reader.holds(data, size)) header.isCutOff = true;
        return true;
    });
    header.pictures = std::max(1u, frames);
    if (!hasPicture && frames == 0) header.isCutOff = true;
}

void readBmp(string_view bytes, ImageHeader& header) {
    const ByteReader reader(bytes, true);
    const std::uint32_t size = reader.u32(14);
    if (size < 16) {
        header.columns = reader.u16(18);
        header.rows = reader.u16(20);
        return;
    }
    header.columns = reader.u32(18);
    const std::uint32_t rows = reader.u32(22); // negative: top row first
    header.rows = rows > 0x7fffffffu ? std::uint64_t{0x100000000} - rows : rows;
    // Without an alpha mask the fourth byte is padding, often 0.
    header.alpha = size >= 56 && reader.u32(66) != 0 ? AlphaKind::Straight : AlphaKind::Unstated;
}

// The next number of a Netpbm header; comments reach from # to the end of the line.
std::uint64_t netpbmNumber(string_view bytes, std::size_t& at) {
    while (at < bytes.size() && !isDigit(bytes[at]))
        at = bytes[at] == '#' ? std::min(bytes.find_first_of("\n\r", at), bytes.size()) : at + 1;
    std::uint64_t value = 0;
    for (; at < bytes.size() && isDigit(bytes[at]); ++at)
        value = std::min<std::uint64_t>(value * 10 + static_cast<unsigned>(bytes[at] - '0'),
                                        std::uint64_t{1} << 40);
    return value;
}

void readNetpbm(string_view bytes, ImageHeader& header) {
    std::size_t at = 2;
    header.columns = netpbmNumber(bytes, at);
    header.rows = netpbmNumber(bytes, at);
    const bool isBitmap = bytes[1] == '1' || bytes[1] == '4';
    if (header.format == ImageFormat::Pnm && !isBitmap) {
        const std::uint64_t largest = netpbmNumber(bytes, at);
        // in text files, OpenCV itself scales numbers up to 255 to the full range
        const bool isText = bytes[1] <= '3';
        if (!isText || largest > 255)
            header.largestSample = static_cast<unsigned>(std::min<std::uint64_t>(largest, 65535));
    }
}

void readExr(string_view bytes, ImageHeader& header) {
    const ByteReader reader(bytes, true);
    header.alpha = AlphaKind::Premultiplied;
    std::size_t at = 8;
    std::uint64_t columns = 0; // columns of the data
    std::uint64_t rows = 0;
    // A damaged header is ignored as a whole: OpenEXR allocates any size that it states.
    const auto giveUp = [&] { header.columns = header.rows = 0; };
    while (reader.u8(at) != 0) { // name \0 type \0 size value
        const std::size_t name = bytes.find('\0', at);
        if (name == string_view::npos) return giveUp();
        const std::size_t type = bytes.find('\0', name + 1);
        if (type == string_view::npos) return giveUp();
        const std::uint64_t size = reader.u32(type + 1);
        const std::uint64_t data = type + 5;
        const string_view key = bytes.substr(at, name - at);
        const bool isData = key == "dataWindow";
        if ((isData || key == "displayWindow") && size == 16 && reader.holds(data, 16)) {
            const auto extent = [&](std::uint64_t low, std::uint64_t high) {
                const std::int64_t span =
                    static_cast<std::int64_t>(static_cast<std::int32_t>(reader.u32(high))) -
                    static_cast<std::int32_t>(reader.u32(low)) + 1;
                return span > 0 ? static_cast<std::uint64_t>(span) : 0;
            };
            (isData ? columns : header.columns) = extent(data, data + 8);
            (isData ? rows : header.rows) = extent(data + 4, data + 12);
        }
        if (!reader.holds(data, size)) return giveUp();
        at = static_cast<std::size_t>(data + size);
    }
    // The display window is the picture; the data may reach beyond it, or fill a part of it.
    const bool isLarge = columns > kMaxImageSide || rows > kMaxImageSide ||
                         static_cast<double>(columns) * static_cast<double>(rows) > kMaxImagePixels;
    if (header.columns == 0 || columns == 0 || rows == 0 || isLarge) {
        header.columns = columns;
        header.rows = rows;
    }
}

void readHdr(string_view bytes, ImageHeader& header) {
    // Lines up to an empty line, then "-Y rows +X columns".
    std::size_t at = bytes.find("\n\n");
    if (at == string_view::npos) return;
    if (bytes.substr(0, at).find("FORMAT=32-bit_rle_xyze") != string_view::npos)
        header.unreadable = "XYZE HDR";
    at += 2;
    const string_view line =
        bytes.substr(at, std::min<std::size_t>(bytes.find('\n', at) - at, 100));
    std::size_t next = 0;
    header.rows = netpbmNumber(line, next);
    header.columns = netpbmNumber(line, next);
    if (!startsWith(line, "-Y") || line.find(" +X ") == string_view::npos)
        header.unreadable = "turned or mirrored HDR";
}

// Start of the codestream of a JPEG 2000 file. In a .jp2 it has a box after any other boxes.
std::uint64_t codestreamAt(string_view bytes, const ByteReader& reader) {
    if (startsWith(bytes, "\xff\x4f")) return 0;
    std::uint64_t at = 0;
    while (reader.holds(at, 8)) {
        std::uint64_t size = reader.u32(at);
        std::uint64_t head = 8;
        if (size == 1) { // a 64-bit size follows
            size = reader.u64(at + 8);
            head = 16;
        }
        if (reader.text(at + 4, 4) == "jp2c") return at + head;
        if (size < head || !reader.holds(at, size)) break;
        at += size;
    }
    return bytes.size();
}

void readJpeg2000(string_view bytes, ImageHeader& header) {
    const ByteReader reader(bytes, false);
    const std::uint64_t at = codestreamAt(bytes, reader);
    if (reader.u32(at) != 0xff4fff51u) return; // SIZ immediately follows SOC
    const auto extent = [&](std::uint64_t high, std::uint64_t low) -> std::uint64_t {
        return reader.u32(high) > reader.u32(low) ? reader.u32(high) - reader.u32(low) : 0;
    };
    header.columns = extent(at + 8, at + 16);
    header.rows = extent(at + 12, at + 20);
    const unsigned depth = reader.u8(at + 42); // bits of the first component
    const unsigned bits = (depth & 127U) + 1;
    if ((depth & 128U) != 0) {
        header.unreadable = "signed JPEG 2000";
    } else if (bits < 8 || bits > 16) {
        header.unreadable = std::to_string(bits) + "-bit JPEG 2000";
    } else {
        header.largestSample = (1U << bits) - 1;
    }
}

// Turning and mirroring belong to the format and are done by its decoder; EXIF only repeats them.
void readHeif(string_view bytes, ImageHeader& header) {
    const HeifFile file(bytes);
    header.columns = static_cast<std::uint64_t>(file.size().width);
    header.rows = static_cast<std::uint64_t>(file.size().height);
    header.pictures = std::max(file.pictures(), heifFrames(bytes));
    header.exif = file.exif();
}

void readUnknown(string_view bytes, ImageHeader& header) {
    header.isText = containsOnlyText(bytes);
    header.otherFormat = startsWith(bytes, "II*") ? "camera raw (cr2)" : otherFormatName(bytes);
}

} // namespace

ImageHeader readImageHeader(string_view bytes, const std::string& extension) {
    using Reader = void (*)(string_view, ImageHeader&);
    constexpr Reader kReaders[] = {readUnknown,  readPng,    readJpeg,   describeTiff, readWebP,
                                   readBmp,      readNetpbm, readNetpbm, readExr,      readHdr,
                                   readJpeg2000, readHeif,   readHeif};
    ImageHeader header;
    header.format = imageFormat(bytes);
    const ImageFormat format = header.format;
    try {
        entryOf(kReaders, format)(bytes, header);
    } catch (const PictureFailure& failure) {
        header.decoderMessage = failure.what();
    }
    if (format == ImageFormat::Jpeg && extension == ".mpo")
        header.pictures = 2;           // at least; the first one is used
    if (format == ImageFormat::Tiff) { // so are many raw pictures of cameras
        if (extension == ".dng")
            header.otherFormat = "DNG";
        else if (isRawExtension(extension))
            header.otherFormat = "camera raw (" + extension.substr(1) + ")";
        if (!header.otherFormat.empty()) header.format = ImageFormat::Unknown;
    }
    return header;
}

} // namespace altiro3D
