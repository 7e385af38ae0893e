#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

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
};

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

/// The settings that chooseFromScene() and chooseStrength() choose; the others stay
/// (docs/mathematics.md, 7).
struct AutoChoices {
    bool framing = false;  ///< Centre of the part that is shown; needs FitMode::Cover.
    bool focus = false;    ///< The depth of the subject.
    bool strength = false; ///< As much parallax as the display shows without double edges.
    /// The given strength, but of estimated depth at most strengthLimit().
    bool limit = false;

    /// Whether something is chosen. @return true if a field is
    [[nodiscard]] bool any() const { return framing || focus || strength || limit; }
};

/// Limit of the result of chooseStrength(), %.
constexpr double kMaxAutoStrength = 12;
/// With chooseStrength(), content moves by at most this part of the width between the outermost
/// views, %: as with strength 10 and focus 0.5.
constexpr double kMaxAutoParallax = 5;
/// With chooseStrength(), at most this part of an outermost view shows what the photo does not, or
/// stretched px, %. Much depth on few px, and depth that is in doubt, thus get less strength.
constexpr double kMaxAutoHidden = 5;
/// Width of the border of a scan that withoutScanBorder() may cut at a side, % of the photo's.
constexpr double kMaxScanBorder = 3;
/// insideViews() enlarges a photo by at most this for what views show beside it, %; by twice as
/// much if that is the border of a scan, which stands out.
constexpr double kMaxSideZoom = 5;

/// How likely each place of a scene belongs to its subject: places that are sharp, near, nearer
/// than others in their row, and close to the middle have large weights; (7.1).
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [any size, CV_32FC1, 0..1, 1 = nearest]; shows all of the photo. NaN counts as 0.
/// @param weights [size of the photo, scaled down to at most 320 px per side, CV_32SC1, 1..65535];
///        the same for any number of threads and on any processor
/// @throws Error InvalidArgument (empty or wrong type)
ALTIRO3D_EXPORT void subjectWeights(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& weights);

/// The part of a scene that fills the panel and has the largest weights; (7.2).
///
/// @param weights from subjectWeights()
/// @param picture size of the photo in px
/// @param panelAspect width : height of the panel, 0.01..100
/// @param zoom 1..1000
/// @return the framing, for FitMode::Cover, with this zoom
/// @throws Error as fitPhoto(), InvalidArgument (weights)
[[nodiscard]] ALTIRO3D_EXPORT Framing frameSubject(const cv::Mat& weights, cv::Size picture,
                                                   double panelAspect, double zoom = 1);

/// Depth of the subject: the median of the depth, weighted with the squares of the weights.
///
/// @param weights from subjectWeights()
/// @param depth of the same scene
/// @param part the part of the scene that is shown, in its widths and heights
/// @return 0..1
/// @throws Error InvalidArgument (types, a part that is not inside)
[[nodiscard]] ALTIRO3D_EXPORT double subjectDepth(const cv::Mat& weights, const cv::Mat& depth,
                                                  const cv::Rect2d& part = {0, 0, 1, 1});

/// The largest strength that a display shows without double edges: parallax between adjacent views
/// stays within kParallaxBudgetPixels, content moves by at most kMaxAutoParallax, and the strength
/// is at most kMaxAutoStrength; (7.3). Arguments are not checked.
///
/// @param focus depth on the panel's surface, 0..1
/// @param quilt layout: view count and view size
/// @param depthRange smallest and largest depth in the picture, each 0..1
/// @return strength in %
[[nodiscard]] ALTIRO3D_EXPORT double chooseStrength(double focus, const QuiltLayout& quilt,
                                                    cv::Vec2d depthRange);

/// The strength at which kMaxAutoHidden of an outermost view was hidden or is stretched; (7.4).
/// Arguments are not checked.
///
/// @param depth of what is shown [rows x cols, CV_32FC1, 0..1]
/// @return strength in %; infinite if the depth is level
[[nodiscard]] ALTIRO3D_EXPORT double strengthLimit(const cv::Mat& depth);

/// The same as for a depth range, for the depth of a picture, and at most strengthLimit().
/// Arguments are not checked.
///
/// @param focus depth on the panel's surface, 0..1
/// @param quilt layout: view count and view size
/// @param depth of what is shown [rows x cols, CV_32FC1, 0..1]
/// @return strength in %
[[nodiscard]] ALTIRO3D_EXPORT double chooseStrength(double focus, const QuiltLayout& quilt,
                                                    const cv::Mat& depth);

/// Chooses framing and focus of a scene, if `choices` requests them.
///
/// @param scene photo and depth, before the fit
/// @param panelAspect width : height of what fills the panel, in px of the photo, 0.01..100
/// @param fit how the photo is fitted
/// @param choices what to choose; the strength is left to chooseStrength(), after the fit
/// @param framing its centre is set if choices.framing
/// @param focus set if choices.focus
/// @throws Error as the functions above, InvalidArgument (framing is to be chosen, but fit is not
///         Cover)
ALTIRO3D_EXPORT void chooseFromScene(const Scene& scene, double panelAspect, FitMode fit,
                                     const AutoChoices& choices, Framing& framing, double& focus);

/// Finds the border of a scan: rows and columns at the rim that have nearly one colour and end in a
/// step all along. What goes on beyond kMaxScanBorder is a part of the photo, such as a night sky.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @return the part of the photo inside; all of it if there is no border
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT cv::Rect withoutScanBorder(const cv::Mat& photo);

/// Moves and enlarges what is shown so that no view looks beyond a part of the photo, as far as
/// kMaxSideZoom allows; (7.5). The depth at the sides determines how far views look.
///
/// @param scene photo and depth, before the fit
/// @param inside the part of the photo that may be seen, from withoutScanBorder()
/// @param panelAspect width : height of what fills the panel, in px of the photo, 0.01..100
/// @param framing the part that is shown, for FitMode::Cover
/// @param options strength and focus
/// @return the framing; as it was if fewer than kMinFramedPixels would be left
/// @throws Error as fitPhoto(), InvalidArgument (type, part)
[[nodiscard]] ALTIRO3D_EXPORT Framing insideViews(const Scene& scene, const cv::Rect& inside,
                                                  double panelAspect, const Framing& framing,
                                                  const ViewOptions& options);

} // namespace altiro3D
