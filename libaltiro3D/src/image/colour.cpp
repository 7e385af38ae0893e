#include "image/colour.hpp"

#include "base/byte_reader.hpp"
#include "base/text.hpp"
#include "image/file_walk.hpp"
#include "image/tiff_file.hpp"

#include <algorithm>
#include <cstring>
#include <locale>
#include <map>
#include <sstream>

namespace altiro3D {

namespace {

using std::string_view;

constexpr std::size_t kMaxProfileBytes = std::size_t{16} << 20; // the largest in use have 3 MB

ColourFacts ofPng(string_view bytes) {
    const ByteReader reader(bytes, false);
    ColourFacts facts;
    bool hasProfile = false;
    walkPng(bytes, [&](string_view name, std::uint64_t data, std::uint64_t size) {
        if (name == "cICP" && size == 4) {
            facts.code = ColourCode{static_cast<int>(reader.u8(data)),
                                    static_cast<int>(reader.u8(data + 1))};
        } else if (name == "iCCP" && !hasProfile) {
            hasProfile = true;
            const string_view chunk = reader.text(data, size);
            const std::size_t end = chunk.find('\0');
            if (end != string_view::npos && end + 2 <= chunk.size())
                facts.icc = inflated(chunk.substr(end + 2), kMaxProfileBytes);
        } else if (name == "sRGB") {
            facts.isSrgb = true;
        } else if (name == "gAMA" && size == 4) {
            facts.gamma = reader.u32(data) / 100000.0;
        } else if (name == "cHRM" && size == 32) {
            facts.chromaticities.emplace();
            for (unsigned i = 0; i < 8; ++i)
                (*facts.chromaticities)[i] = reader.u32(data + std::uint64_t{4} * i) / 100000.0;
        }
        return name != "IDAT"; // colours come first
    });
    return facts;
}

// The profile is in segments "ICC_PROFILE\0", number, count, part.
std::string iccOfJpeg(string_view bytes) {
    constexpr string_view kMark("ICC_PROFILE\0", 12);
    std::map<unsigned, string_view> parts;
    walkJpeg(bytes, [&](unsigned marker, std::size_t, string_view body) {
        if (marker == 0xe2 && startsWith(body, kMark) && body.size() > 14) {
            parts.emplace(static_cast<unsigned char>(body[12]), body.substr(14));
        }
        return marker != 0xda;
    });
    std::string profile;
    for (const auto& part : parts)
        profile += part.second;
    return profile;
}

std::string iccOfWebP(string_view bytes) {
    std::string profile;
    walkWebP(bytes, [&](string_view name, std::uint64_t data, std::uint64_t size) {
        if (name != "ICCP") return true;
        if (size <= kMaxProfileBytes) profile = ByteReader(bytes, true).text(data, size);
        return false;
    });
    return profile;
}

// The attribute "chromaticities": x and y of red, green, blue and white. If missing, those of sRGB.
ColourFacts ofExr(string_view bytes) {
    constexpr string_view kAttribute("chromaticities\0chromaticities\0\x20\0\0\0", 34);
    constexpr std::size_t kMaxHeader = std::size_t{1} << 16;
    ColourFacts facts;
    facts.gamma = 1;
    const std::size_t found = bytes.substr(0, kMaxHeader).find(kAttribute);
    if (found == string_view::npos || bytes.size() < found + kAttribute.size() + 32) return facts;
    std::array<float, 8> values{};
    std::memcpy(values.data(), bytes.data() + found + kAttribute.size(), sizeof(values));
    facts.chromaticities.emplace();
    for (std::size_t i = 0; i < 8; ++i)
        (*facts.chromaticities)[(i + 2) % 8] = double{values[i]};
    return facts;
}

// The line "PRIMARIES= ...": x and y of red, green, blue and white.
ColourFacts ofHdr(string_view bytes) {
    ColourFacts facts;
    facts.gamma = 1;
    const string_view header = bytes.substr(0, bytes.find("\n\n"));
    const std::size_t found = header.find("\nPRIMARIES=");
    if (found == string_view::npos) return facts;
    const string_view line = header.substr(found + 11);
    std::istringstream numbers(std::string(line.substr(0, line.find('\n'))));
    numbers.imbue(std::locale::classic());
    std::array<double, 8> values{};
    for (std::size_t i = 0; i < 8; ++i)
        numbers >> values[(i + 2) % 8];
    if (numbers) facts.chromaticities = values;
    return facts;
}

} // namespace

ColourFacts readColourFacts(string_view bytes, ImageFormat format) {
    ColourFacts facts;
    try {
        if (isHeif(format)) return readColourFacts(HeifFile(bytes));
        if (format == ImageFormat::Png) return ofPng(bytes);
        if (format == ImageFormat::Tiff) {
            const TiffLight light = tiffLight(bytes);
            facts.icc = light.icc;
            facts.gamma = light.isLinear ? 1 : 0;
        }
        if (format == ImageFormat::Exr) return ofExr(bytes);
        if (format == ImageFormat::Hdr) return ofHdr(bytes);
        if (format == ImageFormat::Jpeg) facts.icc = iccOfJpeg(bytes);
        if (format == ImageFormat::WebP) facts.icc = iccOfWebP(bytes);
    } catch (const PictureFailure&) { // decoding reports it
    }
    return facts;
}

ColourFacts readColourFacts(const HeifFile& file, std::optional<std::uint32_t> item) {
    ColourFacts facts;
    facts.icc = file.iccProfile(item);
    if (facts.icc.empty()) facts.code = file.colours(item);
    return facts;
}

} // namespace altiro3D
