#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_reader.hpp"
#include "altiro3D/video_types.hpp"

#include <filesystem>
#include <memory>

namespace altiro3D {

/// Writes frames as a video with FFmpeg's libraries, including sound, subtitles, chapters and tags
/// of the source video.
///
/// All sound tracks are copied packet by packet. Text subtitles are converted to the container's
/// format (mov_text in .mp4 and .mov); other subtitles are copied. Fonts are copied into .mkv.
/// Further video streams, cover pictures and data streams are left out, see notes(). The source's
/// rotation is not written, because its reader has applied it.
///
/// Times are exact in .mp4 and .mov and rounded to 1 ms in .mkv. The file is written as
/// `<name>.part` beside the target and renamed in finish(); without finish() it is removed. An
/// existing file is replaced, links are followed. The same frames give the same bytes, for H264,
/// H264Rgb and Hevc with a fixed number of threads, for the others with any number.
///
/// One thread at a time per object. The source's reader may run in another thread.
class ALTIRO3D_EXPORT VideoWriter {
  public:
    /// Opens the encoder and the file.
    ///
    /// @param path .mkv, .mp4, .m4v or .mov
    /// @param options size, codec, times
    /// @param source reader that supplies the other streams; may be null. They are copied while its
    ///        frames are read, so it must not have delivered a frame yet. It may be destroyed
    ///        before the writer.
    /// @throws Error InvalidArgument (options, a source that has delivered a frame); Unsupported
    ///         (names what this container or this FFmpeg does not support, with advice);
    ///         WriteFailed
    VideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options,
                VideoReader* source = nullptr);
    /// Removes the unfinished file.
    ~VideoWriter();
    VideoWriter(VideoWriter&&) noexcept;            ///< Moves.
    VideoWriter& operator=(VideoWriter&&) noexcept; ///< Moves. @return *this

    /// Encodes a frame.
    ///
    /// @param frame picture [options' size, CV_8UC3, BGR]; times in the options' time base; pts 0
    ///        or more and greater than that of the frame before
    /// @throws Error InvalidArgument (picture, time, after finish()): the frame is not written;
    ///         WriteFailed (full disk, ...): the file is lost
    void write(const VideoFrame& frame);

    /// Writes the remaining data and renames the file to its target. If the source was read to its
    /// end, its other streams are kept whole, else the part that belongs to the frames written.
    ///
    /// @throws Error InvalidArgument (no frame was written, a second call); WriteFailed: the file
    ///         is lost
    void finish();

    /// Remarks on what was left out or changed. @return one sentence each, for people
    const Notes& notes() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
