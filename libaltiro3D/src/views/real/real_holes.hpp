#pragma once

#include "altiro3D/view_options.hpp"

#include <opencv2/core/mat.hpp>

/// Method Real: filling the pixels of a view that the photo does not show.
namespace altiro3D {

/// Data of a warped view besides its colours.
struct Warped {
    cv::Mat holes;    // [as photo, CV_8UC1, 255 = hole]
    cv::Mat nearness; // [as photo, CV_32FC1, px of parallax]
};

/// Fills cracks by a median and inpaints the other holes.
/// @param view [as photo, CV_8UC3, BGR], in and out; at least one px is not a hole
/// @param warped modified
void fillHoles(cv::Mat& view, Warped& warped, const RealOptions& options);

/// Fills holes of a view in place by cv::inpaint, each group of holes separately. The result equals
/// inpainting the whole picture at a lower cost.
/// @param view [rows x cols, CV_8UC3, BGR]
/// @param holes [as view, CV_8UC1, not 0 = hole]
void inpaintHoles(cv::Mat& view, const cv::Mat& holes, const RealOptions& options);

} // namespace altiro3D
