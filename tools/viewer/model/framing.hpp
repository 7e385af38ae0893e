#pragma once

#include "altiro3D/photo_fit.hpp"

/// The part of a photo that is shown, as the mouse changes it. Nothing here throws for a photo of
/// at least 1 x 1 px and a display.
namespace altiro3D::viewer {

/// The wheel enlarges no further.
constexpr double kMaxZoom = 100;

/// What a framing applies to.
struct FramedPhoto {
    cv::Size size;                ///< Of the photo, px.
    double panelAspect = 1;       ///< Width : height of the panel, 0.01..100.
    FitMode fit = FitMode::Cover; ///< How the photo is fitted.
};

/// The framing that this photo allows: its zoom leaves at least kMinFramedPixels rows and
/// columns.
Framing allowed(const Framing& framing, const FramedPhoto& photo);

/// The framing after the picture was dragged; content follows the mouse, up to the photo's ends.
/// @param by in widths and heights of the picture on the panel
Framing moved(const Framing& framing, const FramedPhoto& photo, cv::Point2d by);

/// The framing after a zoom, 1..kMaxZoom; content at the mouse stays, up to the photo's ends.
/// @param at place of the mouse in the picture on the panel, 0..1 @param factor > 0
Framing zoomed(const Framing& framing, const FramedPhoto& photo, cv::Point2d at, double factor);

} // namespace altiro3D::viewer
