#include "media/other_streams.hpp"

#include "altiro3D/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

extern "C" {
#include <libavutil/avstring.h>
}

namespace altiro3D {

namespace {

constexpr int kMaxSubtitleBytes = 1 << 20;

// Tags that describe the source file and not its contents.
bool isOfTheFile(const std::string& name) {
    static const char* const kNames[] = {"encoder",  "major_brand", "minor_version",
                                         "duration", "timecode",    "compatible_brands",
                                         "rotate",   "vendor_id"};
    static const char* const kBeginnings[] = {"BPS", "NUMBER_OF_", "_STATISTICS_", "DURATION"};
    return std::any_of(std::begin(kNames), std::end(kNames),
                       [&](const char* one) { return av_strcasecmp(name.c_str(), one) == 0; }) ||
           std::any_of(std::begin(kBeginnings), std::end(kBeginnings), [&](const char* one) {
               return name.compare(0, std::strlen(one), one) == 0;
           });
}

void copyTags(const VideoTags& tags, AVDictionary*& to) {
    for (const auto& [name, value] : tags) {
        if (!isOfTheFile(name)) av_dict_set(&to, name.c_str(), value.c_str(), 0);
    }
}

bool isText(AVCodecID codec) {
    const AVCodecDescriptor* const descriptor = avcodec_descriptor_get(codec);
    return descriptor != nullptr && (descriptor->props & AV_CODEC_PROP_TEXT_SUB) != 0;
}

std::string describe(const OtherStream& stream) {
    const AVMediaType type = stream.parameters->codec_type;
    const char* const kind = stream.isCover                    ? "cover picture"
                             : type == AVMEDIA_TYPE_AUDIO      ? "sound"
                             : type == AVMEDIA_TYPE_SUBTITLE   ? "subtitles"
                             : type == AVMEDIA_TYPE_VIDEO      ? "further video"
                             : type == AVMEDIA_TYPE_ATTACHMENT ? "attachment"
                                                               : "data";
    std::string text = kind;
    if (stream.parameters->codec_id != AV_CODEC_ID_NONE)
        text += std::string(" ") + avcodec_get_name(stream.parameters->codec_id);
    for (const auto& [name, value] : stream.tags) {
        if (name == "language" && value != "und") text += " (" + value + ")";
    }
    return text;
}

// Whether a container lists the codec. Matroska also holds all sound that WAV has a number for, but
// not Flash's ADPCM, whose packets differ in size.
bool isListed(const AVOutputFormat& container, const AVCodecParameters& stream) {
    unsigned number = 0;
    return avformat_query_codec(&container, stream.codec_id, FF_COMPLIANCE_NORMAL) != 0 ||
           (isMatroska(container) && stream.codec_type == AVMEDIA_TYPE_AUDIO &&
            stream.codec_id != AV_CODEC_ID_ADPCM_SWF &&
            av_codec_get_tag2(container.codec_tag, stream.codec_id, &number) != 0);
}

// Matroska accepts any attachment with a file name and a type.
bool isNamed(const OtherStream& attachment) {
    const auto has = [&](const char* wanted) {
        return std::any_of(attachment.tags.begin(), attachment.tags.end(),
                           [&](const auto& tag) { return tag.first == wanted; });
    };
    return has("filename") && has("mimetype");
}

} // namespace

PacketPtr OtherStreams::pop(std::size_t index, std::optional<std::int64_t> before,
                            AVRational unit) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (index >= packets_.size()) return nullptr;
    std::deque<PacketPtr>& queue = packets_[index];
    const AVRational timeBase = streams[index].timeBase;
    const bool isSubtitle = streams[index].parameters->codec_type == AVMEDIA_TYPE_SUBTITLE;
    const std::int64_t shift = av_rescale_q(origin_, unit_, timeBase);
    while (!queue.empty()) {
        AVPacket& packet = *queue.front();
        const auto isTime = [](std::int64_t one) { return one == AV_NOPTS_VALUE || isNear(one); };
        if (!isNear(shift) || !isTime(packet.pts) || !isTime(packet.dts)) { // without a usable time
            queue.pop_front();
            continue;
        }
        const std::int64_t time = packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts;
        if (time != AV_NOPTS_VALUE) {
            const std::int64_t begin = time - shift;
            if (before && av_compare_ts(begin, timeBase, *before, unit) >= 0) return nullptr;
            const std::int64_t after =
                begin + std::clamp<std::int64_t>(packet.duration, 0, kFarthestTime);
            const bool early = clip_ && begin < 0 && (!isSubtitle || after <= 0);
            if (early || (end_ && av_compare_ts(begin, timeBase, *end_ - origin_, unit_) >= 0)) {
                queue.pop_front();
                continue;
            }
            if (clip_ && begin < 0) { // a subtitle visible at the start of the part
                packet.duration = after;
                packet.pts = shift;
                packet.dts = shift;
            }
        }
        PacketPtr taken = std::move(queue.front());
        queue.pop_front();
        if (taken->pts != AV_NOPTS_VALUE) taken->pts -= shift;
        if (taken->dts != AV_NOPTS_VALUE) taken->dts -= shift;
        return taken;
    }
    return nullptr;
}

StreamCopier::StreamCopier(std::shared_ptr<OtherStreams> source, AVFormatContext& output,
                           const std::string& path, const VideoWriterOptions& wanted, Notes& notes)
    : source_(std::move(source)), output_(output) {
    routes_.reserve(source_->streams.size());
    const bool mkv = isMatroska(*output.oformat);
    for (std::size_t i = 0; i < source_->streams.size(); ++i) {
        const OtherStream& stream = source_->streams[i];
        const AVCodecID codec = stream.parameters->codec_id;
        const auto leaveOut = [&](const std::string& why = {}) {
            notes.push_back({NoteCode::LeftOut, source_->subject + ": " + describe(stream) +
                                                    " is " + why + "left out"});
        };
        const auto refuse = [&](const std::string& advice) {
            throw Error(ErrorCode::Unsupported, path,
                        "cannot hold the " + describe(stream) + " of " + source_->subject +
                            ", expected " + advice);
        };
        if (stream.isCover) {
            leaveOut();
            continue;
        }
        switch (stream.parameters->codec_type) {
        case AVMEDIA_TYPE_AUDIO:
            if (!wanted.audio) break;
            if (stream.isEncrypted) {
                leaveOut("encrypted and ");
            } else if (canHold(*stream.parameters)) {
                addCopy(i);
            } else {
                const bool fitsMkv =
                    !mkv &&
                    isListed(*av_guess_format("matroska", nullptr, nullptr), *stream.parameters);
                refuse(fitsMkv ? "a name that ends in .mkv, or no sound" : "no sound");
            }
            break;
        case AVMEDIA_TYPE_SUBTITLE: {
            if (!wanted.subtitles) break;
            const AVCodecID text = mkv ? AV_CODEC_ID_SUBRIP : AV_CODEC_ID_MOV_TEXT;
            if (canHold(*stream.parameters)) {
                addCopy(i);
            } else if (isText(codec) && addConversion(i, text)) {
                notes.push_back({NoteCode::Converted, source_->subject + ": " + describe(stream) +
                                                          " become " + avcodec_get_name(text)});
            } else {
                refuse(mkv ? "no subtitles" : "a name that ends in .mkv, or no subtitles");
            }
            break;
        }
        case AVMEDIA_TYPE_ATTACHMENT:
            if (wanted.subtitles && mkv && isNamed(stream)) {
                addCopy(i);
            } else if (wanted.subtitles) {
                leaveOut();
            }
            break;
        default:
            // The text stream of QuickTime chapters is rewritten with the chapters.
            if (codec != AV_CODEC_ID_BIN_DATA) leaveOut();
            break;
        }
    }
    if (wanted.metadata) copyTags(source_->tags, output.metadata);
    if (wanted.chapters && !source_->chapters.empty()) addChapters();
}

void StreamCopier::addChapters() {
    const std::size_t count = source_->chapters.size();
    output_.chapters = static_cast<AVChapter**>(av_calloc(count, sizeof(AVChapter*)));
    checkMemory(output_.chapters);
    for (std::size_t i = 0; i < count; ++i) {
        const VideoChapter& from = source_->chapters[i];
        auto* const to = static_cast<AVChapter*>(av_mallocz(sizeof(AVChapter)));
        checkMemory(to);
        to->id = static_cast<std::int64_t>(i) + 1;
        to->time_base = {1, 1000000000};
        to->start = std::llround(from.start * 1e9);
        to->end = std::llround(from.end * 1e9);
        if (!from.title.empty()) av_dict_set(&to->metadata, "title", from.title.c_str(), 0);
        output_.chapters[output_.nb_chapters++] = to;
    }
}

// Whether the container accepts such a stream, by its list of codecs and by a trial.
bool StreamCopier::canHold(const AVCodecParameters& parameters) const {
    if (!isListed(*output_.oformat, parameters)) return false;
    const OutputPtr trial = newOutput(output_.oformat, nullptr);
    AVStream& video = newStream(*trial);
    AVStream& stream = newStream(*trial);
    checkRoom(avcodec_parameters_copy(video.codecpar, output_.streams[0]->codecpar));
    checkRoom(avcodec_parameters_copy(stream.codecpar, &parameters));
    video.time_base = output_.streams[0]->time_base;
    stream.codecpar->codec_tag = 0;
    stream.time_base = {1, std::max(parameters.sample_rate, 1000)};
    checkRoom(avio_open_dyn_buf(&trial->pb));
    const bool holds = avformat_init_output(trial.get(), nullptr) >= 0;
    std::uint8_t* bytes = nullptr;
    avio_close_dyn_buf(trial->pb, &bytes);
    av_free(bytes);
    trial->pb = nullptr;
    return holds;
}

StreamCopier::Route& StreamCopier::addRoute(std::size_t index) {
    const OtherStream& from = source_->streams[index];
    Route& route = routes_.emplace_back();
    route.from = index;
    route.to = &newStream(output_);
    route.to->time_base = from.timeBase;
    route.to->disposition = from.disposition;
    copyTags(from.tags, route.to->metadata);
    source_->take(index);
    return route;
}

void StreamCopier::addCopy(std::size_t index) {
    const OtherStream& from = source_->streams[index];
    AVCodecParameters& to = *addRoute(index).to->codecpar;
    checkRoom(avcodec_parameters_copy(&to, from.parameters.get()));
    // The codec tag differs between containers.
    const AVCodecTag* const* const tags = output_.oformat->codec_tag;
    unsigned tag = 0;
    const bool keeps = tags == nullptr || av_codec_get_id(tags, to.codec_tag) == to.codec_id ||
                       av_codec_get_tag2(tags, to.codec_id, &tag) == 0;
    if (!keeps) to.codec_tag = 0;
}

// Converts text subtitles to another text format; false if this FFmpeg does not support it.
bool StreamCopier::addConversion(std::size_t index, AVCodecID to) {
    const OtherStream& from = source_->streams[index];
    const AVCodec* const reading = avcodec_find_decoder(from.parameters->codec_id);
    const AVCodec* const writing = avcodec_find_encoder(to);
    if (reading == nullptr || writing == nullptr) return false;
    CodecPtr decoder = newDecoder(reading, *from.parameters, from.timeBase);
    CodecPtr encoder(avcodec_alloc_context3(writing));
    checkMemory(encoder.get());
    if (avcodec_open2(decoder.get(), reading, nullptr) < 0) return false;
    encoder->time_base = {1, 1000};
    if (decoder->subtitle_header != nullptr) {
        const auto size = static_cast<std::size_t>(decoder->subtitle_header_size);
        encoder->subtitle_header = static_cast<std::uint8_t*>(av_mallocz(size + 1));
        checkMemory(encoder->subtitle_header);
        std::memcpy(encoder->subtitle_header, decoder->subtitle_header, size);
        encoder->subtitle_header_size = decoder->subtitle_header_size;
    }
    if (avcodec_open2(encoder.get(), writing, nullptr) < 0) return false;
    Route& route = addRoute(index);
    checkRoom(avcodec_parameters_from_context(route.to->codecpar, encoder.get()));
    route.decoder = std::move(decoder);
    route.encoder = std::move(encoder);
    return true;
}

PacketPtr StreamCopier::convert(Route& route, AVPacket& packet) {
    AVSubtitle subtitle{};
    int got = 0;
    if (avcodec_decode_subtitle2(route.decoder.get(), &subtitle, &got, &packet) < 0 || got == 0)
        return nullptr;
    // The packet holds the times, so those inside it begin at 0.
    const AVRational unit = source_->streams[route.from].timeBase;
    const std::int64_t length = subtitle.end_display_time > subtitle.start_display_time &&
                                        subtitle.end_display_time != UINT32_MAX
                                    ? subtitle.end_display_time - subtitle.start_display_time
                                    : av_rescale_q(packet.duration, unit, AVRational{1, 1000});
    subtitle.end_display_time = static_cast<std::uint32_t>(length);
    const std::int64_t late = av_rescale_q(subtitle.start_display_time, AVRational{1, 1000}, unit);
    subtitle.start_display_time = 0;
    std::vector<std::uint8_t> bytes(kMaxSubtitleBytes);
    const int size =
        avcodec_encode_subtitle(route.encoder.get(), bytes.data(), kMaxSubtitleBytes, &subtitle);
    avsubtitle_free(&subtitle);
    if (size <= 0) return nullptr;
    PacketPtr result = newPacket();
    checkRoom(av_new_packet(result.get(), size));
    std::memcpy(result->data, bytes.data(), static_cast<std::size_t>(size));
    result->pts = packet.pts != AV_NOPTS_VALUE ? packet.pts + late : AV_NOPTS_VALUE;
    result->dts = result->pts;
    result->duration = av_rescale_q(length, AVRational{1, 1000}, unit);
    result->flags |= AV_PKT_FLAG_KEY;
    return result;
}

int StreamCopier::writePacket(Route& route, PacketPtr packet) {
    packet->stream_index = route.to->index;
    packet->pos = -1;
    av_packet_rescale_ts(packet.get(), source_->streams[route.from].timeBase, route.to->time_base);
    // Containers refuse decoding times that do not increase, which damaged sources have.
    if (packet->dts == AV_NOPTS_VALUE) packet->dts = packet->pts;
    if (route.lastDts != AV_NOPTS_VALUE && packet->dts != AV_NOPTS_VALUE) {
        const bool strict = (output_.oformat->flags & AVFMT_TS_NONSTRICT) == 0;
        const std::int64_t least = route.lastDts + (strict ? 1 : 0);
        if (packet->dts < least) {
            packet->dts = least;
            if (packet->pts != AV_NOPTS_VALUE) packet->pts = std::max(packet->pts, least);
        }
    }
    if (packet->dts != AV_NOPTS_VALUE) route.lastDts = packet->dts;
    return av_interleaved_write_frame(&output_, packet.get());
}

int StreamCopier::copy(std::optional<std::int64_t> before, AVRational unit) {
    for (Route& route : routes_) {
        while (PacketPtr packet = source_->pop(route.from, before, unit)) {
            if (route.encoder) packet = convert(route, *packet);
            if (!packet) continue;
            const int result = writePacket(route, std::move(packet));
            if (result < 0) return result;
        }
    }
    return 0;
}

} // namespace altiro3D
