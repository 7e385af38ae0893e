// EXIF; the first byte chooses its container.

#include "fuzz.hpp"
#include "image/exif.hpp"

#include <zlib.h>

using namespace altiro3D;

namespace {

// As ImageMagick writes it.
std::string hexadecimal(std::string_view bytes) {
    constexpr const char* kDigits = "0123456789abcdef";
    std::string text = "\nexif\n " + std::to_string(bytes.size()) + "\n";
    for (const char c : bytes) {
        const auto code = static_cast<unsigned char>(c);
        text += kDigits[code >> 4U];
        text += kDigits[code & 15U];
    }
    return text;
}

std::string deflated(const std::string& text) {
    uLongf size = compressBound(static_cast<uLong>(text.size()));
    std::string packed(size, '\0');
    compress(reinterpret_cast<Bytef*>(packed.data()), &size,
             reinterpret_cast<const Bytef*>(text.data()), static_cast<uLong>(text.size()));
    packed.resize(size);
    return packed;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const unsigned kind = bytes.byte() % 5;
    const std::string_view blob = bytes.rest();
    const std::string keyword("Raw profile type exif\0", 22);
    int orientation = 1;
    if (kind == 0) orientation = exifOrientation(blob);
    const auto inText = [&](const std::string& chunk, bool compressed) {
        orientation = exifOrientationInPngText(chunk, compressed).value_or(1);
    };
    if (kind == 1) inText(std::string(blob), false);
    if (kind == 2) inText(std::string(blob), true);
    if (kind == 3) inText(keyword + hexadecimal(blob), false);
    if (kind == 4) inText(keyword + '\0' + deflated(hexadecimal(blob)), true);
    fuzz::require(orientation >= 1 && orientation <= 8, "orientations are 1..8");
    fuzz::require(exifText(blob, kExifArtist).size() <= size, "texts are in the file");
    return 0;
}
