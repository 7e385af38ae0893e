#pragma once

#include "altiro3D/export.hpp"

#include <filesystem>
#include <limits>
#include <opencv2/core/types.hpp>
#include <string>

namespace altiro3D {

// The pinhole camera of method Real. x to the right, y down, z away from the camera; a point
// (X, Y, Z) is seen at
//
//     u = fx X / Z + cx,   v = fy Y / Z + cy            px; (0, 0) is the upper left pixel's centre
//
// Lengths (Z, zNear, zFar, baseline) may have any unit, the same for all.

/// The intrinsic matrix K of a camera, in px of one picture.
struct CameraIntrinsics {
    double fx = 0; ///< Focal length in columns, 0.001..1e9.
    double fy = 0; ///< Focal length in rows, 0.001..1e9.
    double cx = 0; ///< Column of the principal point, -1e9..1e9; (columns - 1) / 2 is the middle.
    double cy = 0; ///< Row of the principal point, -1e9..1e9; (rows - 1) / 2 is the middle.
};

/// The camera that took a photo, the range of distances in it, and how far the virtual cameras
/// move: the pinhole camera of docs/mathematics.md, 3.
struct Camera {
    CameraIntrinsics intrinsics; ///< Of the photo.
    double zNear = 1;            ///< Distance at depth 1, 1e-6..1e9.
    /// Distance at depth 0, > zNear; may be infinite.
    double zFar = std::numeric_limits<double>::infinity();
    /// Distance of the outermost cameras from the photo's, 0..1e9: the camera of view p is
    /// p baseline to its right.
    double baseline = 0;
};

/// Horizontal field of view assumed for an unknown camera.
constexpr double kDefaultFieldOfViewDegrees = 40;

/// Checks a camera.
/// @param camera the camera to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const Camera& camera);

/// Reads a camera from a JSON object with the numbers fx, fy, cx, cy, zNear, zFar and baseline; all
/// are required. zFar may be null, which means infinity. Other fields are ignored.
///
/// @param path the file, at most 1 MiB
/// @return the camera; it is valid
/// @throws Error NotFound, ReadFailed, TooLarge, OutOfMemory, or BadFormat that names the file, the
///         field, its value and what was expected
[[nodiscard]] ALTIRO3D_EXPORT Camera readCamera(const std::filesystem::path& path);

/// As readCamera(), from text.
///
/// @param json the file's contents
/// @param source the file's name, for errors
/// @return the camera; it is valid
/// @throws Error BadFormat that names source, field, value and what was expected
[[nodiscard]] ALTIRO3D_EXPORT Camera parseCamera(const std::string& json,
                                                 const std::string& source);

/// Focal length in px from the horizontal field of view: W / (2 tan(fov / 2)).
///
/// @param columns W, width of the picture in px, > 0
/// @param fovDegrees fov, 0.1..179 degrees
/// @return focal length in px
/// @throws Error InvalidArgument (out of these ranges)
[[nodiscard]] ALTIRO3D_EXPORT double focalLengthFromFieldOfView(int columns, double fovDegrees);

/// Focal length in px from the focal length of a 35 mm camera with the same field of view (EXIF
/// FocalLengthIn35mmFilm): f35 / 36 mm of the picture's longer side.
///
/// @param size size of the whole, uncropped picture in px, at least 1 x 1; orientation does not
///        matter
/// @param focalLength35mm 1..10000 mm
/// @return focal length in px
/// @throws Error InvalidArgument (out of these ranges)
[[nodiscard]] ALTIRO3D_EXPORT double focalLengthFrom35mm(cv::Size size, double focalLength35mm);

/// Intrinsics with square pixels and the principal point in the middle. Arguments are not checked.
///
/// @param size size of the picture in px
/// @param focalLength focal length in px, becomes fx and fy
/// @return K with cx = (columns - 1) / 2 and cy = (rows - 1) / 2
[[nodiscard]] ALTIRO3D_EXPORT CameraIntrinsics centredIntrinsics(cv::Size size, double focalLength);

/// Intrinsics after cropping and resizing the picture. Pixel corners map to pixel corners, so the
/// half px between corner and centre is scaled as well.
///
/// @param intrinsics intrinsics of the whole picture
/// @param part the crop in px of that picture; fractions allowed
/// @param size size of the result in px, at least 1 x 1
/// @return intrinsics in px of the result
/// @throws Error InvalidArgument (an empty part or size)
[[nodiscard]] ALTIRO3D_EXPORT CameraIntrinsics fitted(const CameraIntrinsics& intrinsics,
                                                      const cv::Rect2d& part, cv::Size size);

/// Parallax S between the outermost views for a depth difference of 1: 2 fx baseline (1/zNear -
/// 1/zFar), docs/mathematics.md, (3.5). It replaces strength % of the width.
///
/// @param camera the camera; its intrinsics in px of the picture that S is for
/// @return S in px
/// @throws Error InvalidArgument (camera)
[[nodiscard]] ALTIRO3D_EXPORT double parallaxOf(const Camera& camera);

/// The baseline that gives a parallax: the inverse of parallaxOf(), docs/mathematics.md, (3.5).
///
/// @param camera the camera; its own baseline is ignored
/// @param parallaxPixels S, 0..1e9 px
/// @return baseline in the unit of zNear
/// @throws Error InvalidArgument (camera, parallax)
[[nodiscard]] ALTIRO3D_EXPORT double baselineFor(const Camera& camera, double parallaxPixels);

} // namespace altiro3D
