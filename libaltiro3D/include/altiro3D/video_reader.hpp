#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_frame.hpp"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

class OtherStreams;

/// How a video is opened.
struct VideoReaderOptions {
    double from = 0; ///< First time to deliver, s, 0 or more, less than 1e9.
    double to = std::numeric_limits<double>::infinity(); ///< Time to stop before, s, > from.
    int threads = 0;         ///< Threads that decode, 0..64; 0 = one per processor, at most 16.
    std::string format;      ///< FFmpeg's name of the format or device ("v4l2"); empty: found out.
    VideoTags formatOptions; ///< FFmpeg's settings of the format ("video_size", "1280x720").
};

/// Checks the options; `format` and its options only VideoReader can.
/// @param options what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const VideoReaderOptions& options);

/// What a stream of a video file holds.
enum class StreamKind { Video, Audio, Subtitle, Data, Attachment };

/// One stream of a video file.
struct VideoStreamFacts {
    int index = 0;                       ///< Place in the file, from 0.
    StreamKind kind = StreamKind::Video; ///< What it holds.
    std::string codec;                   ///< FFmpeg's name of the codec ("aac"), or "unknown".
    std::string language;                ///< Three letters ("eng") or empty.
    std::string title;                   ///< Its name, or empty.
    int channels = 0;                    ///< Audio channels.
    int sampleRate = 0;                  ///< Audio samples a second.
    bool isCover = false;                ///< A cover picture, not a video.
};

/// A chapter of a video.
struct VideoChapter {
    double start = 0;  ///< s from the start of the file.
    double end = 0;    ///< s from the start of the file.
    std::string title; ///< Its name, or empty.
};

/// What a video file says about itself. All times count from the start of the file, which may have
/// another number there.
struct VideoFacts {
    std::string format;          ///< FFmpeg's name of the container ("matroska,webm").
    std::string codec;           ///< FFmpeg's name of the video codec ("h264").
    std::string pixelFormat;     ///< FFmpeg's name of the pixel format ("yuv420p").
    bool isDevice = false;       ///< A capture device: what is not read in time is lost.
    int streamIndex = 0;         ///< Which stream is delivered.
    cv::Size size;               ///< Of the frames as delivered: upright.
    int rotationDegrees = 0;     ///< Clockwise turn that is applied to the stored pictures: 0..270.
    bool mirrored = false;       ///< The stored pictures are mirrored left to right after the turn.
    Fraction sampleAspect{1, 1}; ///< Width : height of a px of the upright picture.
    Fraction averageRate;        ///< Frames a second, over all.
    Fraction nominalRate;        ///< Smallest rate that all time stamps fit into.
    bool constantRate = false;   ///< The two rates agree.
    Fraction timeBase{1, 1};     ///< Unit of the frames' times, s.
    std::optional<double> duration;         ///< Of the file, s.
    std::optional<std::int64_t> frameCount; ///< Frames in the whole file: stated or estimated.
    VideoColour colour;                     ///< How colours are stored.
    std::vector<VideoStreamFacts> streams;  ///< All streams, the delivered one included.
    std::vector<VideoChapter> chapters;     ///< In the file's order.
    VideoTags tags;                         ///< Of the file.
};

/// What happened while reading, so far.
struct VideoReadCounts {
    std::int64_t frames = 0;        ///< Frames delivered.
    std::int64_t corrupt = 0;       ///< Packets and frames left out because they are damaged.
    std::int64_t repairedTimes = 0; ///< Frames whose time was missing or ran backwards.
    bool truncated = false;         ///< The file ended before its end.
};

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
    /// @param path a file that FFmpeg can read, `-` for the standard input, or a capture device
    ///        (`/dev/video0`)
    /// @param options the part to read, threads, format of a device
    /// @throws Error NotFound; ReadFailed (a directory, no permission); BadFormat (empty, no video
    ///         in it, cut off before its index); Unsupported (a codec without a decoder, an unknown
    ///         `format`); TooLarge (more px than kMaxPicturePixels); InvalidArgument (options);
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
