// Pictures that hold both eyes: what their files state, and how they are split.

#include "altiro3D/enum_table.hpp"
#include "altiro3D/image_io.hpp"

#include "base/byte_reader.hpp"
#include "base/checks.hpp"
#include "base/image_format.hpp"
#include "base/text.hpp"
#include "image/file_walk.hpp"
#include "image/picture_halves.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

namespace altiro3D {

namespace {

using std::string_view;

// Both eyes in one picture, the right one's at the left.
bool isPairName(const std::filesystem::path& photo) {
    const std::string extension = lowerExtension(photo);
    return extension == ".jps" || extension == ".pns";
}

StereoPair split(const cv::Mat& picture, const StatedEyes& eyes, const std::string& name) {
    const bool isBeside =
        eyes.layout == StereoLayout::LeftRight || eyes.layout == StereoLayout::RightLeft;
    const HalfPlaces places = halfPlaces(picture.size(), isBeside, eyes.gap);
    check(!places.first.empty(), name.c_str(), shapeText(picture) + ", expected two halves");
    StereoPair pair;
    pair.left = picture(places.first);
    pair.right = picture(places.second);
    if (eyes.layout == StereoLayout::RightLeft || eyes.layout == StereoLayout::BottomTop)
        cv::swap(pair.left, pair.right);
    for (cv::Mat* half : {&pair.left, &pair.right})
        stretch(*half, eyes.squeeze, cv::INTER_LINEAR);
    return pair;
}

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
    walkPng(bytes, [&](string_view name, std::uint64_t data, std::uint64_t size) {
        if (name != "sTER") return name != "IDAT";
        const unsigned mode = reader.u8(data);
        if (size != 1 || mode > 1) {
            mark.damage = "it states a layout that does not exist";
            return false;
        }
        StatedEyes& eyes = mark.eyes.emplace();
        eyes.layout = mode == 0 ? StereoLayout::RightLeft : StereoLayout::LeftRight;
        eyes.gap = static_cast<int>((16 - reader.u32(16) % 16) % 16); // 16 is IHDR's width
        if (eyes.gap > 7) eyes.gap = 0; // not as the chunk demands: halves
        return false;
    });
    return mark;
}

} // namespace

MarkedEyes findMarkedEyes(const std::filesystem::path& photo, string_view bytes, Notes* notes) {
    const EyesMark mark = readEyesMark(bytes);
    const bool isJpeg = imageFormat(bytes) == ImageFormat::Jpeg;
    const std::string name = isJpeg ? "JPS header" : "chunk sTER";
    if (!mark.unreadable.empty()) {
        throw Error(ErrorCode::Unsupported, photo.string(),
                    "is " + mark.unreadable + " by its " + name +
                        ", which is not read, expected the eyes beside or above each other");
    }
    const bool isPns = lowerExtension(photo) == ".pns";
    if (mark.eyes) return {mark.eyes, false, isJpeg ? "JPS" : isPns ? "PNS" : "PNG with sTER"};
    const auto note = [&](NoteCode code, const std::string& text) {
        addNote(notes, code, "its " + name + text);
    };
    if (mark.isOneEye) {
        note(NoteCode::AsItIs, " says that the picture is of one eye: it is read as a photo");
        return {};
    }
    if (!isPairName(photo)) {
        if (!mark.damage.empty())
            note(NoteCode::LeftOut, " is not used, as " + mark.damage + ": it is read as a photo");
        return {};
    }
    if (!mark.damage.empty()) {
        note(NoteCode::LeftOut, " is not used, as " + mark.damage +
                                    ": the right eye's picture is taken to be at the left");
    }
    return {StatedEyes{StereoLayout::RightLeft, Squeeze::None, 0}, true, isPns ? "PNS" : "JPS"};
}

StereoPair splitMarkedEyes(const cv::Mat& picture, const MarkedEyes& marked,
                           const std::string& name) {
    StatedEyes eyes = *marked.eyes;
    if (marked.isByName) eyes.squeeze = squeezeOf(picture.size(), true, StereoHalves::Automatic);
    if (eyes.gap > 0 && eyes.gap >= std::min(picture.cols, picture.rows) / 2) eyes.gap = 0;
    StereoPair pair = split(picture, eyes, name);
    pair.origin = marked.origin;
    if (eyes.squeeze != Squeeze::None) pair.origin += ", squeezed";
    return pair;
}

StereoPair splitStereoPair(const cv::Mat& picture, StereoLayout layout, StereoHalves halves) try {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
    constexpr const char* kNames[] = {"left and right half", "right and left half",
                                      "upper and lower half", "lower and upper half"};
    const bool isBeside = layout == StereoLayout::LeftRight || layout == StereoLayout::RightLeft;
    const StatedEyes eyes{layout, squeezeOf(picture.size(), isBeside, halves), 0};
    StereoPair pair = split(picture, eyes, "picture");
    pair.origin = entryOf(kNames, layout);
    if (eyes.squeeze != Squeeze::None) pair.origin += ", squeezed";
    return pair;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

EyesMark readEyesMark(string_view bytes) {
    const ImageFormat format = imageFormat(bytes);
    if (format == ImageFormat::Jpeg) return markOfJpeg(bytes);
    return format == ImageFormat::Png ? markOfPng(bytes) : EyesMark();
}

} // namespace altiro3D
