#include "base/image_format.hpp"

#include "base/byte_reader.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>

namespace altiro3D {

namespace {

using std::string_view;

// Signatures of formats that are not supported, for a good error message.
struct Signature {
    std::size_t at;
    string_view bytes;
    const char* name;
};

constexpr std::array<Signature, 17> kOthers = {{
    {0, string_view("GIF8", 4), "GIF"},
    {0, string_view("\xff\x0a", 2), "JPEG XL"},
    {4, string_view("JXL \r\n\x87\n", 8), "JPEG XL"},
    {0, string_view("8BPS", 4), "PSD"},
    {0, string_view("gimp xcf", 8), "XCF"},
    {0, string_view("%PDF", 4), "PDF"},
    {0, string_view("FUJIFILMCCD-RAW", 15), "camera raw (raf)"},
    {0, string_view("IIRO", 4), "camera raw (orf)"},
    {0, string_view("IIRS", 4), "camera raw (orf)"},
    {0, string_view("MMOR", 4), "camera raw (orf)"},
    {0, string_view("IIU\0", 4), "camera raw (rw2)"},
    {0, string_view("FOVb", 4), "camera raw (x3f)"},
    {0, string_view("\x93NUMPY", 6), "NumPy"},
    {0, string_view("PK\3\4", 4), "ZIP"},
    {0, string_view("\x1f\x8b", 2), "gzip"},
    {0, string_view("\x1a\x45\xdf\xa3", 4), "Matroska video"},
    {8, string_view("AVI ", 4), "AVI video"},
}};

// The brands of an ISO base media file: the main one, then those that it is compatible with.
bool hasBrand(string_view bytes, std::initializer_list<string_view> brands) {
    constexpr std::size_t kMaxBrands = 64;
    const ByteReader reader(bytes, false);
    const std::size_t end = std::min<std::size_t>(reader.u32(0), 16 + 4 * kMaxBrands);
    for (std::size_t at = 8; at + 4 <= std::max<std::size_t>(end, 12); at += 4) {
        if (at == 12) continue; // the version of the main brand
        if (std::find(brands.begin(), brands.end(), reader.text(at, 4)) != brands.end()) {
            return true;
        }
    }
    return false;
}

bool isIsoMedia(string_view bytes) {
    return bytes.size() >= 12 && bytes.substr(4, 4) == "ftyp";
}

// ISO base media files: the brand distinguishes pictures from videos.
ImageFormat isoMediaFormat(string_view bytes) {
    if (bytes.substr(8, 4) == "crx ") return ImageFormat::Unknown;
    if (hasBrand(bytes, {"avif", "avis"})) return ImageFormat::Avif;
    if (hasBrand(bytes, {"heic", "heix", "heim", "heis", "hevc", "hevx", "mif1", "msf1"})) {
        return ImageFormat::Heic;
    }
    return ImageFormat::Unknown;
}

} // namespace

bool containsOnlyText(string_view bytes) {
    const string_view begin = bytes.substr(0, 4096);
    return std::all_of(begin.begin(), begin.end(), [](char c) {
        const auto code = static_cast<unsigned char>(c);
        return code >= 0x20 || code == '\n' || code == '\r' || code == '\t';
    });
}

std::string otherFormatName(string_view bytes) {
    for (const Signature& signature : kOthers) {
        if (bytes.size() >= signature.at &&
            startsWith(bytes.substr(signature.at), signature.bytes)) {
            return signature.name;
        }
    }
    if (isIsoMedia(bytes)) return bytes.substr(8, 4) == "crx " ? "camera raw (cr3)" : "MP4 video";
    if (!containsOnlyText(bytes)) return {};
    const string_view begin = bytes.substr(0, 4096);
    if (begin.find("<svg") != string_view::npos) return "SVG";
    for (const char* mark : {"<html", "<HTML", "<!DOCTYPE html"}) {
        if (begin.find(mark) != string_view::npos) return "HTML";
    }
    return {};
}

ImageFormat imageFormat(string_view bytes) {
    if (startsWith(bytes, string_view("\x89PNG\r\n\x1a\n", 8))) return ImageFormat::Png;
    if (startsWith(bytes, string_view("\xff\xd8", 2))) return ImageFormat::Jpeg;
    // Canon's CR2 has its own mark inside a TIFF header.
    const bool isCr2 = bytes.size() >= 10 && bytes.substr(8, 2) == "CR";
    const string_view start = bytes.substr(0, 4);
    for (const string_view mark : {string_view("II*\0", 4), string_view("MM\0*", 4),
                                   string_view("II+\0", 4), string_view("MM\0+", 4)})
        if (start == mark && !isCr2) return ImageFormat::Tiff;
    if (startsWith(bytes, "RIFF") && bytes.size() >= 12 && bytes.substr(8, 4) == "WEBP") {
        return ImageFormat::WebP;
    }
    if (startsWith(bytes, "BM") && bytes.size() >= 18 && !containsOnlyText(bytes)) {
        return ImageFormat::Bmp;
    }
    if (bytes.size() >= 3 && bytes[0] == 'P' &&
        string_view(" \t\r\n#").find(bytes[2]) != string_view::npos) {
        if (bytes[1] >= '1' && bytes[1] <= '6') return ImageFormat::Pnm;
        if (bytes[1] == 'f' || bytes[1] == 'F') return ImageFormat::Pfm;
    }
    if (startsWith(bytes, string_view("\x76\x2f\x31\x01", 4))) return ImageFormat::Exr;
    if (startsWith(bytes, "#?RADIANCE") || startsWith(bytes, "#?RGBE")) return ImageFormat::Hdr;
    if (startsWith(bytes, string_view("\0\0\0\x0cjP  \r\n\x87\n", 12)) ||
        startsWith(bytes, string_view("\xff\x4f\xff\x51", 4))) {
        return ImageFormat::Jpeg2000;
    }
    if (isIsoMedia(bytes)) return isoMediaFormat(bytes);
    return ImageFormat::Unknown;
}

} // namespace altiro3D
