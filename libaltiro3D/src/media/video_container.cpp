#include "media/video_container.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>

extern "C" {
#include <libavutil/stereo3d.h>
}

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// FFmpeg's name of the container for a file name, or null.
const char* containerName(const fs::path& path) {
    const std::string extension = lowerExtension(path);
    if (extension == ".mkv" || path == "-") return "matroska";
    if (extension == ".mp4" || extension == ".m4v") return "mp4";
    if (extension == ".mov") return "mov";
    return nullptr;
}

// Says in the stream how its frames show both eyes. FFmpeg writes some layouts to MP4, none to MOV.
void markEyes(EyesPicture picture, AVFormatContext& output, AVStream& stream) {
    AVStereo3D mark{};
    mark.type = picture == EyesPicture::Rows           ? AV_STEREO3D_LINES
                : picture == EyesPicture::Columns      ? AV_STEREO3D_COLUMNS
                : picture == EyesPicture::Checkerboard ? AV_STEREO3D_CHECKERBOARD
                : picture == EyesPicture::TopBottom || picture == EyesPicture::TopBottomHalf
                    ? AV_STEREO3D_TOPBOTTOM
                    : AV_STEREO3D_SIDEBYSIDE;
    if (picture == EyesPicture::Crossed) mark.flags = AV_STEREO3D_FLAG_INVERT;
    if (isMatroska(*output.oformat)) { // it states the size at which one eye is displayed
        const bool isWide = picture == EyesPicture::SideBySideHalf;
        if (isWide || picture == EyesPicture::TopBottomHalf) {
            stream.sample_aspect_ratio = isWide ? AVRational{2, 1} : AVRational{1, 2};
            stream.codecpar->sample_aspect_ratio = stream.sample_aspect_ratio;
        }
    }
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 31, 102)
    AVCodecParameters& coded = *stream.codecpar;
    AVPacketSideData* const side = av_packet_side_data_new(
        &coded.coded_side_data, &coded.nb_coded_side_data, AV_PKT_DATA_STEREO3D, sizeof mark, 0);
    std::uint8_t* const bytes = side == nullptr ? nullptr : side->data;
#else
    std::uint8_t* const bytes = av_stream_new_side_data(&stream, AV_PKT_DATA_STEREO3D, sizeof mark);
#endif
    checkMemory(bytes);
    std::memcpy(bytes, &mark, sizeof mark);
    output.strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL; // without it, MP4 leaves the mark out
}

} // namespace

PartFile::PartFile(const fs::path& path) : path_(path), target_(followLinks(path)) {
    if (path == "-") {
        path_ = "standard output";
        if (const int result = avio_open(&io_, "pipe:1", AVIO_FLAG_WRITE); result < 0) fail(result);
        return;
    }
    if (!target_.has_filename()) failWrite(path, EISDIR);
    if (const std::string problem = nameProblem(target_); !problem.empty())
        throw Error(ErrorCode::WriteFailed, path.string(), problem + ", expected another name");
    const FileState state = stateOf(target_);
    if (!state.exists() && state.error != ENOENT) failWrite(path, state.error);
    if (state.exists() && state.isDirectory())
        throw Error(ErrorCode::WriteFailed, path.string(), "is a directory, expected a file name");
    if (state.exists() && !state.isRegular()) {
        throw Error(ErrorCode::WriteFailed, path.string(),
                    "is a device or pipe, expected a file name: a video is written out of order");
    }
    // A writable directory would let the rename replace a write-protected file.
    if (const int error = state.exists() ? checkWritable(target_) : 0) failWrite(path, error);

    part_ = besideName(target_, ".part");
    // A part left by a crash is overwritten; a part that is being written is locked.
    for (;;) {
        file_ = openFile(part_, OpenFor::Part);
        if (!file_.isOpen()) failWrite(path, errno);
        if (!lockFile(file_)) {
            throw Error(ErrorCode::WriteFailed, path.string(),
                        "is being written by another process (" + part_.filename().string() + ")");
        }
        // Another writer may have renamed it between the two steps.
        const FileState named = stateOf(part_);
        const FileState opened = stateOf(file_);
        if (named.exists() && opened.exists() && named.id == opened.id) break;
    }
    if (const int result = avio_open(&io_, ("file:" + part_.string()).c_str(), AVIO_FLAG_WRITE);
        result < 0) { // else it is empty now
        close();
        fail(result);
    }
    if (state.exists()) {
        // If this is not allowed, the new file keeps the default permissions.
        [[maybe_unused]] const int ignored = takeOwnerAndMode(file_, state);
    }
}

PartFile::~PartFile() {
    close();
}

void PartFile::close() {
    avio_closep(&io_);
    if (!file_.isOpen()) return;
    std::error_code ignored;
    fs::remove(part_, ignored);
    file_.close();
}

void PartFile::fail(int result) const {
    throw Error(ErrorCode::WriteFailed, path_.string(), "cannot be written: " + ffmpegText(result));
}

void PartFile::check() const {
    if (io_->error < 0) fail(io_->error);
}

void PartFile::finish() {
    avio_flush(io_);
    check();
    if (!file_.isOpen()) { // standard output
        if (const int result = avio_closep(&io_); result < 0) fail(result);
        return;
    }
    if (const int error = flushFile(file_)) failWrite(path_, error);
    if (const int result = avio_closep(&io_); result < 0) fail(result);
    // Closed only after the rename, because closing releases the lock against other writers.
    if (const int error = moveFile(part_, target_)) failWrite(path_, error);
    flushDirectoryOf(target_);
    if (const int error = file_.close()) failWrite(path_, error);
}

bool canWriteVideo(const fs::path& path) {
    return path != "-" && containerName(path) != nullptr;
}

VideoContainer::VideoContainer(const fs::path& path) : path_(path) {
    const char* const container = containerName(path);
    if (container == nullptr) {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "has a name that no video container here has, expected .mkv, .mp4 or .mov");
    }
    output_ = newOutput(nullptr, container);
}

bool VideoContainer::canHold(const VideoWriterOptions& options,
                             const std::shared_ptr<OtherStreams>& source) {
    AVStream& pictures = newStream(*output_);
    pictures.codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
    pictures.codecpar->codec_id = AV_CODEC_ID_H264; // stands for any codec that the kind holds
    pictures.codecpar->width = pictures.codecpar->height = 16;
    pictures.time_base = {1, 1000};
    try {
        Notes notes;
        const StreamCopier trial(source, *output_, path_.string(), options, notes);
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
    // Sound may begin slightly before 0, for its decoder. Times are not shifted for this.
    output.avoid_negative_ts = AVFMT_AVOID_NEG_TS_DISABLED;
    stream_ = &newStream(output);
    checkRoom(avcodec_parameters_copy(stream_->codecpar, &pictures));
    timeBase_ = rational(options.timeBase);
    stream_->time_base = timeBase_;
    stream_->sample_aspect_ratio = rational(options.sampleAspect);
    stream_->disposition = AV_DISPOSITION_DEFAULT;
    if (options.constantRate) stream_->avg_frame_rate = rational(options.frameRate);
    if (options.eyes && !isAnaglyph(*options.eyes)) markEyes(*options.eyes, output, *stream_);
    if (source)
        copier_ = std::make_unique<StreamCopier>(source, output, path_.string(), options, notes);
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
