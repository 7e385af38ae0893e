#include "media/ffmpeg.hpp"

#include "altiro3D/error.hpp"
#include "base/system_library.hpp"

#include <mutex>

extern "C" {
#include <libavdevice/avdevice.h>
#include <libavutil/log.h>
}

namespace altiro3D {

void Dictionary::set(const std::string& name, const std::string& value) {
    av_dict_set(&entries_, name.c_str(), value.c_str(), 0);
}

std::string Dictionary::firstName() const {
    const AVDictionaryEntry* const entry =
        av_dict_get(entries_, "", nullptr, AV_DICT_IGNORE_SUFFIX);
    return entry != nullptr ? entry->key : "";
}

void quietFfmpeg() {
    static std::once_flag once;
    std::call_once(once, [] {
        if (av_log_get_level() == AV_LOG_INFO) av_log_set_level(AV_LOG_QUIET); // INFO: the default
    });
}

namespace {

#ifdef ALTIRO3D_LINKS_ALL_FFMPEG
constexpr const char* kDevices = "libavdevice";

bool registerDevices() {
    avdevice_register_all();
    return true;
}
#else
constexpr const char* kDevices = "libavdevice.so." AV_STRINGIFY(LIBAVDEVICE_VERSION_MAJOR);

// Loaded at run time, not linked: its hundred libraries (X11, sound, 3D, ...) would take a third of
// every program's start-up time, and only capture devices need them.
bool registerDevices() {
    static const bool areThere = [] {
        void* const all = addressIn(openLibrary(kDevices), "avdevice_register_all");
        if (all != nullptr) reinterpret_cast<decltype(&avdevice_register_all)>(all)();
        return all != nullptr;
    }();
    return areThere;
}
#endif

} // namespace

const AVInputFormat* inputFormat(const std::string& name) {
    const AVInputFormat* format = av_find_input_format(name.c_str());
    const bool withDevices = format != nullptr || registerDevices();
    if (format == nullptr) format = av_find_input_format(name.c_str());
    if (format == nullptr) {
        std::string problem = "is \"" + name + "\", which this FFmpeg does not know";
        if (!withDevices) problem += std::string("; capture devices need ") + kDevices;
        throw Error(ErrorCode::Unsupported, "format", problem);
    }
    return format;
}

std::string ffmpegText(int number) {
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(number, text, sizeof text);
    return text;
}

void checkMemory(const void* memory) {
    if (memory == nullptr) throw Error(ErrorCode::OutOfMemory, "video", "does not fit into memory");
}

PacketPtr newPacket() {
    PacketPtr packet(av_packet_alloc());
    checkMemory(packet.get());
    return packet;
}

FramePtr newFrame() {
    FramePtr frame(av_frame_alloc());
    checkMemory(frame.get());
    return frame;
}

FramePtr newFrame(int format, int width, int height) {
    FramePtr frame = newFrame();
    frame->format = format;
    frame->width = width;
    frame->height = height;
    checkRoom(av_frame_get_buffer(frame.get(), 0));
    return frame;
}

CodecPtr newDecoder(const AVCodec* codec, const AVCodecParameters& parameters, AVRational unit) {
    CodecPtr decoder(avcodec_alloc_context3(codec));
    checkMemory(decoder.get());
    checkRoom(avcodec_parameters_to_context(decoder.get(), &parameters));
    decoder->pkt_timebase = unit;
    return decoder;
}

ParametersPtr copyOf(const AVCodecParameters& parameters) {
    ParametersPtr copy(avcodec_parameters_alloc());
    checkMemory(copy.get());
    checkRoom(avcodec_parameters_copy(copy.get(), &parameters));
    return copy;
}

OutputPtr newOutput(const AVOutputFormat* kind, const char* name) {
    AVFormatContext* raw = nullptr;
    checkRoom(avformat_alloc_output_context2(&raw, kind, name, nullptr));
    return OutputPtr(raw);
}

AVStream& newStream(AVFormatContext& output) {
    AVStream* const stream = avformat_new_stream(&output, nullptr);
    checkMemory(stream);
    return *stream;
}

Fraction fraction(AVRational ratio) {
    if (ratio.num <= 0 || ratio.den <= 0) return {};
    return {ratio.num, ratio.den};
}

double startSeconds(const AVFormatContext& format) {
    const bool isStated = format.start_time != AV_NOPTS_VALUE;
    return isStated ? static_cast<double>(format.start_time) / AV_TIME_BASE : 0;
}

void setEyes(const AVStereo3D* stereo, VideoFacts& facts) {
    if (stereo == nullptr) return;
    const int type = numberOf(stereo->type);
    if (type <= AV_STEREO3D_2D || type > AV_STEREO3D_COLUMNS) return;
    facts.eyes = av_stereo3d_type_name(static_cast<unsigned>(type));
    const bool isInverted = (stereo->flags & AV_STEREO3D_FLAG_INVERT) != 0;
    if (type == AV_STEREO3D_SIDEBYSIDE)
        facts.eyesLayout = isInverted ? StereoLayout::RightLeft : StereoLayout::LeftRight;
    if (type == AV_STEREO3D_TOPBOTTOM)
        facts.eyesLayout = isInverted ? StereoLayout::BottomTop : StereoLayout::TopBottom;
    if (isInverted) facts.eyes += ", inverted";
}

bool isMatroska(const AVOutputFormat& format) {
    return std::strcmp(format.name, "matroska") == 0;
}

VideoTags tagsOf(const AVDictionary* dictionary) {
    VideoTags tags;
    const AVDictionaryEntry* entry = nullptr;
    while ((entry = av_dict_get(dictionary, "", entry, AV_DICT_IGNORE_SUFFIX)) != nullptr)
        tags.emplace_back(entry->key, entry->value);
    return tags;
}

std::string tagOf(const AVDictionary* dictionary, const char* name) {
    const AVDictionaryEntry* const entry = av_dict_get(dictionary, name, nullptr, 0);
    return entry != nullptr ? entry->value : "";
}

} // namespace altiro3D
