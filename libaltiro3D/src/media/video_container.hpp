#pragma once

#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "base/system_file.hpp"
#include "media/ffmpeg.hpp"
#include "media/other_streams.hpp"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

namespace altiro3D {

/// A file that FFmpeg writes as `<name>.part` beside its target and that is renamed to it at the
/// end; or standard output, which "-" stands for.
class PartFile {
  public:
    /// @throws Error WriteFailed (a directory, not a regular file, no permission, another writer)
    explicit PartFile(const std::filesystem::path& path);
    /// Removes the part unless it was finished.
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    AVIOContext* io() { return io_; }
    /// Empty for standard output.
    const std::filesystem::path& partPath() const { return part_; }

    /// Throws the error of the first failed write, if any. @throws Error WriteFailed
    void check() const;
    /// Flushes to the disk and renames. @throws Error WriteFailed
    void finish();

  private:
    [[noreturn]] void fail(int result) const;
    void close();

    std::filesystem::path path_;   // as given, for errors
    std::filesystem::path target_; // without links
    std::filesystem::path part_;
    FileHandle file_; // holds the lock
    AVIOContext* io_ = nullptr;
};

/// A video file being written: encoded pictures, and the other streams of the source video.
/// Pictures come from an encoder or from other files. All functions throw Error WriteFailed.
class VideoContainer {
  public:
    /// @throws Error Unsupported (the extension)
    explicit VideoContainer(const std::filesystem::path& path);

    const AVOutputFormat& kind() const { return *output_->oformat; }
    bool isMatroska() const { return altiro3D::isMatroska(kind()); }

    /// Whether it can hold the streams of the source that are wanted. The trial uses it up: it
    /// cannot be opened afterwards.
    bool canHold(const VideoWriterOptions& options, const std::shared_ptr<OtherStreams>& source);

    /// Begins the file.
    /// @param options times, tags and which of the other streams are wanted
    /// @param source the other streams; may be null
    /// @param notes receives what is left out
    /// @throws Error Unsupported (what this container does not support), WriteFailed
    void open(const AVCodecParameters& pictures, const VideoWriterOptions& options,
              const std::shared_ptr<OtherStreams>& source, Notes& notes);

    /// Longest time from one picture to the next, s: MP4 and MOV store it in 32 bits. For open
    /// files.
    double longestPause() const {
        constexpr double kLongest = 1e11; // some 3000 years
        constexpr int kMostTicks = std::numeric_limits<std::int32_t>::max();
        return isMatroska() ? kLongest : kMostTicks * av_q2d(stream_->time_base);
    }

    /// Writes an encoded picture, times in the options' time base. Takes the packet's reference.
    void write(AVPacket& packet);
    /// Writes the packets of the source's other streams before a time, in the options' time base.
    void copyOthers(std::optional<std::int64_t> before);
    bool sourceHasEnded() const { return copier_ && copier_->sourceHasEnded(); }
    /// Writes the remaining data and renames the file to its target.
    /// @param end end of the last picture in the options' time base; other streams end there unless
    ///        the source has been read to its end
    /// @param notes receives the number of damaged packets left out
    void finish(std::int64_t end, Notes& notes);

    /// Throws if a call of FFmpeg failed; the file is then lost.
    void checkWritten(int result);
    /// Throws if a write failed before.
    void checkUsable() const;

  private:
    void checkPacket(int result);

    std::filesystem::path path_;
    // Destroyed after the container that writes to it.
    std::unique_ptr<PartFile> file_;
    OutputPtr output_;
    AVStream* stream_ = nullptr;
    AVRational timeBase_{1, 1};
    std::unique_ptr<StreamCopier> copier_;
    std::int64_t picturesWritten_ = 0;
    std::int64_t refused_ = 0; // packets the container has refused
    bool failed_ = false;
};

} // namespace altiro3D
