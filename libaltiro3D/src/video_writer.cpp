#include "altiro3D/video_writer.hpp"

#include "altiro3D/error.hpp"
#include "checks.hpp"
#include "ffmpeg.hpp"
#include "part_file.hpp"
#include "stream_copier.hpp"
#include "text.hpp"
#include "video_picture.hpp"

#include <algorithm>
#include <map>
#include <thread>

extern "C" {
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr int kLeastSide = 16;
constexpr int kLargestSide = 16384;
constexpr int kMostThreads = 64;
constexpr int kLinesOfHighDefinition = 720;
constexpr int kSlicesOfFfv1 = 16; // fixed, so that bytes do not depend on the threads
const char* const kPresets[] = {"ultrafast", "superfast", "veryfast", "faster",  "fast",
                                "medium",    "slow",      "slower",   "veryslow"};

// FFmpeg's name of the container for a file name, or null.
const char* containerName(const fs::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    if (extension == ".mkv") return "matroska";
    if (extension == ".mp4" || extension == ".m4v") return "mp4";
    if (extension == ".mov") return "mov";
    return nullptr;
}

const char* encoderName(VideoCodec codec) {
    switch (codec) {
    case VideoCodec::H264:
        return "libx264";
    case VideoCodec::H264Rgb:
        return "libx264rgb";
    case VideoCodec::Hevc:
        return "libx265";
    case VideoCodec::Ffv1:
        return "ffv1";
    case VideoCodec::ProRes:
        return "prores_ks";
    }
    return "";
}

AVPixelFormat pixelFormat(const VideoWriterOptions& options) {
    switch (options.codec) {
    case VideoCodec::H264:
    case VideoCodec::Hevc:
        return options.compatible ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV444P;
    case VideoCodec::H264Rgb:
        return AV_PIX_FMT_BGR24;
    case VideoCodec::Ffv1:
        return AV_PIX_FMT_BGR0;
    case VideoCodec::ProRes:
        return AV_PIX_FMT_YUV444P10;
    }
    return AV_PIX_FMT_NONE;
}

bool isRgb(AVPixelFormat format) {
    return format == AV_PIX_FMT_BGR24 || format == AV_PIX_FMT_BGR0;
}

bool hasQuality(VideoCodec codec) {
    return codec == VideoCodec::H264 || codec == VideoCodec::H264Rgb || codec == VideoCodec::Hevc;
}

std::string fractionText(const Fraction& ratio) {
    return std::to_string(ratio.numerator) + "/" + std::to_string(ratio.denominator);
}

void checkPositive(const Fraction& ratio, const char* field, bool mayBeUnknown) {
    check(ratio.isKnown() || (mayBeUnknown && ratio.numerator == 0 && ratio.denominator > 0), field,
          "is " + fractionText(ratio) + ", expected more than 0");
}

} // namespace

void validate(const VideoWriterOptions& options) {
    const auto side = [](int value) { return value >= kLeastSide && value <= kLargestSide; };
    check(side(options.size.width) && side(options.size.height), "size",
          "is " + sizeText(options.size) + " px, expected " + std::to_string(kLeastSide) + ".." +
              std::to_string(kLargestSide) + " px a side");
    check(options.crf >= 0 && options.crf <= 51, "crf",
          "is " + numberText(options.crf) + ", expected 0..51");
    check(std::find(std::begin(kPresets), std::end(kPresets), options.preset) != std::end(kPresets),
          "preset", "is \"" + options.preset + "\", expected ultrafast .. veryslow");
    checkPositive(options.timeBase, "timeBase", false);
    checkPositive(options.frameRate, "frameRate", !options.constantRate);
    checkPositive(options.sampleAspect, "sampleAspect", false);
    check(options.threads >= 0 && options.threads <= kMostThreads, "threads",
          "is " + std::to_string(options.threads) + ", expected 0.." +
              std::to_string(kMostThreads));
    check(!options.matrix || *options.matrix != ColourMatrix::Rgb || isRgb(pixelFormat(options)),
          "matrix", "is Rgb, expected another one or a codec of red, green and blue");
    check(!options.compatible || options.codec == VideoCodec::H264 ||
              options.codec == VideoCodec::Hevc,
          "compatible", "is set, expected the codec H264 or Hevc with it");
    check(!options.compatible || (options.size.width % 2 == 0 && options.size.height % 2 == 0),
          "size",
          "is " + sizeText(options.size) +
              " px, expected even sides for 4:2:0 (4:4:4 takes any, or change the size first)");
}

bool canWriteVideo(const fs::path& path) {
    return containerName(path) != nullptr;
}

struct VideoWriter::Impl {
    Impl(const fs::path& path, const VideoWriterOptions& given,
         const std::shared_ptr<OtherStreams>& source);

    void write(const VideoFrame& frame);
    void finish();

    Notes notes;

  private:
    void openEncoder(const std::shared_ptr<OtherStreams>& source);
    void openContainer(const std::shared_ptr<OtherStreams>& source);
    void encode(const AVFrame* frame);
    void copyOthers(std::optional<std::int64_t> before);
    void checkWritten(int result);
    void checkPacket(int result);
    void checkOpen() const;

    fs::path path_;
    VideoWriterOptions options_;
    AVPixelFormat format_;
    // The part is destroyed last, after the container that writes into it.
    std::unique_ptr<PartFile> file_;
    OutputPtr output_;
    CodecPtr encoder_;
    AVStream* stream_ = nullptr;
    std::unique_ptr<FrameMaker> frames_;
    std::unique_ptr<StreamCopier> copier_;
    PacketPtr packet_ = newPacket();
    std::map<std::int64_t, std::int64_t> durations_; // of the frames inside the encoder, by pts
    std::int64_t lastPts_ = -1;
    std::int64_t lastDuration_ = 0;
    std::int64_t framesWritten_ = 0;
    std::int64_t refused_ = 0; // packets the container would not take
    bool failed_ = false;
    bool finished_ = false;
};

VideoWriter::Impl::Impl(const fs::path& path, const VideoWriterOptions& given,
                        const std::shared_ptr<OtherStreams>& source)
    : path_(path), options_(given), format_(AV_PIX_FMT_NONE) {
    validate(options_);
    quietFfmpeg();
    format_ = pixelFormat(options_);
    const char* const container = containerName(path);
    if (container == nullptr) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "has a name that no video container here has, expected .mkv, .mp4 or .mov");
    }
    AVFormatContext* raw = nullptr;
    if (avformat_alloc_output_context2(&raw, nullptr, container, nullptr) < 0) {
        checkMemory(nullptr);
    }
    output_.reset(raw);
    openEncoder(source);
    openContainer(source);
}

void VideoWriter::Impl::openEncoder(const std::shared_ptr<OtherStreams>& source) {
    const char* const name = encoderName(options_.codec);
    const AVCodec* const codec = avcodec_find_encoder_by_name(name);
    if (codec == nullptr) {
        throw Error(ErrorCode::Unsupported, "codec",
                    std::string("needs the encoder ") + name + ", which this FFmpeg lacks");
    }
    if (avformat_query_codec(output_->oformat, codec->id, FF_COMPLIANCE_NORMAL) <= 0) {
        const char* const advice = options_.codec == VideoCodec::ProRes
                                       ? "a name that ends in .mov or .mkv"
                                       : "a name that ends in .mkv";
        throw Error(ErrorCode::Unsupported, path_.string(),
                    std::string("cannot hold ") + avcodec_get_name(codec->id) +
                        " video, expected " + advice);
    }
    encoder_.reset(avcodec_alloc_context3(codec));
    checkMemory(encoder_.get());
    AVCodecContext& encoder = *encoder_;
    encoder.width = options_.size.width;
    encoder.height = options_.size.height;
    encoder.pix_fmt = format_;
    encoder.time_base = rational(options_.timeBase);
    if (options_.frameRate.isKnown()) encoder.framerate = rational(options_.frameRate);
    encoder.sample_aspect_ratio = rational(options_.sampleAspect);
    const auto processors = static_cast<int>(std::thread::hardware_concurrency());
    const int threads =
        options_.threads > 0 ? options_.threads : std::clamp(processors, 1, kMostThreads);
    encoder.thread_count = threads;
    encoder.flags |= AV_CODEC_FLAG_BITEXACT;
    if ((output_->oformat->flags & AVFMT_GLOBALHEADER) != 0) {
        encoder.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }

    ColourMatrix matrix = ColourMatrix::Rgb;
    ColourRange range = ColourRange::Full;
    if (!isRgb(format_)) {
        const ColourMatrix before = source ? source->colour.matrix : ColourMatrix::Bt601;
        matrix = before == ColourMatrix::Bt2020 || options_.size.height < kLinesOfHighDefinition
                     ? before
                     : ColourMatrix::Bt709;
        if (matrix == ColourMatrix::Rgb) matrix = ColourMatrix::Bt601; // of a small RGB source
        matrix = options_.matrix.value_or(matrix);
        range = options_.range.value_or(ColourRange::Limited);
    }
    encoder.colorspace = colourSpace(matrix);
    encoder.color_range = colourRange(range);
    if (format_ == AV_PIX_FMT_YUV420P) encoder.chroma_sample_location = AVCHROMA_LOC_LEFT;
    encoder.color_primaries = AVCOL_PRI_UNSPECIFIED;
    encoder.color_trc = AVCOL_TRC_UNSPECIFIED;
    if (source) {
        encoder.color_primaries = static_cast<AVColorPrimaries>(source->colour.primaries);
        encoder.color_trc = static_cast<AVColorTransferCharacteristic>(source->colour.transfer);
    }
    if (matrix == ColourMatrix::Bt709) {
        if (encoder.color_primaries == AVCOL_PRI_UNSPECIFIED)
            encoder.color_primaries = AVCOL_PRI_BT709;
        if (encoder.color_trc == AVCOL_TRC_UNSPECIFIED) encoder.color_trc = AVCOL_TRC_BT709;
    }

    Dictionary settings;
    if (hasQuality(options_.codec)) {
        settings.set("preset", options_.preset);
        settings.set("crf", numberText(options_.crf));
    }
    if (options_.codec == VideoCodec::Hevc) {
        // It prints by itself and starts threads for all processors unless told.
        settings.set("x265-params", "log-level=none:pools=" + std::to_string(threads));
        encoder.thread_count = std::min(threads, 16);
        if (std::string(output_->oformat->name) != "matroska") {
            encoder.codec_tag = MKTAG('h', 'v', 'c', '1'); // what players of Apple ask for
        }
    } else if (options_.codec == VideoCodec::Ffv1) {
        encoder.level = 3;
        encoder.gop_size = 1;
        encoder.slices = kSlicesOfFfv1;
        settings.set("slicecrc", "1");
    } else if (options_.codec == VideoCodec::ProRes) {
        settings.set("profile", "4444");
        settings.set("vendor", "apl0");
        settings.set("alpha_bits", "0");
    }
    const int result = avcodec_open2(&encoder, codec, settings.address());
    if (result < 0) {
        throw Error(ErrorCode::Unsupported, path_.string(),
                    std::string("cannot be encoded by ") + name + " at " + sizeText(options_.size) +
                        " px: " + ffmpegText(result));
    }
    frames_ = std::make_unique<FrameMaker>(format_, options_.size, matrix, range, threads);
}

void VideoWriter::Impl::openContainer(const std::shared_ptr<OtherStreams>& source) {
    AVFormatContext& output = *output_;
    output.flags |= AVFMT_FLAG_BITEXACT;
    // Sound may begin a little before 0 (what its decoder needs to start); pictures stay put.
    output.avoid_negative_ts = AVFMT_AVOID_NEG_TS_DISABLED;
    stream_ = avformat_new_stream(&output, nullptr);
    checkMemory(stream_);
    if (avcodec_parameters_from_context(stream_->codecpar, encoder_.get()) < 0) {
        checkMemory(nullptr);
    }
    stream_->time_base = encoder_->time_base;
    stream_->sample_aspect_ratio = encoder_->sample_aspect_ratio;
    stream_->disposition = AV_DISPOSITION_DEFAULT;
    if (options_.constantRate) stream_->avg_frame_rate = rational(options_.frameRate);
    if (source) {
        copier_ = std::make_unique<StreamCopier>(
            source, output, path_.string(),
            StreamCopier::Wanted{options_.audio, options_.subtitles, options_.chapters,
                                 options_.metadata},
            notes);
    }
    for (const auto& [name, value] : options_.tags)
        av_dict_set(&output.metadata, name.c_str(), value.c_str(), 0);

    file_ = std::make_unique<PartFile>(path_);
    output.pb = file_->io();
    output.flags |= AVFMT_FLAG_CUSTOM_IO;
    // The index is moved to the front at the end, by reading the file again.
    const std::string url = "file:" + file_->partPath().string();
    av_freep(&output.url);
    output.url = av_strdup(url.c_str());
    checkMemory(output.url);
    Dictionary settings;
    if (std::string(output.oformat->name) != "matroska") {
        settings.set("movflags", "+faststart");
    }
    const int result = avformat_write_header(&output, settings.address());
    file_->check();
    if (result < 0) {
        throw Error(ErrorCode::Unsupported, path_.string(),
                    "cannot hold these streams together: " + ffmpegText(result));
    }
}

void VideoWriter::Impl::checkOpen() const {
    check(!finished_, "write", "comes after finish()");
    if (failed_) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "cannot be written any further after a failure");
    }
}

void VideoWriter::Impl::checkWritten(int result) {
    if (result < 0) failed_ = true;
    file_->check();
    if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
    if (result < 0) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "cannot be written: " + ffmpegText(result));
    }
}

// As checkWritten(); a damaged packet of the source's sound, which the container refuses, is no
// reason to give up. It may come to light while another packet is written.
void VideoWriter::Impl::checkPacket(int result) {
    const bool refused = result == AVERROR_INVALIDDATA || result == AVERROR(EINVAL);
    if (copier_ && refused && refused_ <= framesWritten_) {
        ++refused_;
        result = 0;
    }
    checkWritten(result);
}

// Gives the encoder a frame (null: the end) and writes what comes out.
void VideoWriter::Impl::encode(const AVFrame* frame) {
    int result = avcodec_send_frame(encoder_.get(), frame);
    checkWritten(result == AVERROR_EOF ? 0 : result);
    for (;;) {
        result = avcodec_receive_packet(encoder_.get(), packet_.get());
        if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
        checkWritten(result);
        const auto known = durations_.find(packet_->pts);
        if (known != durations_.end()) {
            packet_->duration = known->second;
            durations_.erase(known);
        }
        av_packet_rescale_ts(packet_.get(), encoder_->time_base, stream_->time_base);
        packet_->stream_index = stream_->index;
        checkPacket(av_interleaved_write_frame(output_.get(), packet_.get()));
        ++framesWritten_;
    }
}

void VideoWriter::Impl::write(const VideoFrame& frame) {
    checkOpen();
    checkType(frame.picture, {CV_8UC3}, "frame", "CV_8UC3");
    check(frame.picture.size() == options_.size, "frame",
          shapeText(frame.picture) + ", expected " + sizeText(options_.size) + " px");
    check(frame.pts > lastPts_, "frame",
          "has the time " + std::to_string(frame.pts) + ", expected " +
              (lastPts_ < 0 ? std::string("0 or more")
                            : "more than the last one's, " + std::to_string(lastPts_)));
    AVFrame& picture = frames_->make(frame.picture);
    picture.pts = frame.pts;
    picture.pict_type = AV_PICTURE_TYPE_NONE;
    picture.sample_aspect_ratio = encoder_->sample_aspect_ratio;
    picture.colorspace = encoder_->colorspace;
    picture.color_range = encoder_->color_range;
    picture.color_primaries = encoder_->color_primaries;
    picture.color_trc = encoder_->color_trc;
    lastPts_ = frame.pts;
    lastDuration_ = std::max<std::int64_t>(frame.duration, 0);
    durations_[frame.pts] = lastDuration_;
    encode(&picture);
    copyOthers(frame.pts + lastDuration_);
}

// Hands over what the source's other streams have before a time.
void VideoWriter::Impl::copyOthers(std::optional<std::int64_t> before) {
    if (!copier_) return;
    for (int result = -1; result < 0;) {
        result = copier_->copy(before, encoder_->time_base);
        checkPacket(result);
    }
}

void VideoWriter::Impl::finish() {
    checkOpen();
    check(lastPts_ >= 0, "finish", "comes before the first frame");
    encode(nullptr);
    const bool whole = copier_ && copier_->sourceHasEnded();
    copyOthers(whole ? std::nullopt : std::optional<std::int64_t>(lastPts_ + lastDuration_));
    // What is still waiting to be interleaved.
    for (int result = -1; result < 0;) {
        result = av_interleaved_write_frame(output_.get(), nullptr);
        checkPacket(result);
    }
    checkWritten(av_write_trailer(output_.get()));
    file_->finish();
    finished_ = true;
    if (refused_ > 0) {
        notes.push_back(path_.string() + ": " + std::to_string(refused_) +
                        (refused_ == 1 ? " damaged packet" : " damaged packets") +
                        " of the source's sound or subtitles could not be kept");
    }
}

VideoWriter::VideoWriter(const fs::path& path, const VideoWriterOptions& options,
                         VideoReader* source) {
    std::shared_ptr<OtherStreams> streams;
    if (source != nullptr) {
        streams = source->otherStreams();
        check(streams->want(), "source",
              "has delivered a frame already, expected a writer before the first one");
    }
    impl_ = std::make_unique<Impl>(path, options, streams);
}

VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

void VideoWriter::write(const VideoFrame& frame) {
    impl_->write(frame);
}

void VideoWriter::finish() {
    impl_->finish();
}

const Notes& VideoWriter::notes() const {
    return impl_->notes;
}

} // namespace altiro3D
