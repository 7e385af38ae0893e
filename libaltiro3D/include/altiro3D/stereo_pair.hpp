#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D {

/// How one picture holds the pictures of both eyes.
enum class StereoLayout {
    LeftRight, ///< The left eye's picture is the left half.
    RightLeft, ///< The left eye's picture is the right half (for cross-eyed viewing).
    TopBottom  ///< The left eye's picture is the upper half.
};

/// Shape of the halves.
enum class StereoHalves {
    Automatic, ///< Squeezed if the whole picture is about 16:9 (1.70 to 1.85), else full.
    Full,      ///< Each half has the shape of the scene.
    Squeezed   ///< Each half is squeezed to half its width (TopBottom: height), as for 3D TV.
};

/// The pictures of the two eyes.
struct StereoPair {
    cv::Mat left;       ///< [rows x cols, CV_8UC3, BGR]
    cv::Mat right;      ///< [rows x cols, CV_8UC3, BGR]; its size may differ a little
    std::string origin; ///< Where it was, for people: "MPO", "spatial HEIC", "left and right half".
};

/// Reads the two pictures of a file that is marked as a stereo pair: an MPO of a 3D camera (JPEG
/// with MP type "multi-frame image, disparity", CIPA DC-007) or a spatial photo (HEIC or AVIF with
/// a group `ster`). Both are upright and in sRGB.
///
/// The contents decide, not the name. Other multi-picture files (bursts, panoramas, portraits) are
/// not pairs. A damaged second picture does not make the file unreadable: the function then returns
/// no pair and adds a remark.
///
/// @param photo any picture; a pipe is not read, because it can be read only once
/// @param notes if given, receives a remark if the file has a pair that is not used
/// @return the pair; nothing for other files
/// @throws Error as readPhoto(), for a file that is a pair
[[nodiscard]] ALTIRO3D_EXPORT std::optional<StereoPair>
readStereoPair(const std::filesystem::path& photo, Notes* notes = nullptr);

/// Splits a picture that holds both eyes, exactly in the middle (an odd row or column in the middle
/// belongs to neither). Squeezed halves are stretched to their shape by linear interpolation.
///
/// @param picture [rows x cols, CV_8UC3, BGR], at least 2 px in the direction of the split
/// @param layout order of the eyes
/// @param halves shape of the halves
/// @return the pair; full halves share the memory of `picture`
/// @throws Error InvalidArgument (empty, wrong type, too small to split), TooLarge (stretched
///         halves of more than 65500 px a side)
[[nodiscard]] ALTIRO3D_EXPORT StereoPair splitStereoPair(
    const cv::Mat& picture, StereoLayout layout, StereoHalves halves = StereoHalves::Automatic);

} // namespace altiro3D
