#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/scene.hpp"
#include "altiro3D/view_options.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>

namespace altiro3D {

/// Names of a kind of picture for two eyes.
struct EyesPictureName {
    const char* option; ///< "sbs", as tools call it.
    const char* words;  ///< "side by side", for people.
    /// The tag that players look for in a file name, without "_"; see hasEyesTag().
    const char* tag;
};

/// The names of a kind of picture. @param picture the kind @return its names
[[nodiscard]] ALTIRO3D_EXPORT EyesPictureName nameOf(EyesPicture picture);

/// Whether a file name has a tag by which players know the kind of picture.
/// @param file the name; directories are ignored and the file is not accessed
/// @param picture the kind
/// @return true for any of the usual tags; always true for interlaced pictures, which have no tag
[[nodiscard]] ALTIRO3D_EXPORT bool hasEyesTag(const std::filesystem::path& file,
                                              EyesPicture picture);

/// The kind of a picture that holds both eyes.
/// @param layout order of the eyes @param halves shape of the halves
/// @param whole size of the picture in px
/// @return the kind; nothing for orders that joinEyes() does not make
[[nodiscard]] ALTIRO3D_EXPORT std::optional<EyesPicture>
eyesPictureOf(StereoLayout layout, StereoHalves halves, cv::Size whole);

/// The size of a picture for two eyes.
/// @param eye size of the picture of one eye in px
/// @param picture kind
/// @return columns x rows in px; halves of an odd size are rounded up
[[nodiscard]] ALTIRO3D_EXPORT cv::Size eyesSize(cv::Size eye, EyesPicture picture);

/// Joins the pictures of both eyes. Whole pictures keep their px, so splitStereoPair() can split
/// them again; squeezed ones are area-averaged.
/// @param left [rows x cols, CV_8UC3, BGR]
/// @param right [as left]
/// @param picture kind
/// @param joined [eyesSize(), CV_8UC3, BGR]; reused if it fits; must not share memory with the eyes
/// @throws Error InvalidArgument (empty, type, shared memory), Mismatch (sizes differ), OutOfMemory
ALTIRO3D_EXPORT void joinEyes(const cv::Mat& left, const cv::Mat& right, EyesPicture picture,
                              cv::Mat& joined);

/// Comfortable parallax between two eyes for a depth difference of 1, in % of the picture's width,
/// for ViewOptions::strengthPercent.
constexpr double kEyesStrength = 2.5;

/// Which of the eyes' pictures are rendered.
enum class EyesFrom {
    Both,    ///< Both, from positions -1 and +1: the photo lies between them.
    KeepLeft ///< The right one, from position +2: the left one is the photo.
};

/// Renders the pictures of both eyes from a photo with depth.
/// @param scene as for Depth2Quilt::render(), for example from placeScene()
/// @param views method, strength (kEyesStrength) and focus
/// @param from the eyes to render
/// @return left and right eye [rows x shown columns of the scene]; with KeepLeft, the left one is a
///         copy of the photo
/// @throws Error as Depth2Quilt::render()
[[nodiscard]] ALTIRO3D_EXPORT StereoPair renderEyes(const Scene& scene, const ViewOptions& views,
                                                    EyesFrom from = EyesFrom::Both);

} // namespace altiro3D
