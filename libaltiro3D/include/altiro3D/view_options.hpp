#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <filesystem>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <tuple>

namespace altiro3D {

/// How holes, which no pixel of the photo reaches, are filled.
enum class Inpainting {
    Telea,       ///< Fast marching (Telea 2004).
    NavierStokes ///< Continues lines of equal brightness (Bertalmio et al. 2001).
};

/// How method Real fills areas that the photo does not show.
struct RealOptions {
    Inpainting inpainting = Inpainting::Telea; ///< See Inpainting.
    double inpaintingRadius = 3;               ///< Neighbourhood of a pixel in a hole, px, 1..20.
    bool backgroundOnly = false; ///< Fill disocclusions from the background only; false, as
                                 ///< published, uses the foreground as well.

    /// All fields, to compare or save them. @param o the options @return references to its fields
    template <typename Options>
    static auto fields(Options& o) {
        return std::tie(o.inpainting, o.inpaintingRadius, o.backgroundOnly);
    }
};

/// How views are rendered from a photo and its depth.
enum class ViewMethod {
    Fast,   ///< Backward mapping, depth read at the destination pixel: no holes, soft edges.
    Real,   ///< Projects each pixel into the virtual camera, the nearest wins; holes are inpainted.
    Layered ///< Surfaces per row, cut at depth steps, over a background that is painted once.
};

/// What a view shows in a disocclusion, a place where background comes into sight that the photo
/// hides.
enum class LayeredFill {
    Continue,       ///< The border pixel of the background, repeated along the row.
    BackgroundLayer ///< A hidden background, painted once behind the foreground for all views.
};

/// Options of method Layered. The defaults were chosen by measurement (docs/lab/views.md).
struct LayeredOptions {
    /// The surface between neighbouring pixels is torn if their depth step moves them apart by more
    /// than this in the outermost view, px, > 0, at most 1000. Below, the surface is stretched.
    double tearPixels = 1;
    /// How many background px at a tear move with the foreground, because they are mixed with its
    /// colour, 0..8. Where the photo shows the border clearly, the photo decides instead.
    int edgeDilationPixels = 1;
    /// Whether a px at the border of a near object is split into the colours of the object and of
    /// the background, which then move separately. false: the whole px moves with the near object.
    bool softBorders = true;
    /// What disocclusions show.
    LayeredFill fill = LayeredFill::BackgroundLayer;

    /// All fields, to compare or save them. @param o the options @return references to its fields
    template <typename Options>
    static auto fields(Options& o) {
        return std::tie(o.tearPixels, o.edgeDilationPixels, o.softBorders, o.fill);
    }
};

/// Options of the views.
struct ViewOptions {
    ViewMethod method = ViewMethod::Layered; ///< How views are rendered.
    /// Parallax between the outermost views for a depth difference of 1, in % of the picture's
    /// width, 0..10000.
    double strengthPercent = 10;
    /// Depth of zero parallax, 0 (farthest) .. 1 (nearest). Content there appears on the panel's
    /// surface.
    double focus = 0.5;
    /// Fast: number of fixed-point iterations that find the source pixel, 0 (as published: depth is
    /// read at the destination pixel) .. 16. Not to be confused with PlacementOptions::refine,
    /// which corrects the depth.
    int refinement = 0;
    /// Real: how holes are filled.
    RealOptions real;
    /// Layered: edges and disocclusions.
    LayeredOptions layered;

    /// All fields, to compare or save them. @param o the options @return references to its fields
    template <typename Options>
    static auto fields(Options& o) {
        return std::tie(o.method, o.strengthPercent, o.focus, o.refinement, o.real, o.layered);
    }
};

/// Whether options are equal. @param a one @param b the other @return true if all fields are
[[nodiscard]] inline bool operator==(const RealOptions& a, const RealOptions& b) {
    return RealOptions::fields(a) == RealOptions::fields(b);
}
/// As above. @param a one @param b the other @return true if all fields are
[[nodiscard]] inline bool operator==(const LayeredOptions& a, const LayeredOptions& b) {
    return LayeredOptions::fields(a) == LayeredOptions::fields(b);
}
/// As above. @param a one @param b the other @return true if all fields are
[[nodiscard]] inline bool operator==(const ViewOptions& a, const ViewOptions& b) {
    return ViewOptions::fields(a) == ViewOptions::fields(b);
}

/// Checks all options, including those of the other methods.
/// @param options the options to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const ViewOptions& options);

/// Parallax between adjacent views.
struct AdjacentParallax {
    double viewPixels = 0;  ///< px of a view.
    double panelPixels = 0; ///< px of the panel.
};

/// Above this parallax between adjacent views (px of a view) hard edges begin to appear double.
constexpr double kParallaxBudgetPixels = 5;

/// The largest parallax between adjacent views for a depth range: docs/mathematics.md, (3.3), with
/// d the end of the range that is farther from the focus. Arguments are not checked.
/// @param options strength and focus
/// @param quilt layout: view count and view size
/// @param panelSize size of the panel in px
/// @param depthRange smallest and largest depth in the picture, each 0..1
/// @return the parallax, 0 or more; 0 for fewer than two views
[[nodiscard]] ALTIRO3D_EXPORT AdjacentParallax adjacentParallax(const ViewOptions& options,
                                                                const QuiltLayout& quilt,
                                                                cv::Size panelSize,
                                                                cv::Vec2d depthRange = {0, 1});

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
    CameraIntrinsics intrinsics; ///< Intrinsics of the photo.
    double zNear = 1;            ///< Distance at depth 1, 1e-6..1e9.
    /// Distance at depth 0, > zNear; may be infinite.
    double zFar = std::numeric_limits<double>::infinity();
    /// Distance of the outermost cameras from the photo's, 0..1e9. The camera of view p lies p
    /// times this to the right of the photo's.
    double baseline = 0;
};

/// Checks a camera.
/// @param camera the camera to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const Camera& camera);

/// Reads a camera from a JSON object with the numbers fx, fy, cx, cy, zNear, zFar and baseline; all
/// are required. zFar may be null, which means infinity. Other fields are ignored.
/// @param path the file, at most 1 MiB
/// @return the camera; it is valid
/// @throws Error NotFound, ReadFailed, TooLarge, OutOfMemory, or BadFormat that names the file, the
///         field, its value and what was expected
[[nodiscard]] ALTIRO3D_EXPORT Camera readCamera(const std::filesystem::path& path);

/// As readCamera(), from text.
/// @param json the file's contents
/// @param source the file's name, for errors
/// @return the camera; it is valid
/// @throws Error BadFormat that names source, field, value and what was expected
[[nodiscard]] ALTIRO3D_EXPORT Camera parseCamera(const std::string& json,
                                                 const std::string& source);

/// Intrinsics after cropping and resizing the picture. Pixel corners map to pixel corners, so the
/// half px between corner and centre is scaled as well.
/// @param intrinsics intrinsics of the whole picture
/// @param part the crop in px of that picture; fractions allowed
/// @param size size of the result in px, at least 1 x 1
/// @return intrinsics in px of the result
/// @throws Error InvalidArgument (an empty part or size)
[[nodiscard]] ALTIRO3D_EXPORT CameraIntrinsics fitted(const CameraIntrinsics& intrinsics,
                                                      const cv::Rect2d& part, cv::Size size);

/// Parallax S between the outermost views for a depth difference of 1: 2 fx baseline (1/zNear -
/// 1/zFar), docs/mathematics.md, (3.5). It replaces strength % of the width.
/// @param camera the camera; its intrinsics in px of the picture that S is for
/// @return S in px
/// @throws Error InvalidArgument (camera)
[[nodiscard]] ALTIRO3D_EXPORT double parallaxOf(const Camera& camera);

} // namespace altiro3D
