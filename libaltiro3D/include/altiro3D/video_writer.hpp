#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_reader.hpp"
#include "altiro3D/video_types.hpp"

#include <filesystem>
#include <memory>

namespace altiro3D {

/// Writes frames as a video through FFmpeg's libraries, with sound, subtitles, chapters and tags of
/// the video they were made from.
///
/// Sound is copied packet by packet, all tracks; text subtitles become what the container holds
/// (mov_text in .mp4 and .mov), others are copied; fonts are copied into .mkv. Further video
/// streams, cover pictures and data streams are left out, see notes(). The source's rotation is not
/// written, as its reader has applied it.
///
/// Times are kept exactly in .mp4 and .mov, to 1 ms in .mkv. The file grows as `<name>.part` beside
/// the target and gets its name in finish(); without that it is removed. A file that exists is
/// replaced, links are followed. The same frames give the same bytes for a fixed number of threads
/// (H264, H264Rgb and Hevc) or any number (the others).
///
/// One thread at a time per object; the source's reader may run in another thread.
class ALTIRO3D_EXPORT VideoWriter {
  public:
    /// Opens the encoder and the file.
    ///
    /// @param path .mkv, .mp4, .m4v or .mov
    /// @param options size, codec, times
    /// @param source where the other streams come from; they pass while its frames are read, so it
    ///        must not have delivered a frame yet. It may end before the writer. May be null.
    /// @throws Error InvalidArgument (options, a source that has begun); Unsupported (what this
    ///         container or this FFmpeg cannot hold or encode, by name, with advice); WriteFailed
    VideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options,
                VideoReader* source = nullptr);
    /// Removes the unfinished file.
    ~VideoWriter();
    VideoWriter(VideoWriter&&) noexcept;            ///< Moves.
    VideoWriter& operator=(VideoWriter&&) noexcept; ///< Moves. @return *this

    /// Encodes a frame.
    ///
    /// @param frame picture [options' size, CV_8UC3, BGR]; times in the options' time base, pts 0
    ///        or more and after the last one's
    /// @throws Error InvalidArgument (picture, time, after finish()): the frame is left out;
    ///         WriteFailed (full disk, ...): the file is then lost
    void write(const VideoFrame& frame);

    /// Writes what is left and gives the file its name. If the source has been read to its end all
    /// of its other streams are kept, else what belongs to the frames written.
    ///
    /// @throws Error InvalidArgument (no frame was written, a second call); WriteFailed: the file
    ///         is then lost
    void finish();

    /// What was left out or changed. @return one sentence each, for people
    const Notes& notes() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
