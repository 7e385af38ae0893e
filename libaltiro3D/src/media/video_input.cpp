#include "media/video_input.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "base/text.hpp"
#include "media/video_marks.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <limits>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

extern "C" {
#include <libavutil/avstring.h>
#include <libavutil/display.h>
#include <libavutil/dovi_meta.h>
#include <libavutil/pixdesc.h>
}

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using Kind = VideoInput::Kind;

// Whether an MP4 or QuickTime file has boxes but not the one with its index.
bool lacksMovieIndex(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    bool known = false;
    for (int box = 0; box < 10000; ++box) {
        unsigned char head[16];
        if (!file.read(reinterpret_cast<char*>(head), 8)) break;
        const auto number = [&](int from, int count) {
            std::uint64_t value = 0;
            for (int i = from; i < from + count; ++i)
                value = value << 8 | head[i];
            return value;
        };
        std::uint64_t size = number(0, 4);
        const std::string type(reinterpret_cast<const char*>(head) + 4, 4);
        if (type == "moov") return false;
        known = known || type == "ftyp" || type == "mdat";
        std::uint64_t read = 8;
        if (size == 1) {
            if (!file.read(reinterpret_cast<char*>(head) + 8, 8)) break;
            size = number(8, 8);
            read = 16;
        }
        if (!known || size < read || size > (std::uint64_t{1} << 62)) break;
        file.seekg(static_cast<std::streamoff>(size - read), std::ios::cur);
    }
    return known;
}

StreamKind streamKind(AVMediaType type) {
    switch (type) {
    case AVMEDIA_TYPE_VIDEO:
        return StreamKind::Video;
    case AVMEDIA_TYPE_AUDIO:
        return StreamKind::Audio;
    case AVMEDIA_TYPE_SUBTITLE:
        return StreamKind::Subtitle;
    case AVMEDIA_TYPE_ATTACHMENT:
        return StreamKind::Attachment;
    default:
        return StreamKind::Data;
    }
}

const char* kindName(AVMediaType type) {
    constexpr const char* kNames[] = {"video", "audio", "subtitles", "data", "attachment"};
    return entryOf(kNames, streamKind(type));
}

std::string codecName(AVCodecID id) {
    return id == AV_CODEC_ID_NONE ? "unknown" : avcodec_get_name(id);
}

// Data that describes a stream; null if there are none.
template <class Data>
const Data* sideData(const AVStream& stream, AVPacketSideDataType type,
                     std::size_t least = sizeof(Data)) {
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
    const AVPacketSideData* const data = av_packet_side_data_get(
        stream.codecpar->coded_side_data, stream.codecpar->nb_coded_side_data, type);
    return data != nullptr && data->size >= least ? reinterpret_cast<const Data*>(data->data)
                                                  : nullptr;
#else
    std::size_t size = 0;
    const std::uint8_t* const data = av_stream_get_side_data(&stream, type, &size);
    return data != nullptr && size >= least ? reinterpret_cast<const Data*>(data) : nullptr;
#endif
}

// How surely a stream holds depth, by its title and by its px: one grey value of 16 bits.
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

// The video stream to deliver: those of colours (or of depth, if it is wanted), large ones and the
// default one first, cover pictures never.
AVStream* chooseStream(const AVFormatContext& format, bool isDepth) {
    AVStream* best = nullptr;
    double bestScore = -1;
    for (unsigned i = 0; i < format.nb_streams; ++i) {
        AVStream* const stream = format.streams[i];
        const AVCodecParameters& parameters = *stream->codecpar;
        if (parameters.codec_type != AVMEDIA_TYPE_VIDEO || isCover(*stream)) continue;
        double score = static_cast<double>(parameters.width) * parameters.height;
        if (avcodec_find_decoder(parameters.codec_id) != nullptr) score += 1e12;
        if ((stream->disposition & AV_DISPOSITION_DEFAULT) != 0) score += 5e6;
        score += (isDepth ? 1e11 : -1e11) * likenessToDepth(*stream);
        if (best != nullptr && score <= bestScore) continue;
        best = stream;
        bestScore = score;
    }
    return best;
}

std::string otherContents(const AVFormatContext& format) {
    std::string text;
    for (unsigned i = 0; i < format.nb_streams; ++i) {
        const AVCodecParameters& parameters = *format.streams[i]->codecpar;
        if (!text.empty()) text += ", ";
        text += (isCover(*format.streams[i]) ? std::string("cover picture")
                                             : kindName(parameters.codec_type)) +
                " " + codecName(parameters.codec_id);
    }
    return text;
}

// Throws with our own message if a path cannot be read.
void checkFile(const fs::path& path, const std::string& subject) {
    struct stat state {};
    const bool exists = ::stat(path.c_str(), &state) == 0;
    const int whyNot = errno;
    if (!exists && (whyNot == ENOENT || whyNot == ENOTDIR))
        throw Error(ErrorCode::NotFound, subject, "does not exist, expected a video file");
    if (!exists) {
        throw Error(ErrorCode::ReadFailed, subject,
                    "cannot be read: " + std::generic_category().message(whyNot));
    }
    if (S_ISDIR(state.st_mode))
        throw Error(ErrorCode::ReadFailed, subject, "is a directory, expected a video file");
    if (S_ISREG(state.st_mode) && state.st_size == 0)
        throw Error(ErrorCode::BadFormat, subject, "is empty, expected a video file");
}

// Whether each packet holds one frame that is shown. Fields may have a packet each, and some codecs
// have packets of frames that are only referred to.
bool hasFramePerPacket(const AVCodecParameters& parameters) {
    const int order = numberOf(parameters.field_order);
    const bool isProgressive = order == AV_FIELD_PROGRESSIVE;
    const AVCodecDescriptor* const codec = avcodec_descriptor_get(parameters.codec_id);
    switch (parameters.codec_id) {
    case AV_CODEC_ID_H264:
        return isProgressive;
    case AV_CODEC_ID_HEVC:
    case AV_CODEC_ID_VP9:
    case AV_CODEC_ID_AV1:
        return isProgressive || order == AV_FIELD_UNKNOWN;
    default:
        return codec != nullptr && (codec->props & AV_CODEC_PROP_INTRA_ONLY) != 0;
    }
}

void chooseStream(VideoInput& input, bool isDepth) {
    input.stream = chooseStream(*input.format, isDepth);
    if (input.stream == nullptr) {
        const std::string contents = otherContents(*input.format);
        throw Error(ErrorCode::BadFormat, input.subject,
                    "holds no video stream" + (contents.empty() ? "" : " but " + contents) +
                        ", expected a video");
    }
}

bool isLive(const VideoInput& input) {
    constexpr std::string_view kPictures = "_pipe"; // ppm_pipe, png_pipe, ...
    const std::string_view format = input.format->iformat->name;
    const bool arePictures = format.size() > kPictures.size() &&
                             format.substr(format.size() - kPictures.size()) == kPictures;
    return input.kind == Kind::Device || (input.kind == Kind::Stream && arePictures);
}

const AVCodec* decoderOf(VideoInput& input) {
    const AVCodecID id = input.stream->codecpar->codec_id;
    const AVCodec* const usual = avcodec_find_decoder(id);
    const bool isVpx = id == AV_CODEC_ID_VP8 || id == AV_CODEC_ID_VP9;
    if (!isVpx || tagOf(input.stream->metadata, "alpha_mode") != "1") return usual;
    // FFmpeg's own decoders leave the transparency out.
    const AVCodec* const whole =
        avcodec_find_decoder_by_name(id == AV_CODEC_ID_VP8 ? "libvpx" : "libvpx-vp9");
    if (whole != nullptr) return whole;
    input.notes.push_back({NoteCode::LeftOut, input.subject + ": its transparency is left out, "
                                                              "because this FFmpeg lacks libvpx"});
    return usual;
}

void openDecoder(VideoInput& input, int threads) {
    const AVCodecParameters& parameters = *input.stream->codecpar;
    const std::string name = codecName(parameters.codec_id);
    const AVCodec* const codec = decoderOf(input);
    if (codec == nullptr) {
        char tag[AV_FOURCC_MAX_STRING_SIZE] = {};
        av_fourcc_make_string(tag, parameters.codec_tag);
        throw Error(ErrorCode::Unsupported, input.subject,
                    "has video of the codec " +
                        (name == "unknown" ? "\"" + std::string(tag) + "\"" : name) +
                        ", which this FFmpeg cannot decode");
    }
    if (static_cast<double>(parameters.width) * parameters.height > kMaxImagePixels) {
        throw Error(ErrorCode::TooLarge, input.subject,
                    "has pictures of " + pairText(parameters.width, parameters.height) +
                        " px, expected at most " + numberText(kMaxImagePixels, 9) + " px");
    }
    const auto* const dolby =
        sideData<AVDOVIDecoderConfigurationRecord>(*input.stream, AV_PKT_DATA_DOVI_CONF);
    if (dolby != nullptr && dolby->dv_bl_signal_compatibility_id == 0 &&
        (dolby->dv_profile == 5 || dolby->dv_profile == 10)) {
        throw Error(ErrorCode::Unsupported, input.subject,
                    "is Dolby Vision of profile " + std::to_string(dolby->dv_profile) +
                        ", whose pictures have colours of their own, expected a profile with an "
                        "HDR10, HLG or SDR base layer, such as 8");
    }
    input.decoder = newDecoder(codec, parameters, input.stream->time_base);
    input.decoder->thread_count = threads;
    // Threads that decode one frame each hold a frame per thread back.
    if (isLive(input)) input.decoder->thread_type = FF_THREAD_SLICE;
    input.decoder->max_pixels = static_cast<std::int64_t>(kMaxImagePixels);
    Dictionary decoding;
    if (input.joinsEyes && !input.alternates) decoding.set("view_ids", "-1"); // all
    const int result = avcodec_open2(input.decoder.get(), codec, decoding.address());
    if (result < 0) {
        throw Error(ErrorCode::Unsupported, input.subject,
                    "has video of the codec " + name +
                        ", which cannot be decoded: " + ffmpegText(result));
    }
    if (parameters.width <= 0 || parameters.height <= 0) {
        if (name == "webp") {
            throw Error(ErrorCode::Unsupported, input.subject,
                        "is an animated WebP picture, expected a video; convert it first");
        }
        throw Error(ErrorCode::BadFormat, input.subject,
                    "has " + name + " video without a size: nothing of it can be decoded");
    }
}

// End of the last picture or sound, s from the start of the file. Chapters and subtitles may end
// later.
double endOfPictureAndSound(const AVFormatContext& format) {
    double end = 0;
    for (unsigned i = 0; i < format.nb_streams; ++i) {
        const AVStream& stream = *format.streams[i];
        const AVMediaType type = stream.codecpar->codec_type;
        const bool lasts = type == AVMEDIA_TYPE_VIDEO || type == AVMEDIA_TYPE_AUDIO;
        if (!lasts || stream.duration == AV_NOPTS_VALUE || isCover(stream)) continue;
        const std::int64_t begin = stream.start_time != AV_NOPTS_VALUE ? stream.start_time : 0;
        const double ticks = static_cast<double>(begin) + static_cast<double>(stream.duration);
        end = std::max(end, ticks * av_q2d(stream.time_base));
    }
    return end - startSeconds(format);
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
    const bool isBeside = layout == StereoLayout::LeftRight || layout == StereoLayout::RightLeft;
    const double eye = av_q2d(own) * parameters.width / parameters.height;
    const bool isOfFrame = isBeside ? eye > 2.45 : eye < 1.23;
    const AVRational doubled = av_mul_q(own, isBeside ? AVRational{2, 1} : AVRational{1, 2});
    if (isOfFrame && shape.num > 0 && av_cmp_q(shape, doubled) == 0) shape = own;
}

// Fills the facts about the pictures from the container and the delivered stream.
void fillFacts(VideoInput& input) {
    VideoFacts& facts = input.facts;
    const AVStream& video = *input.stream;
    const AVCodecParameters& parameters = *video.codecpar;
    facts.format = input.format->iformat->name;
    facts.codec = codecName(parameters.codec_id);
    const char* const pixels = av_get_pix_fmt_name(static_cast<AVPixelFormat>(parameters.format));
    facts.pixelFormat = pixels != nullptr ? pixels : "unknown";
    facts.isDevice = input.kind == Kind::Device;
    facts.isLive = isLive(input);
    setRotation(facts,
                sideData<std::int32_t>(video, AV_PKT_DATA_DISPLAYMATRIX, 9 * sizeof(std::int32_t)));
    const bool isAcross = facts.rotationDegrees % 180 != 0;
    setEyes(sideData<AVStereo3D>(video, AV_PKT_DATA_STEREO3D), facts);
    correctEyeShape(input);
    const cv::Size stored(parameters.width, parameters.height);
    facts.size = isAcross ? cv::Size(stored.height, stored.width) : stored;
    if (input.joinsEyes) {
        facts.size.width *= 2;
        facts.eyes = input.alternates ? kAlternateFrames : kSpatialVideo;
        facts.eyesLayout = StereoLayout::LeftRight;
    } else if (input.alternates || input.isMvc) {
        facts.eyes.clear();
    }
    const Fraction aspect =
        fraction(av_guess_sample_aspect_ratio(input.format.get(), input.stream, nullptr));
    if (aspect.isKnown()) {
        facts.sampleAspect = isAcross ? Fraction{aspect.denominator, aspect.numerator} : aspect;
    }
    const AVRational share{1, input.alternates ? 2 : 1};
    facts.averageRate = fraction(av_mul_q(video.avg_frame_rate, share));
    facts.nominalRate = fraction(av_mul_q(video.r_frame_rate, share));
    facts.constantRate = facts.averageRate.isKnown() && facts.nominalRate.isKnown() &&
                         std::abs(facts.averageRate.value() / facts.nominalRate.value() - 1) < 1e-3;
    facts.timeBase = fraction(video.time_base);

    const double unit = av_q2d(video.time_base);
    if (input.format->duration != AV_NOPTS_VALUE && input.format->duration > 0) {
        facts.duration = static_cast<double>(input.format->duration) / AV_TIME_BASE;
        if (input.format->duration_estimation_method != AVFMT_DURATION_FROM_BITRATE)
            input.end = *facts.duration;
    }
    const bool hasOwn = video.duration != AV_NOPTS_VALUE && video.duration > 0;
    if (hasOwn) input.end = std::min(input.end, endOfPictureAndSound(*input.format));
    if (video.nb_frames > 0) {
        facts.frameCount = video.nb_frames / share.den;
    } else if (facts.averageRate.isKnown() && (hasOwn || facts.duration)) {
        const double length = hasOwn ? static_cast<double>(video.duration) * unit : *facts.duration;
        facts.frameCount = std::llround(length * facts.averageRate.value());
    }
    facts.colour =
        videoColour(static_cast<AVPixelFormat>(parameters.format), numberOf(parameters.color_space),
                    numberOf(parameters.color_range), numberOf(parameters.color_primaries),
                    numberOf(parameters.color_trc), stored.height);

    if (input.format->start_time != AV_NOPTS_VALUE) {
        input.startPts =
            av_rescale_q(input.format->start_time, AVRational{1, AV_TIME_BASE}, video.time_base);
        if (!isNear(input.startPts)) input.startPts = 0;
    }
}

// Lists the streams, chapters and tags of the file.
void listContents(const AVFormatContext& format, VideoFacts& facts) {
    for (unsigned i = 0; i < format.nb_streams; ++i) {
        const AVStream& stream = *format.streams[i];
        VideoStreamFacts& fact = facts.streams.emplace_back();
        fact.index = static_cast<int>(i);
        fact.kind = streamKind(stream.codecpar->codec_type);
        fact.codec = codecName(stream.codecpar->codec_id);
        fact.language = tagOf(stream.metadata, "language");
        fact.title = tagOf(stream.metadata, "title");
        fact.channels = stream.codecpar->ch_layout.nb_channels;
        fact.sampleRate = stream.codecpar->sample_rate;
    }
    const double start = startSeconds(format);
    for (unsigned i = 0; i < format.nb_chapters; ++i) {
        const AVChapter& chapter = *format.chapters[i];
        const double length = av_q2d(chapter.time_base);
        facts.chapters.push_back({static_cast<double>(chapter.start) * length - start,
                                  static_cast<double>(chapter.end) * length - start,
                                  tagOf(chapter.metadata, "title")});
    }
    facts.tags = tagsOf(format.metadata);
}

// The first bytes that wait in a pipe; they stay there. Empty if it is another file.
std::string waitingBytes(const FileHandle& pipe) {
    std::string bytes(std::size_t{1} << 16, '\0');
    int ends[2] = {-1, -1};
    if (::pipe2(ends, O_CLOEXEC) != 0) return {};
    const FileHandle from(ends[0]);
    const FileHandle to(ends[1]);
    ssize_t count = ::tee(pipe.get(), to.get(), bytes.size(), 0);
    if (count > 0) count = ::read(from.get(), bytes.data(), bytes.size());
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    return bytes;
}

// A pipe is opened once. MP4 files may have their index at the end, so they are copied first,
// unless they are made to be read as they come (with fragments).
// @return what to open
std::string openStream(VideoInput& input, const fs::path& path) {
    constexpr std::uintmax_t kMostCopied = std::uintmax_t{1} << 36;
    input.kind = Kind::Stream;
    input.file = path == "-" ? FileHandle(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0))
                             : openFile(path, O_RDONLY | O_NOCTTY);
    if (!input.file.isOpen()) {
        throw Error(ErrorCode::ReadFailed, input.subject,
                    "cannot be read: " + std::generic_category().message(errno));
    }
    const std::string start = waitingBytes(input.file);
    const std::string box = start.substr(std::min<std::size_t>(4, start.size()), 4);
    constexpr std::string_view kFirstBoxes[] = {"ftyp", "moov", "mdat", "wide", "free", "skip"};
    if (std::find(std::begin(kFirstBoxes), std::end(kFirstBoxes), box) != std::end(kFirstBoxes)) {
        const std::size_t index = start.find("moov");
        const bool isWhole = start.find("mvex", index) < start.find("moof", index);
        if (index < start.find("mdat") && isWhole) {
            input.head = start.substr(index);
        } else {
            input.file = unnamedCopy(input.file, input.subject, kMostCopied);
            input.kind = Kind::File;
            return "file:" + nameOf(input.file).string();
        }
    }
    return "pipe:" + std::to_string(input.file.get());
}

// The streams whose packets are encrypted.
std::set<int> encryptedStreams(const AVFormatContext& format, const std::string& boxes) {
    std::set<int> encrypted;
    std::size_t at = 0; // MP4 has a list of sample entries for each stream
    for (int i = 0; i < static_cast<int>(format.nb_streams); ++i) {
        constexpr std::size_t kEntry = 16; // from the name of the list to that of its first entry
        at = at == std::string::npos ? at : boxes.find("stsd", at + 1);
        const bool isNamed = at != std::string::npos && at + kEntry + 3 < boxes.size() &&
                             boxes.compare(at + kEntry, 3, "enc") == 0;
        const AVStream& stream = *format.streams[i];
        const std::uint32_t tag = stream.codecpar->codec_tag;
        if (isNamed || !tagOf(stream.metadata, "enc_key_id").empty() ||
            tag == MKTAG('d', 'r', 'm', 'i') || tag == MKTAG('d', 'r', 'm', 's'))
            encrypted.insert(i);
    }
    return encrypted;
}

} // namespace

void openContainer(VideoInput& input, const fs::path& path, const VideoReaderOptions& options) {
    quietFfmpeg();
    input.subject = path == "-" ? "standard input" : path.string();
    std::string url = "file:" + path.string();
    const AVInputFormat* wantedFormat = nullptr;
    std::string wanted = options.format;
    std::error_code noFile;
    const bool isCamera = wanted.empty() && path != "-" && fs::is_character_file(path, noFile);
    if (isCamera) wanted = "v4l2";
    if (!wanted.empty()) {
        wantedFormat = inputFormat(wanted);
        if ((wantedFormat->flags & AVFMT_NOFILE) != 0) {
            input.kind = Kind::Device;
            url = path.string();
        }
    }
    fs::path source = path;
    if (input.kind == Kind::File && path == "-") {
        // one that is a file is read as one: the index of an .mp4 may be at its end
        const bool isFile =
            fs::is_regular_file("/dev/stdin", noFile) && ::lseek(STDIN_FILENO, 0, SEEK_CUR) == 0;
        input.kind = Kind::Stream;
        source = "/dev/stdin";
        url = isFile ? "file:/dev/stdin" : openStream(input, path);
    } else if (input.kind == Kind::File) {
        checkFile(path, input.subject);
        if (givesBytesOnce(path)) url = openStream(input, path);
    }
    if (input.file.isOpen()) source = nameOf(input.file);

    Dictionary settings;
    for (const auto& [name, value] : options.formatOptions)
        settings.set(name, value);
    // A file must not open other files over the network.
    if (input.kind != Kind::Device) settings.set("protocol_whitelist", "file,pipe,crypto,data");
    AVFormatContext* raw = nullptr;
    int result = avformat_open_input(&raw, url.c_str(), wantedFormat, settings.address());
    if (result < 0) {
        // FFmpeg's Y4M reader returns "busy" for a picture beyond its limits.
        if (result == AVERROR_INVALIDDATA || result == AVERROR_EOF ||
            (input.kind == Kind::File && result == AVERROR(EBUSY))) {
            if (input.kind == Kind::File && lacksMovieIndex(source)) {
                throw Error(
                    ErrorCode::BadFormat, input.subject,
                    "has no index (moov): it is cut off or was never finished, expected a whole "
                    "file");
            }
            throw Error(ErrorCode::BadFormat, input.subject, "is not a video that FFmpeg can read");
        }
        if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
        // Error of drivers of devices that are not cameras when asked for their formats.
        if (isCamera &&
            (result == AVERROR(ENOTTY) || result == AVERROR(EINVAL) || result == AVERROR(ENODEV))) {
            throw Error(ErrorCode::BadFormat, input.subject,
                        "is a device but not a camera, expected a video file, a camera, or the "
                        "name of the device's format");
        }
        throw Error(ErrorCode::ReadFailed, input.subject, "cannot be read: " + ffmpegText(result));
    }
    input.format.reset(raw);
    if (const std::string unused = settings.firstName();
        !unused.empty() && unused != "protocol_whitelist") {
        throw Error(ErrorCode::InvalidArgument, "formatOptions",
                    "have \"" + unused + "\", which the format " + input.format->iformat->name +
                        " does not know");
    }
    if (std::strcmp(input.format->iformat->name, "tty") == 0) { // this format accepts any text
        throw Error(ErrorCode::BadFormat, input.subject, "is a text, expected a video file");
    }
    result = avformat_find_stream_info(raw, nullptr);
    if (result < 0 && raw->nb_streams == 0)
        throw Error(ErrorCode::BadFormat, input.subject, "cannot be read: " + ffmpegText(result));
    if (url.compare(0, 5, "file:") == 0) input.head = streamHead(source, raw->iformat->name);
    input.encrypted = encryptedStreams(*raw, input.head);
}

namespace {

// Whether a second layer of HEVC holds the other eye's picture (MV-HEVC, the boxes "lhvC" and
// "vexu" of a sample entry). FFmpeg before 7.1 says nothing of it.
bool isSpatial(std::string_view boxes) {
    const std::size_t entry = boxes.find("hvc1");
    return entry != std::string::npos && boxes.find("lhvC", entry) < entry + 4096 &&
           boxes.find("vexu", entry) < entry + 4096;
}

// FFmpeg 7.1 writes the layout of both eyes into the box "st3d", and "vexu" without a layout; of
// both it reads the latter alone.
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

} // namespace

namespace {

// Reads what the first picture of H.264 or HEVC, its container and other streams state of a second
// layer and of frames by turns.
void findOtherEye(VideoInput& input, std::string_view head) {
    const AVCodecParameters& parameters = *input.stream->codecpar;
    const AVCodecID codec = parameters.codec_id;
    EyesInPacket found;
    constexpr std::size_t kMost = 100; // packets of other streams
    const bool mayHold = codec == AV_CODEC_ID_H264 || codec == AV_CODEC_ID_HEVC;
    while (mayHold && input.kind != Kind::Device && input.ahead.size() < kMost) {
        PacketPtr packet = newPacket();
        if (av_read_frame(input.format.get(), packet.get()) < 0) break; // and then again
        const std::string_view bytes(reinterpret_cast<const char*>(packet->data),
                                     static_cast<std::size_t>(std::max(packet->size, 0)));
        const bool isPicture = packet->stream_index == input.stream->index && !bytes.empty();
        if (isPicture) found = eyesInPacket(parameters, bytes);
        input.ahead.push_back(std::move(packet));
        if (isPicture) break;
    }
    constexpr unsigned kSecondLayer = 0x20; // of MPEG transport streams
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

// Another video that can be the other eye's; null if there is none.
const AVStream* twinOf(const VideoInput& input) {
    AVFormatContext& format = *input.format;
    const AVStream& read = *input.stream;
    const auto programOf = [&](const AVStream& stream) {
        return av_find_program_from_stream(&format, nullptr, stream.index);
    };
    for (unsigned i = 0; i < format.nb_streams; ++i) {
        const AVStream& stream = *format.streams[i];
        const AVCodecParameters& parameters = *stream.codecpar;
        constexpr int kOthers = AV_DISPOSITION_DUB | AV_DISPOSITION_COMMENT |
                                AV_DISPOSITION_VISUAL_IMPAIRED | AV_DISPOSITION_HEARING_IMPAIRED;
        if (&stream != &read && parameters.codec_type == AVMEDIA_TYPE_VIDEO && !isCover(stream) &&
            parameters.codec_id == read.codecpar->codec_id && parameters.width > 0 &&
            parameters.width == read.codecpar->width &&
            parameters.height == read.codecpar->height && stream.nb_frames == read.nb_frames &&
            av_cmp_q(stream.avg_frame_rate, read.avg_frame_rate) == 0 &&
            (stream.disposition & kOthers) == 0 && programOf(stream) == programOf(read) &&
            tagOf(stream.metadata, "language") == tagOf(read.metadata, "language"))
            return &stream;
    }
    return nullptr;
}

} // namespace

VideoInput openVideoInput(const fs::path& path, const VideoReaderOptions& options) {
    VideoInput input;
    openContainer(input, path, options);
    chooseStream(input, options.isDepth);
    const AVCodecParameters& parameters = *input.stream->codecpar;
    if (input.encrypted.count(input.stream->index) > 0) {
        throw Error(ErrorCode::Unsupported, input.subject,
                    "is encrypted, so its pictures cannot be read, expected a video that is not");
    }
    const std::string head = std::exchange(input.head, {});
    const bool hasEyes = parameters.codec_id == AV_CODEC_ID_HEVC && isSpatial(head);
    // a turned picture would have to be joined the other way
    const bool isTurned = sideData<std::int32_t>(*input.stream, AV_PKT_DATA_DISPLAYMATRIX,
                                                 9 * sizeof(std::int32_t)) != nullptr;
    findOtherEye(input, head);
    const bool joins = options.bothEyes && !isTurned && parameters.width % 2 == 0;
    input.joinsEyes = joins && (input.alternates || (hasEyes && kDecodesBothEyes));
    openDecoder(input, options.threads);
    fillFacts(input);
    if (input.facts.eyes.empty()) readStereoBox(head, input.facts);
    refuseSpherical(input.subject,
                    sideData<AVSphericalMapping>(*input.stream, AV_PKT_DATA_SPHERICAL), head,
                    input.facts);
    listContents(*input.format, input.facts);
    const auto note = [&input](const std::string& text) {
        input.notes.push_back({NoteCode::LeftOut, input.subject + ": " + text});
    };
    const AVStream& depth = *chooseStream(*input.format, true);
    if (!options.isDepth && &depth != input.stream && likenessToDepth(depth) > 0) {
        const std::string title = tagOf(depth.metadata, "title");
        input.notes.push_back(
            {NoteCode::AsItIs,
             input.subject + ": its track " + std::to_string(depth.index) +
                 " seems to hold depth (" + (title.empty() ? "16 bits of grey" : title) +
                 "), so track " + std::to_string(input.stream->index) +
                 " is read; --depth with the same file takes the depth from the other"});
    }
    if (hasEyes && !input.joinsEyes) {
        note(std::string("is a spatial video (MV-HEVC), of which the left eye alone is read") +
             (kDecodesBothEyes ? "" : "; FFmpeg 7.1 or newer reads both"));
    }
    if (input.isMvc) {
        note("is a 3D video in MVC (H.264 with a second layer), of which the base view alone, "
             "usually the left eye's, is read, because FFmpeg does not decode the other; a program "
             "that does, such as BD3D2MK3D (Windows), makes a side by side video of it");
    }
    if (const AVStream* const twin = twinOf(input); twin != nullptr && !input.isMvc) {
        const auto [first, second] = std::minmax(input.stream->index, twin->index);
        note("holds two videos of one size, of which one is read; if they are the pictures of both "
             "eyes, this joins them, and --stereo left-right:full reads the result: ffmpeg -i " +
             shellWord(input.subject) + " -filter_complex '[0:" + std::to_string(first) +
             "][0:" + std::to_string(second) + "]hstack' eyes_LRF.mp4");
    }
    if (input.alternates && !input.joinsEyes)
        note("shows the eyes by turns, of which the left eye alone is read");
    return input;
}

bool VideoInput::hasFixedTimes() const {
    // after a seek, it would not be known whose turn it is
    return kind == Kind::File && format->start_time != AV_NOPTS_VALUE && !alternates &&
           (format->iformat->flags & AVFMT_TS_DISCONT) == 0;
}

int VideoInput::readPacket(AVPacket& packet) {
    if (ahead.empty()) return av_read_frame(format.get(), &packet);
    av_packet_move_ref(&packet, ahead.front().get());
    ahead.pop_front();
    return 0;
}

std::optional<std::int64_t> countPackets(const fs::path& path, VideoReaderOptions options,
                                         double from) {
    options.threads = 1;
    VideoInput input = openVideoInput(path, options);
    if (!input.hasFixedTimes() || !hasFramePerPacket(*input.stream->codecpar)) return std::nullopt;
    for (unsigned i = 0; i < input.format->nb_streams; ++i) {
        AVStream* const stream = input.format->streams[i];
        if (stream != input.stream) stream->discard = AVDISCARD_ALL;
    }
    const std::int64_t until =
        input.startPts + std::llround(from / av_q2d(input.stream->time_base));
    const PacketPtr packet = newPacket();
    std::vector<std::int64_t> times;
    std::int64_t lastDts = std::numeric_limits<std::int64_t>::min();
    for (; input.readPacket(*packet) >= 0; av_packet_unref(packet.get())) {
        if (packet->stream_index != input.stream->index) continue;
        const bool isSound = isNear(packet->pts) && isNear(packet->dts) && packet->dts > lastDts &&
                             packet->pts >= packet->dts &&
                             (packet->flags & AV_PKT_FLAG_CORRUPT) == 0;
        // Decoders drop pictures before the first key frame.
        const bool isFirst = lastDts == std::numeric_limits<std::int64_t>::min();
        const bool begins = !isFirst || (packet->flags & AV_PKT_FLAG_KEY) != 0;
        if (!isSound || !begins) return std::nullopt;
        lastDts = packet->dts;
        if (packet->dts >= until) break;
        if ((packet->flags & AV_PKT_FLAG_DISCARD) != 0) continue; // decoded, not shown
        if (!times.empty() && packet->pts < times.front()) return std::nullopt;
        times.push_back(packet->pts);
    }
    std::sort(times.begin(), times.end());
    if (std::adjacent_find(times.begin(), times.end()) != times.end()) return std::nullopt;
    return std::lower_bound(times.begin(), times.end(), until) - times.begin();
}

} // namespace altiro3D
