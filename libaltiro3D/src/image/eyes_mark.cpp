#include "image/eyes_mark.hpp"

#include "base/byte_reader.hpp"
#include "base/image_format.hpp"
#include "base/text.hpp"
#include "image/jpeg_walk.hpp"

#include <cstdint>

namespace altiro3D {

namespace {

using std::string_view;

constexpr string_view kJpsMark = "_JPSJPS_";

// The length of the descriptor (2 bytes), then from its last byte to its first: media, layout,
// flags, separation.
EyesMark readJps(string_view body) {
    constexpr unsigned kHalfHeight = 1;
    constexpr unsigned kHalfWidth = 2;
    constexpr unsigned kLeftFirst = 4;
    const ByteReader reader(body, false);
    EyesMark mark;
    if (!reader.holds(0, 6) || reader.u16(0) < 4) {
        mark.damage = "it is cut off";
        return mark;
    }
    const unsigned separation = reader.u8(2);
    const unsigned flags = reader.u8(3);
    const unsigned layout = reader.u8(4);
    const unsigned media = reader.u8(5);
    if (media == 0) {
        mark.isOneEye = true;
        return mark;
    }
    if (media != 1) {
        mark.damage = "it states the medium " + std::to_string(media) + ", which does not exist";
        return mark;
    }
    StatedEyes eyes;
    const bool isLeftFirst = (flags & kLeftFirst) != 0;
    switch (layout) {
    case 1:
        mark.unreadable = "interleaved";
        return mark;
    case 2:
        eyes.layout = isLeftFirst ? StereoLayout::LeftRight : StereoLayout::RightLeft;
        break;
    case 3:
        eyes.layout = isLeftFirst ? StereoLayout::TopBottom : StereoLayout::BottomTop;
        break;
    case 4:
        mark.unreadable = "anaglyph";
        return mark;
    default:
        mark.damage = "it states the layout " + std::to_string(layout) + ", which does not exist";
        return mark;
    }
    const unsigned half = flags & (kHalfWidth | kHalfHeight); // both keep the shape
    if (half == kHalfWidth) eyes.squeeze = Squeeze::Width;
    if (half == kHalfHeight) eyes.squeeze = Squeeze::Height;
    eyes.gap = static_cast<int>(separation);
    mark.eyes = eyes;
    return mark;
}

EyesMark markOfJpeg(string_view bytes) {
    EyesMark mark;
    bool isFound = false;
    walkJpeg(bytes, [&](unsigned marker, std::size_t /*at*/, string_view body) {
        if (marker == 0xe3 && startsWith(body, kJpsMark)) {
            mark = readJps(body.substr(kJpsMark.size()));
            isFound = true;
        }
        return !isFound && marker != 0xda;
    });
    return mark;
}

// The right picture begins at a multiple of 8 px: the width is 2 w and up to 7 px of padding.
EyesMark markOfPng(string_view bytes) {
    const ByteReader reader(bytes, false);
    EyesMark mark;
    for (std::uint64_t at = 8; reader.holds(at, 12);) {
        const std::uint64_t size = reader.u32(at);
        const string_view name = reader.text(at + 4, 4);
        if (name == "IDAT" || !reader.holds(at + 8, size + 4)) break;
        if (name == "sTER") {
            const unsigned mode = reader.u8(at + 8);
            if (size != 1 || mode > 1) {
                mark.damage = "it states a layout that does not exist";
                break;
            }
            StatedEyes& eyes = mark.eyes.emplace();
            eyes.layout = mode == 0 ? StereoLayout::RightLeft : StereoLayout::LeftRight;
            eyes.gap = static_cast<int>((16 - reader.u32(16) % 16) % 16); // 16 is IHDR's width
            if (eyes.gap > 7) eyes.gap = 0; // not as the chunk demands: halves
            break;
        }
        at += size + 12;
    }
    return mark;
}

} // namespace

EyesMark readEyesMark(string_view bytes) {
    switch (imageFormat(bytes)) {
    case ImageFormat::Jpeg:
        return markOfJpeg(bytes);
    case ImageFormat::Png:
        return markOfPng(bytes);
    default:
        return {};
    }
}

} // namespace altiro3D
