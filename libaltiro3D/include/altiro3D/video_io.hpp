#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D {

/// A ratio of whole numbers, such as 24000/1001; 0/1 = unknown.
struct Fraction {
    int numerator = 0;   ///< The numerator.
    int denominator = 1; ///< The denominator, > 0.

    /// The ratio as a number. @return numerator / denominator
    [[nodiscard]] double value() const { return static_cast<double>(numerator) / denominator; }
    /// Whether it is known. @return true if it is more than 0
    [[nodiscard]] bool isKnown() const { return numerator > 0 && denominator > 0; }
};

/// One picture of a video and its time. Times are whole numbers of the frames' time base
/// (VideoFacts::timeBase, VideoWriterOptions::timeBase), so they are exact.
struct VideoFrame {
    cv::Mat picture;           ///< [rows x cols, CV_8UC3, BGR], upright
    std::int64_t pts = 0;      ///< Time of display, in time bases from the start.
    std::int64_t duration = 0; ///< Duration of display, in time bases; 0 = unknown.
};

/// Matrix that converts red, green and blue to brightness and colour.
enum class ColourMatrix {
    Rgb,   ///< Stored as red, green and blue.
    Bt601, ///< ITU-R BT.601: standard definition.
    Bt709, ///< ITU-R BT.709: high definition.
    Bt2020 ///< ITU-R BT.2020 with non-constant luminance: ultra-high definition.
};

/// Values of black and white.
enum class ColourRange {
    Limited, ///< 16 and 235 (of 255), as in television.
    Full     ///< 0 and 255.
};

/// Colour encoding of a video stream.
struct VideoColour {
    ColourMatrix matrix = ColourMatrix::Bt709; ///< As stated in the file, else assumed.
    ColourRange range = ColourRange::Limited;  ///< As stated in the file, else assumed.
    bool stated = false;                       ///< The file states the matrix.
    int primaries = 2; ///< Code of the primaries in ISO/IEC 23091-2; 2 = not stated.
    int transfer = 2;  ///< Code of the transfer curve in ISO/IEC 23091-2; 2 = not stated.
};

/// Names and values of a file's tags ("title", "artist", ...), in the file's order.
using VideoTags = std::vector<std::pair<std::string, std::string>>;

/// Options to open a video.
struct VideoReaderOptions {
    double from = 0; ///< First time to deliver, s, 0 or more, less than 1e9.
    double to = std::numeric_limits<double>::infinity(); ///< Time to stop before, s, > from.
    int threads = 0;         ///< Decoder threads, 0..64; 0 = one per processor, at most 16.
    std::string format;      ///< FFmpeg's name of the format or device ("v4l2"); empty = detected.
    VideoTags formatOptions; ///< FFmpeg's options of the format ("video_size", "1280x720").
};

/// Checks the options except `format` and `formatOptions`, which VideoReader checks.
/// @param options the options to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const VideoReaderOptions& options);

/// Kind of a stream in a video file.
enum class StreamKind { Video, Audio, Subtitle, Data, Attachment };

/// One stream of a video file.
struct VideoStreamFacts {
    int index = 0;                       ///< Index in the file, from 0.
    StreamKind kind = StreamKind::Video; ///< Kind of the stream.
    std::string codec;                   ///< FFmpeg's name of the codec ("aac"), or "unknown".
    std::string language;                ///< Three letters ("eng") or empty.
    std::string title;                   ///< Its name, or empty.
    int channels = 0;                    ///< Audio channels.
    int sampleRate = 0;                  ///< Audio samples per second.
    bool isCover = false;                ///< A cover picture, not a video.
};

/// A chapter of a video.
struct VideoChapter {
    double start = 0;  ///< s from the start of the file.
    double end = 0;    ///< s from the start of the file.
    std::string title; ///< Its name, or empty.
};

/// Properties of a video file. All times count from the start of the file, even if the file's own
/// time stamps start at another value.
struct VideoFacts {
    std::string format;      ///< FFmpeg's name of the container ("matroska,webm").
    std::string codec;       ///< FFmpeg's name of the video codec ("h264").
    std::string pixelFormat; ///< FFmpeg's name of the pixel format ("yuv420p").
    bool isDevice = false;   ///< A capture device: frames not read in time are lost.
    int streamIndex = 0;     ///< Index of the stream that is delivered.
    cv::Size size;           ///< Of the frames as delivered: upright.
    int rotationDegrees = 0; ///< Clockwise rotation that is applied to the stored pictures, 0..270.
    bool mirrored = false;   ///< The stored pictures are mirrored left-right after the rotation.
    Fraction sampleAspect{1, 1};            ///< Width : height of a px of the upright picture.
    Fraction averageRate;                   ///< Average frames per second.
    Fraction nominalRate;                   ///< Lowest rate that can represent all time stamps.
    bool constantRate = false;              ///< The two rates agree.
    Fraction timeBase{1, 1};                ///< Unit of the frames' times, s.
    std::optional<double> duration;         ///< Of the file, s.
    std::optional<std::int64_t> frameCount; ///< Frames in the whole file: stated or estimated.
    VideoColour colour;                     ///< How colours are stored.
    std::vector<VideoStreamFacts> streams;  ///< All streams, the delivered one included.
    std::vector<VideoChapter> chapters;     ///< In the file's order.
    VideoTags tags;                         ///< Of the file.
};

/// Counts of what was read so far.
struct VideoReadCounts {
    std::int64_t frames = 0;        ///< Frames delivered.
    std::int64_t corrupt = 0;       ///< Packets and frames skipped because they are damaged.
    std::int64_t repairedTimes = 0; ///< Frames whose time was missing or not increasing.
    bool truncated = false;         ///< The file is cut off.
};

/// Names and values of settings; a run is resumed with the same ones only.
using RunSettings = std::map<std::string, std::string>;

/// What a later run needs to go on; the bytes mean something to the function that takes them back
/// only.
struct SavedState {
    std::string bytes; ///< Empty: there is none.
};

/// How far a video is.
struct VideoProgress {
    std::int64_t frames = 0;     ///< Frames that are made, those of an earlier run included.
    std::int64_t keptFrames = 0; ///< Of these, frames of an earlier run.
    double end = 0;              ///< Where they end, s from the beginning of the part.
    std::optional<std::int64_t> framesInAll; ///< Frames to be made, as far as known.
    std::optional<double> length;            ///< Length of the part, s, as far as known.
    bool finishing = false; ///< All frames are with the encoder; the file is being closed.
};

/// Takes the progress and says whether to go on.
using VideoProgressFunction = std::function<bool(const VideoProgress& progress)>;

/// Encoding of the frames. In a Native, neighbouring sub-pixels belong to different views, so all
/// codecs keep the colour of every px, except with VideoWriterOptions::compatible.
enum class VideoCodec {
    H264,    ///< H.264 High 4:4:4 Predictive, libx264: .mkv .mp4 .mov
    H264Rgb, ///< H.264 of red, green and blue, libx264rgb: .mkv .mp4 .mov
    Hevc,    ///< H.265 4:4:4, libx265: .mkv .mp4 .mov
    Ffv1,    ///< Lossless FFV1: .mkv
    ProRes   ///< ProRes 4444, 10 bits: .mkv .mov
};

/// Effort of libx264 and libx265: a slower preset makes a smaller file of the same quality.
enum class EncoderPreset {
    UltraFast,
    SuperFast,
    VeryFast,
    Faster,
    Fast,
    Medium,
    Slow,
    Slower,
    VerySlow
};

/// Options to write a video.
struct VideoWriterOptions {
    cv::Size size;                       ///< Size of all frames, px, 16..16384 per side.
    VideoCodec codec = VideoCodec::H264; ///< See VideoCodec.
    /// 4:2:0 for players that support nothing else (H264 and Hevc); even sides only. It blends the
    /// views of a Native.
    bool compatible = false;
    double crf = 16; ///< Quality of H264, H264Rgb, Hevc, 0..51; lower is better.
    EncoderPreset preset = EncoderPreset::SuperFast; ///< Of H264, H264Rgb and Hevc.
    Fraction timeBase{1, 1000};                      ///< Unit of the frames' times, s.
    Fraction frameRate;          ///< Frames per second, may be approximate; 0/1 = unknown.
    bool constantRate = false;   ///< frameRate holds for every frame.
    Fraction sampleAspect{1, 1}; ///< Width : height of a px.
    /// Colour matrix. By default, from 720 lines on BT.709, or BT.2020 if the source has it; below
    /// 720 lines the source's, or BT.601. RGB codecs have no matrix.
    std::optional<ColourMatrix> matrix;
    std::optional<ColourRange> range;  ///< Default: limited. RGB codecs are always full.
    std::optional<VideoColour> colour; ///< Of the source; default: from its reader, if given.
    int threads = 0;   ///< Encoder threads, 0..64; 0 = one per processor. The bytes depend on it.
    bool audio = true; ///< Copy the source's sound.
    bool subtitles = true; ///< Copy or convert the source's subtitles.
    bool chapters = true;  ///< Copy the source's chapters.
    bool metadata = true;  ///< Copy the source's tags.
    VideoTags tags;        ///< Further tags of the file; they override the source's.
};

/// Checks the options.
/// @param options the options to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const VideoWriterOptions& options);

/// Whether VideoWriter can write the extension of a file name: .mkv, .mp4, .m4v or .mov.
/// @param path file name; the file is not accessed
/// @return true if it is
[[nodiscard]] ALTIRO3D_EXPORT bool canWriteVideo(const std::filesystem::path& path);

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
    [[nodiscard]] const VideoFacts& facts() const;

    /// The next frame, in memory of its own.
    ///
    /// @return the frame, its times in facts().timeBase; nothing at the end
    /// @throws Error ReadFailed, BadFormat (not one frame could be decoded), Unsupported (a pixel
    ///         format that cannot be read), OutOfMemory
    [[nodiscard]] std::optional<VideoFrame> next();

    /// next() into a frame whose memory is used again if it fits and nobody else holds it.
    ///
    /// @param frame becomes the next one: picture [facts().size, CV_8UC3, BGR], times in
    ///        facts().timeBase
    /// @return false at the end; the frame is then as before
    /// @throws Error as next()
    [[nodiscard]] bool read(VideoFrame& frame);

    /// How many frames of the video `VideoReaderOptions::from` leaves out. They are counted, as a
    /// rate need not be constant: by the packets of a file, which is quick, or, where packets do
    /// not tell, by decoding from the start. To be called before the first frame is read.
    ///
    /// @return the first frame's number in the whole video, from 0
    /// @throws Error InvalidArgument (a frame has been read), and as next()
    [[nodiscard]] std::int64_t framesBefore();

    /// Leaves out frames, so that the next one is the one of a time, as a run that is resumed needs
    /// it. Fast where the file can be wound, and counts() then begin anew; times stay as they are.
    /// A writer that was given this reader gets the other streams from there on only.
    ///
    /// @param pts of the next frame in facts().timeBase, as next() gave it in an earlier run;
    ///        without such a frame the first later one comes
    /// @throws Error as next()
    void skipTo(std::int64_t pts);

    /// What happened so far. @return counts from the beginning, or from where skipTo() has wound to
    [[nodiscard]] const VideoReadCounts& counts() const;

    /// Remarks about the file and what happened so far.
    /// @return one sentence each, for people; the first one tells of the cut where
    ///         `counts().truncated`
    [[nodiscard]] Notes notes() const;

  private:
    friend class VideoWriter;
    friend class ResumableVideoWriter;
    [[nodiscard]] std::shared_ptr<OtherStreams> otherStreams() const;
    bool pass(std::int64_t until); // the other streams only; false at the end

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

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
    [[nodiscard]] const Notes& notes() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// How a video is written so that a run that dies can go on.
struct ResumableVideoOptions {
    int segmentFrames = 60; ///< Frames that are kept at a time, 1..100000: what a dying run loses.
    bool resume = false;    ///< Go on where an earlier run ended, if there is one.
    RunSettings settings;   ///< Everything that shapes the frames.
};

/// What an earlier run has left.
struct KeptVideo {
    std::int64_t frames = 0;  ///< Frames that are written already.
    std::int64_t nextPts = 0; ///< Time of the next one, in the options' time base.
    SavedState state;         ///< What the caller gave with the last of them.
};

/// Writes a video in segments that outlive the process, and joins them in the end without encoding
/// again. A run that is resumed gives the same bytes as one that was not interrupted.
///
/// Beside `NAME` a directory `NAME.parts` holds the segments (each of them plays) and `run.json`,
/// which lists them; it goes when the file is complete. The other streams of the source are copied
/// when the segments are joined.
///
/// One thread at a time per object, one process at a time per name.
class ALTIRO3D_EXPORT ResumableVideoWriter {
  public:
    /// Begins or resumes a run.
    ///
    /// @param path .mkv, .mp4, .m4v or .mov
    /// @param options as for VideoWriter
    /// @param resumable see ResumableVideoOptions
    /// @param source the video that the frames are made from, opened for this call only: what the
    ///        file cannot hold of it is said before any work is done; may be null
    /// @throws Error as VideoWriter; InvalidArgument (segmentFrames); WriteFailed (`NAME.parts` is
    /// there and `resume` is not set, or another
    ///         process is at it); Mismatch (other settings, by name); BadFormat (what is in
    ///         `NAME.parts`)
    ResumableVideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options,
                         const ResumableVideoOptions& resumable, VideoReader* source = nullptr);
    /// Keeps all whole segments; without any, nothing stays.
    ~ResumableVideoWriter();
    ResumableVideoWriter(ResumableVideoWriter&&) noexcept;            ///< Moves.
    ResumableVideoWriter& operator=(ResumableVideoWriter&&) noexcept; ///< Moves. @return *this

    /// Where a video's segments are.
    /// @param path of the video
    /// @return `path` + ".parts"
    [[nodiscard]] static std::filesystem::path partsDirectory(const std::filesystem::path& path);

    /// Whether an earlier run has left something to go on from.
    /// @param path of the video
    /// @return true if there is a `run.json` in `NAME.parts`
    [[nodiscard]] static bool isUnfinished(const std::filesystem::path& path);

    /// Removes what an earlier run has left; without an unfinished run nothing is done.
    /// @param path of the video
    /// @throws Error WriteFailed (another process is at it, no permission)
    static void discard(const std::filesystem::path& path);

    /// What was there at the beginning. @return 0 frames if the run is new
    [[nodiscard]] const KeptVideo& kept() const;
    /// Whether there is something that a later run can go on from.
    /// @return true if a segment is whole and the video is not complete
    [[nodiscard]] bool keepsWork() const;
    /// Whether a segment ends with a frame; write() keeps a state with such frames only.
    /// @param frameNumber number of the frame, from 0, over all runs
    /// @return true if it does
    [[nodiscard]] bool endsSegment(std::int64_t frameNumber) const;

    /// Encodes a frame.
    ///
    /// @param frame as for VideoWriter; the first one's pts is kept().nextPts or more
    /// @param state what is needed to make the next frame, if this one ends a segment
    /// @throws Error InvalidArgument (picture, time, after finish()), WriteFailed; whole segments
    ///         stay
    void write(const VideoFrame& frame, const SavedState& state = {});

    /// Joins all segments and gives the file its name.
    ///
    /// @param source the video that the frames were made from, opened anew for this call; may be
    ///        null
    /// @param complete false: more frames could follow; then the segments stay, so that a later run
    ///        can go on
    /// @throws Error InvalidArgument (no frame was written, a second call, a source that has
    ///         begun), BadFormat (a damaged segment), Unsupported, WriteFailed, and what reading
    ///         the source throws
    void finish(VideoReader* source, bool complete = true);

    /// What was left out or changed. @return one sentence each, for people
    [[nodiscard]] const Notes& notes() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
