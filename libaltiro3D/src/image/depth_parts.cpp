#include "image/depth_parts.hpp"

#include "base/byte_reader.hpp"
#include "base/image_format.hpp"
#include "base/text.hpp"
#include "image/exif.hpp"
#include "image/file_walk.hpp"
#include "image/xmp.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace altiro3D {

namespace {

using std::string_view;

constexpr string_view kExifMark("Exif\0\0", 6);
constexpr string_view kExtendedXmpMark("http://ns.adobe.com/xmp/extension/\0", 35);
constexpr string_view kMpfMark("MPF\0", 4);
constexpr unsigned kMaxPictures = 100;        // limit for a multi-picture file
constexpr std::uint32_t kTypeMask = 0xffffff; // bits of an attribute that hold the picture's type
constexpr std::uint32_t kTypeDisparity = 0x020002; // one of several eyes
constexpr std::size_t kMaxXmpBytes = std::size_t{256} << 20;

// Namespaces, by the part that all their generations have.
constexpr string_view kGDepth = "google.com/photos/1.0/depthmap";
constexpr string_view kGImage = "google.com/photos/1.0/image";
constexpr string_view kDynamicDepthMap = "google.com/photos/dd/1.0/depthmap";
constexpr string_view kXmpNote = "adobe.com/xmp/note";
constexpr string_view kPixelData = "apple.com/pixeldatainfo";

bool isPicture(string_view bytes) {
    const ImageFormat format = imageFormat(bytes);
    return format == ImageFormat::Jpeg || format == ImageFormat::Png;
}

// What precedes the first scan of a JPEG.
struct JpegParts {
    int orientation = 0;               // from the first EXIF; 0 without one
    string_view xmp;                   // from the first such segment
    std::vector<string_view> extended; // segments of the extended XMP
    std::vector<string_view> pictures; // further ones of a multi-picture file
    string_view secondEye;             // the first further one, if it belongs to a stereo pair
};

// Extended XMP: each segment has a GUID, the whole length, the offset of its part, and the part.
// Segments of other GUIDs are left over from other versions of the file.
std::string extendedXmp(const JpegParts& parts, const Xmp& main, std::size_t fileBytes) {
    constexpr std::size_t kHeader = 40;
    const std::size_t maxBytes = std::min(fileBytes, kMaxXmpBytes);
    string_view guid = main.value(kXmpNote, "HasExtendedXMP");
    std::string text;
    for (const string_view segment : parts.extended) {
        const ByteReader reader(segment, false);
        if (!reader.holds(0, kHeader)) continue;
        if (guid.empty()) guid = segment.substr(0, 32);
        if (segment.substr(0, 32) != guid) continue;
        const std::size_t length = reader.u32(32);
        const std::size_t offset = reader.u32(36);
        const string_view part = segment.substr(kHeader);
        if (text.empty() && length <= maxBytes) text.resize(length);
        if (offset > text.size() || part.size() > text.size() - offset) continue;
        std::copy(part.begin(), part.end(), text.begin() + static_cast<std::ptrdiff_t>(offset));
    }
    return text;
}

// Finds the pictures after the first one (CIPA DC-007). Offsets count from the start of `index`.
void findFurtherPictures(string_view file, std::size_t at, string_view index, JpegParts& parts) {
    if (index.size() < 8) return;
    const ByteReader reader(index, index[0] == 'I');
    const ByteReader whole(file, false);
    const std::uint64_t directory = reader.u32(4);
    const unsigned entries = reader.u16(directory);
    for (unsigned i = 0; i < std::min(entries, kMaxPictures); ++i) {
        const std::uint64_t entry = directory + 2 + std::uint64_t{12} * i;
        if (reader.u16(entry) != 0xb002) continue; // the list of pictures
        const std::uint64_t count = reader.u32(entry + 4) / 16;
        const std::uint64_t list = reader.u32(entry + 8);
        std::uint64_t bytes = 0; // pictures do not overlap
        for (std::uint64_t k = 1; k < std::min<std::uint64_t>(count, kMaxPictures); ++k) {
            const std::uint64_t size = reader.u32(list + 16 * k + 4);
            const std::uint64_t offset = reader.u32(list + 16 * k + 8);
            const string_view picture = whole.text(at + offset, size);
            if (offset == 0 || !isPicture(picture)) continue;
            bytes += size;
            if (bytes > file.size()) return;
            if (k == 1 && (reader.u32(list + 16 * k) & kTypeMask) == kTypeDisparity)
                parts.secondEye = picture;
            parts.pictures.push_back(picture);
        }
        return;
    }
}

bool isPanorama(const Xmp& xmp) {
    return xmp.has("google.com/photos/1.0/panorama", "ProjectionType");
}

JpegParts partsOf(string_view jpeg) {
    JpegParts parts;
    walkJpeg(jpeg, [&](unsigned marker, std::size_t at, string_view body) {
        if (marker == 0xe1 && parts.orientation == 0 && startsWith(body, kExifMark)) {
            parts.orientation = exifOrientation(body);
        } else if (marker == 0xe1 && parts.xmp.empty() && startsWith(body, kXmpMark)) {
            parts.xmp = body.substr(kXmpMark.size());
        } else if (marker == 0xe1 && startsWith(body, kExtendedXmpMark)) {
            parts.extended.push_back(body.substr(kExtendedXmpMark.size()));
        } else if (marker == 0xe2 && parts.pictures.empty() && startsWith(body, kMpfMark)) {
            findFurtherPictures(jpeg, at + kMpfMark.size(), body.substr(kMpfMark.size()), parts);
        }
        return marker != 0xda;
    });
    return parts;
}

// The bytes of an item of Dynamic Depth. Items follow one another after the photo, whose length the
// file may state wrongly; if no picture is there, they are at the end of the file.
string_view itemBytes(string_view jpeg, const std::vector<XmpItem>& items, std::size_t wanted) {
    const ByteReader reader(jpeg, false);
    const std::size_t end =
        walkJpeg(jpeg, [](unsigned, std::size_t, string_view) { return true; }).after;
    std::uint64_t before = items.front().padding;
    std::uint64_t after = 0;
    for (std::size_t i = 1; i < items.size(); ++i) {
        const std::uint64_t length = items[i].length + items[i].padding;
        if (items[i].length > jpeg.size() || items[i].padding > jpeg.size()) return {};
        (i < wanted ? before : after) += length;
    }
    const std::uint64_t size = items[wanted].length;
    const string_view found = reader.text(end + before, size);
    if (isPicture(found)) return found;
    const string_view last =
        after <= jpeg.size() ? reader.text(jpeg.size() - after, size) : string_view();
    return isPicture(last) ? last : string_view();
}

// The item with a meaning, or whose URI names it; 0, the photo itself, if there is none.
std::size_t itemOf(const std::vector<XmpItem>& items, string_view semantic, string_view uri) {
    for (std::size_t i = 1; i < items.size(); ++i) {
        if (items[i].semantic == semantic ||
            (items[i].semantic.empty() && items[i].uri.find(uri) != std::string::npos)) {
            return i;
        }
    }
    return 0;
}

// Format, Near and Far of GDepth and Dynamic Depth; the first description that has them counts.
void readRange(const std::vector<const Xmp*>& descriptions, string_view space, DepthPart& part) {
    for (const Xmp* const xmp : descriptions) {
        if (!xmp->has(space, "Format")) continue;
        part.isDistance = xmp->value(space, "Format") == "RangeLinear";
        part.nearest = xmp->number(space, "Near");
        part.farthest = xmp->number(space, "Far");
        return;
    }
}

std::optional<DepthPart> dynamicDepth(string_view jpeg, const std::vector<const Xmp*>& all) {
    for (const Xmp* const xmp : all) {
        const std::size_t index = itemOf(xmp->items(), "Depth", "depthmap");
        if (index == 0) continue;
        DepthPart part;
        part.form = EmbeddedDepthForm::DynamicDepth;
        part.coded = itemBytes(jpeg, xmp->items(), index);
        readRange(all, kDynamicDepthMap, part);
        if (!part.coded.empty()) return part;
    }
    return std::nullopt;
}

std::optional<DepthPart> gDepth(const std::vector<const Xmp*>& all) {
    for (const Xmp* const xmp : all) {
        const string_view data = xmp->value(kGDepth, "Data");
        if (data.empty()) continue;
        DepthPart part;
        part.form = EmbeddedDepthForm::GDepth;
        part.decoded = decodeBase64(data);
        readRange(all, kGDepth, part);
        if (isPicture(part.decoded)) return part;
    }
    return std::nullopt;
}

// Portrait mattes are "depth" with a subtype; gain maps have neither.
std::optional<DepthPart> appleJpeg(const std::vector<string_view>& pictures) {
    for (const string_view picture : pictures) {
        const JpegParts parts = partsOf(picture);
        const Xmp xmp(parts.xmp);
        const string_view type = xmp.value(kPixelData, "AuxiliaryImageType");
        const bool isDistance = type == "depth";
        if ((type != "disparity" && !isDistance) || xmp.has(kPixelData, "AuxiliaryImageSubType")) {
            continue;
        }
        DepthPart part;
        part.form = EmbeddedDepthForm::AppleJpeg;
        part.coded = picture;
        part.isNearBright = !isDistance;
        part.isDistance = isDistance;
        part.nearest = xmp.number(kPixelData, "FloatMinValue");
        part.farthest = xmp.number(kPixelData, "FloatMaxValue");
        return part;
    }
    return std::nullopt;
}

} // namespace

std::optional<DepthPart> findDepthPart(string_view jpeg) {
    const JpegParts parts = partsOf(jpeg);
    const Xmp xmp(parts.xmp);
    const std::string extended = extendedXmp(parts, xmp, jpeg.size());
    const Xmp more(extended);
    const std::vector<const Xmp*> all{&xmp, &more};
    std::optional<DepthPart> part = dynamicDepth(jpeg, all);
    if (!part) part = gDepth(all);
    if (!part) part = appleJpeg(parts.pictures);
    if (part) part->orientation = std::max(1, parts.orientation);
    return part;
}

SecondEye findSecondEye(string_view jpeg) {
    const JpegParts parts = partsOf(jpeg);
    if (parts.secondEye.empty()) {
        const Xmp xmp(parts.xmp);
        if (!isPanorama(xmp)) return {};
        const std::string extended = extendedXmp(parts, xmp, jpeg.size());
        std::string right = decodeBase64(Xmp(extended).value(kGImage, "Data"));
        if (!isPicture(right)) right.clear();
        return {{}, std::max(1, parts.orientation), std::move(right)};
    }
    const int own = partsOf(parts.secondEye).orientation;
    return {parts.secondEye, std::max(1, own > 1 ? own : parts.orientation), {}};
}

string_view findUnblurred(string_view jpeg, std::string& decoded) {
    const JpegParts parts = partsOf(jpeg);
    const Xmp xmp(parts.xmp);
    if (isPanorama(xmp)) return {}; // its GImage is the right eye's picture
    const std::string extended = extendedXmp(parts, xmp, jpeg.size());
    const Xmp more(extended);
    for (const Xmp* const each : {&xmp, &more}) {
        const std::size_t index = itemOf(each->items(), "Original", "original");
        if (index > 0) {
            const string_view original = itemBytes(jpeg, each->items(), index);
            if (!original.empty()) return original;
        }
        const string_view data = each->value(kGImage, "Data");
        if (data.empty()) continue;
        decoded = decodeBase64(data);
        if (isPicture(decoded)) return decoded;
    }
    return {};
}

} // namespace altiro3D
