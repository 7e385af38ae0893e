#pragma once

#include "altiro3D/video_types.hpp"

#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

/// Ownership and small conversions for FFmpeg's C interfaces.
namespace altiro3D {

struct FreePacket {
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct FreeFrame {
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreeCodec {
    void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
};
struct FreeParameters {
    void operator()(AVCodecParameters* parameters) const { avcodec_parameters_free(&parameters); }
};
struct CloseInput {
    void operator()(AVFormatContext* format) const { avformat_close_input(&format); }
};
struct FreeOutput {
    void operator()(AVFormatContext* format) const { avformat_free_context(format); }
};
struct FreeScaler {
    void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

using PacketPtr = std::unique_ptr<AVPacket, FreePacket>;
using FramePtr = std::unique_ptr<AVFrame, FreeFrame>;
using CodecPtr = std::unique_ptr<AVCodecContext, FreeCodec>;
using ParametersPtr = std::unique_ptr<AVCodecParameters, FreeParameters>;
using InputPtr = std::unique_ptr<AVFormatContext, CloseInput>;
using OutputPtr = std::unique_ptr<AVFormatContext, FreeOutput>;
using ScalerPtr = std::unique_ptr<SwsContext, FreeScaler>;

/// The number in a field of an enumeration. FFmpeg stores what files say without a check, and in
/// C++ reading a value that the enumeration cannot hold is undefined.
template <class Enumeration>
int numberOf(const Enumeration& field) {
    int number = 0;
    static_assert(sizeof field == sizeof number, "C's enumerations are int");
    std::memcpy(&number, &field, sizeof number);
    return number;
}

/// Files may hold times at the ends of the numbers; of those up to here a sum of three fits.
constexpr std::int64_t kFarthestTime = std::numeric_limits<std::int64_t>::max() / 4;
/// False for AV_NOPTS_VALUE, too.
inline bool isNear(std::int64_t time) {
    return time >= -kFarthestTime && time <= kFarthestTime;
}

/// A dictionary that is freed at the end.
class Dictionary {
  public:
    Dictionary() = default;
    ~Dictionary() { av_dict_free(&entries_); }
    Dictionary(const Dictionary&) = delete;
    Dictionary& operator=(const Dictionary&) = delete;

    void set(const std::string& name, const std::string& value);
    AVDictionary** address() { return &entries_; }
    /// Name of an entry that nobody has taken, or empty.
    std::string firstName() const;

  private:
    AVDictionary* entries_ = nullptr;
};

/// FFmpeg prints nothing from now on, unless the process has chosen its level of messages.
void quietFfmpeg();

/// The format of that name, capture devices included.
/// @throws Error Unsupported if this FFmpeg does not know it
const AVInputFormat* inputFormat(const std::string& name);

/// FFmpeg's words for an error number.
std::string ffmpegText(int number);

/// @throws Error OutOfMemory @return new objects, never null
PacketPtr newPacket();
FramePtr newFrame();
/// @throws Error OutOfMemory
void checkMemory(const void* memory);

inline AVRational rational(const Fraction& fraction) {
    return {fraction.numerator, fraction.denominator};
}
/// 0/1 where it is not known.
Fraction fraction(AVRational ratio);

bool isMatroska(const AVOutputFormat& format);

/// Entries of a dictionary.
VideoTags tagsOf(const AVDictionary* dictionary);
/// Value of a name, or empty.
std::string tagOf(const AVDictionary* dictionary, const char* name);

} // namespace altiro3D
