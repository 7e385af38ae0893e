#pragma once

#include "altiro3D/camera.hpp"

#include <opencv2/core/mat.hpp>

/// Method Real: what is done about the pixels of a view that the photo does not show.
namespace altiro3D {

/// What is known of a view on its way, beside its colours.
struct Warped {
    cv::Mat holes;    // [as photo, CV_8UC1, 255 = hole]
    cv::Mat nearness; // [as photo, CV_32FC1, px of parallax]
};

/// Gives cracks a median and inpaints what is left.
/// @param view [as photo, CV_8UC3, BGR], in and out; at least one px is no hole
/// @param warped changed on the way
void fillHoles(cv::Mat& view, Warped& warped, const RealOptions& options);

/// Fills holes of a view in place by cv::inpaint, each group of holes on its own: the same picture
/// as inpainting the whole, without its cost.
///
/// @param view [rows x cols, CV_8UC3, BGR]
/// @param holes [as view, CV_8UC1, not 0 = hole]
void inpaintHoles(cv::Mat& view, const cv::Mat& holes, const RealOptions& options);

} // namespace altiro3D
