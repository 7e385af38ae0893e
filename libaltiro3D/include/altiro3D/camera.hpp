#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/view_options.hpp"

#include <filesystem>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>

namespace altiro3D {

// The pinhole camera of method Real. x to the right, y down, z away from the camera; a point
// (X, Y, Z) is seen at
//
//     u = fx X / Z + cx,   v = fy Y / Z + cy            px; (0, 0) is the upper left pixel's centre
//
// Lengths (Z, zNear, zFar, baseline, T) may have any unit, as long as it is one.

/// The intrinsic matrix K of a camera, in px of one picture.
struct CameraIntrinsics {
    double fx = 0; ///< Focal length in columns, 0.001..1e9.
    double fy = 0; ///< Focal length in rows, 0.001..1e9.
    double cx = 0; ///< Column of the principal point, -1e9..1e9; (columns - 1) / 2 is the middle.
    double cy = 0; ///< Row of the principal point, -1e9..1e9; (rows - 1) / 2 is the middle.
};

/// The camera that took a photo, the distances in it, and how far the virtual cameras move: the
/// pinhole camera of docs/mathematics.md, 3.
struct Camera {
    CameraIntrinsics intrinsics;                           ///< Of the photo.
    double zNear = 1;                                      ///< Distance at depth 1, 1e-6..1e9.
    double zFar = std::numeric_limits<double>::infinity(); ///< Distance at depth 0, more than
                                                           ///< zNear; may be infinite.
    double baseline = 0; ///< How far the outermost cameras stand beside the photo's, 0..1e9: that
                         ///< of view p stands p baseline to the right of it.
};

/// The horizontal field of view that is taken where nothing is known about the camera.
constexpr double kDefaultFieldOfViewDegrees = 40;

/// Checks intrinsics.
/// @param intrinsics what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const CameraIntrinsics& intrinsics);

/// Checks a camera.
/// @param camera what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const Camera& camera);

/// Reads a camera from a JSON object with the numbers fx, fy, cx, cy, zNear, zFar and baseline, all
/// of them required. zFar may be null: infinitely far. Other fields are passed over.
///
/// @param path the file, at most 1 MiB
/// @return the camera, valid
/// @throws Error NotFound, ReadFailed, TooLarge, OutOfMemory, or BadFormat that names the file, the
///         field, its value and what was expected
ALTIRO3D_EXPORT Camera readCamera(const std::filesystem::path& path);

/// As readCamera(), from text.
///
/// @param json the file's contents
/// @param source the file's name, for errors
/// @return the camera, valid
/// @throws Error BadFormat that names source, field, value and what was expected
ALTIRO3D_EXPORT Camera parseCamera(const std::string& json, const std::string& source);

/// Focal length in px from the horizontal field of view: W / (2 tan(fov / 2)).
///
/// @param columns W, width of the picture in px, > 0
/// @param fovDegrees fov, 0.1..179 degrees
/// @return focal length in px
/// @throws Error InvalidArgument (out of these ranges)
ALTIRO3D_EXPORT double focalLengthFromFieldOfView(int columns, double fovDegrees);

/// Focal length in px from that of a 35 mm camera with the same view (EXIF
/// FocalLengthIn35mmFilm): f35 / 36 mm of the picture's longer side.
///
/// @param size the whole picture in px, at least 1 x 1, before any crop, upright or not
/// @param focalLength35mm 1..10000 mm
/// @return focal length in px
/// @throws Error InvalidArgument (out of these ranges)
ALTIRO3D_EXPORT double focalLengthFrom35mm(cv::Size size, double focalLength35mm);

/// Intrinsics with square pixels and the principal point in the middle. Nothing is checked.
///
/// @param size the picture in px
/// @param focalLength in px, becomes fx and fy
/// @return K with cx = (columns - 1) / 2 and cy = (rows - 1) / 2
ALTIRO3D_EXPORT CameraIntrinsics centredIntrinsics(cv::Size size, double focalLength);

/// Intrinsics after a part of the picture was cut out and brought to another size. Corners of
/// pixels stay corners, so the principal point moves by half a px, too.
///
/// @param intrinsics of the whole picture
/// @param part the part, px of the picture that the intrinsics belong to, fractions allowed
/// @param size the result's size in px, at least 1 x 1
/// @return intrinsics in px of the result
/// @throws Error InvalidArgument (an empty part or size)
ALTIRO3D_EXPORT CameraIntrinsics fitted(const CameraIntrinsics& intrinsics, const cv::Rect2d& part,
                                        cv::Size size);

/// Distance from relative inverse depth: 1/Z = d (1/zNear - 1/zFar) + 1/zFar; infinite at d = 0 if
/// zFar is (docs/mathematics.md, (3.4)).
///
/// @param depth d, 0..1; clamped, NaN counts as 0
/// @param zNear distance at depth 1, > 0; not checked
/// @param zFar distance at depth 0, more than zNear, may be +inf; not checked
/// @return Z in the unit of zNear
ALTIRO3D_EXPORT double metricDistance(double depth, double zNear, double zFar);

/// @overload
/// @param depth [rows x cols, CV_32FC1, 0..1, 1 = nearest]
/// @param zNear distance at depth 1, 1e-6..1e9
/// @param zFar distance at depth 0, more than zNear, may be +inf
/// @param distance [as depth, CV_32FC1, in the unit of zNear, may be +inf]; may be `depth` itself
/// @throws Error InvalidArgument (type, zNear, zFar)
ALTIRO3D_EXPORT void metricDistance(const cv::Mat& depth, double zNear, double zFar,
                                    cv::Mat& distance);

/// Relative inverse depth of a distance: the inverse of metricDistance(), docs/mathematics.md,
/// (3.4).
///
/// @param distance Z, in the unit of zNear, may be +inf
/// @param zNear distance at depth 1, > 0; not checked
/// @param zFar distance at depth 0, more than zNear, may be +inf; not checked
/// @return d, clamped to 0..1; 0 for NaN and for what is not in front of the camera (Z <= 0)
ALTIRO3D_EXPORT double relativeDepth(double distance, double zNear, double zFar);

/// Parallax S between the outermost views of two things that lie a whole depth range apart:
/// 2 fx baseline (1/zNear - 1/zFar), docs/mathematics.md, (3.5). It takes the place of strength %
/// of the width.
///
/// @param camera the camera, its intrinsics in px of the picture that S is for
/// @return S in px
/// @throws Error InvalidArgument (camera)
ALTIRO3D_EXPORT double parallaxOf(const Camera& camera);

/// The baseline that gives a parallax: the inverse of parallaxOf(), docs/mathematics.md, (3.5).
///
/// @param camera the camera; its own baseline is not read
/// @param parallaxPixels S, 0..1e9 px
/// @return baseline in the unit of zNear
/// @throws Error InvalidArgument (camera, parallax)
ALTIRO3D_EXPORT double baselineFor(const Camera& camera, double parallaxPixels);

/// Where a camera stands and looks: a point X of the photo's camera is R X + T for this one. A
/// camera at C has T = -R C: moved to the right by b and not turned, (-b, 0, 0).
struct CameraPose {
    cv::Matx33d rotation = cv::Matx33d::eye(); ///< R, orthonormal to 1e-6, determinant 1.
    cv::Vec3d translation{0, 0, 0};            ///< T, in the unit of the distances, -1e9..1e9 each.
};

/// Checks a pose.
/// @param pose what to check
/// @throws Error InvalidArgument (rows of R that are not orthonormal, a mirror, T out of its range)
ALTIRO3D_EXPORT void validate(const CameraPose& pose);

/// A virtual camera.
struct ViewCamera {
    CameraIntrinsics intrinsics; ///< K_v.
    CameraPose pose;             ///< [R|T].
};

/// The camera of the view at a position: p baseline to the right, with the principal point moved so
/// that what lies at the focus stays put, which makes the displacement docs/mathematics.md, (3.2).
///
/// @param camera the photo's
/// @param focus depth of zero parallax, 0..1
/// @param position p, camera position, -1 leftmost .. +1 rightmost; any finite number
/// @return K_v and [R|T], R the identity, T = (-p baseline, 0, 0)
/// @throws Error InvalidArgument (camera, focus, position)
ALTIRO3D_EXPORT ViewCamera viewCamera(const Camera& camera, double focus, double position);

/// Renders a photo as another camera sees it (method Real, any pose): each pixel is back-projected
/// with its distance, moved, projected and spread over the pixels it falls between; the nearest
/// wins. Cracks get a median, what was hidden is inpainted. Black if no pixel of the photo is seen.
///
/// Positions are computed in double and then rounded to 1/256 px. Warps on one thread; any number
/// of threads may call it at once. For cameras side by side Depth2Quilt gives the same views
/// without matrices. The projection is K_v (R X + T), docs/mathematics.md, 3.
///
/// @param photo [rows x cols, CV_8UC3, BGR], sides at most 32766 px
/// @param distance [as photo, CV_32FC1, Z; +inf = infinitely far; NaN, 0 and less = not known, such
///        pixels are left out]
/// @param photoCamera K_o, of the photo
/// @param viewCamera K_v, of the view, which has the photo's size
/// @param pose [R|T] of the view's camera, T in the unit of the distances
/// @param options see RealOptions
/// @param view [as photo, CV_8UC3, BGR]; may be the photo itself
/// @throws Error InvalidArgument (types, cameras, pose, options), TooLarge, Mismatch (photo and
///         distance differ in size)
ALTIRO3D_EXPORT void renderReal(const cv::Mat& photo, const cv::Mat& distance,
                                const CameraIntrinsics& photoCamera,
                                const CameraIntrinsics& viewCamera, const CameraPose& pose,
                                const RealOptions& options, cv::Mat& view);

} // namespace altiro3D
