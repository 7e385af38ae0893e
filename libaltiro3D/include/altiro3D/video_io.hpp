#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"

#include <cstddef>
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

/// A ratio of integers, such as 24000/1001; 0/1 = unknown.
struct Fraction {
    int numerator = 0;   ///< The numerator, >= 0.
    int denominator = 1; ///< The denominator, > 0.

    /// The ratio as a floating-point number. @return numerator / denominator
    [[nodiscard]] double value() const { return static_cast<double>(numerator) / denominator; }
    /// Whether the ratio is known. @return true if it is more than 0
    [[nodiscard]] bool isKnown() const { return numerator > 0 && denominator > 0; }
};

/// One picture of a video and its time. Times are integers that count units of a time base, so they
/// are exact: time in s = pts * timeBase.value(). The time base is VideoFacts::timeBase for frames
/// from a reader and VideoWriterOptions::timeBase for frames to a writer.
struct VideoFrame {
    cv::Mat picture;      ///< [rows x cols, CV_8UC3, BGR], upright; see VideoReaderOptions::isDepth
    std::int64_t pts = 0; ///< Time of display, in units of the time base, 0 or more. VideoReader
                          ///< counts it from the start of the file or of the part.
    std::int64_t duration = 0;   ///< Duration of display, in units of the time base; 0 = unknown.
    Fraction sampleAspect{1, 1}; ///< From a reader: width : height of a px.
};

/// Matrix that converts red, green and blue to luma and chroma.
enum class ColourMatrix {
    Rgb,   ///< Stored as red, green and blue.
    Bt601, ///< ITU-R BT.601: standard definition.
    Bt709, ///< ITU-R BT.709: high definition.
    Bt2020 ///< ITU-R BT.2020 with non-constant luminance: ultra-high definition.
};

/// Stored values of black and white.
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
    /// Start of the part to deliver, s from the start of the file, 0 or more, less than 1e9. The
    /// first frame delivered is the first one whose time is `from` or later.
    double from = 0;
    /// End of the part, s from the start of the file, > from; infinity: the end of the file. Frames
    /// whose time is `to` or later are not delivered.
    double to = std::numeric_limits<double>::infinity();
    int threads = 0;         ///< Decoder threads, 0..64; 0 = one per processor, at most 16.
    std::string format;      ///< FFmpeg's name of the format or device ("v4l2"); empty = detected.
    VideoTags formatOptions; ///< FFmpeg's options of the format ({{"video_size", "1280x720"}}).
    bool deinterlace = true; ///< Interpolate the lines that interlaced frames lack (bwdif).
    /// The pictures are depth: numbers are delivered as stored; alpha and colour encoding are
    /// ignored. Grey of more than 8 bits is delivered as CV_16UC1, scaled to 16 bits.
    bool isDepth = false;
    /// Deliver both eyes' pictures side by side, the left one first; VideoFacts::eyes then states
    /// the kind. This applies to spatial video (MV-HEVC; needs FFmpeg 7.1), videos whose frames
    /// show the eyes alternately, and files with a video for each eye (AVI of stereo cameras;
    /// titles with "left" and "right"). If false, only the left eye's pictures are delivered, and
    /// notes() says so.
    bool bothEyes = false;
    /// With `bothEyes`: the file holds a video for each eye, even if it does not say so.
    bool joinsVideos = false;
};

/// VideoFacts::eyes of spatial video that is read with VideoReaderOptions::bothEyes.
constexpr const char* kSpatialVideo = "spatial video";
/// VideoFacts::eyes of frames that show the eyes alternately; two frames are joined into one.
constexpr const char* kAlternateFrames = "frame alternate";
/// VideoFacts::eyes of a file with a video for each eye, if both are read.
constexpr const char* kTwoVideos = "two videos";

/// Checks the options except `format` and `formatOptions`; VideoReader checks these.
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
    std::string title;                   ///< Its title, or empty.
    int channels = 0;                    ///< Audio channels.
    int sampleRate = 0;                  ///< Audio samples per second.
};

/// A chapter of a video.
struct VideoChapter {
    double start = 0;  ///< s from the start of the file.
    double end = 0;    ///< s from the start of the file.
    std::string title; ///< Its title, or empty.
};

/// Properties of a video file, of the whole file even if only a part of it is read. All times count
/// from the start of the file, even if the file's own time stamps start at another value.
struct VideoFacts {
    std::string format;      ///< FFmpeg's name of the container ("matroska,webm").
    std::string codec;       ///< FFmpeg's name of the video codec ("h264").
    std::string pixelFormat; ///< FFmpeg's name of the pixel format ("yuv420p").
    bool isDevice = false;   ///< A capture device: frames not read in time are lost.
    /// Frames are delivered as they arrive and set the pace: a capture device, or pictures on the
    /// standard input (ppm_pipe, ...), which have no times. Their durations may be unknown, 0.
    bool isLive = false;
    cv::Size size;           ///< Size in px of the first frame as delivered, upright.
    int rotationDegrees = 0; ///< Clockwise rotation that is applied to the stored pictures, 0..270.
    bool mirrored = false;   ///< The stored pictures are mirrored left-right after the rotation.
    Fraction sampleAspect{1, 1};            ///< Width : height of a px of the upright picture.
    Fraction averageRate;                   ///< Average frames per second.
    Fraction nominalRate;                   ///< Lowest rate that can represent all time stamps.
    bool constantRate = false;              ///< The two rates agree within 0.1 %.
    Fraction timeBase{1, 1};                ///< Unit of the frames' times, s.
    std::optional<double> duration;         ///< Duration of the whole file, s; nothing if unknown.
    std::optional<std::int64_t> frameCount; ///< Frames in the whole file, as stated in it or
                                            ///< estimated from its duration; nothing if unknown.
    /// How each frame shows both eyes, as stated by the container, else by the first frame:
    /// FFmpeg's name ("side by side"), or a constant from above if the reader joins the pictures.
    /// Empty: nothing is stated.
    std::string eyes;
    std::optional<StereoLayout> eyesLayout; ///< Layout of `eyes`; nothing if it cannot be read.
    VideoColour colour;                     ///< How colours are stored.
    std::vector<VideoStreamFacts> streams;  ///< All streams, the delivered one included.
    std::vector<VideoChapter> chapters;     ///< In the file's order.
    VideoTags tags;                         ///< Tags of the file.

    /// Whether the reader joins both eyes' pictures, which are then full halves.
    /// @return true for kSpatialVideo, kAlternateFrames and kTwoVideos
    [[nodiscard]] bool areJoined() const {
        return eyes == kSpatialVideo || eyes == kAlternateFrames || eyes == kTwoVideos;
    }
};

/// Counts of what was read so far.
struct VideoReadCounts {
    std::int64_t frames = 0;        ///< Frames delivered.
    std::int64_t corrupt = 0;       ///< Packets and frames skipped because they are damaged.
    std::int64_t repairedTimes = 0; ///< Frames whose time was missing or not increasing.
    bool truncated = false;         ///< The file ends too early.
};

/// Names and values of the settings of a run. A run can be resumed only with equal settings.
using RunSettings = std::map<std::string, std::string>;

/// The state that a later run needs to resume. Only the class that made it can read its bytes.
struct SavedState {
    std::string bytes; ///< The state; empty: none.
};

/// Progress of a conversion. For a percentage, use `end` and `length` if `framesInAll` is unknown.
struct VideoProgress {
    std::int64_t frames = 0;     ///< Frames made so far, including those of an earlier run.
    std::int64_t keptFrames = 0; ///< Frames of an earlier run, which are not made again.
    double end = 0;              ///< End of the last frame made, s from the start of the part.
    /// Expected total of `frames`; nothing if unknown. It may be estimated, for a part of a file
    /// from its length and the average frame rate.
    std::optional<std::int64_t> framesInAll;
    std::optional<double> length; ///< Expected final value of `end`, s; nothing if unknown.
    bool finishing = false;       ///< All frames are made; the file is being closed.
};

/// Receives the progress. Returns true to continue, false to cancel.
using VideoProgressFunction = std::function<bool(const VideoProgress& progress)>;

/// Encoding of the frames. In a Native, neighbouring sub-pixels belong to different views, so all
/// codecs keep the colour of every px, except with VideoWriterOptions::compatible.
enum class VideoCodec {
    H264,    ///< H.264 High 4:4:4 Predictive, libx264: .mkv .mp4 .m4v .mov
    H264Rgb, ///< H.264 of red, green and blue, libx264rgb: .mkv .mp4 .m4v .mov
    Hevc,    ///< H.265 4:4:4, libx265: .mkv .mp4 .m4v .mov
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

/// Names a preset as x264 and x265 do.
/// @param preset one of the enumerators
/// @return for example "superfast"
[[nodiscard]] ALTIRO3D_EXPORT const char* presetName(EncoderPreset preset);

/// Options to write a video.
struct VideoWriterOptions {
    cv::Size size;                       ///< Size of all frames, px, 16..16384 per side.
    VideoCodec codec = VideoCodec::H264; ///< See VideoCodec.
    /// 4:2:0 for players that support nothing else (H264 and Hevc); even sides only. It blends the
    /// views of a Native.
    bool compatible = false;
    double crf = 16; ///< Constant rate factor of H264, H264Rgb, Hevc, 0..51; lower is better.
    EncoderPreset preset = EncoderPreset::SuperFast; ///< Effort of H264, H264Rgb and Hevc.
    /// The frames are Natives, whose neighbouring px belong to different views. In 4:4:4, H264 and
    /// Hevc are then encoded without psychovisual optimization and, unless crf is below 1, at
    /// crf + 2, which is more accurate at about the same size. H264 with the presets up to Fast
    /// also omits arithmetic coding and deblocking, which halves the time to decode, and quantizes
    /// chroma a little more coarsely than luma. With UltraFast and SuperFast, the quantizer is
    /// fixed (at that crf) unless maxRate is set, and the encoder does not search for cuts, for
    /// sub-pixel motion or for the best number of B-frames.
    bool native = false;
    /// Largest mean bit rate of H264 and H264Rgb over some seconds, Mbit/s, 1..100000; 0: no limit.
    /// The quantizer rises where the limit requires it. Not with a lossless `crf` (below 1).
    double maxRate = 0;
    Fraction timeBase{1, 1000};  ///< Unit of the frames' times, s, > 0.
    Fraction frameRate;          ///< Frames per second, may be approximate; 0/1 = unknown.
    bool constantRate = false;   ///< frameRate, which must be known, holds for every frame.
    Fraction sampleAspect{1, 1}; ///< Width : height of a px.
    /// How each frame shows both eyes; the file states it (AVStereo3D). Matroska supports all
    /// kinds, MP4 and M4V those side by side and above each other. Anaglyphs are ordinary frames.
    std::optional<EyesPicture> eyes;
    /// Colour matrix. Default: BT.2020 if the source has it; otherwise BT.709 if `size` has 720
    /// lines or more, else the source's matrix, or BT.601 without one. RGB codecs have no matrix.
    std::optional<ColourMatrix> matrix;
    std::optional<ColourRange> range; ///< Default: limited. RGB codecs are always full.
    /// Colour encoding of the source, for the default of `matrix` and for the tags of the file.
    /// Default: that of the source's reader, if one is given.
    std::optional<VideoColour> colour;
    /// Encoder threads, 0..64; 0 = one per processor. With several, H264 at UltraFast uses one
    /// more, as it has no look-ahead. The bytes of H264, H264Rgb and Hevc depend on the number.
    int threads = 0;
    bool audio = true;     ///< Copy the source's sound.
    bool subtitles = true; ///< Copy or convert the source's subtitles.
    bool chapters = true;  ///< Copy the source's chapters.
    bool metadata = true;  ///< Copy the source's tags.
    VideoTags tags;        ///< Further tags of the file; they override the source's.
};

/// Checks the options.
/// @param options the options to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const VideoWriterOptions& options);

/// Whether VideoWriter supports an extension: .mkv, .mp4, .m4v or .mov. "-" has none.
/// @param path file name; the file is not accessed
/// @return true if it does
[[nodiscard]] ALTIRO3D_EXPORT bool canWriteVideo(const std::filesystem::path& path);

class OtherStreams;

/// Reads the frames of a video through FFmpeg's libraries.
///
/// Frames are delivered upright (the file's rotation is applied) and as 8-bit BGR, converted with
/// the matrix and range that the stream states. If it states none, BT.601 is assumed up to 576
/// lines and BT.709 above. Values of more than 8 bits are rounded. Wide gamut (BT.2020, P3) and HDR
/// (PQ, HLG) become sRGB as in photos; only the base layer of Dolby Vision is read. Transparent
/// parts become black. Interlaced frames are deinterlaced. If the frame size or the shape of the px
/// changes, each frame has its own. If a file has several video streams, the largest one is read.
///
/// Times count from the start of the file, or from `VideoReaderOptions::from`; the pts of the first
/// frame is 0 or more. A damaged frame is skipped and counted; the previous frame is shown longer
/// instead. If a file is cut off, the frames that it holds are delivered.
///
/// The class turns FFmpeg's messages on stderr off for the whole process, unless the process has
/// called `av_log_set_level()`. One thread at a time per object.
class ALTIRO3D_EXPORT VideoReader {
  public:
    /// Opens a video.
    /// @param path a file that FFmpeg can read, `-` for the standard input, or a capture device. If
    ///        `options.format` is empty, any character device (`/dev/video0`) or link to one counts
    ///        as a capture device.
    /// @param options the part to read, threads, format of a device
    /// @throws Error NotFound; ReadFailed (a directory, no permission); BadFormat (empty, no video
    ///         stream, cut off before its index); Unsupported (a codec without a decoder, an
    ///         unknown `format`, no second video for `joinsVideos`); TooLarge (more px than
    ///         kMaxImagePixels); InvalidArgument (options); OutOfMemory
    explicit VideoReader(const std::filesystem::path& path, const VideoReaderOptions& options = {});
    ~VideoReader();
    VideoReader(VideoReader&&) noexcept;            ///< Moves.
    VideoReader& operator=(VideoReader&&) noexcept; ///< Moves. @return *this

    /// Properties of the file. @return the facts; they do not change while frames are read
    [[nodiscard]] const VideoFacts& facts() const;

    /// Reads the next frame.
    /// @return the frame, its times in facts().timeBase; nothing at the end
    /// @throws Error ReadFailed, BadFormat (no frame could be decoded), Unsupported (a pixel format
    ///         that cannot be read), OutOfMemory
    [[nodiscard]] std::optional<VideoFrame> next();

    /// Reads the next frame.
    /// @param frame receives the picture, as VideoFrame::picture says, in new memory, and its times
    ///        in facts().timeBase
    /// @return false at the end; the frame is then unchanged
    /// @throws Error as next()
    [[nodiscard]] bool read(VideoFrame& frame);

    /// Counts the frames that `VideoReaderOptions::from` skips. Call it before the first frame is
    /// read. It counts packets, which is fast. If that is unreliable, it decodes from the start.
    /// @return number of the first delivered frame in the whole video, from 0
    /// @throws Error InvalidArgument (a frame has been read), and as next()
    [[nodiscard]] std::int64_t framesBefore();

    /// Skips frames, for a run that is resumed. If the file allows seeking, this is fast, and
    /// counts() restart at 0. Times of frames do not change. A writer that has this reader as its
    /// source receives sound and the other streams only from the new position on.
    /// @param pts time of the next frame to deliver, in facts().timeBase, as next() gave it in an
    ///        earlier run; if no frame has this time, the first later one is delivered
    /// @throws Error as next()
    void skipTo(std::int64_t pts);

    /// Counts of what was read so far. @return counts since the start, or since the last seek by
    ///         skipTo()
    [[nodiscard]] const VideoReadCounts& counts() const;

    /// Remarks about the file and what happened so far.
    /// @return the remarks, each with the name of the file in front; if `counts().truncated`, the
    ///         first one has the code CutOff
    [[nodiscard]] Notes notes() const;

  private:
    friend class VideoWriter;
    friend class SegmentJoiner;
    [[nodiscard]] std::shared_ptr<OtherStreams> otherStreams() const;
    bool pass(std::int64_t until); // passes on the other streams only; false at the end

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Writes frames with FFmpeg's libraries, with sound, subtitles, chapters and tags of the source.
///
/// All sound tracks are copied without encoding them again. Text subtitles are converted to the
/// container's format (mov_text in .mp4 and .mov); other subtitles are copied. Fonts are copied
/// into .mkv. Further video streams, cover pictures and data streams are skipped, see notes(). The
/// source's rotation is not written, because its reader has applied it.
///
/// Times are exact in .mp4 and .mov and rounded to 1 ms in .mkv. The file is written as `NAME.part`
/// next to the target and renamed in finish(); without finish() it is removed. An existing file is
/// replaced; symbolic links are followed. The same frames give the same bytes: for H264, H264Rgb
/// and Hevc with a fixed number of encoder threads, for the other codecs with any number.
///
/// One thread at a time per object. The source's reader may run in another thread.
class ALTIRO3D_EXPORT VideoWriter {
  public:
    /// Opens the encoder and the file.
    /// @param path file name with the extension .mkv, .mp4, .m4v or .mov; "-": Matroska to standard
    ///        output, without length and index, which are known only at the end
    /// @param options size, codec, times
    /// @param source reader of the video that supplies sound and the other streams; may be null.
    ///        They are copied while its frames are read, so it must not have delivered a frame yet.
    ///        It may be destroyed before the writer.
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
    /// @param frame picture [VideoWriterOptions::size, CV_8UC3, BGR]; times in units of
    ///        VideoWriterOptions::timeBase; pts 0 or more, greater than that of the frame before,
    ///        by at most what the container can store: in MP4 and MOV 2^31 - 1 units of the file's
    ///        time base (6.6 hours at 1/90000 s), in Matroska 1e11 s
    /// @throws Error InvalidArgument (picture, time, after finish()): the frame is not written;
    ///         WriteFailed (full disk, ...): the file is lost
    void write(const VideoFrame& frame);

    /// Writes the remaining data and renames the file to its target. If the source was read to its
    /// end, its other streams are kept to their end; otherwise they end with the last frame.
    /// @throws Error InvalidArgument (no frame, a second call); WriteFailed: the file is lost
    void finish();

    /// Remarks on what was left out or converted. @return the remarks; finish() may add some
    [[nodiscard]] const Notes& notes() const;

    /// Chooses a container that can hold the sound and the subtitles of a video.
    /// @param source reader of the video, which must not have delivered a frame
    /// @param options codec, audio, subtitles
    /// @return the extension of a file name: the first of .mp4, .mkv and .mov that can hold all of
    ///         them (.mkv and .mov for VideoCodec::ProRes, .mkv for Ffv1), else the first
    [[nodiscard]] static std::string extensionFor(VideoReader& source,
                                                  const VideoWriterOptions& options);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Whether there is an unfinished run of a video. Also true while a VideoConverter writes it.
/// @param path file name of the video
/// @return true if `NAME.parts` holds a `run.json`
[[nodiscard]] ALTIRO3D_EXPORT bool isVideoUnfinished(const std::filesystem::path& path);

/// The directory that keeps the frames of an unfinished run.
/// @param path file name of the video
/// @return `path` + ".parts"; another name beside it if that is too long for the file system
[[nodiscard]] ALTIRO3D_EXPORT std::filesystem::path
unfinishedVideoDirectory(const std::filesystem::path& path);

/// Options to read the sound of a file.
struct AudioReaderOptions {
    /// Index of the sound stream in the file (VideoStreamFacts::index); -1 = the default one.
    int stream = -1;
    int sampleRate = 48000; ///< Samples per second to deliver, 4000..384000.
    double from = 0;        ///< Start, s from the start of the file, 0 or more, less than 1e9.
};

/// Reads one sound track of a file through FFmpeg's libraries, as stereo samples in 32-bit floating
/// point (-1..1). Other channel layouts are mixed to stereo.
///
/// The first sample delivered belongs to the time `from` of the file, on the same clock as the
/// frames of VideoReader. Where the track has no sound (before its start, in a gap), silence is
/// delivered; a damaged packet is skipped and replaced by silence. After a seek the time is as
/// exact as the container's times: to the sample in .wav, .flac, .mov and .mp4, to 1 ms in .mkv. A
/// mono track is delivered in both channels at 71 % of its amplitude, which is as loud.
///
/// The class turns FFmpeg's messages off as VideoReader does. One thread at a time per object.
class ALTIRO3D_EXPORT AudioReader {
  public:
    /// Opens a sound track.
    /// @param path a file that FFmpeg can read
    /// @param options track, rate and start
    /// @throws Error NotFound; ReadFailed; BadFormat (no sound, or `options.stream` is not a sound
    ///         stream); Unsupported (a codec without a decoder, a rate of the file outside
    ///         1000..768000 samples per second); InvalidArgument (options); OutOfMemory
    explicit AudioReader(const std::filesystem::path& path, const AudioReaderOptions& options = {});
    ~AudioReader();
    AudioReader(AudioReader&&) noexcept;            ///< Moves.
    AudioReader& operator=(AudioReader&&) noexcept; ///< Moves. @return *this

    /// Reads the next samples.
    /// @param samples receives left and right in turn, 2 * `count` numbers
    /// @param count number of samples per channel
    /// @return number of samples per channel that were read; less than `count` only at the end
    /// @throws Error OutOfMemory; Unsupported (the rate changes to one outside the limits)
    [[nodiscard]] std::size_t read(float* samples, std::size_t count);

    /// Goes to another time; the next sample read belongs to it.
    /// @param seconds s from the start of the file, 0 or more, less than 1e9; after the end:
    ///        nothing is left to read
    /// @throws Error InvalidArgument; ReadFailed (the file does not allow seeking)
    void seek(double seconds);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
