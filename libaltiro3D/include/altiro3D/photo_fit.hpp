#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/scene.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <tuple>

namespace altiro3D {

/// How a picture is fitted to another shape.
enum class FitMode {
    Cover,   ///< Fills the panel; the excess is cropped, equally on both sides unless framed.
    Contain, ///< Shows all of the picture; black bars fill the rest.
    Stretch  ///< Shows all of the picture, distorted to the panel's shape.
};

/// The part of a picture that is shown. It is moved inside if it would extend beyond the picture.
struct Framing {
    /// Centre in widths and heights of the picture, each 0..1; (0, 0) is the top left corner.
    cv::Point2d centre{0.5, 0.5};
    /// Enlargement, 1..1000, relative to the fit by FitMode.
    double zoom = 1;

    /// All fields, to compare or save them. @param o the framing @return references to its fields
    template <typename Part>
    static auto fields(Part& o) {
        return std::tie(o.centre.x, o.centre.y, o.zoom);
    }
};

/// Whether two framings are equal. @param a one @param b the other @return true if all fields are
[[nodiscard]] inline bool operator==(const Framing& a, const Framing& b) {
    return Framing::fields(a) == Framing::fields(b);
}
/// Whether two framings differ. @param a one @param b the other @return true if a field does
[[nodiscard]] inline bool operator!=(const Framing& a, const Framing& b) {
    return !(a == b);
}

/// With a zoom above 1, the part that is shown must have at least this many rows and columns.
constexpr int kMinFramedPixels = 16;

/// The source and target rectangles of a fit, and its margins:
///
///     picture   |     |<----- source ----->|           |
///     fitted    |left |<----- size ------->|right|          leftMargin, rightMargin
struct PhotoFit {
    cv::Rect source; ///< Part of the picture that the panel shows, in its px.
    cv::Rect target; ///< Its position on the panel, in px; the rest is black.
    cv::Size size;   ///< Size of the picture on the panel in px.
    /// Columns of the fitted picture left of `size`. They show what lies to the left of `source` in
    /// the picture, at the same scale; views from the side show them at the edges of the panel.
    int leftMargin = 0;
    int rightMargin = 0; ///< The same at the right.

    /// Size of the fitted picture. @return `size` with both margins
    [[nodiscard]] cv::Size fittedSize() const {
        return {leftMargin + size.width + rightMargin, size.height};
    }
    /// The columns of the fitted picture that the panel shows. @return those between the margins
    [[nodiscard]] cv::Range shown() const { return {leftMargin, leftMargin + size.width}; }
    /// The part of the fitted picture that is not black. @return `target` with both margins
    [[nodiscard]] cv::Rect filled() const {
        return {target.x, target.y, leftMargin + target.width + rightMargin, target.height};
    }
};

/// Adds margins to a fit: narrower where the picture ends, none beside bars at the left or right.
/// @param fit without margins, from fitPhoto()
/// @param picture size of the picture in px that the fit was made for
/// @param pixels wanted width of each margin, px of the result, 0 or more
/// @return the fit with margins
/// @throws Error as applyFit(), InvalidArgument (negative pixels)
[[nodiscard]] ALTIRO3D_EXPORT PhotoFit withMargins(const PhotoFit& fit, cv::Size picture,
                                                   int pixels);

/// Computes the fit to the panel's shape. The result may have another shape (square tiles for a
/// wide panel); the display then stretches it. docs/mathematics.md, (6.1) and (6.2).
/// @param picture size of the picture in px, at least 1 x 1
/// @param panelAspect width : height of the picture on the panel, 0.01..100
/// @param result size of the result in px, at least 1 x 1
/// @param mode crop, bars or distortion
/// @param framing the part to show; with FitMode::Contain, zooming first shrinks the bars
/// @return the fit
/// @throws Error InvalidArgument (out of these ranges; a zoom that leaves fewer than
///         kMinFramedPixels rows or columns)
[[nodiscard]] ALTIRO3D_EXPORT PhotoFit fitPhoto(cv::Size picture, double panelAspect,
                                                cv::Size result, FitMode mode = FitMode::Cover,
                                                const Framing& framing = {});

/// Resamples a picture by a fit: area average to shrink, cubic to enlarge.
/// @param picture [rows x cols, CV_8UC3, BGR], of the size that the fit was made for
/// @param fit from fitPhoto()
/// @param fitted [fit.fittedSize(), CV_8UC3, BGR], always in new memory, so it may be the same
///        object as `picture`
/// @throws Error Mismatch (the fit is for another size), InvalidArgument (type, a fit whose target
///         is not inside its result, margins that the picture does not have)
ALTIRO3D_EXPORT void applyFit(const cv::Mat& picture, const PhotoFit& fit, cv::Mat& fitted);

/// Resamples a depth map for a fitted photo. Bars get the depth of the focus, so they do not move.
/// @param depth [any size, CV_32FC1, 0..1]; covers the whole photo
/// @param photoSize size in px of the photo that the fit was made for
/// @param fit from fitPhoto()
/// @param fittedPhoto [fit.fittedSize(), CV_8UC3, BGR], the photo after applyFit(); fitDepth()
///        aligns depth edges with it. Empty: depth is enlarged by linear interpolation, which is
///        faster and sufficient for method Fast
/// @param focus depth of the bars, 0..1
/// @param fitted [fit.fittedSize(), CV_32FC1, 0..1]
/// @throws Error Mismatch (the fit is for another size, the fitted photo has another size),
///         InvalidArgument (types, focus, a fit as for applyFit())
ALTIRO3D_EXPORT void applyFitToDepth(const cv::Mat& depth, cv::Size photoSize, const PhotoFit& fit,
                                     const cv::Mat& fittedPhoto, double focus, cv::Mat& fitted);

/// Measures how the depth of a scene differs from its photo. For DepthEdges::Matched, growth and
/// shift are 0; for DepthEdges::Aligned, only mixed px are measured.
/// @param scene photo and depth of one size
/// @return the flaws
/// @throws Error as measureDepthFlaws() of photo and depth
[[nodiscard]] ALTIRO3D_EXPORT DepthFlaws measureDepthFlaws(const Scene& scene);

/// Refines the depth of a scene: refineDepth(), with measureDepthFlaws() of the scene unless the
/// options have flaws. Sets Scene::mixedPixels.
/// @param scene photo and depth of one size; its refined depth is newly allocated
/// @param options how the depth is refined
/// @param part the part of the photo that has no bars, within the photo; empty: all of it
/// @return the flaws that were corrected
/// @throws Error as refineDepth(), InvalidArgument (part)
ALTIRO3D_EXPORT DepthFlaws refineScene(Scene& scene, const DepthRefineOptions& options = {},
                                       const cv::Rect& part = {});

/// Fits a photo and its depth map to the panel's shape: applyFit(), applyFitToDepth(), and then
/// refineScene() inside the bars. If the fit enlarges the photo 1.25 times or more and the depth
/// map is not larger than the photo, depth is refined first, at the size of the photo. The flaws,
/// except mixed px, are then lengths in px of the photo.
/// @param scene the photo, of the size that the fit was made for, and its depth map of any size
/// @param fit from fitPhoto()
/// @param focus depth of the bars, 0..1
/// @param fitted result: all of fit.fittedSize(), with the margins outside of Scene::shown; may be
///        `scene`; unchanged if an error is thrown
/// @param refine how the depth is refined; its flaws, if set, are used instead of measured ones
/// @return the flaws that were corrected
/// @throws Error as applyFit(), applyFitToDepth(), refineDepth() and checkDepthRange()
ALTIRO3D_EXPORT DepthFlaws fitScene(const Scene& scene, const PhotoFit& fit, double focus,
                                    Scene& fitted, const DepthRefineOptions& refine = {});

} // namespace altiro3D
