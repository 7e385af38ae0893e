#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Puts the layout of one depth map under the detail of another: detail + share * (layout -
/// smoothed detail). What is smoother than 1/80 of the longer side is layout (docs/lab/depth.md).
///
/// @param layout [any size, CV_32FC1, 0..1]
/// @param share of `layout`, 0..1; the rest of the layout remains that of `detail`
/// @param detail [rows x cols, CV_32FC1, 0..1] changed in place; may exceed 0..1 a little
void putLayoutUnder(cv::Mat layout, double share, cv::Mat& detail);

} // namespace altiro3D
