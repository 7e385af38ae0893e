#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_types.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

namespace altiro3D {

class OtherStreams;

/// Reads the frames of a video through FFmpeg's libraries.
///
/// Frames come upright (the rotation that the file asks for is applied), as 8-bit BGR, with the
/// matrix and range that the stream states; where it states none BT.601 holds up to 576 lines and
/// BT.709 above. Values of more than 8 bits are rounded; HDR is not tone-mapped; interlaced
/// pictures stay as they are; `notes()` says so. Of several video streams the largest one counts.
///
/// Times count from the start of the file, or from `VideoReaderOptions::from`, so the first frame's
/// pts is 0 or more. A damaged frame is left out and counted, the one before stays longer. A file
/// that is cut off delivers what is there.
///
/// FFmpeg's own messages to stderr are turned off for the process, unless it has set
/// `av_log_set_level()` itself. One thread at a time per object.
class ALTIRO3D_EXPORT VideoReader {
  public:
    /// Opens a video.
    ///
    /// @param path a file that FFmpeg can read, `-` for the standard input, or a capture device:
    ///        without a stated format any character device (`/dev/video0`), also by a link
    /// @param options the part to read, threads, format of a device
    /// @throws Error NotFound; ReadFailed (a directory, no permission); BadFormat (empty, no video
    ///         in it, cut off before its index); Unsupported (a codec without a decoder, an unknown
    ///         `format`); TooLarge (more px than kMaxImagePixels); InvalidArgument (options);
    ///         OutOfMemory
    explicit VideoReader(const std::filesystem::path& path, const VideoReaderOptions& options = {});
    ~VideoReader();
    VideoReader(VideoReader&&) noexcept;            ///< Moves.
    VideoReader& operator=(VideoReader&&) noexcept; ///< Moves. @return *this

    /// What the file says about itself. @return the facts, the same all the time
    const VideoFacts& facts() const;

    /// The next frame, in memory of its own.
    ///
    /// @return the frame, its times in facts().timeBase; nothing at the end
    /// @throws Error ReadFailed, BadFormat (not one frame could be decoded), Unsupported (a pixel
    ///         format that cannot be read), OutOfMemory
    std::optional<VideoFrame> next();

    /// next() into a frame whose memory is used again if it fits and nobody else holds it.
    ///
    /// @param frame becomes the next one: picture [facts().size, CV_8UC3, BGR], times in
    ///        facts().timeBase
    /// @return false at the end; the frame is then as before
    /// @throws Error as next()
    bool read(VideoFrame& frame);

    /// How many frames of the video `VideoReaderOptions::from` leaves out. They are counted, as a
    /// rate need not be constant: by the packets of a file, which is quick, or, where packets do
    /// not tell, by decoding from the start. To be called before the first frame is read.
    ///
    /// @return the first frame's number in the whole video, from 0
    /// @throws Error InvalidArgument (a frame has been read), and as next()
    std::int64_t framesBefore();

    /// Leaves out frames, so that the next one is the one of a time, as a run that is resumed needs
    /// it. Fast where the file can be wound, and counts() then begin anew; times stay as they are.
    /// A writer that was given this reader gets the other streams from there on only.
    ///
    /// @param pts of the next frame in facts().timeBase, as next() gave it in an earlier run;
    ///        without such a frame the first later one comes
    /// @throws Error as next()
    void skipTo(std::int64_t pts);

    /// What happened so far. @return counts from the beginning, or from where skipTo() has wound to
    const VideoReadCounts& counts() const;

    /// Remarks about the file and what happened so far.
    /// @return one sentence each, for people; the first one tells of the cut where
    ///         `counts().truncated`
    Notes notes() const;

  private:
    friend class VideoWriter;
    friend class ResumableVideoWriter;
    std::shared_ptr<OtherStreams> otherStreams() const;
    bool pass(std::int64_t until); // the other streams only; false at the end

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
