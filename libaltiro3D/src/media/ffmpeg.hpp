#pragma once

#include "altiro3D/video_io.hpp"
#include "base/owned.hpp" // IWYU pragma: export

#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/stereo3d.h>
#include <libswscale/swscale.h>
}

/// Ownership and conversions for FFmpeg's C interfaces.
namespace altiro3D {

using PacketPtr = std::unique_ptr<AVPacket, Free<av_packet_free>>;
using FramePtr = std::unique_ptr<AVFrame, Free<av_frame_free>>;
using CodecPtr = std::unique_ptr<AVCodecContext, Free<avcodec_free_context>>;
using ParametersPtr = std::unique_ptr<AVCodecParameters, Free<avcodec_parameters_free>>;
using InputPtr = std::unique_ptr<AVFormatContext, Free<avformat_close_input>>;
using OutputPtr = std::unique_ptr<AVFormatContext, Free<avformat_free_context>>;
using ScalerPtr = std::unique_ptr<SwsContext, Free<sws_freeContext>>;

/// Reads an enumeration field as a number. FFmpeg stores values from files unchecked, and in C++
/// reading a value outside the enumeration is undefined.
template <class Enumeration>
int numberOf(const Enumeration& field) {
    int number = 0;
    static_assert(sizeof field == sizeof number, "C's enumerations are int");
    std::memcpy(&number, &field, sizeof number);
    return number;
}

/// Whether FFmpeg decodes both eyes' pictures of spatial video (7.1 and newer).
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(61, 19, 100)
constexpr bool kDecodesBothEyes = true;
#else
constexpr bool kDecodesBothEyes = false;
#endif

/// Limit of times from files; a sum of three times within it does not overflow.
constexpr std::int64_t kFarthestTime = std::numeric_limits<std::int64_t>::max() / 4;
/// Whether a time is within the limit. False for AV_NOPTS_VALUE.
inline bool isNear(std::int64_t time) {
    return time >= -kFarthestTime && time <= kFarthestTime;
}

class Dictionary {
  public:
    Dictionary() = default;
    ~Dictionary() { av_dict_free(&entries_); }
    Dictionary(const Dictionary&) = delete;
    Dictionary& operator=(const Dictionary&) = delete;

    void set(const std::string& name, const std::string& value);
    AVDictionary** address() { return &entries_; }
    /// Name of the first entry that FFmpeg did not consume, or empty.
    std::string firstName() const;

  private:
    AVDictionary* entries_ = nullptr;
};

/// Silences FFmpeg's messages, unless the process has chosen a log level.
void quietFfmpeg();

/// Finds a format by name, including capture devices.
/// @throws Error Unsupported if this FFmpeg does not know it
const AVInputFormat* inputFormat(const std::string& name);

/// FFmpeg's message for an error number.
std::string ffmpegText(int number);

/// Allocates a packet. @return never null @throws Error OutOfMemory
PacketPtr newPacket();
FramePtr newFrame();
/// A frame with memory for its pixels.
FramePtr newFrame(int format, int width, int height);
/// A decoder of a stream that is not open yet.
CodecPtr newDecoder(const AVCodec* codec, const AVCodecParameters& parameters, AVRational unit);
ParametersPtr copyOf(const AVCodecParameters& parameters);
/// A container to write, given by its kind or by the name of the kind.
OutputPtr newOutput(const AVOutputFormat* kind, const char* name);
AVStream& newStream(AVFormatContext& output);

/// @throws Error OutOfMemory
void checkMemory(const void* memory);
/// For the result of a call that fails only for lack of memory. @throws Error OutOfMemory
inline void checkRoom(int result) {
    if (result < 0) checkMemory(nullptr);
}

inline AVRational rational(const Fraction& fraction) {
    return {fraction.numerator, fraction.denominator};
}
/// Converts a ratio; 0/1 if it is unknown.
Fraction fraction(AVRational ratio);

/// Start of a file, s; 0 if it is not stated.
double startSeconds(const AVFormatContext& format);

/// States how frames hold both eyes; nothing for null, and for one eye.
void setEyes(const AVStereo3D* stereo, VideoFacts& facts);

bool isMatroska(const AVOutputFormat& format);

/// Whether a stream is a picture of the file, not a video.
inline bool isCover(const AVStream& stream) {
    constexpr int kCovers = AV_DISPOSITION_ATTACHED_PIC | AV_DISPOSITION_TIMED_THUMBNAILS;
    return (stream.disposition & kCovers) != 0;
}

/// Data that describes a stream; null if there are none.
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

/// Entries of a dictionary.
VideoTags tagsOf(const AVDictionary* dictionary);
/// Value of an entry, or empty.
std::string tagOf(const AVDictionary* dictionary, const char* name);

} // namespace altiro3D
