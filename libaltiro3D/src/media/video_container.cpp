#include "media/video_container.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// FFmpeg's name of the container for a file name, or null.
const char* containerName(const fs::path& path) {
    const std::string extension = lowerExtension(path);
    if (extension == ".mkv") return "matroska";
    if (extension == ".mp4" || extension == ".m4v") return "mp4";
    if (extension == ".mov") return "mov";
    return nullptr;
}

} // namespace

bool canWriteVideo(const fs::path& path) {
    return containerName(path) != nullptr;
}

VideoContainer::VideoContainer(const fs::path& path) : path_(path) {
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
}

std::unique_ptr<StreamCopier> VideoContainer::copierOf(const VideoWriterOptions& options,
                                                       const std::shared_ptr<OtherStreams>& source,
                                                       Notes& notes) {
    return std::make_unique<StreamCopier>(
        source, *output_, path_.string(),
        StreamCopier::Wanted{options.audio, options.subtitles, options.chapters, options.metadata},
        notes);
}

bool VideoContainer::canHold(const VideoWriterOptions& options,
                             const std::shared_ptr<OtherStreams>& source) {
    AVStream* const pictures = avformat_new_stream(output_.get(), nullptr);
    checkMemory(pictures);
    pictures->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
    pictures->codecpar->codec_id = AV_CODEC_ID_H264; // the others are held by any of them
    pictures->codecpar->width = pictures->codecpar->height = 16;
    pictures->time_base = {1, 1000};
    try {
        Notes notes;
        copierOf(options, source, notes);
        return true;
    } catch (const Error& error) {
        if (error.code() != ErrorCode::Unsupported) throw;
        return false;
    }
}

void VideoContainer::open(const AVCodecParameters& pictures, const VideoWriterOptions& options,
                          const std::shared_ptr<OtherStreams>& source, Notes& notes) {
    AVFormatContext& output = *output_;
    output.flags |= AVFMT_FLAG_BITEXACT;
    // Sound may begin slightly before 0, for the start of its decoder. Times are not shifted for
    // this.
    output.avoid_negative_ts = AVFMT_AVOID_NEG_TS_DISABLED;
    stream_ = avformat_new_stream(&output, nullptr);
    checkMemory(stream_);
    if (avcodec_parameters_copy(stream_->codecpar, &pictures) < 0) checkMemory(nullptr);
    timeBase_ = rational(options.timeBase);
    stream_->time_base = timeBase_;
    stream_->sample_aspect_ratio = rational(options.sampleAspect);
    stream_->disposition = AV_DISPOSITION_DEFAULT;
    if (options.constantRate) stream_->avg_frame_rate = rational(options.frameRate);
    if (source) copier_ = copierOf(options, source, notes);
    for (const auto& [name, value] : options.tags)
        av_dict_set(&output.metadata, name.c_str(), value.c_str(), 0);

    file_ = std::make_unique<PartFile>(path_);
    output.pb = file_->io();
    output.flags |= AVFMT_FLAG_CUSTOM_IO;
    // At the end, the index is moved to the front by reading the file again.
    const std::string url = "file:" + file_->partPath().string();
    av_freep(&output.url);
    output.url = av_strdup(url.c_str());
    checkMemory(output.url);
    Dictionary settings;
    if (!isMatroska()) settings.set("movflags", "+faststart");
    const int result = avformat_write_header(&output, settings.address());
    avio_flush(output.pb); // a full disk is reported now, not after the first block
    file_->check();
    if (result < 0) {
        throw Error(ErrorCode::Unsupported, path_.string(),
                    "cannot hold these streams together: " + ffmpegText(result) + ", expected " +
                        (isMatroska() ? "" : "a name that ends in .mkv, or ") +
                        "no sound, subtitles and chapters");
    }
}

void VideoContainer::checkUsable() const {
    if (failed_) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "cannot be written any further after a failure");
    }
}

void VideoContainer::checkWritten(int result) {
    if (result < 0) failed_ = true;
    if (file_) file_->check();
    if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
    if (result < 0) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "cannot be written: " + ffmpegText(result));
    }
}

// As checkWritten(), but tolerates damaged packets of the source's sound that the container
// refuses. The error may occur while another packet is written.
void VideoContainer::checkPacket(int result) {
    const bool refused = result == AVERROR_INVALIDDATA || result == AVERROR(EINVAL);
    if (copier_ && refused && refused_ <= picturesWritten_) {
        ++refused_;
        result = 0;
    }
    checkWritten(result);
}

void VideoContainer::write(AVPacket& packet) {
    av_packet_rescale_ts(&packet, timeBase_, stream_->time_base);
    packet.stream_index = stream_->index;
    packet.pos = -1;
    checkPacket(av_interleaved_write_frame(output_.get(), &packet));
    ++picturesWritten_;
}

void VideoContainer::copyOthers(std::optional<std::int64_t> before) {
    if (!copier_) return;
    for (int result = -1; result < 0;) {
        result = copier_->copy(before, timeBase_);
        checkPacket(result);
    }
}

void VideoContainer::finish(std::int64_t end, Notes& notes) {
    failed_ = true; // cleared on success: FFmpeg must not finish a file twice
    copyOthers(sourceHasEnded() ? std::nullopt : std::optional<std::int64_t>(end));
    // Flushes packets that wait for interleaving.
    for (int result = -1; result < 0;) {
        result = av_interleaved_write_frame(output_.get(), nullptr);
        checkPacket(result);
    }
    checkWritten(av_write_trailer(output_.get()));
    // The muxer counts the packets it has accepted for a stream.
    const std::int64_t lost = picturesWritten_ - stream_->nb_frames;
    if (refused_ > 0 && lost > 0) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "would lack " + std::to_string(lost) + " of " +
                        std::to_string(picturesWritten_) +
                        " pictures, which were refused as damaged");
    }
    file_->finish();
    failed_ = false;
    if (refused_ > 0) {
        notes.push_back(
            {NoteCode::Repaired, path_.string() + ": " + std::to_string(refused_) +
                                     (refused_ == 1 ? " damaged packet" : " damaged packets") +
                                     " of the source's sound or subtitles could not be kept"});
    }
}

} // namespace altiro3D
