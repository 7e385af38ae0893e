#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <opencv2/core/types.hpp>

namespace altiro3D {

/// How holes are painted that no pixel of the photo belongs to.
enum class Inpainting {
    Telea,       ///< Fast marching (Telea 2004).
    NavierStokes ///< Continues lines of equal brightness (Bertalmio et al. 2001).
};

/// What method Real does with what the photo does not show.
struct RealOptions {
    Inpainting inpainting = Inpainting::Telea; ///< See Inpainting.
    double inpaintingRadius = 3; ///< How far around a hole's pixel is looked, px, 1..20.
    bool backgroundOnly = false; ///< Paint what was hidden from what lies behind only, not from the
                                 ///< thing that hid it, too; false is the published method.
};

/// Checks options.
/// @param options what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const RealOptions& options);

/// How views are made from a photo and its depth.
enum class ViewMethod {
    Fast,   ///< Backward map read at the destination pixel, linear: cheap, no holes, soft at edges.
    Real,   ///< Each pixel projected into the virtual camera, nearest first; holes inpainted.
    Layered ///< Rows of surfaces, cut at depth steps, over a background that is painted once.
};

/// What a disocclusion shows: the part of the background that the photo does not.
enum class LayeredFill {
    Continue,       ///< The background's border pixel, repeated along the row.
    BackgroundLayer ///< A hidden background, painted once behind the foreground, for all views.
};

/// Knobs of method Layered; the defaults were measured (docs/tradeoff.md).
struct LayeredOptions {
    /// Neighbours are torn apart where their depth step moves them apart by more than this in the
    /// outermost view, px, > 0, at most 1000; less stretches the surface between them.
    double tearPixels = 1;
    /// Background pixels at a tear that go with the foreground, since they are mixed with its
    /// colour, px, 0..8. Where the photo shows the border clearly, it decides.
    int edgeDilationPixels = 1;
    /// Depth steps spread over some twice as many px are made sharp, as networks draw them soft,
    /// px, 0..8; 0 if depth is exact.
    int softEdgePixels = 2;
    /// See LayeredFill.
    LayeredFill fill = LayeredFill::BackgroundLayer;
};

/// What the views look like.
struct ViewOptions {
    ViewMethod method = ViewMethod::Layered; ///< See ViewMethod.
    /// Parallax between the outermost views of two things that lie a whole depth range apart, in %
    /// of the picture's width, 0..10000.
    double strengthPercent = 10;
    /// Depth of zero parallax, 0 (farthest) .. 1 (nearest): it appears on the panel's surface.
    double focus = 0.5;
    /// Fast: fixed-point steps that read depth where a px comes from instead of where it goes to, 0
    /// (as published) .. 16.
    int refinement = 0;
    /// Real: what is done about holes.
    RealOptions real;
    /// Layered: edges and what they hide.
    LayeredOptions layered;
};

/// Checks options, also those of methods that are not chosen.
/// @param options what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const ViewOptions& options);

/// How far things move from one view to the next.
struct AdjacentParallax {
    double viewPixels = 0;  ///< In px of a view.
    double panelPixels = 0; ///< In px of the panel.
};

/// Above this parallax between adjacent views, in px of a view, hard edges begin to show double.
constexpr double kParallaxBudgetPixels = 5;

/// The largest parallax between adjacent views that a depth map gives: docs/mathematics.md, (3.3),
/// with d the end of the range that is farther from the focus. Nothing is checked.
///
/// @param options strength and focus
/// @param quilt view count and size
/// @param panelSize panel in px
/// @param depthRange smallest and largest depth in the picture, each 0..1
/// @return the parallax, 0 or more; 0 for less than two views
ALTIRO3D_EXPORT AdjacentParallax adjacentParallax(const ViewOptions& options,
                                                  const QuiltLayout& quilt, cv::Size panelSize,
                                                  cv::Vec2d depthRange = {0, 1});

} // namespace altiro3D
