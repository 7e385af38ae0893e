#pragma once

#include "altiro3D/export.hpp"

#include <cstdint>
#include <filesystem>
#include <limits>
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
    double value() const { return static_cast<double>(numerator) / denominator; }
    /// Whether it is known. @return true if it is more than 0
    bool isKnown() const { return numerator > 0 && denominator > 0; }
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

/// Encoding of the frames. In a Native, neighbouring sub-pixels belong to different views, so all
/// codecs keep the colour of every px, except with VideoWriterOptions::compatible.
enum class VideoCodec {
    H264,    ///< H.264 High 4:4:4 Predictive, libx264: .mkv .mp4 .mov
    H264Rgb, ///< H.264 of red, green and blue, libx264rgb: .mkv .mp4 .mov
    Hevc,    ///< H.265 4:4:4, libx265: .mkv .mp4 .mov
    Ffv1,    ///< Lossless FFV1: .mkv
    ProRes   ///< ProRes 4444, 10 bits: .mkv .mov
};

/// Options to write a video.
struct VideoWriterOptions {
    cv::Size size;                       ///< Size of all frames, px, 16..16384 per side.
    VideoCodec codec = VideoCodec::H264; ///< See VideoCodec.
    /// 4:2:0 for players that support nothing else (H264 and Hevc); even sides only. It blends the
    /// views of a Native.
    bool compatible = false;
    double crf = 16;                  ///< Quality of H264, H264Rgb, Hevc, 0..51; lower is better.
    std::string preset = "superfast"; ///< Of H264, H264Rgb, Hevc: "ultrafast".."veryslow".
    Fraction timeBase{1, 1000};       ///< Unit of the frames' times, s.
    Fraction frameRate;               ///< Frames per second, may be approximate; 0/1 = unknown.
    bool constantRate = false;        ///< frameRate holds for every frame.
    Fraction sampleAspect{1, 1};      ///< Width : height of a px.
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
ALTIRO3D_EXPORT bool canWriteVideo(const std::filesystem::path& path);

} // namespace altiro3D
