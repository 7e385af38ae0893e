#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/view_options.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

/// Framing, focus and strength that follow from the scene: docs/mathematics.md, section 7.
namespace altiro3D {

/// The settings that chooseFromScene() and chooseStrength() choose; the others stay.
struct AutoChoices {
    bool framing = false;  ///< Centre of the part that is shown; needs FitMode::Cover.
    bool focus = false;    ///< The depth of the subject.
    bool strength = false; ///< As much parallax as the display shows without double edges.

    /// Whether something is chosen. @return true if a field is
    [[nodiscard]] bool any() const { return framing || focus || strength; }
};

/// Limit of the result of chooseStrength(), %.
constexpr double kMaxAutoStrength = 20;
/// With chooseStrength(), content moves by at most this part of the width between the outermost
/// views, %: as with strength 10 and focus 0.5.
constexpr double kMaxAutoParallax = 5;

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

} // namespace altiro3D
