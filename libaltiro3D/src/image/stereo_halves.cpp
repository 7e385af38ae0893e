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
#include <utility>

namespace altiro3D {

namespace {

using std::string_view;

// Whether a name says that one picture holds both eyes, the right one's at the left.
bool isPairName(const std::filesystem::path& photo) {
    const std::string extension = lowerExtension(photo);
    return extension == ".jps" || extension == ".pns";
}

StereoPair split(const cv::Mat& picture, const StatedEyes& eyes, const std::string& name) {
    const HalfPlaces places = halfPlaces(picture.size(), liesBeside(eyes.layout), eyes.gap);
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

// The number of lines of one colour at a rim, if they end in a step along the whole line; else 0.
// @param line gives a row or column by its distance from the rim
template <class Line>
int frameLines(int count, const Line& line) {
    constexpr double kNoise = 16; // grey levels
    constexpr double kFew = 0.01; // share of a line's px
    constexpr double kMany = 0.33;
    constexpr int kBlur = 8; // lines at the step that compression changes
    const cv::Scalar colour = cv::mean(line(0));
    const auto shareBeside = [&](int i) {
        cv::Mat same;
        cv::inRange(line(i), colour - cv::Scalar::all(kNoise), colour + cv::Scalar::all(kNoise),
                    same);
        return 1 - static_cast<double>(cv::countNonZero(same)) / static_cast<double>(same.total());
    };
    int end = 0;
    while (end < count / 3 && shareBeside(end) <= kFew)
        ++end;
    if (end == 0) return 0;
    for (int i = end; i < std::min(end + kBlur, count / 3); ++i) {
        if (shareBeside(i) >= kMany) return i;
    }
    return 0;
}

constexpr string_view kJpsMark = "_JPSJPS_";
constexpr string_view kTextMark("altiro3D\0eyes ", 14); // for PNG; layout and flags follow
constexpr unsigned kHalfHeight = 1;
constexpr unsigned kHalfWidth = 2;
constexpr unsigned kLeftFirst = 4;

EyesMark readDescriptor(unsigned media, unsigned layout, unsigned flags, unsigned separation) {
    EyesMark mark;
    if (media == 0) {
        mark.isOneEye = true;
        return mark;
    }
    if (media != 1) {
        mark.damage = "it states the medium " + std::to_string(media) + ", which does not exist";
    } else if (layout == 1 || layout == 4) {
        mark.unreadable = layout == 1 ? "interleaved" : "anaglyph";
    } else if (layout != 2 && layout != 3) {
        mark.damage = "it states the layout " + std::to_string(layout) + ", which does not exist";
    }
    if (!mark.damage.empty() || !mark.unreadable.empty()) return mark;
    StatedEyes& eyes = mark.eyes.emplace();
    const bool isLeftFirst = (flags & kLeftFirst) != 0;
    eyes.layout = layout == 2   ? isLeftFirst ? StereoLayout::LeftRight : StereoLayout::RightLeft
                  : isLeftFirst ? StereoLayout::TopBottom
                                : StereoLayout::BottomTop;
    const unsigned half = flags & (kHalfWidth | kHalfHeight); // both keep the shape
    if (half == kHalfWidth) eyes.squeeze = Squeeze::Width;
    if (half == kHalfHeight) eyes.squeeze = Squeeze::Height;
    eyes.gap = static_cast<int>(separation);
    return mark;
}

// Length of the descriptor (2 bytes), then in reverse order: media, layout, flags, separation.
EyesMark readJps(string_view body) {
    const ByteReader reader(body, false);
    EyesMark mark;
    if (!reader.holds(0, 6) || reader.u16(0) < 4) {
        mark.damage = "it is cut off";
    } else {
        mark = readDescriptor(reader.u8(5), reader.u8(4), reader.u8(3), reader.u8(2));
    }
    mark.name = "JPS header";
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
        const string_view text = name == "tEXt" ? reader.text(data, size) : string_view();
        if (startsWith(text, kTextMark) && text.size() == kTextMark.size() + 3) {
            mark = readDescriptor(1, static_cast<unsigned>(text[kTextMark.size()] - '0'),
                                  static_cast<unsigned>(text.back() - '0'), 0);
            mark.name = "mark of altiro3D";
            return false;
        }
        if (name != "sTER") return name != "IDAT";
        mark.name = "chunk sTER";
        const unsigned mode = reader.u8(data);
        if (size != 1 || mode > 1) {
            mark.damage = "it states a layout that does not exist";
            return false;
        }
        StatedEyes& eyes = mark.eyes.emplace();
        eyes.layout = mode == 0 ? StereoLayout::RightLeft : StereoLayout::LeftRight;
        eyes.gap = static_cast<int>((16 - reader.u32(16) % 16) % 16); // 16 is IHDR's width
        if (eyes.gap > 7) eyes.gap = 0; // not as the chunk requires: halves
        return false;
    });
    return mark;
}

} // namespace

void leaveOutFrame(StereoPair& pair, Notes* notes) {
    const cv::Size whole = pair.left.size();
    if (pair.right.size() != whole) return;
    cv::Rect left({}, whole);
    cv::Rect right = left;
    for (const bool isAcross : {true, false}) {
        const int count = isAcross ? whole.width : whole.height;
        const auto frame = [&](const cv::Mat& eye, bool isLast) {
            return frameLines(count, [&](int i) {
                const int at = isLast ? count - 1 - i : i;
                return isAcross ? eye.col(at) : eye.row(at);
            });
        };
        const int first[] = {frame(pair.left, false), frame(pair.right, false)};
        const int last[] = {frame(pair.left, true), frame(pair.right, true)};
        // a frame around each eye; a sky lies at one end only
        std::pair<int, int> cut(std::min(first[0], first[1]), std::min(last[0], last[1]));
        if (cut.first == 0 || cut.second == 0) cut = {};
        // a frame around both, and a gap: the right eye's is the mirror image of the left one's
        const std::pair<int, int> mirrored(std::min(first[0], last[1]),
                                           std::min(last[0], first[1]));
        const bool isMirrored = mirrored.first + mirrored.second > cut.first + cut.second;
        if (isMirrored) cut = mirrored;
        const int all = cut.first + cut.second;
        if (all < std::max(4, count / 200)) continue;
        (isAcross ? left.x : left.y) = cut.first;
        (isAcross ? right.x : right.y) = isMirrored ? cut.second : cut.first;
        for (cv::Rect* part : {&left, &right})
            (isAcross ? part->width : part->height) -= all;
    }
    if (left.size() == whole) return;
    pair.left = pair.left(left);
    pair.right = pair.right(right);
    addNote(notes, NoteCode::LeftOut,
            "the border of one colour around the pictures of the eyes is left out: " +
                pairText(left.width, left.height) + " of the " + sizeText(whole) +
                " of each are used");
}

MarkedEyes findMarkedEyes(const std::filesystem::path& photo, string_view bytes, Notes* notes) {
    const EyesMark mark = readEyesMark(bytes);
    const bool isJpeg = imageFormat(bytes) == ImageFormat::Jpeg;
    if (!mark.unreadable.empty()) {
        throw Error(ErrorCode::Unsupported, photo.string(),
                    "is " + mark.unreadable + " by its " + mark.name +
                        ", which is not read, expected the eyes beside or above each other");
    }
    const bool isPns = lowerExtension(photo) == ".pns";
    if (mark.eyes) {
        const bool isSter = mark.name == "chunk sTER";
        return {mark.eyes, false,
                isJpeg   ? "JPS"
                : isPns  ? "PNS"
                : isSter ? "PNG with sTER"
                         : mark.name};
    }
    const auto note = [&](NoteCode code, const std::string& text) {
        addNote(notes, code, "its " + mark.name + text);
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
                           const std::string& name, Notes* notes) {
    StatedEyes eyes = *marked.eyes;
    if (marked.isByName) eyes.squeeze = squeezeOf(picture.size(), true, StereoHalves::Automatic);
    if (eyes.gap > 0 && eyes.gap >= std::min(picture.cols, picture.rows) / 2) eyes.gap = 0;
    StereoPair pair = split(picture, eyes, name);
    leaveOutFrame(pair, notes);
    pair.origin = marked.origin;
    if (eyes.squeeze != Squeeze::None) pair.origin += ", squeezed";
    return pair;
}

StereoPair splitStereoPair(const cv::Mat& picture, StereoLayout layout, StereoHalves halves) try {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
    constexpr const char* kNames[] = {"left and right half", "right and left half",
                                      "upper and lower half", "lower and upper half"};
    const StatedEyes eyes{layout, squeezeOf(picture.size(), liesBeside(layout), halves), 0};
    StereoPair pair = split(picture, eyes, "picture");
    pair.origin = entryOf(kNames, layout);
    if (eyes.squeeze != Squeeze::None) pair.origin += ", squeezed";
    return pair;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

StereoPair splitNamedHalves(const cv::Mat& picture, StereoLayout layout, StereoHalves halves,
                            const std::filesystem::path& name, string_view bytes, Notes* notes) {
    halves = halvesOf(name, halves);
    const std::optional<StatedEyes> stated = readEyesMark(bytes).eyes;
    if (halves == StereoHalves::Automatic && stated &&
        liesBeside(stated->layout) == liesBeside(layout))
        halves = stated->squeeze == Squeeze::None ? StereoHalves::Full : StereoHalves::Squeezed;
    StereoPair pair = splitStereoPair(picture, layout, halves);
    constexpr const char* kOptions[] = {"left-right", "right-left", "top-bottom", "bottom-top"};
    // a squeezed pair has the shape of one scene; if it is wider, or higher, its halves are whole
    const double aspect = static_cast<double>(picture.cols) / picture.rows;
    const bool mayBeSqueezed = liesBeside(layout) ? aspect < 1.95 : aspect > 1.02;
    if (halves == StereoHalves::Automatic && mayBeSqueezed &&
        squeezeOf(picture.size(), liesBeside(layout), halves) == Squeeze::None) {
        addNote(notes, NoteCode::Doubtful,
                "its halves, " + sizeText(pair.left.size()) +
                    ", may be squeezed, as it does not state their shape, and are taken as they "
                    "are: --stereo " +
                    entryOf(kOptions, layout) + ":squeezed stretches them, :full settles it");
    }
    leaveOutFrame(pair, notes);
    return pair;
}

EyesMark readEyesMark(string_view bytes) {
    const ImageFormat format = imageFormat(bytes);
    if (format == ImageFormat::Jpeg) return markOfJpeg(bytes);
    return format == ImageFormat::Png ? markOfPng(bytes) : EyesMark();
}

FileMark eyesMark(EyesPicture kind, bool swapped) {
    constexpr std::pair<int, int> kDescriptors[] = {{2, kLeftFirst},
                                                    {2, kLeftFirst | kHalfWidth},
                                                    {2, 0},
                                                    {3, kLeftFirst},
                                                    {3, kLeftFirst | kHalfHeight},
                                                    {4, kLeftFirst},
                                                    {4, kLeftFirst},
                                                    {4, kLeftFirst},
                                                    {1, kLeftFirst},
                                                    {1, kLeftFirst},
                                                    {1, kLeftFirst}};
    const auto [layout, usual] = entryOf(kDescriptors, kind);
    const unsigned flags = static_cast<unsigned>(usual) ^ (swapped ? kLeftFirst : 0);
    FileMark mark;
    mark.text = std::string(kTextMark) + std::to_string(layout) + ' ' + std::to_string(flags);
    // length, name; length of the descriptor, separation, flags, layout, media; no comment
    mark.segment = std::string("\xff\xe3\0\x12", 4) + std::string(kJpsMark) +
                   std::string("\0\4\0", 3) + static_cast<char>(flags) + static_cast<char>(layout) +
                   std::string("\1\0\0", 3);
    mark.isUnmixed = kind >= EyesPicture::Anaglyph;
    return mark;
}

} // namespace altiro3D
