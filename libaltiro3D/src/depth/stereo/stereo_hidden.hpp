#pragma once

#include "altiro3D/scene.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// What only the right eye of a pair sees, where the left eye would see it if nothing stood before
/// it:
///
///     right picture      b b b b h h h T T T b b     h: seen by the right eye only
///     left picture       b b b T T T b b b b b b     T: a thing, b: background
///     hidden layer       . . . . h h . . . . . .     of the left picture: behind T
///
/// @param right [rows x cols, CV_8UC3, BGR], its rows moved to those of the left picture
/// @param leftDisparity [as right, CV_32FC1], shares of the width, all known
/// @param rightDisparity the same for the px of the right picture
/// @return colours, and their disparities as HiddenLayer::depth
HiddenLayer hiddenByRight(const cv::Mat& right, const cv::Mat& leftDisparity,
                          const cv::Mat& rightDisparity);

} // namespace altiro3D
