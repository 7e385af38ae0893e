#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/scene.hpp"
#include "altiro3D/view_options.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

// Scenes of Gaussian splats ("3DGS", Kerbl et al. 2023). x to the right, y down, z forward; lengths
// have any unit, the same for all.

/// A splat: a soft ellipsoid of one colour.
struct Splat {
    cv::Vec3f centre;   ///< Its middle.
    cv::Vec3f radii;    ///< Standard deviations along its own axes, 0 or more.
    cv::Vec4f rotation; ///< Quaternion w, x, y, z that turns its axes to those of the scene; unit.
    cv::Vec3f colour;   ///< Red, green, blue in display values: 0 black, 1 full; may lie outside.
    float opacity = 0;  ///< In its middle, 0..1.
};

/// A pinhole camera in a scene of splats.
struct SplatCamera {
    cv::Size size;               ///< Size of its pictures in px.
    CameraIntrinsics intrinsics; ///< In px of its pictures.
    /// Directions in the scene: rows right, down and forward. Orthonormal.
    cv::Matx33d axes = cv::Matx33d::eye();
    cv::Vec3d eye; ///< Position in the scene.
};

/// A scene of splats.
struct SplatScene {
    std::vector<Splat> splats; ///< In the order of the file.
    int degree = 0;            ///< Degree of the spherical harmonics, 0 (none) .. 3.
    /// For each splat, (degree + 1)^2 - 1 coefficients that change its colour with the direction of
    /// view. Each coefficient is three numbers: red, green and blue.
    std::vector<float> harmonics;
    /// The scene was trained with the filter of Mip-Splatting: small splats are fainter.
    bool isAntialiased = false;
    std::optional<SplatCamera> camera; ///< The photo's camera, if known; see readSplats().
    /// Distance of zero parallax from `camera`; 0 if the file does not have it.
    double focusDistance = 0;
};

/// How the axes of a file lie.
enum class SplatAxes {
    Auto, ///< As its format says: RUB in .spz, RDF in all others.
    Rdf,  ///< x right, y down, z forward.
    Rub   ///< x right, y up, z back.
};

/// Whether a file is named like a scene of splats. @param path the file; it is not opened
/// @return true for .ply, .splat and .spz in upper or lower case
[[nodiscard]] ALTIRO3D_EXPORT bool isSplatFileName(const std::filesystem::path& path);

/// Reads a scene of splats: .ply (as 3DGS and SHARP write it, and compressed), .splat, .spz (also
/// version 4 if the library was built with libzstd). Splats with impossible numbers are left out
/// and counted in a remark.
///
/// A .ply gets the first of these cameras that exists:
/// - that of the elements of SHARP in the file;
/// - the middle one in `cameras.json` beside the file;
/// - if the file is in a folder named `iteration_...`: the middle one in `cameras.json` two folders
///   above that folder.
///
/// With SplatAxes::Rub, `cameras.json` is not used.
/// @param path the file, at most 16 GiB; 64 million splats
/// @param axes how the axes of the file lie
/// @param notes if given, receives remarks
/// @return the scene, with at least one splat
/// @throws Error NotFound, ReadFailed, TooLarge, OutOfMemory, Unsupported (.sog, .ksplat, meshes,
///         point clouds), BadFormat (says what is damaged, or how many of the stated splats the
///         file holds)
[[nodiscard]] ALTIRO3D_EXPORT SplatScene readSplats(const std::filesystem::path& path,
                                                    SplatAxes axes = SplatAxes::Auto,
                                                    Notes* notes = nullptr);

/// As readSplats(), from memory; without `cameras.json`.
/// @param bytes contents of the file @param name its name, for its ending and errors
/// @param axes, notes as above @return the scene @throws Error as above
[[nodiscard]] ALTIRO3D_EXPORT SplatScene parseSplats(const std::string& bytes,
                                                     const std::filesystem::path& name,
                                                     SplatAxes axes = SplatAxes::Auto,
                                                     Notes* notes = nullptr);

/// Writes a scene as .ply (fields that all viewers read) or .spz (version 3: rounded, 10 to 15
/// times smaller; y up, z back).
/// @param path the file; its ending decides
/// @param scene the scene; `camera` goes into a .ply as elements after the splats, as SHARP writes
///        them; some viewers cannot read such files
/// @throws Error WriteFailed, InvalidArgument (ending; no splats; one with impossible numbers
///         or out of the range of .spz; another number of harmonics)
ALTIRO3D_EXPORT void writeSplats(const std::filesystem::path& path, const SplatScene& scene);

/// How a camera is chosen for a scene. Fields that are not set are chosen from the scene.
struct SplatCameraOptions {
    double yaw = 0;  ///< Turn around the scene, degrees, -360..360; > 0: the camera moves right.
    double tilt = 0; ///< Turn around the scene, degrees, -90..90; > 0: the camera moves up.
    std::optional<cv::Vec3d> position; ///< Its place.
    std::optional<cv::Vec3d> lookAt;   ///< A point in the middle of the picture.
    std::optional<cv::Vec3d> up;       ///< A direction that is up in the picture.
    std::optional<double> viewDegrees; ///< Vertical angle of view, degrees, 1..150.
};

/// A chosen camera.
struct ChosenSplatCamera {
    SplatCamera camera; ///< For pictures of the wanted size.
    std::string how;    ///< How it was chosen, for people: "that of the file".
};

/// Chooses a camera (docs/mathematics.md, 9): that of the file; else one at the origin if the scene
/// lies in front of it, as scenes of one photo do; else one in front of the middle of the opaque
/// part.
/// @param scene the scene
/// @param size of the pictures in px
/// @param aspect width : height of the shown pictures, 0.01..100; that of `size` if px are square
/// @param options see SplatCameraOptions
/// @return the camera
/// @throws Error InvalidArgument (size, aspect, an option), BadFormat (no splat is opaque enough)
[[nodiscard]] ALTIRO3D_EXPORT ChosenSplatCamera chooseSplatCamera(
    const SplatScene& scene, cv::Size size, double aspect, const SplatCameraOptions& options = {});

/// What a camera sees of a scene.
struct SplatView {
    cv::Mat picture; ///< [rows x cols, CV_8UC3, BGR] in front of black
    cv::Mat
        distance;  ///< [as `picture`, CV_32FC1], along the view; NaN where nothing is half opaque
    cv::Mat alpha; ///< [as `picture`, CV_32FC1] opacity, 0..1
};

/// Renders a scene of splats by parallel cameras: the formula of 3DGS, docs/mathematics.md, 9.
/// Splats are sorted once for all of them.
///
/// Immutable; render() is thread-safe. Results are the same bytes for any number of threads.
class ALTIRO3D_EXPORT SplatRenderer {
  public:
    /// Sorts the splats by their distance.
    /// @param scene the scene; must outlive the renderer if it has harmonics
    /// @param camera the middle camera; sides of 1..16384 px
    /// @param simple without harmonics: quicker, for a camera that is being moved
    /// @throws Error InvalidArgument (camera; a scene that is empty, too large or has another
    ///         number of harmonics), OutOfMemory
    SplatRenderer(const SplatScene& scene, const SplatCamera& camera, bool simple = false);

    /// Renders the view of a camera that has moved to the side.
    /// @param shift of the eye to the right, in the unit of the scene
    /// @param focusDistance the distance at which all views show the same, > 1e-15; may be infinite
    /// @param picture [rows x cols, CV_8UC3, BGR]; may be a part of a larger one
    /// @throws Error InvalidArgument (shift, focusDistance)
    void render(double shift, double focusDistance, cv::Mat& picture) const;

    /// Renders the middle view with its distances. @return the view
    [[nodiscard]] SplatView render() const;

    /// Size of the pictures. @return px
    [[nodiscard]] cv::Size size() const;

    /// Splats nearer than this are not drawn. @return distance along the view
    [[nodiscard]] double nearest() const;

  private:
    struct Impl;
    std::shared_ptr<const Impl> impl_;
};

/// Where views of splats cross, and how far their cameras are apart.
struct SplatPlacement {
    double focusDistance = 0; ///< Distance of zero parallax.
    double baseline = 0;      ///< Distance of the outermost cameras from the middle one.
    double focus = 0;         ///< 0 (farthest) .. 1 (nearest): `focusDistance` as depth.
    /// Parallax of depth 1 against depth 0 between the outermost views, % of a view's width.
    double strengthPercent = 0;
    double zNear = 0; ///< Distance of depth 1: 2 % of what is seen is nearer.
    double zFar = 0;  ///< Distance of depth 0: 2 % of what is seen is farther.
};

/// Places views (docs/mathematics.md, 9). Depth is linear in 1 / distance.
/// @param view what the middle camera sees, also at another size
/// @param camera the middle camera
/// @param quilt layout of the views: their number
/// @param focus 0..1; not set: the median of what the middle third shows
/// @param strengthPercent 0..10000; not set: the largest that the display shows without double
///        edges, as for photos
/// @return the placement; a baseline of 0 if all that is seen has one distance
/// @throws Error InvalidArgument (an option, camera, layout; nothing is seen), TooLarge (layout)
[[nodiscard]] ALTIRO3D_EXPORT SplatPlacement
placeSplats(const SplatView& view, const SplatCamera& camera, const QuiltLayout& quilt,
            std::optional<double> focus = {}, std::optional<double> strengthPercent = {});

/// Renders the views of a quilt.
/// @param renderer of the middle camera, whose pictures have the size of a view
/// @param placement from placeSplats() @param layout of the quilt
/// @param quilt [layout.size(), CV_8UC3, BGR]; reused if it fits
/// @param goOn receives the number of each view before it is rendered; false cancels. May be empty.
/// @return false if `goOn` has stopped the work
/// @throws Error Mismatch (size), InvalidArgument (layout, placement), TooLarge (layout)
ALTIRO3D_EXPORT bool renderQuilt(const SplatRenderer& renderer, const SplatPlacement& placement,
                                 const QuiltLayout& layout, cv::Mat& quilt,
                                 const std::function<bool(int view)>& goOn = {});

/// The depth of a view.
/// @param view from SplatRenderer::render() @param placement from placeSplats()
/// @return [as the view, CV_32FC1, 0..1, 1 = nearest]; px without a distance have depth 0
/// @throws Error InvalidArgument (type of the distances, placement)
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat depthOf(const SplatView& view,
                                              const SplatPlacement& placement);

/// How a photo becomes splats.
struct PhotoSplatOptions {
    double viewDegrees = 55; ///< Vertical angle of view of the photo, degrees, 1..150.
    double radius = 0.5;     ///< Standard deviation of a splat, px, 0.05..5.
    double focus = 0.5;      ///< Depth at SplatScene::focusDistance, 0..1.
    /// Background is painted behind steps of depth as far as outermost views of this strength
    /// (ViewOptions::strengthPercent, 0..100) show it.
    double reachPercent = 20;
};

/// Turns a photo and its depth into splats: a flat one for each px, along the slope of its surface;
/// surfaces end at steps of depth, and the background that method Layered paints behind them has
/// splats of its own. Depth 0..1 becomes distances of 100..10; they are not metric.
/// @param scene photo and depth of the same size, as placeScene() makes them
/// @param options see PhotoSplatOptions
/// @return the scene with the camera of the photo
/// @throws Error as for Depth2Quilt::render(), InvalidArgument (options)
[[nodiscard]] ALTIRO3D_EXPORT SplatScene splatsOf(const Scene& scene,
                                                  const PhotoSplatOptions& options = {});

} // namespace altiro3D
