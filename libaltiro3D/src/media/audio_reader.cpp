#include "altiro3D/video_io.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "media/ffmpeg.hpp"
#include "media/video_input.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

extern "C" {
#include <libavutil/channel_layout.h>
#include <libswresample/swresample.h>
}

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr int kMinFileRate = 1000; // bounds the memory of resampled frames
constexpr int kMaxFileRate = 768000;
constexpr double kStepsBackSeconds[] = {0.5, 3, 20}; // decoders need a run-up
constexpr double kJump = 0.02; // s; smaller differences are the rounding of a container's times
constexpr double kLatestSeconds = 1e9;

using ResamplerPtr = std::unique_ptr<SwrContext, Free<swr_free>>;

void checkTime(const char* name, double seconds) {
    check(seconds >= 0 && seconds < kLatestSeconds, name,
          "is " + numberText(seconds) + " s, expected 0 or more, less than 1e9 s");
}

// What a resampler was made for: rate, format of samples, channels.
using Format = std::array<int, 3>;

} // namespace

// Frames are resampled to `ready`. Positions count delivered samples from the start of the file.
struct AudioReader::Impl {
    Impl(const fs::path& path, const AudioReaderOptions& options);

    std::size_t read(float* samples, std::size_t count);
    void seek(double seconds);

  private:
    void open(int wanted);
    void goBack(double seconds);
    void restart();
    bool decode();
    bool feed();
    void resample(const AVFrame* given);
    void place(const AVFrame& given);
    void makeResampler(const AVFrame& given);

    int rate_;
    VideoInput input_;
    AVStream* stream_ = nullptr;
    CodecPtr decoder_;
    ResamplerPtr resampler_;
    Format format_;
    PacketPtr packet_ = newPacket();
    FramePtr frame_ = newFrame();
    std::vector<float> ready_;    // stereo
    std::size_t taken_ = 0;       // samples of `ready_` that were delivered or dropped
    std::int64_t next_ = 0;       // position of the sample to deliver next
    std::int64_t readyStart_ = 0; // position of ready_[0]
    bool isPlaced_ = false;       // readyStart_ is known
    bool sentEnd_ = false;
    bool ended_ = false;
};

AudioReader::Impl::Impl(const fs::path& path, const AudioReaderOptions& options)
    : rate_(options.sampleRate) {
    checkTime("from", options.from);
    check(rate_ >= 4000 && rate_ <= 384000, "sampleRate",
          "is " + std::to_string(rate_) + ", expected 4000..384000");
    openContainer(input_, path, {});
    open(options.stream);
    if (options.from > 0) seek(options.from);
}

void AudioReader::Impl::open(int wanted) {
    AVFormatContext& file = *input_.format;
    const int index =
        wanted >= 0 ? wanted : av_find_best_stream(&file, AVMEDIA_TYPE_AUDIO, -1, -1, nullptr, 0);
    if (wanted < 0 && index < 0)
        throw Error(ErrorCode::BadFormat, input_.subject, "holds no sound that can be decoded");
    if (index >= static_cast<int>(file.nb_streams) ||
        file.streams[index]->codecpar->codec_type != AVMEDIA_TYPE_AUDIO) {
        throw Error(ErrorCode::BadFormat, input_.subject,
                    "has no sound in stream " + std::to_string(index));
    }
    stream_ = file.streams[index];
    const AVCodecParameters& parameters = *stream_->codecpar;
    const AVCodec* const codec = avcodec_find_decoder(parameters.codec_id);
    const std::string name = avcodec_get_name(parameters.codec_id);
    if (input_.encrypted.count(index) > 0)
        throw Error(ErrorCode::Unsupported, input_.subject, "has sound that is encrypted");
    if (codec == nullptr) {
        throw Error(ErrorCode::Unsupported, input_.subject,
                    "has sound of the codec " + name + ", which this FFmpeg cannot decode");
    }
    decoder_ = newDecoder(codec, parameters, stream_->time_base);
    decoder_->thread_count = 1;
    if (const int result = avcodec_open2(decoder_.get(), codec, nullptr); result < 0) {
        throw Error(ErrorCode::Unsupported, input_.subject,
                    "has sound of the codec " + name +
                        ", which cannot be decoded: " + ffmpegText(result));
    }
    for (unsigned i = 0; i < file.nb_streams; ++i) {
        if (file.streams[i] != stream_) file.streams[i]->discard = AVDISCARD_ALL;
    }
}

void AudioReader::Impl::restart() {
    avcodec_flush_buffers(decoder_.get());
    resampler_.reset();
    format_ = {};
    ready_.clear();
    taken_ = 0;
    isPlaced_ = sentEnd_ = ended_ = false;
}

void AudioReader::Impl::seek(double seconds) {
    checkTime("seconds", seconds);
    const std::int64_t target = std::llround(seconds * rate_);
    // A container may seek past the time; then the search starts further back.
    for (const double back : kStepsBackSeconds) {
        if (seconds <= back) break;
        goBack(seconds - back);
        next_ = target;
        if (!decode() || readyStart_ <= target) return;
    }
    goBack(0);
    next_ = target;
}

// Where seeking fails at any time but the start, everything is read from the start.
void AudioReader::Impl::goBack(double seconds) {
    AVFormatContext& file = *input_.format;
    const std::int64_t start = file.start_time != AV_NOPTS_VALUE ? file.start_time : 0;
    const std::int64_t goal = start + std::llround(seconds * AV_TIME_BASE);
    if (seconds > 0 && avformat_seek_file(&file, -1, INT64_MIN, goal, goal, 0) >= 0) {
        restart();
        return;
    }
    if (avformat_seek_file(&file, -1, INT64_MIN, INT64_MIN, INT64_MAX, 0) < 0 &&
        avformat_seek_file(&file, -1, INT64_MIN, start, INT64_MAX, 0) < 0) {
        throw Error(ErrorCode::ReadFailed, input_.subject,
                    "cannot seek in its sound, expected a file with an index");
    }
    restart();
}

// Passes the next packet or the end to the decoder; false if the end was passed before.
bool AudioReader::Impl::feed() {
    if (sentEnd_) return false;
    for (;;) {
        av_packet_unref(packet_.get());
        if (av_read_frame(input_.format.get(), packet_.get()) < 0) { // also a file that is cut off
            sentEnd_ = true;
            avcodec_send_packet(decoder_.get(), nullptr);
            return true;
        }
        if (packet_->stream_index != stream_->index || packet_->size == 0) continue;
        if (avcodec_send_packet(decoder_.get(), packet_.get()) == AVERROR(ENOMEM))
            checkMemory(nullptr);
        return true; // the decoder skips a damaged packet
    }
}

// Decodes until samples are ready; false at the end.
bool AudioReader::Impl::decode() {
    while (!ended_) {
        const int result = avcodec_receive_frame(decoder_.get(), frame_.get());
        if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
        if (result == AVERROR(EAGAIN)) {
            if (feed()) continue;
            ended_ = true;
        } else if (result == AVERROR_EOF) {
            ended_ = true;
        } else if (result < 0 || frame_->nb_samples <= 0 || frame_->sample_rate <= 0) {
            continue;
        }
        if (ended_) {
            if (!resampler_) return false;
            readyStart_ += static_cast<std::int64_t>(ready_.size() / 2);
            resample(nullptr); // what the resampler still holds
        } else {
            place(*frame_);
            resample(frame_.get());
        }
        if (!ready_.empty()) return true;
    }
    return false;
}

// Sets the position of a frame's samples: they follow those before, unless the file says otherwise.
void AudioReader::Impl::place(const AVFrame& given) {
    makeResampler(given);
    const std::int64_t follows = readyStart_ + static_cast<std::int64_t>(ready_.size() / 2);
    const std::int64_t pts = given.best_effort_timestamp;
    readyStart_ = isPlaced_ ? follows : next_;
    if (isNear(pts)) {
        const double time = static_cast<double>(pts) * av_q2d(stream_->time_base) -
                            startSeconds(*input_.format) -
                            static_cast<double>(swr_get_delay(resampler_.get(), rate_)) / rate_;
        const bool jumps = std::abs(time - static_cast<double>(follows) / rate_) > kJump;
        if (std::abs(time) < kLatestSeconds && (!isPlaced_ || jumps))
            readyStart_ = std::llround(time * rate_);
    }
    isPlaced_ = true;
}

void AudioReader::Impl::makeResampler(const AVFrame& given) {
    const Format wanted{given.sample_rate, given.format, given.ch_layout.nb_channels};
    if (resampler_ && wanted == format_) return;
    if (given.sample_rate < kMinFileRate || given.sample_rate > kMaxFileRate) {
        throw Error(ErrorCode::Unsupported, input_.subject,
                    "has sound of " + std::to_string(given.sample_rate) +
                        " samples per second, expected 1000..768000");
    }
    AVChannelLayout stereo{};
    AVChannelLayout own{};
    av_channel_layout_default(&stereo, 2);
    if (av_channel_layout_check(&given.ch_layout) == 1 &&
        given.ch_layout.order != AV_CHANNEL_ORDER_UNSPEC) {
        checkRoom(av_channel_layout_copy(&own, &given.ch_layout));
    } else {
        av_channel_layout_default(&own, given.ch_layout.nb_channels);
    }
    SwrContext* made = nullptr;
    const int set = swr_alloc_set_opts2(&made, &stereo, AV_SAMPLE_FMT_FLT, rate_, &own,
                                        static_cast<AVSampleFormat>(given.format),
                                        given.sample_rate, 0, nullptr);
    av_channel_layout_uninit(&own);
    resampler_.reset(made);
    if (set < 0 || swr_init(made) < 0) {
        resampler_.reset();
        throw Error(ErrorCode::Unsupported, input_.subject,
                    "has sound of " + std::to_string(wanted[2]) +
                        " channels, which cannot be mixed to stereo");
    }
    format_ = wanted;
}

// Replaces `ready_`, all of which has been used.
void AudioReader::Impl::resample(const AVFrame* given) {
    const int room =
        swr_get_out_samples(resampler_.get(), given != nullptr ? given->nb_samples : 0);
    ready_.resize(static_cast<std::size_t>(std::max(room, 0)) * 2);
    auto* out = reinterpret_cast<std::uint8_t*>(ready_.data());
    const int made = swr_convert(
        resampler_.get(), &out, std::max(room, 0),
        given != nullptr ? const_cast<const std::uint8_t**>(given->extended_data) : nullptr,
        given != nullptr ? given->nb_samples : 0);
    if (made == AVERROR(ENOMEM)) checkMemory(nullptr);
    ready_.resize(static_cast<std::size_t>(std::max(made, 0)) * 2);
    taken_ = 0;
}

std::size_t AudioReader::Impl::read(float* samples, std::size_t count) {
    std::size_t done = 0;
    while (done < count) {
        if (taken_ * 2 >= ready_.size() && !decode()) break;
        const std::int64_t at = readyStart_ + static_cast<std::int64_t>(taken_);
        const std::size_t left = ready_.size() / 2 - taken_;
        if (at < next_) { // before the wanted time
            taken_ += std::min(left, static_cast<std::size_t>(next_ - at));
            continue;
        }
        const bool isGap = at > next_;
        const std::size_t here =
            std::min(count - done, isGap ? static_cast<std::size_t>(at - next_) : left);
        float* const to = samples + 2 * done;
        if (isGap) {
            std::fill_n(to, 2 * here, 0.F);
        } else {
            std::copy_n(ready_.data() + 2 * taken_, 2 * here, to);
            taken_ += here;
        }
        done += here;
        next_ += static_cast<std::int64_t>(here);
    }
    return done;
}

AudioReader::AudioReader(const fs::path& path, const AudioReaderOptions& options)
    : impl_(std::make_unique<Impl>(path, options)) {}
AudioReader::~AudioReader() = default;
AudioReader::AudioReader(AudioReader&&) noexcept = default;
AudioReader& AudioReader::operator=(AudioReader&&) noexcept = default;

std::size_t AudioReader::read(float* samples, std::size_t count) {
    return impl_->read(samples, count);
}

void AudioReader::seek(double seconds) {
    impl_->seek(seconds);
}

} // namespace altiro3D
