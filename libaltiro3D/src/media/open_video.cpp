#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "base/text.hpp"
#include "media/video_input.hpp"
#include "media/video_marks.hpp"
#include "media/video_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

extern "C" {
#include <libavutil/display.h>
#include <libavutil/dovi_meta.h>
#include <libavutil/pixdesc.h>
}

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using Kind = VideoInput::Kind;

StreamKind streamKind(AVMediaType type) {
    return type == AVMEDIA_TYPE_VIDEO        ? StreamKind::Video
           : type == AVMEDIA_TYPE_AUDIO      ? StreamKind::Audio
           : type == AVMEDIA_TYPE_SUBTITLE   ? StreamKind::Subtitle
           : type == AVMEDIA_TYPE_ATTACHMENT ? StreamKind::Attachment
                                             : StreamKind::Data;
}

const char* kindName(AVMediaType type) {
    constexpr const char* kNames[] = {"video", "audio", "subtitles", "data", "attachment"};
    return entryOf(kNames, streamKind(type));
}

std::string codecName(AVCodecID id) {
    return id == AV_CODEC_ID_NONE ? "unknown" : avcodec_get_name(id);
}

// The video stream to deliver: prefers colours (or depth, if it is wanted), then large streams,
// then the default one; never takes cover pictures.
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

// Whether each packet holds one frame that is shown. Fields may have a packet each, and some codecs
// have packets of frames that are only referred to.
bool hasFramePerPacket(const AVCodecParameters& parameters) {
    const int order = numberOf(parameters.field_order);
    const bool isProgressive = order == AV_FIELD_PROGRESSIVE;
    const AVCodecDescriptor* const codec = avcodec_descriptor_get(parameters.codec_id);
    const AVCodecID id = parameters.codec_id;
    if (id == AV_CODEC_ID_H264) return isProgressive;
    if (id == AV_CODEC_ID_HEVC || id == AV_CODEC_ID_VP9 || id == AV_CODEC_ID_AV1)
        return isProgressive || order == AV_FIELD_UNKNOWN;
    return codec != nullptr && (codec->props & AV_CODEC_PROP_INTRA_ONLY) != 0;
}

bool isLive(const VideoInput& input) {
    const bool arePictures = endsWith(input.format->iformat->name, "_pipe"); // ppm_pipe, ...
    return input.kind == Kind::Device || (input.kind == Kind::Stream && arePictures);
}

const AVCodec* decoderOf(VideoInput& input, const AVStream& stream) {
    const AVCodecID id = stream.codecpar->codec_id;
    const AVCodec* const usual = avcodec_find_decoder(id);
    const bool isVpx = id == AV_CODEC_ID_VP8 || id == AV_CODEC_ID_VP9;
    if (!isVpx || tagOf(stream.metadata, "alpha_mode") != "1") return usual;
    // FFmpeg's own decoders leave the transparency out.
    const AVCodec* const whole =
        avcodec_find_decoder_by_name(id == AV_CODEC_ID_VP8 ? "libvpx" : "libvpx-vp9");
    if (whole != nullptr) return whole;
    input.notes.push_back({NoteCode::LeftOut, input.subject + ": its transparency is left out, "
                                                              "because this FFmpeg lacks libvpx"});
    return usual;
}

CodecPtr openDecoder(VideoInput& input, const AVStream& stream, int threads) {
    const AVCodecParameters& parameters = *stream.codecpar;
    const std::string name = codecName(parameters.codec_id);
    const AVCodec* const codec = decoderOf(input, stream);
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
        sideData<AVDOVIDecoderConfigurationRecord>(stream, AV_PKT_DATA_DOVI_CONF);
    if (dolby != nullptr && dolby->dv_bl_signal_compatibility_id == 0 &&
        (dolby->dv_profile == 5 || dolby->dv_profile == 10)) {
        throw Error(ErrorCode::Unsupported, input.subject,
                    "is Dolby Vision of profile " + std::to_string(dolby->dv_profile) +
                        ", whose pictures have colours of their own, expected a profile with an "
                        "HDR10, HLG or SDR base layer, such as 8");
    }
    CodecPtr decoder = newDecoder(codec, parameters, stream.time_base);
    decoder->thread_count = threads;
    // Threads that decode one frame each hold a frame per thread back.
    if (isLive(input)) decoder->thread_type = FF_THREAD_SLICE;
    decoder->max_pixels = static_cast<std::int64_t>(kMaxImagePixels);
    Dictionary decoding;
    if (input.joinsEyes && !input.alternates && input.twin == nullptr)
        decoding.set("view_ids", "-1"); // all
    const int result = avcodec_open2(decoder.get(), codec, decoding.address());
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
    return decoder;
}

// End of the last picture or sound, s from the file's start. Chapters and subtitles may end later.
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

// Fills the facts about the pictures from the container and the delivered stream.
void fillFacts(VideoInput& input, const std::string& head) {
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
    const cv::Size stored(parameters.width, parameters.height);
    facts.size = isAcross ? cv::Size(stored.height, stored.width) : stored;
    describeEyes(input, head);
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

} // namespace

VideoInput openVideoInput(const fs::path& path, const VideoReaderOptions& options) {
    VideoInput input;
    openContainer(input, path, options);
    input.stream = chooseStream(*input.format, options.isDepth);
    if (input.stream == nullptr) {
        const std::string contents = otherContents(*input.format);
        throw Error(ErrorCode::BadFormat, input.subject,
                    "holds no video stream" + (contents.empty() ? "" : " but " + contents) +
                        ", expected a video");
    }
    if (input.encrypted.count(input.stream->index) > 0) {
        throw Error(ErrorCode::Unsupported, input.subject,
                    "is encrypted, so its pictures cannot be read, expected a video that is not");
    }
    const std::string head = std::exchange(input.head, {});
    findOtherEye(input, options, head);
    input.decoder = openDecoder(input, *input.stream, options.threads);
    if (input.twin != nullptr) input.twinDecoder = openDecoder(input, *input.twin, options.threads);
    fillFacts(input, head);
    refuseSpherical(input, head);
    listContents(*input.format, input.facts);
    const AVStream& depth = *chooseStream(*input.format, true);
    if (!options.isDepth && &depth != input.stream && likenessToDepth(depth) > 0) {
        const std::string title = tagOf(depth.metadata, "title");
        input.notes.push_back(
            {NoteCode::AsItIs, input.subject + ": its track " + std::to_string(depth.index) +
                                   " seems to hold depth (" +
                                   (title.empty() ? "16 bits of grey" : title) + "), so track " +
                                   std::to_string(input.stream->index) +
                                   " is read for the colours"});
    }
    return input;
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
