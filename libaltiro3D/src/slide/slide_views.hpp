#pragma once

#include "slide/slide_solver.hpp"

#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace altiro3D {

/// Virtual cameras in a row along the path, which all look in the same direction, and their window.
/// A camera at position s sees a point of inverse depth q in the column
///
///     focal (x - s (q - focus)) + middle.x
///
/// so points whose q is `focus` stay in their columns.
struct SlideWindow {
    cv::Size size;      ///< Size of the views, px.
    double focal = 0;   ///< px
    cv::Point2d middle; ///< Middle of the picture of the camera at 0, px.
    double focus = 0;
};

/// The same window with views of another size.
SlideWindow scaled(const SlideWindow& window, cv::Size size);

/// A picture of the clip and its camera.
struct SlideFrame {
    cv::Mat picture;   ///< [any size, CV_8UC3, BGR]
    double aspect = 1; ///< Height : width before its size was rounded.
    SlideCamera camera;
};

/// The view of a camera at `position`, made from one frame.
/// @param depth [window size, CV_32FC1] inverse depth of each px; empty: all have that of the focus
cv::Mat viewFrom(const SlideFrame& frame, const SlideLens& lens, const SlideWindow& window,
                 double position, const cv::Mat& depth = {});

/// The part of the plane of the focus that all cameras see: in px of a window whose focal length is
/// 1 and whose middle is at 0. @param aspect height : width of the frames
cv::Rect2d commonPart(const std::vector<SlideCamera>& cameras, const SlideLens& lens, double aspect,
                      double focus);

/// The inverse depth of what two frames see, by matching them.
struct SlideDepths {
    cv::Mat left;  ///< [window size, CV_32FC1, NaN = unknown], as the camera at the position of the
                   ///< left frame sees it
    cv::Mat right; ///< The same for the right frame.
};
/// @param left the frame with the smaller position
/// @param low,high range of inverse depth in the scene
SlideDepths matchFrames(const SlideFrame& left, const SlideFrame& right, const SlideLens& lens,
                        const SlideWindow& window, double low, double high);

/// The view of a camera between two frames: each px of both is moved to its place in it; what only
/// one of them shows comes from that one.
cv::Mat viewBetween(const SlideFrame& left, const SlideFrame& right, const SlideLens& lens,
                    const SlideWindow& window, double position, const SlideDepths& depths);

/// The share of the places seen by only one of two frames that look like what is in front of them.
/// It is small if near and far are right, because they then look like what is behind. 0.5: unknown.
/// @param pairs left and right frames @param low,high as for matchFrames()
double frontShare(const std::vector<std::pair<SlideFrame, SlideFrame>>& pairs,
                  const SlideLens& lens, const SlideWindow& window, double low, double high);

/// The median of the known values of each px. @param depths one or more of one size
cv::Mat medianDepth(const std::vector<cv::Mat>& depths);

} // namespace altiro3D
