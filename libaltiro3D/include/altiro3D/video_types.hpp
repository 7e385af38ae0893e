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

/// A ratio of whole numbers, such as 24000/1001; 0/1 where it is not known.
struct Fraction {
    int numerator = 0;   ///< Above the line.
    int denominator = 1; ///< Below the line, > 0.

    /// The ratio as a number. @return numerator / denominator
    double value() const { return static_cast<double>(numerator) / denominator; }
    /// Whether it is known. @return true if it is more than 0
    bool isKnown() const { return numerator > 0 && denominator > 0; }
};

/// One picture of a video and when it is shown. Times are whole numbers of the time base that goes
/// with the frames (VideoFacts::timeBase, VideoWriterOptions::timeBase), so they stay exact.
struct VideoFrame {
    cv::Mat picture;           ///< [rows x cols, CV_8UC3, BGR], upright
    std::int64_t pts = 0;      ///< When it appears, in time bases from the start.
    std::int64_t duration = 0; ///< How long it stays, in time bases; 0 = not known.
};

/// How brightness and colour of a video are made of red, green and blue.
enum class ColourMatrix {
    Rgb,   ///< Stored as red, green and blue.
    Bt601, ///< ITU-R BT.601: standard definition.
    Bt709, ///< ITU-R BT.709: high definition.
    Bt2020 ///< ITU-R BT.2020 with non-constant luminance: ultra-high definition.
};

/// Which numbers black and white have.
enum class ColourRange {
    Limited, ///< 16 and 235 (of 255), as television.
    Full     ///< 0 and 255.
};

/// The colours of a video stream.
struct VideoColour {
    ColourMatrix matrix = ColourMatrix::Bt709; ///< As stated in the file, else as assumed.
    ColourRange range = ColourRange::Limited;  ///< As stated in the file, else as assumed.
    bool stated = false;                       ///< The file states the matrix.
    int primaries = 2; ///< Number of ISO/IEC 23091-2 for the primaries; 2 = not stated.
    int transfer = 2;  ///< Number of ISO/IEC 23091-2 for the transfer curve; 2 = not stated.
};

/// Names and values that a file carries ("title", "artist", ...), in the file's order.
using VideoTags = std::vector<std::pair<std::string, std::string>>;

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

/// How frames are encoded. In a Native neighbouring sub-pixels belong to different views, so all
/// but `compatible` keep the colour of every px.
enum class VideoCodec {
    H264,    ///< H.264 High 4:4:4 Predictive, libx264: .mkv .mp4 .mov
    H264Rgb, ///< H.264 of red, green and blue, libx264rgb: .mkv .mp4 .mov
    Hevc,    ///< H.265 4:4:4, libx265: .mkv .mp4 .mov
    Ffv1,    ///< Lossless FFV1: .mkv
    ProRes   ///< ProRes 4444, 10 bits: .mkv .mov
};

/// How a video is written.
struct VideoWriterOptions {
    cv::Size size;                       ///< Of all frames, px, 16..16384 a side.
    VideoCodec codec = VideoCodec::H264; ///< How frames are encoded.
    /// 4:2:0 for players that can do no more (H264 and Hevc); even sides only. It blurs a Native's
    /// views into each other.
    bool compatible = false;
    double crf = 16;                  ///< Quality of H264, H264Rgb, Hevc, 0..51; less is better.
    std::string preset = "superfast"; ///< Of H264, H264Rgb, Hevc: "ultrafast".."veryslow".
    Fraction timeBase{1, 1000};       ///< Unit of the frames' times, s.
    Fraction frameRate;               ///< Frames a second, if only about; 0/1 = not known.
    bool constantRate = false;        ///< frameRate holds for every frame.
    Fraction sampleAspect{1, 1};      ///< Width : height of a px.
    /// Else BT.709 from 720 lines on (BT.2020 if the source is), below them the source's, or
    /// BT.601. Codecs of red, green and blue have none.
    std::optional<ColourMatrix> matrix;
    std::optional<ColourRange>
        range; ///< Else limited. Codecs of red, green and blue: full, always.
    std::optional<VideoColour> colour; ///< Of the source; else as its reader says, if there is one.
    int threads = 0;   ///< Threads that encode, 0..64; 0 = one per processor. Bytes depend on it.
    bool audio = true; ///< Copy the source's sound.
    bool subtitles = true; ///< Copy or convert the source's subtitles.
    bool chapters = true;  ///< Copy the source's chapters.
    bool metadata = true;  ///< Copy the source's tags.
    VideoTags tags;        ///< Further tags of the file; they win over the source's.
};

/// Checks the options.
/// @param options what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const VideoWriterOptions& options);

/// Whether the file name's extension is one that VideoWriter can write: .mkv, .mp4, .m4v or .mov.
/// @param path file name; the file is not looked at
/// @return true if it is
ALTIRO3D_EXPORT bool canWriteVideo(const std::filesystem::path& path);

} // namespace altiro3D
