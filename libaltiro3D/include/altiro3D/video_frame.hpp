#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
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

} // namespace altiro3D
