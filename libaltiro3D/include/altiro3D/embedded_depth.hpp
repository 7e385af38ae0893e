#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D {

/// How a photo's file holds depth.
enum class EmbeddedDepthForm {
    AppleHeic,    ///< Auxiliary picture of a portrait by an iPhone.
    AppleJpeg,    ///< The same as a JPEG: a further JPEG in the file (multi-picture format).
    GDepth,       ///< Base64 in XMP: lens blur and older phones by Google.
    DynamicDepth, ///< A picture after the photo: newer phones by Google and others.
    Avif,         ///< Auxiliary picture of an AVIF file.
    Samsung,      ///< Raw numbers after the photo. Experimental: no original was tested.
    Huawei        ///< Raw numbers after the photo. Experimental: no original was tested.
};

/// Depth out of a photo's file. It is small and soft compared with the photo; fitScene() aligns it.
struct EmbeddedDepth {
    EmbeddedDepthForm form = EmbeddedDepthForm::DynamicDepth; ///< Where it was.
    cv::Mat depth; ///< [any size, CV_32FC1, 0..1, 1 = nearest], relative inverse depth, upright.

    /// For people. @return for example "Dynamic Depth, 1024 x 768 px"
    [[nodiscard]] ALTIRO3D_EXPORT std::string text() const;
};

/// Reads the depth that phones store in their photos.
///
/// Depth is used only if its shape is the photo's (2 %) and it is not flat. Portrait mattes and
/// gain maps are not depth. If XMP describes depth that is no longer in the file, there is none. No
/// fault in it makes a photo unreadable: damaged depth is reported in `notes` and left out.
///
/// @param photo JPEG, HEIC or AVIF; other formats have none, and a pipe, which can be read only
/// once,
///        is not read
/// @param notes if given, receives a remark if the file has depth that is not used
/// @return the depth; nothing if there is none that can be used
/// @throws Error NotFound, ReadFailed, TooLarge (2 GiB), OutOfMemory
[[nodiscard]] ALTIRO3D_EXPORT std::optional<EmbeddedDepth>
readEmbeddedDepth(const std::filesystem::path& photo, Notes* notes = nullptr);

/// Reads the sharp original of a photo that was blurred by its camera (portrait modes): `GImage` of
/// lens blur, item "Original" of Dynamic Depth. It may be smaller than the photo.
///
/// @param photo as for readEmbeddedDepth()
/// @param notes if given, receives a remark if there is an original that cannot be used
/// @return [rows x cols, CV_8UC3, BGR], upright; empty if the file has none of the photo's shape
/// @throws Error as readEmbeddedDepth()
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat readUnblurredPhoto(const std::filesystem::path& photo,
                                                         Notes* notes = nullptr);

/// The photo that a depth image is for, by its name: "d/a" of d/a-depth.png. The end of the name,
/// before the extension, is one of '-', '_', '.' and ' ', and then `depth`, `depthmap`, `depth_map`
/// or `disparity`, in any case.
///
/// @param depth the depth image; the file is not accessed
/// @return the photo's path without extension; empty if the name is not that of a depth image
[[nodiscard]] ALTIRO3D_EXPORT std::filesystem::path
photoOfDepthName(const std::filesystem::path& depth);

/// Finds the depth image beside a photo: the pictures in the same directory whose
/// photoOfDepthName() is the photo.
///
/// @param photo the photo; the file is not accessed
/// @return the first such picture in natural order; empty if there is none or the directory cannot
///         be read
[[nodiscard]] ALTIRO3D_EXPORT std::filesystem::path
findDepthBeside(const std::filesystem::path& photo);

/// Whether a picture looks like a depth image rather than a photo: it shows no colours
/// (hasColours()), at least 70 % of it is smooth, and it has several greys. Grey photos with that
/// little detail, such as fog, also look so; depth that is noisy or has few levels does not
/// (docs/depth.md).
///
/// @param picture [rows x cols, CV_8UC3, CV_16UC3 or CV_32FC3, BGR], as of readImage(); pictures
///        below 16 px a side never look so
/// @return true if it does
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT bool looksLikeDepthImage(const cv::Mat& picture);

/// Writes a photo with its depth as one JPEG in the form Dynamic Depth 1.0: both with quality 95,
/// the depth as RangeInverse (near = dark), after the photo. The file appears complete or not at
/// all. readEmbeddedDepth() reads it back, as do programs that take depth photos of phones.
///
/// @param path file name with the extension .jpg or .jpeg
/// @param photo [rows x cols, CV_8UC3, BGR], sides of at most 65500 px
/// @param depth [any size of the photo's shape, CV_32FC1, 0..1, 1 = nearest]; clamped, NaN counts
///        as 0
/// @throws Error InvalidArgument (empty, wrong type), Unsupported (extension, too many px),
/// Mismatch
///         (shapes differ by more than 2 %), WriteFailed, OutOfMemory
ALTIRO3D_EXPORT void writePhotoWithDepth(const std::filesystem::path& path, const cv::Mat& photo,
                                         const cv::Mat& depth);

} // namespace altiro3D
