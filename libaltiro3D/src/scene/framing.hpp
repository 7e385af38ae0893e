#pragma once

#include "altiro3D/photo_fit.hpp"
#include "altiro3D/view_options.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// The part of a photo that the panel shows: PhotoFit::source of fitPhoto(), which does not depend
/// on the size of the result.
inline cv::Rect shownPart(cv::Size photo, double panelAspect, FitMode mode,
                          const Framing& framing) {
    return fitPhoto(photo, panelAspect, {1, 1}, mode, framing).source;
}

/// How likely each place of a scene belongs to its subject: places that are sharp, near, nearer
/// than others in their row, and close to the middle have large weights; (7.1).
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [any size, CV_32FC1, 0..1, 1 = nearest]; shows all of the photo. NaN counts as 0.
/// @param weights [size of the photo, scaled down to at most 320 px per side, CV_32SC1, 1..65535];
///        the same for any number of threads and on any processor
/// @throws Error InvalidArgument (empty or wrong type)
void subjectWeights(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& weights);

/// The part of a scene that fills the panel and has the largest weights; (7.2).
/// @param weights from subjectWeights()
/// @param picture size of the photo in px
/// @param panelAspect width : height of the panel, 0.01..100
/// @param zoom 1..1000
/// @return the framing, for FitMode::Cover, with this zoom
/// @throws Error as fitPhoto(), InvalidArgument (weights)
Framing frameSubject(const cv::Mat& weights, cv::Size picture, double panelAspect, double zoom = 1);

/// Depth of the subject: the median of the depth, weighted with the squares of the weights.
/// @param weights from subjectWeights()
/// @param depth of the same scene
/// @param part the part of the scene that is shown, in its widths and heights
/// @return 0..1
/// @throws Error InvalidArgument (types, a part that is not inside)
double subjectDepth(const cv::Mat& weights, const cv::Mat& depth,
                    const cv::Rect2d& part = {0, 0, 1, 1});

/// Width of the border of a scan that withoutScanBorder() may cut at a side, % of the photo's.
constexpr double kMaxScanBorder = 3;
/// The most by which insideViews() enlarges a photo to hide what views would show beside it, %;
/// twice as much if the border of a scan lies there, which stands out.
constexpr double kMaxSideZoom = 5;

/// Finds the border of a scan: rows and columns at the rim that have nearly one colour and end in a
/// step all along. What goes on beyond kMaxScanBorder is a part of the photo, such as a night sky.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @return the part of the photo inside; all of it if there is no border
/// @throws Error InvalidArgument (empty or wrong type)
cv::Rect withoutScanBorder(const cv::Mat& photo);

/// Moves and enlarges what is shown so that no view looks beyond a part of the photo, as far as
/// kMaxSideZoom allows; (7.5). The depth at the sides determines how far views look.
/// @param scene photo and depth, before the fit
/// @param inside the part of the photo that may be seen, from withoutScanBorder()
/// @param panelAspect width : height of what fills the panel, in px of the photo, 0.01..100
/// @param framing the part that is shown, for FitMode::Cover
/// @param options strength and focus
/// @return the framing; as it was if fewer than kMinFramedPixels would be left
/// @throws Error as fitPhoto(), InvalidArgument (type, part)
Framing insideViews(const Scene& scene, const cv::Rect& inside, double panelAspect,
                    const Framing& framing, const ViewOptions& options);

/// The largest strength for a range of depth without double edges and too large shifts; (7.3).
/// @param depthRange smallest and largest depth @return %, at most kMaxAutoStrength
double strengthOfRange(double focus, const QuiltLayout& quilt, cv::Vec2d depthRange);

} // namespace altiro3D
