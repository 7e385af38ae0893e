#pragma once

#include "altiro3D/image_io.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace altiro3D {

/// Whether the halves of a layout are the left and the right one.
inline bool liesBeside(StereoLayout layout) {
    return layout == StereoLayout::LeftRight || layout == StereoLayout::RightLeft;
}

/// The halves of a picture: the left and the right one, or the upper and the lower one.
struct HalfPlaces {
    cv::Rect first;
    cv::Rect second;
};

/// @param gap px between the halves, which belong to neither; one more if the rest is odd
/// @return halves of one size; empty ones if the picture is too small
inline HalfPlaces halfPlaces(cv::Size whole, bool isBeside, int gap = 0) {
    const cv::Size half(isBeside ? std::max(0, whole.width - gap) / 2 : whole.width,
                        isBeside ? whole.height : std::max(0, whole.height - gap) / 2);
    return {{{0, 0}, half}, {{whole.width - half.width, whole.height - half.height}, half}};
}

/// Direction in which halves are squeezed to half their size.
enum class Squeeze { None, Width, Height };

/// @param whole width : height of the whole picture
inline Squeeze squeezeOf(double whole, bool isBeside, StereoHalves halves) {
    constexpr double kNarrowest = 1.70; // 3D TV: 16:9 = 1.78
    constexpr double kWidest = 1.85;    // 3D cinema
    if (halves == StereoHalves::Full) return Squeeze::None;
    if (halves == StereoHalves::Automatic && !(whole >= kNarrowest && whole <= kWidest))
        return Squeeze::None;
    return isBeside ? Squeeze::Width : Squeeze::Height;
}
inline Squeeze squeezeOf(cv::Size whole, bool isBeside, StereoHalves halves) {
    return squeezeOf(static_cast<double>(whole.width) / whole.height, isBeside, halves);
}

/// The size of a half in the shape of the scene.
inline cv::Size stretchedSize(cv::Size half, Squeeze squeeze) {
    if (squeeze == Squeeze::Width) half.width *= 2;
    if (squeeze == Squeeze::Height) half.height *= 2;
    return half;
}

/// Gives a half the shape of the scene. @param interpolation of OpenCV
inline void stretch(cv::Mat& half, Squeeze squeeze, int interpolation) {
    if (squeeze == Squeeze::None) return;
    cv::Mat stretched;
    cv::resize(half, stretched, stretchedSize(half.size(), squeeze), 0, 0, interpolation);
    half = stretched;
}

/// Whether two pictures can be those of two eyes: shapes within 5 %, or 1 px of small pictures.
inline bool canBeEyes(cv::Size left, cv::Size right) {
    constexpr double kTolerance = 0.05;
    const double ratio = static_cast<double>(left.width) * right.height /
                         (static_cast<double>(right.width) * left.height);
    return std::abs(ratio - 1) <= kTolerance ||
           std::max(std::abs(left.width - right.width), std::abs(left.height - right.height)) <= 1;
}

/// Whether two pictures have the same shape within 2 %, as a photo and its depth.
inline bool haveOneShape(cv::Size a, cv::Size b) {
    constexpr double kTolerance = 0.02;
    const double ratio =
        static_cast<double>(a.width) * b.height / (static_cast<double>(a.height) * b.width);
    return std::abs(ratio - 1) <= kTolerance;
}

/// How a picture file states that it holds the pictures of both eyes.
struct StatedEyes {
    StereoLayout layout = StereoLayout::RightLeft;
    Squeeze squeeze = Squeeze::None;
    int gap = 0; ///< px between the two pictures.
};

/// What a JPEG or PNG file states about the eyes.
struct EyesMark {
    std::optional<StatedEyes> eyes;
    std::string name;       ///< What it is called: "JPS header"; empty: there is none.
    std::string damage;     ///< Why a mark is not used: the end of a sentence; empty: none or good.
    std::string unreadable; ///< A layout that is not read ("interleaved"); empty otherwise.
    bool isOneEye = false;  ///< The mark says that the picture shows one eye.
};

/// Reads the JPS header of a JPEG (first segment APP3 "_JPSJPS_", before the first scan), or the
/// chunk sTER or writeImage()'s mark of a PNG (before the pixels). Any bytes give a result.
EyesMark readEyesMark(std::string_view bytes);

/// How a file is marked and kept.
struct FileMark {
    std::string text;       ///< PNG: keyword, a zero byte, text; empty: none.
    std::string segment;    ///< JPEG; empty: none.
    bool isUnmixed = false; ///< Neighbouring px or colours belong to different views or eyes.
};

/// The mark of a picture for both eyes. The text holds layout and flags of a JPS header.
FileMark eyesMark(EyesPicture kind, bool swapped);

/// The eyes in one picture, as its file or its name (.jps, .pns) states.
struct MarkedEyes {
    std::optional<StatedEyes> eyes; ///< Nothing for other files.
    bool isByName = false;          ///< The shape decides whether the halves are squeezed.
    std::string origin;             ///< As of StereoPair.
};

/// @param photo name of the file @param bytes its contents
/// @param notes if given, receives a remark if a mark is not used
/// @throws Error Unsupported (interleaved or anaglyph JPS)
MarkedEyes findMarkedEyes(const std::filesystem::path& photo, std::string_view bytes, Notes* notes);

/// Removes a frame of one colour around both eyes' pictures and a gap between them, as much from
/// both. Eyes of different sizes are not changed. @param notes if given, receives a remark
void leaveOutFrame(StereoPair& pair, Notes* notes);

/// Splits a picture by what findMarkedEyes() found. @param name for messages
/// @param notes if given, receives a remark if a frame is removed
/// @throws Error InvalidArgument (too small to split)
StereoPair splitMarkedEyes(const cv::Mat& picture, const MarkedEyes& marked,
                           const std::string& name, Notes* notes);

/// As splitStereoFile(), of a picture in memory. @param name of its file @param bytes its contents
StereoPair splitNamedHalves(const cv::Mat& picture, StereoLayout layout, StereoHalves halves,
                            const std::filesystem::path& name, std::string_view bytes,
                            Notes* notes);

} // namespace altiro3D
