#include "media/video_marks.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/byte_reader.hpp"
#include "base/text.hpp"
#include "image/picture_halves.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

extern "C" {
#include <libavutil/avstring.h>
#include <libavutil/spherical.h>
}

namespace altiro3D {

namespace {

constexpr std::size_t kNone = std::string_view::npos;

// What the first packet of H.264 or HEVC states about both eyes.
struct EyesInPacket {
    bool isMvc = false;      // a second layer of H.264 holds the other eye's pictures
    bool alternates = false; // frames show the eyes alternately
    bool rightFirst = false; // they begin with the right eye
};

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

// Reads the message "frame packing arrangement" of H.264 and HEVC.
void readPacking(std::string_view message, EyesInPacket& found) {
    BitReader reader(message);
    reader.code();                   // the number of the arrangement
    if (reader.bits(1) != 0) return; // cancelled
    constexpr unsigned kByTurns = 5;
    constexpr unsigned kRightFirst = 2;
    found.alternates = reader.bits(7) == kByTurns;
    reader.skip(1);
    found.rightFirst = found.alternates && reader.bits(6) == kRightFirst;
}

// Reads a unit of messages. @param headSize bytes before them
void readMessages(std::string_view unit, std::size_t headSize, EyesInPacket& found) {
    const std::string bytes = withoutPrevention(unit);
    const ByteReader reader(bytes, false);
    std::uint64_t at = headSize;
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
        if (type == kFramePacking) readPacking(reader.text(at, bytes.size() - at), found);
        at += size;
    }
}

// Any bytes give a result.
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
    found.isMvc = !isHevc && setup.find("mvcC") != kNone; // written by MakeMKV
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
        constexpr unsigned kSecondLayer = 20; // MVC unless the first bit says SVC
        if (type == kMessages) readMessages(unit, 1, found);
        if ((type == kSecondSetup && (profile == 118 || profile == 128)) ||
            (type == kSecondLayer && unit.size() > 1 && (profile & 128U) == 0))
            found.isMvc = true;
    });
    return found;
}

// Whether a second layer of HEVC holds the other eye's picture (MV-HEVC, the boxes "lhvC" and
// "vexu" of a sample entry). FFmpeg before 7.1 says nothing of it.
bool isSpatial(std::string_view boxes) {
    const std::size_t entry = boxes.find("hvc1");
    return entry != std::string::npos && boxes.find("lhvC", entry) < entry + 4096 &&
           boxes.find("vexu", entry) < entry + 4096;
}

// FFmpeg 7.1 writes the layout of both eyes into the box "st3d", and "vexu" without a layout; if
// both exist, it reads only "vexu".
void readStereoBox(const std::string& boxes, VideoFacts& facts) {
    const std::string start("\0\0\0\x0dst3d\0\0\0\0", 12);
    const std::size_t at = boxes.find(start);
    if (at == std::string::npos || at + start.size() >= boxes.size()) return;
    AVStereo3D mark = {};
    const auto mode = static_cast<unsigned char>(boxes[at + start.size()]);
    if (mode != 1 && mode != 2) return; // one eye
    mark.type = mode == 1 ? AV_STEREO3D_TOPBOTTOM : AV_STEREO3D_SIDEBYSIDE;
    setEyes(&mark, facts);
}

// Reads what the first picture of H.264 or HEVC, its container and other streams state about a
// second layer and alternating frames.
void readFirstPicture(VideoInput& input, std::string_view head) {
    const AVCodecParameters& parameters = *input.stream->codecpar;
    const AVCodecID codec = parameters.codec_id;
    EyesInPacket found;
    constexpr std::size_t kMost = 100; // packets of other streams
    const bool mayHold = codec == AV_CODEC_ID_H264 || codec == AV_CODEC_ID_HEVC;
    while (mayHold && input.kind != VideoInput::Kind::Device && input.ahead.size() < kMost) {
        PacketPtr packet = newPacket();
        if (av_read_frame(input.format.get(), packet.get()) < 0) break; // and then again
        const std::string_view bytes(reinterpret_cast<const char*>(packet->data),
                                     static_cast<std::size_t>(std::max(packet->size, 0)));
        const bool isPicture = packet->stream_index == input.stream->index && !bytes.empty();
        if (isPicture) found = eyesInPacket(parameters, bytes);
        input.ahead.push_back(std::move(packet));
        if (isPicture) break;
    }
    constexpr unsigned kSecondLayer = 0x20; // in MPEG transport streams
    for (unsigned i = 0; i < input.format->nb_streams; ++i) {
        const AVCodecParameters& other = *input.format->streams[i]->codecpar;
        found.isMvc = found.isMvc || (codec == AV_CODEC_ID_H264 && other.codec_id == codec &&
                                      other.codec_tag == kSecondLayer);
    }
    input.isMvc = found.isMvc || (codec == AV_CODEC_ID_H264 && head.find("mvcC") != head.npos);
    const auto* const mark = sideData<AVStereo3D>(*input.stream, AV_PKT_DATA_STEREO3D);
    const bool isMarked = mark != nullptr && numberOf(mark->type) == AV_STEREO3D_FRAMESEQUENCE;
    // Matroska marks MVC in the same way
    input.alternates = !input.isMvc && (found.alternates || isMarked);
    input.rightFirst = found.alternates ? found.rightFirst
                                        : isMarked && (mark->flags & AV_STEREO3D_FLAG_INVERT) != 0;
}

// The eye that a video's names state: 'l', 'r', or 0 if they state none.
char namedEye(const AVStream& stream) {
    for (const char* const tag : {"stereo_mode", "title", "name", "handler_name"}) {
        const std::string text = tagOf(stream.metadata, tag);
        const bool isLeft = av_stristr(text.c_str(), "left") != nullptr;
        const bool isRight = av_stristr(text.c_str(), "right") != nullptr;
        if (isLeft != isRight) return isLeft ? 'l' : 'r';
    }
    return 0;
}

// Another video that can be the other eye's, perhaps without some frames; null if there is none.
AVStream* twinOf(const VideoInput& input) {
    AVFormatContext& format = *input.format;
    const AVStream& read = *input.stream;
    const auto programOf = [&](const AVStream& stream) {
        return av_find_program_from_stream(&format, nullptr, stream.index);
    };
    for (unsigned i = 0; i < format.nb_streams; ++i) {
        AVStream& stream = *format.streams[i];
        const AVCodecParameters& parameters = *stream.codecpar;
        constexpr int kOthers = AV_DISPOSITION_DUB | AV_DISPOSITION_COMMENT |
                                AV_DISPOSITION_VISUAL_IMPAIRED | AV_DISPOSITION_HEARING_IMPAIRED;
        if (&stream != &read && parameters.codec_type == AVMEDIA_TYPE_VIDEO && !isCover(stream) &&
            parameters.codec_id == read.codecpar->codec_id && parameters.width > 0 &&
            parameters.width == read.codecpar->width &&
            parameters.height == read.codecpar->height &&
            parameters.format == read.codecpar->format &&
            std::abs(stream.nb_frames - read.nb_frames) <= 2 + read.nb_frames / 50 &&
            (av_cmp_q(stream.avg_frame_rate, read.avg_frame_rate) == 0 ||
             av_cmp_q(stream.r_frame_rate, read.r_frame_rate) == 0) &&
            (stream.disposition & kOthers) == 0 && programOf(stream) == programOf(read) &&
            tagOf(stream.metadata, "language") == tagOf(read.metadata, "language") &&
            likenessToDepth(stream) == likenessToDepth(read) &&
            input.encrypted.count(stream.index) == 0)
            return &stream;
    }
    return nullptr;
}

// Finds the other eye in a second video, and reads it if that is wanted.
// @param joins if there is one
void findTwin(VideoInput& input, const VideoReaderOptions& options, bool joins) {
    AVStream* twin = twinOf(input);
    VideoFacts frames;
    setEyes(sideData<AVStereo3D>(*input.stream, AV_PKT_DATA_STEREO3D), frames);
    if (twin == nullptr || !frames.eyes.empty() || input.isMvc || input.alternates ||
        input.joinsEyes) {
        if (!options.joinsVideos) return;
        throw Error(ErrorCode::Unsupported, input.subject,
                    "does not hold two videos of one size and rate, expected those of both eyes");
    }
    const char eye = namedEye(*input.stream);
    const bool isNamed = eye != 0 && namedEye(*twin) + eye == 'l' + 'r';
    AVStream** const streams = input.format->streams;
    const auto videos = std::count_if(streams, streams + input.format->nb_streams, [](auto* one) {
        return one->codecpar->codec_type == AVMEDIA_TYPE_VIDEO;
    });
    const bool isCamera = videos == 2 && input.stream->codecpar->codec_id == AV_CODEC_ID_MJPEG &&
                          std::strcmp(input.format->iformat->name, "avi") == 0;
    const auto note = [&](NoteCode code, const std::string& text) {
        input.notes.push_back({code, input.subject + ": holds two videos of one size, " + text});
    };
    if (!isNamed && !isCamera && !options.joinsVideos) {
        note(NoteCode::LeftOut, "of which one is read; if they are the pictures of both eyes, "
                                "--stereo videos reads both");
        return;
    }
    if (isNamed ? eye == 'r' : twin->index < input.stream->index) std::swap(input.stream, twin);
    if (!joins) {
        note(NoteCode::LeftOut, "of both eyes, of which the left eye's alone is read");
        return;
    }
    input.joinsEyes = true;
    input.twin = twin;
    const bool isSure =
        isNamed || options.joinsVideos || startsWith(tagOf(input.stream->metadata, "Make"), "FUJI");
    if (!isSure)
        note(NoteCode::Doubtful, "which are read as the pictures of both eyes, as stereo "
                                 "cameras write them; --stereo off reads one alone");
}

// Matroska states the size of one eye's picture, and FFmpeg gives the px the shape that leads to
// it. Other programs state the whole frame's size instead. Where that would make an eye wider than
// any scene, or an eye above the other one narrow, the bitstream's shape holds.
void correctEyeShape(const VideoInput& input) {
    const auto& layout = input.facts.eyesLayout;
    if (!layout || std::strncmp(input.format->iformat->name, "matroska", 8) != 0) return;
    AVRational& shape = input.stream->sample_aspect_ratio;
    const AVCodecParameters& parameters = *input.stream->codecpar;
    const AVRational own =
        parameters.sample_aspect_ratio.num > 0 ? parameters.sample_aspect_ratio : AVRational{1, 1};
    const bool isBeside = liesBeside(*layout);
    const double eye = av_q2d(own) * parameters.width / parameters.height;
    const bool isOfFrame = isBeside ? eye > 2.45 : eye < 1.23;
    const AVRational doubled = av_mul_q(own, isBeside ? AVRational{2, 1} : AVRational{1, 2});
    if (isOfFrame && shape.num > 0 && av_cmp_q(shape, doubled) == 0) shape = own;
}

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
    constexpr int kHalfEquirectangular = 3; // since FFmpeg 7.1, as the next ones
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

// FFmpeg 5.1 reads only Google's marks with all elements and no mesh, and none of Apple's.
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

} // namespace

int likenessToDepth(const AVStream& stream) {
    int likeness = stream.codecpar->format == AV_PIX_FMT_GRAY16LE ||
                           stream.codecpar->format == AV_PIX_FMT_GRAY16BE
                       ? 1
                       : 0;
    for (const char* const tag : {"title", "name", "handler_name"}) {
        if (av_stristr(tagOf(stream.metadata, tag).c_str(), "depth") != nullptr)
            return 2 + likeness;
    }
    return likeness;
}

void findOtherEye(VideoInput& input, const VideoReaderOptions& options, const std::string& head) {
    const AVCodecParameters& parameters = *input.stream->codecpar;
    const bool hasLayer = parameters.codec_id == AV_CODEC_ID_HEVC && isSpatial(head);
    const auto note = [&input](const std::string& text) {
        input.notes.push_back({NoteCode::LeftOut, input.subject + ": " + text});
    };
    // a turned picture would have to be joined the other way
    const bool isTurned = sideData<std::int32_t>(*input.stream, AV_PKT_DATA_DISPLAYMATRIX,
                                                 9 * sizeof(std::int32_t)) != nullptr;
    const bool joins = options.bothEyes && !isTurned && parameters.width % 2 == 0;
    readFirstPicture(input, head);
    input.joinsEyes = joins && (input.alternates || (hasLayer && kDecodesBothEyes));
    if (hasLayer && !input.joinsEyes) {
        note(std::string("is a spatial video (MV-HEVC), of which the left eye alone is read") +
             (kDecodesBothEyes ? "" : "; FFmpeg 7.1 or newer reads both"));
    }
    if (input.isMvc) {
        note("is a 3D video in MVC (H.264 with a second layer), of which the base view alone, "
             "usually the left eye's, is read, because FFmpeg does not decode the other; a program "
             "that does, such as BD3D2MK3D (Windows), makes a side by side video of it");
    }
    if (input.alternates && !input.joinsEyes)
        note("shows the eyes by turns, of which the left eye alone is read");
    findTwin(input, options, joins);
}

void describeEyes(VideoInput& input, const std::string& head) {
    VideoFacts& facts = input.facts;
    setEyes(sideData<AVStereo3D>(*input.stream, AV_PKT_DATA_STEREO3D), facts);
    correctEyeShape(input);
    if (facts.eyes.empty()) readStereoBox(head, facts);
    if (input.joinsEyes) {
        facts.size.width *= 2;
        facts.eyes = input.alternates        ? kAlternateFrames
                     : input.twin != nullptr ? kTwoVideos
                                             : kSpatialVideo;
        facts.eyesLayout = StereoLayout::LeftRight;
    } else if (input.alternates || input.isMvc) {
        facts.eyes.clear();
        facts.eyesLayout.reset();
    }
}

void refuseSpherical(const VideoInput& input, std::string_view head) {
    const auto* const stated = sideData<AVSphericalMapping>(*input.stream, AV_PKT_DATA_SPHERICAL);
    const auto found = stated != nullptr ? projectionOf(*stated) : projectionOf(head);
    if (!found) return;
    using Layout = StereoLayout;
    const VideoFacts& facts = input.facts;
    Layout layout = facts.eyesLayout.value_or(Layout::LeftRight);
    bool isPair = facts.eyesLayout.has_value();
    if (!isPair && head.find("StereoMode>top-bottom") != kNone) layout = Layout::TopBottom;
    isPair = isPair || layout == Layout::TopBottom || head.find("StereoMode>left-right") != kNone;
    const bool isBeside = liesBeside(layout);
    const bool isInverted = layout == Layout::RightLeft || layout == Layout::BottomTop;
    // a part of 90 x 58.7 degrees, 16:9, as sharp as the middle of the video
    const double eye = facts.size.width / (isPair && isBeside ? 2.0 : 1.0);
    const int unit = 2 * std::max(1, static_cast<int>(eye * 360 / (CV_PI * found->degrees) / 32));
    const std::string pair = isBeside ? ":in_stereo=sbs" : ":in_stereo=tb";
    throw Error(ErrorCode::Unsupported, input.subject,
                "is a video of " + numberText(found->degrees) + " degrees (" + found->words +
                    (isPair ? ", both eyes" : "") +
                    "), whose pictures are bent, expected a flat part of it, as made by: ffmpeg "
                    "-i " +
                    shellWord(input.subject) + " -vf v360=output=flat:input=" + found->filter +
                    (isPair ? pair + ":out_stereo=sbs" : "") + ":h_fov=90:v_fov=58.7:w=" +
                    std::to_string(16 * unit) + ":h=" + std::to_string(9 * unit) +
                    (isPair ? isInverted ? " flat_RLF.mp4" : " flat_LRF.mp4" : " flat.mp4"));
}

} // namespace altiro3D
