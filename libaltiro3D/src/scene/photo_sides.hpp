#pragma once

#include "altiro3D/photo_fit.hpp"
#include "altiro3D/view_options.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// Width of the border of a scan that withoutScanBorder() may cut at a side, % of the photo's.
constexpr double kMaxScanBorder = 3;
/// insideViews() enlarges a photo by at most this for what views show beside it, %; by twice as
/// much if that is the border of a scan, which stands out.
constexpr double kMaxSideZoom = 5;

/// Finds the border of a scan: rows and columns at the rim that have nearly one colour and end in a
/// step all along. What goes on beyond kMaxScanBorder is a part of the photo, such as a night sky.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @return the part of the photo inside; all of it if there is no border
/// @throws Error InvalidArgument (empty or wrong type)
cv::Rect withoutScanBorder(const cv::Mat& photo);

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
Framing insideViews(const Scene& scene, const cv::Rect& inside, double panelAspect,
                    const Framing& framing, const ViewOptions& options);

} // namespace altiro3D
