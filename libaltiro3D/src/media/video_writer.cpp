#include "altiro3D/video_io.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "media/ffmpeg.hpp"
#include "media/video_container.hpp"
#include "media/video_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

extern "C" {
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr int kMinSide = 16;
constexpr int kMaxSide = 16384;
constexpr int kMaxThreads = 64;
constexpr int kLinesOfHighDefinition = 720;
constexpr int kSlicesOfFfv1 = 16; // fixed, so the bytes do not depend on the threads

// In the order of VideoCodec.
constexpr struct {
    const char* encoder;
    AVPixelFormat format;
} kCodecs[] = {{"libx264", AV_PIX_FMT_YUV444P},
               {"libx264rgb", AV_PIX_FMT_BGR24},
               {"libx265", AV_PIX_FMT_YUV444P},
               {"ffv1", AV_PIX_FMT_BGR0},
               {"prores_ks", AV_PIX_FMT_YUV444P10}};

AVPixelFormat pixelFormat(const VideoWriterOptions& options) {
    return options.compatible ? AV_PIX_FMT_YUV420P : entryOf(kCodecs, options.codec).format;
}

bool isRgb(AVPixelFormat format) {
    return format == AV_PIX_FMT_BGR24 || format == AV_PIX_FMT_BGR0;
}

bool hasQuality(VideoCodec codec) {
    return codec == VideoCodec::H264 || codec == VideoCodec::H264Rgb || codec == VideoCodec::Hevc;
}

// Natives in 4:4:4 are encoded without psychovisual optimization: it keeps the texture of one
// image, not that of many views, and makes chroma coarser, which here belongs to other views than
// luma. docs/lab/video.md has the measurements.
bool isExact(const VideoWriterOptions& options) {
    return options.native && !options.compatible &&
           (options.codec == VideoCodec::H264 || options.codec == VideoCodec::Hevc);
}

// Without that optimization, files have about the same size at a greater value. 0 is lossless.
double usedCrf(const VideoWriterOptions& options) {
    constexpr double kExactIsGreaterBy = 2;
    constexpr double kMost = 51;
    if (!isExact(options) || options.crf < 1) return options.crf;
    return std::min(options.crf + kExactIsGreaterBy, kMost);
}

// Natives are noisy, and their rate is high: CAVLC without deblocking is decoded in half of CABAC's
// time. The coarser chroma, which an eye hardly sees, pays for the larger files. Slow presets keep
// the accuracy of every sub-pixel. In the quick presets, a fixed quantizer spares x264 the analysis
// of small copies of the frames, a fifth of its time or more. A rate cap needs a rate factor,
// because that can be changed while encoding.
std::string x264Params(const VideoWriterOptions& options) {
    if (!isExact(options)) return {};
    if (options.preset >= EncoderPreset::Medium) return "psy=0";
    std::string all = "psy=0:cabac=0:no-deblock=1:chroma-qp-offset=2";
    const std::string fixed = options.maxRate > 0
                                  ? ":qcomp=1:aq-mode=0:mbtree=0"
                                  : ":qp=" + std::to_string(std::lround(usedCrf(options)));
    if (options.preset == EncoderPreset::UltraFast) return all + ":bframes=3:b-adapt=0" + fixed;
    if (options.preset == EncoderPreset::SuperFast)
        return all + ":subme=0:b-adapt=0:weightp=0:scenecut=0" + fixed;
    return all;
}

// Holds the rate below a cap by a greater quantizer. x264's own buffer control gives other bytes in
// each run if it has threads; this one depends only on the sizes of the packets that came out.
class RateCap {
  public:
    explicit RateCap(const VideoWriterOptions& options)
        : factor_(usedCrf(options)), bitsPerSecond_(1e6 * options.maxRate),
          bitsPerTick_(bitsPerSecond_ * options.timeBase.value()) {}

    void count(const AVPacket& packet) {
        const std::int64_t passed = std::max<std::int64_t>(packet.pts - lastPts_, 0);
        debt_ = std::max(debt_ - bitsPerTick_ * static_cast<double>(passed), 0.0);
        debt_ += 8.0 * packet.size;
        lastPts_ += passed;
    }

    /// The factor for the next frame.
    double factor() const {
        constexpr double kMost = 51;
        return std::min(factor_ + kGain * debt_ / bitsPerSecond_, kMost);
    }

  private:
    // Per second of debt; five steps halve the rate. A greater gain makes it swing with the 20
    // frames in flight of 16 threads.
    static constexpr double kGain = 12;
    double factor_;
    double bitsPerSecond_;
    double bitsPerTick_;
    double debt_ = 0; // bits that came before their time
    std::int64_t lastPts_ = 0;
};

std::string x265Params(const VideoWriterOptions& options, int threads) {
    // By default, x265 prints messages and starts threads for all processors.
    const std::string params = "log-level=none:pools=" + std::to_string(threads);
    return isExact(options) ? params + ":psy-rd=0:psy-rdoq=0" : params;
}

void checkPositive(const Fraction& ratio, const char* field, bool mayBeUnknown) {
    check(ratio.isKnown() || (mayBeUnknown && ratio.numerator == 0 && ratio.denominator > 0), field,
          "is " + std::to_string(ratio.numerator) + "/" + std::to_string(ratio.denominator) +
              ", expected more than 0");
}

} // namespace

const char* presetName(EncoderPreset preset) {
    constexpr const char* kNames[] = {"ultrafast", "superfast", "veryfast", "faster",  "fast",
                                      "medium",    "slow",      "slower",   "veryslow"};
    return entryOf(kNames, preset);
}

void validate(const VideoWriterOptions& options) {
    const auto side = [](int value) { return value >= kMinSide && value <= kMaxSide; };
    check(side(options.size.width) && side(options.size.height), "size",
          "is " + sizeText(options.size) + ", expected " + std::to_string(kMinSide) + ".." +
              std::to_string(kMaxSide) + " px a side");
    check(options.crf >= 0 && options.crf <= 51, "crf",
          "is " + numberText(options.crf) + ", expected 0..51");
    check(options.maxRate == 0 || (options.maxRate >= 1 && options.maxRate <= 100000), "maxRate",
          "is " + numberText(options.maxRate) + ", expected 0 or 1..100000");
    check(options.maxRate == 0 ||
              (options.codec == VideoCodec::H264 || options.codec == VideoCodec::H264Rgb),
          "maxRate", "is set, expected the codec H264 or H264Rgb with it");
    check(options.maxRate == 0 || options.crf >= 1, "maxRate",
          "is set, expected a crf of 1 or more with it");
    check(options.preset >= EncoderPreset::UltraFast && options.preset <= EncoderPreset::VerySlow,
          "preset",
          "is " + std::to_string(static_cast<int>(options.preset)) + ", expected an EncoderPreset");
    checkPositive(options.timeBase, "timeBase", false);
    checkPositive(options.frameRate, "frameRate", !options.constantRate);
    checkPositive(options.sampleAspect, "sampleAspect", false);
    const auto checkColour = [](int number, const char* field, int most) {
        check(number >= 1 && number <= most, field,
              "is " + std::to_string(number) + ", expected 1.." + std::to_string(most));
    };
    if (options.colour) {
        checkColour(options.colour->primaries, "colour.primaries", AVCOL_PRI_NB - 1);
        checkColour(options.colour->transfer, "colour.transfer", AVCOL_TRC_NB - 1);
    }
    check(options.threads >= 0 && options.threads <= kMaxThreads, "threads",
          "is " + std::to_string(options.threads) + ", expected 0.." + std::to_string(kMaxThreads));
    check(!options.matrix || *options.matrix != ColourMatrix::Rgb || isRgb(pixelFormat(options)),
          "matrix", "is Rgb, expected another one or a codec of red, green and blue");
    check(!options.compatible || options.codec == VideoCodec::H264 ||
              options.codec == VideoCodec::Hevc,
          "compatible", "is set, expected the codec H264 or Hevc with it");
    check(!options.compatible || (options.size.width % 2 == 0 && options.size.height % 2 == 0),
          "size",
          "is " + sizeText(options.size) +
              ", expected even sides for 4:2:0 (4:4:4 takes any, or change the size first)");
}

struct VideoWriter::Impl {
    Impl(const fs::path& path, const VideoWriterOptions& given,
         const std::shared_ptr<OtherStreams>& source);

    void write(const VideoFrame& frame);
    void finish();

    Notes notes;

  private:
    void openEncoder();
    std::pair<ColourMatrix, ColourRange> setColours();
    void encode(const AVFrame* frame);
    void checkOpen() const;

    fs::path path_;
    VideoWriterOptions options_;
    AVPixelFormat format_;
    VideoContainer container_;
    CodecPtr encoder_;
    std::unique_ptr<FrameMaker> frames_;
    std::optional<RateCap> cap_;
    PacketPtr packet_ = newPacket();
    std::map<std::int64_t, std::int64_t> durations_; // frames inside the encoder, by pts
    std::int64_t lastPts_ = -1;
    std::int64_t lastDuration_ = 0;
    bool finished_ = false;
};

VideoWriter::Impl::Impl(const fs::path& path, const VideoWriterOptions& given,
                        const std::shared_ptr<OtherStreams>& source)
    : path_(path), options_((validate(given), given)), format_(pixelFormat(options_)),
      container_(path) {
    quietFfmpeg();
    if (source && !options_.colour) options_.colour = source->colour;
    openEncoder();
    const ParametersPtr parameters(avcodec_parameters_alloc());
    checkMemory(parameters.get());
    checkRoom(avcodec_parameters_from_context(parameters.get(), encoder_.get()));
    container_.open(*parameters, options_, source, notes);
}

// Sets the colour tags of the encoder and returns its matrix and range.
std::pair<ColourMatrix, ColourRange> VideoWriter::Impl::setColours() {
    AVCodecContext& encoder = *encoder_;
    ColourMatrix matrix = ColourMatrix::Rgb;
    ColourRange range = ColourRange::Full;
    if (!isRgb(format_)) {
        const ColourMatrix before = options_.colour ? options_.colour->matrix : ColourMatrix::Bt601;
        matrix = before == ColourMatrix::Bt2020 || options_.size.height < kLinesOfHighDefinition
                     ? before
                     : ColourMatrix::Bt709;
        if (matrix == ColourMatrix::Rgb) matrix = ColourMatrix::Bt601; // small RGB source
        matrix = options_.matrix.value_or(matrix);
        range = options_.range.value_or(ColourRange::Limited);
    }
    encoder.colorspace = colourSpace(matrix);
    encoder.color_range = colourRange(range);
    if (format_ == AV_PIX_FMT_YUV420P) encoder.chroma_sample_location = AVCHROMA_LOC_LEFT;
    const VideoColour stated = options_.colour.value_or(VideoColour());
    const auto used = [&](int code) { // of H.273: 2 is not stated, and 1 is that of Rec. 709
        return code == 2 && matrix == ColourMatrix::Bt709 ? 1 : code;
    };
    encoder.color_primaries = static_cast<AVColorPrimaries>(used(stated.primaries));
    encoder.color_trc = static_cast<AVColorTransferCharacteristic>(used(stated.transfer));
    return {matrix, range};
}

void VideoWriter::Impl::openEncoder() {
    const char* const name = entryOf(kCodecs, options_.codec).encoder;
    const AVCodec* const codec = avcodec_find_encoder_by_name(name);
    if (codec == nullptr) {
        throw Error(ErrorCode::Unsupported, path_.string(),
                    std::string("needs the encoder ") + name +
                        ", which this FFmpeg lacks, expected the codec ffv1 or prores");
    }
    if (avformat_query_codec(&container_.kind(), codec->id, FF_COMPLIANCE_NORMAL) <= 0) {
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
        options_.threads > 0 ? options_.threads : std::clamp(processors, 1, kMaxThreads);
    encoder.thread_count = threads;
    encoder.flags |= AV_CODEC_FLAG_BITEXACT;
    if ((container_.kind().flags & AVFMT_GLOBALHEADER) != 0)
        encoder.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;

    const auto [matrix, range] = setColours();
    Dictionary settings;
    if (hasQuality(options_.codec)) {
        settings.set("preset", presetName(options_.preset));
        settings.set("crf", numberText(usedCrf(options_)));
    }
    if (options_.codec == VideoCodec::H264) settings.set("x264-params", x264Params(options_));
    if (options_.codec == VideoCodec::H264 && options_.preset == EncoderPreset::UltraFast &&
        threads > 1) {
        // Threads wait for rows of the frame before; other presets look ahead with a thread more.
        encoder.thread_count = threads + 1;
    }
    if (options_.codec == VideoCodec::Hevc) {
        settings.set("x265-params", x265Params(options_, threads));
        encoder.thread_count = std::min(threads, 16);
        if (!container_.isMatroska()) {
            encoder.codec_tag = MKTAG('h', 'v', 'c', '1'); // required by Apple's players
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
                        ": " + ffmpegText(result));
    }
    if (options_.maxRate > 0) cap_.emplace(options_);
    frames_ = std::make_unique<FrameMaker>(format_, options_.size, matrix, range, threads);
}

void VideoWriter::Impl::checkOpen() const {
    check(!finished_, "write", "comes after finish()");
    container_.checkUsable();
}

// Sends a frame to the encoder (null = end) and writes the packets it returns.
void VideoWriter::Impl::encode(const AVFrame* frame) {
    if (cap_) av_opt_set_double(encoder_->priv_data, "crf", cap_->factor(), 0);
    int result = avcodec_send_frame(encoder_.get(), frame);
    container_.checkWritten(result == AVERROR_EOF ? 0 : result);
    for (;;) {
        result = avcodec_receive_packet(encoder_.get(), packet_.get());
        if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
        container_.checkWritten(result);
        if (cap_) cap_->count(*packet_);
        const auto known = durations_.find(packet_->pts);
        if (known != durations_.end()) {
            packet_->duration = known->second;
            durations_.erase(known);
        }
        container_.write(*packet_);
    }
}

void VideoWriter::Impl::write(const VideoFrame& frame) {
    checkOpen();
    checkType(frame.picture, {CV_8UC3}, "frame", "CV_8UC3");
    check(frame.picture.size() == options_.size, "frame",
          shapeText(frame.picture) + ", expected " + sizeText(options_.size));
    check(frame.pts > lastPts_, "frame",
          "has the time " + std::to_string(frame.pts) + ", expected " +
              (lastPts_ < 0 ? std::string("0 or more")
                            : "more than the last one's, " + std::to_string(lastPts_)));
    const auto pause = static_cast<double>(frame.pts - std::max<std::int64_t>(lastPts_, 0));
    check(pause * options_.timeBase.value() <= container_.longestPause(), "frame",
          "has the time " + std::to_string(frame.pts) + ", expected at most " +
              numberText(container_.longestPause()) + " s after the last one");
    AVFrame& picture = frames_->make(frame.picture);
    picture.pts = frame.pts;
    picture.pict_type = AV_PICTURE_TYPE_NONE;
    picture.sample_aspect_ratio = encoder_->sample_aspect_ratio;
    picture.colorspace = encoder_->colorspace;
    picture.color_range = encoder_->color_range;
    picture.color_primaries = encoder_->color_primaries;
    picture.color_trc = encoder_->color_trc;
    lastPts_ = frame.pts;
    lastDuration_ = std::clamp<std::int64_t>(frame.duration, 0,
                                             std::numeric_limits<std::int64_t>::max() - frame.pts);
    durations_[frame.pts] = lastDuration_;
    encode(&picture);
    container_.copyOthers(frame.pts + lastDuration_);
}

void VideoWriter::Impl::finish() {
    checkOpen();
    check(lastPts_ >= 0, "finish", "comes before the first frame");
    encode(nullptr);
    container_.finish(lastPts_ + lastDuration_, notes);
    finished_ = true;
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

void VideoWriter::write(const VideoFrame& frame) try {
    impl_->write(frame);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void VideoWriter::finish() {
    impl_->finish();
}

const Notes& VideoWriter::notes() const {
    return impl_->notes;
}

std::string VideoWriter::extensionFor(VideoReader& source, const VideoWriterOptions& options) {
    std::vector<std::string> extensions = {".mp4", ".mkv", ".mov"};
    if (options.codec == VideoCodec::ProRes) extensions = {".mov", ".mkv"};
    if (options.codec == VideoCodec::Ffv1) extensions = {".mkv"};
    for (const std::string& extension : extensions) {
        if (VideoContainer("video" + extension).canHold(options, source.otherStreams()))
            return extension;
    }
    return extensions.front();
}

} // namespace altiro3D
