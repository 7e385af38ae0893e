#include "media/video_marks.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/byte_reader.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <system_error>

namespace altiro3D {

namespace {

constexpr std::size_t kNone = std::string_view::npos;

// The number in an element of the XML of Google's first marks; 0 if it is missing.
double numberIn(std::string_view xml, const char* element) {
    const std::size_t at = xml.find(element);
    const std::size_t value = at == kNone ? kNone : xml.find('>', at);
    return value == kNone ? 0 : numberAt(xml.substr(value + 1));
}

// A projection, as FFmpeg's filter v360 calls it, and for people.
struct Projection {
    const char* filter;
    const char* words;
    double degrees; // its width
};
constexpr Projection kSphere{"e", "equirectangular", 360};
constexpr Projection kHalfSphere{"he", "half equirectangular", 180};
constexpr Projection kCube{"c3x2", "cubemap", 360};
constexpr Projection kFisheye{"fisheye:ih_fov=180:iv_fov=180", "fisheye", 180};
constexpr Projection kMesh{"he", "mesh, usually nearly half equirectangular", 180};

std::optional<Projection> projectionOf(const AVSphericalMapping& stated) {
    constexpr int kHalfEquirectangular = 3; // of FFmpeg 7.1, as the next ones
    constexpr int kRectilinear = 4;
    const int projection = numberOf(stated.projection);
    if (projection == kRectilinear) return std::nullopt;
    if (projection > kRectilinear) return kFisheye;
    if (projection == AV_SPHERICAL_CUBEMAP) return kCube;
    const double left = stated.bound_left;
    const bool isHalf = projection == AV_SPHERICAL_EQUIRECTANGULAR_TILE &&
                        (left + stated.bound_right) / UINT32_MAX > 0.4;
    return isHalf || projection == kHalfEquirectangular ? kHalfSphere : kSphere;
}

// FFmpeg 5.1 reads of Google's marks only those with all elements and not those with a mesh, and
// none of Apple's.
std::optional<Projection> projectionOf(std::string_view head) {
    constexpr std::string_view kUuid("\xff\xcc\x82\x63\xf8\x55\x4a\x93"
                                     "\x88\x14\x58\x7a\x02\x52\x1f\xdd",
                                     16);
    if (const std::size_t at = head.find(kUuid); at != kNone) {
        const std::string_view xml = head.substr(at, 10000);
        const double whole = numberIn(xml, "FullPanoWidthPixels");
        const double part = numberIn(xml, "CroppedAreaImageWidthPixels");
        if (xml.find("Spherical>true") != kNone)
            return part > 0 && part < 0.6 * whole ? kHalfSphere : kSphere;
    }
    for (std::size_t at = 0; (at = head.find("sv3d", at)) != kNone; ++at) {
        const std::string_view box = head.substr(at, 200);
        if (box.size() < 12 || box.substr(8, 4) != "svhd") continue;
        if (box.find("cbmp") != kNone) return kCube;
        return box.find("equi") != kNone ? kSphere : kMesh;
    }
    if (const std::size_t at = head.find(std::string_view("prji\0\0\0\0", 8)); at != kNone) {
        const std::string_view kind = head.substr(at + 8, 4);
        if (kind == "equi") return kSphere;
        if (kind == "hequ") return kHalfSphere;
        if (kind == "fish" || kind == "prim") return kFisheye;
    }
    // Matroska: the type "mesh" in a projection
    const std::size_t at = head.find("\x76\x71\x81\x03");
    const std::size_t begin = at == kNone ? kNone : head.rfind("\x76\x70", at);
    return begin != kNone && at - begin < 16 ? std::optional(kMesh) : std::nullopt;
}

// Calls a function with each NAL unit. @param lengthSize bytes of its length; 0: start codes
template <class Function>
void forUnits(std::string_view bytes, unsigned lengthSize, const Function& function) {
    if (lengthSize == 0) {
        constexpr std::string_view kStart("\0\0\1", 3);
        std::size_t at = bytes.find(kStart);
        while (at != kNone) {
            const std::size_t next = bytes.find(kStart, at + 3);
            function(bytes.substr(at + 3, next == kNone ? kNone : next - at - 3));
            at = next;
        }
        return;
    }
    const ByteReader reader(bytes, false);
    for (std::uint64_t at = 0; reader.holds(at, lengthSize);) {
        const std::uint64_t size = reader.number(at, lengthSize);
        function(reader.text(at + lengthSize, size));
        at += lengthSize + size;
    }
}

// Reads the message "frame packing arrangement" of H.264 and HEVC. @param at begin of the message
void readPacking(const ByteReader& reader, std::uint64_t at, EyesInPacket& found) {
    std::uint64_t bit = 8 * at;
    const auto take = [&](int count) {
        unsigned value = 0;
        for (; count > 0; --count, ++bit)
            value = value << 1 | (reader.u8(bit / 8) >> (7 - bit % 8) & 1U);
        return value;
    };
    int zeros = 0; // the number of the arrangement has as many bits after its first 1
    while (zeros < 32 && take(1) == 0)
        ++zeros;
    take(zeros);
    if (take(1) != 0) return; // cancelled
    constexpr unsigned kByTurns = 5;
    constexpr unsigned kRightFirst = 2;
    found.alternates = take(7) == kByTurns;
    take(1);
    found.rightFirst = found.alternates && take(6) == kRightFirst;
}

// Reads a unit of messages. @param headSize bytes before them
void readMessages(std::string_view unit, std::size_t headSize, EyesInPacket& found) {
    std::string bytes; // without the bytes that keep start codes from occurring
    for (std::size_t i = headSize; i < unit.size(); ++i) {
        if (unit[i] != 3 || i < 2 || unit[i - 1] != 0 || unit[i - 2] != 0) bytes += unit[i];
    }
    const ByteReader reader(bytes, false);
    std::uint64_t at = 0;
    const auto number = [&] {
        std::uint64_t value = 0;
        while (reader.u8(at) == 0xFF) {
            value += 0xFF;
            ++at;
        }
        return value + reader.u8(at++);
    };
    constexpr std::uint64_t kFramePacking = 45;
    while (reader.holds(at, 3)) {
        const std::uint64_t type = number();
        const std::uint64_t size = number();
        if (type == kFramePacking) readPacking(reader, at, found);
        at += size;
    }
}

} // namespace

std::string streamHead(const std::filesystem::path& path, std::string_view format) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return {}; // others are read once
    std::ifstream file(path, std::ios::binary);
    const auto read = [&file](std::uint64_t size) {
        constexpr std::uint64_t kMostBytes = 1 << 24;
        std::string bytes(static_cast<std::size_t>(std::min(size, kMostBytes)), '\0');
        file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        bytes.resize(static_cast<std::size_t>(file.gcount()));
        return bytes;
    };
    constexpr std::uint64_t kTracks = 1 << 16; // of Matroska are in front
    if (startsWith(format, "matroska")) return read(kTracks);
    if (!startsWith(format, "mov,")) return {};
    std::uint64_t at = 0;
    for (int boxes = 0; boxes < 1000 && file.seekg(static_cast<std::streamoff>(at)); ++boxes) {
        const std::string head = read(16);
        if (head.size() < 16) break;
        const ByteReader reader(head, false);
        const std::uint64_t size = reader.u32(0) == 1 ? reader.u64(8) : reader.u32(0);
        if (head.compare(4, 4, "moov") == 0) return read(size);
        if (size < 8 || size > UINT64_MAX / 2 - at) break;
        at += size;
    }
    return {};
}

void refuseSpherical(const std::string& subject, const AVSphericalMapping* stated,
                     std::string_view head, const VideoFacts& facts) {
    const auto found = stated != nullptr ? projectionOf(*stated) : projectionOf(head);
    if (!found) return;
    using Layout = StereoLayout;
    Layout layout = facts.eyesLayout.value_or(Layout::LeftRight);
    bool isPair = facts.eyesLayout.has_value();
    if (!isPair && head.find("StereoMode>top-bottom") != kNone) layout = Layout::TopBottom;
    isPair = isPair || layout == Layout::TopBottom || head.find("StereoMode>left-right") != kNone;
    const bool isBeside = layout == Layout::LeftRight || layout == Layout::RightLeft;
    const bool isInverted = layout == Layout::RightLeft || layout == Layout::BottomTop;
    // a part of 90 x 58.7 degrees, 16:9, as sharp as the middle of the video
    constexpr double kPi = 3.14159265358979;
    const double eye = facts.size.width / (isPair && isBeside ? 2.0 : 1.0);
    const int unit = 2 * std::max(1, static_cast<int>(eye * 360 / (kPi * found->degrees) / 32));
    const std::string pair = isBeside ? ":in_stereo=sbs" : ":in_stereo=tb";
    throw Error(ErrorCode::Unsupported, subject,
                "is a video of " + numberText(found->degrees) + " degrees (" + found->words +
                    (isPair ? ", both eyes" : "") +
                    "), whose pictures are bent, expected a flat part of it, as made by: ffmpeg "
                    "-i " +
                    shellWord(subject) + " -vf v360=output=flat:input=" + found->filter +
                    (isPair ? pair + ":out_stereo=sbs" : "") + ":h_fov=90:v_fov=58.7:w=" +
                    std::to_string(16 * unit) + ":h=" + std::to_string(9 * unit) +
                    (isPair ? isInverted ? " flat_RLF.mp4" : " flat_LRF.mp4" : " flat.mp4"));
}

EyesInPacket eyesInPacket(const AVCodecParameters& stream, std::string_view bytes) {
    EyesInPacket found;
    const bool isHevc = stream.codec_id == AV_CODEC_ID_HEVC;
    if (!isHevc && stream.codec_id != AV_CODEC_ID_H264) return found;
    const std::string_view setup(
        reinterpret_cast<const char*>(stream.extradata),
        stream.extradata == nullptr ? 0 : static_cast<std::size_t>(stream.extradata_size));
    const bool hasLengths = !setup.empty() && setup[0] == 1;
    const unsigned lengthSize =
        hasLengths ? (ByteReader(setup, false).u8(isHevc ? 21 : 4) & 3U) + 1 : 0;
    found.isMvc = !isHevc && setup.find("mvcC") != kNone; // of MakeMKV
    forUnits(bytes, lengthSize, [&](std::string_view unit) {
        const ByteReader reader(unit, false);
        if (isHevc) {
            constexpr unsigned kMessages = 39;
            if ((reader.u8(0) >> 1 & 63U) == kMessages) readMessages(unit, 2, found);
            return;
        }
        const unsigned type = reader.u8(0) & 31U;
        const unsigned profile = reader.u8(1);
        constexpr unsigned kMessages = 6;
        constexpr unsigned kSecondSetup = 15; // its profile: Multiview or Stereo High
        constexpr unsigned kSecondLayer = 20; // of MVC unless the first bit says SVC
        if (type == kMessages) readMessages(unit, 1, found);
        if ((type == kSecondSetup && (profile == 118 || profile == 128)) ||
            (type == kSecondLayer && unit.size() > 1 && (profile & 128U) == 0))
            found.isMvc = true;
    });
    return found;
}

} // namespace altiro3D
