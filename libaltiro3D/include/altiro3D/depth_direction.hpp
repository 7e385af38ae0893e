#pragma once

#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Whether near and far of a depth map look exchanged: far = 1 instead of near = 1.
///
/// Three signs must agree, because a false alarm is worse than a missed one (docs/depth.md):
/// - the depth falls from the top to the bottom: its correlation with the row is -0.3 or less;
/// - the border of the upper half is nearer than the middle, on average;
/// - the depth contradicts the photo: its correlation with estimateDepthFromCues() is -0.3 or less.
///
/// All are measured at 64 x 64 places. For depth with a standard deviation below 0.02 there, the
/// result is false. The third sign takes about 30 ms and is examined only if the first two agree.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth depth map of the photo [any size, CV_32FC1, 0..1, 1 = nearest]; clamped, NaN counts
///        as 0
/// @return true if near and far are probably exchanged
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT bool looksInverted(const cv::Mat& photo, const cv::Mat& depth);

} // namespace altiro3D
