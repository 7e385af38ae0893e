#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
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

/// Checks options.
/// @param options the options to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const RealOptions& options);

/// How views are rendered from a photo and its depth.
enum class ViewMethod {
    Fast,   ///< Backward mapping, depth read at the destination pixel: no holes, soft edges.
    Real,   ///< Projects each pixel into the virtual camera, the nearest wins; holes are inpainted.
    Layered ///< Surfaces per row, cut at depth steps, over a background that is painted once.
};

/// What a disocclusion shows, i.e. a part of the background that is hidden in the photo.
enum class LayeredFill {
    Continue,       ///< The border pixel of the background, repeated along the row.
    BackgroundLayer ///< A hidden background, painted once behind the foreground for all views.
};

/// Options of method Layered. The defaults were chosen by measurement (docs/lab/views.md).
struct LayeredOptions {
    /// The surface between neighbouring pixels is torn if their depth step moves them apart by more
    /// than this in the outermost view, px, > 0, at most 1000. Below, the surface is stretched.
    double tearPixels = 1;
    /// Background pixels at a tear that move with the foreground, because they are mixed with its
    /// colour, px, 0..8. Where the photo shows the border clearly, the photo decides instead.
    int edgeDilationPixels = 1;
    /// Whether colours at the borders of near things, where px show what is behind them as well,
    /// are split: each part moves with its own surface. false: all of a px moves with the near
    /// thing.
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
    /// Fast: fixed-point iterations that read depth at the source pixel instead of the destination,
    /// 0 (as published) .. 16. NativeOptions::refine is another thing: it corrects the depth.
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

/// Adds the margins that views from the side show at the edges of the panel. Their width is the
/// largest shift, rounded up to a multiple of 1/32 of the result's width (so small changes of the
/// options keep the fit), and at most half the width.
///
/// @param fit from fitPhoto()
/// @param picture size of the picture in px that the fit was made for
/// @param options strength and focus of the views
/// @return the fit with margins, as withMargins(fit, picture, pixels)
/// @throws Error InvalidArgument (options)
[[nodiscard]] ALTIRO3D_EXPORT PhotoFit withMargins(const PhotoFit& fit, cv::Size picture,
                                                   const ViewOptions& options);

/// Parallax between adjacent views.
struct AdjacentParallax {
    double viewPixels = 0;  ///< px of a view.
    double panelPixels = 0; ///< px of the panel.
};

/// Above this parallax between adjacent views (px of a view) hard edges begin to appear double.
constexpr double kParallaxBudgetPixels = 5;

/// The largest parallax between adjacent views for a depth range: docs/mathematics.md, (3.3), with
/// d the end of the range that is farther from the focus. Arguments are not checked.
///
/// @param options strength and focus
/// @param quilt layout: view count and view size
/// @param panelSize size of the panel in px
/// @param depthRange smallest and largest depth in the picture, each 0..1
/// @return the parallax, 0 or more; 0 for fewer than two views
[[nodiscard]] ALTIRO3D_EXPORT AdjacentParallax adjacentParallax(const ViewOptions& options,
                                                                const QuiltLayout& quilt,
                                                                cv::Size panelSize,
                                                                cv::Vec2d depthRange = {0, 1});

} // namespace altiro3D
