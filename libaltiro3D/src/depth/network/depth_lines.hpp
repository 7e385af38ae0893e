#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace altiro3D {

/// The long straight edges of a photo.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @return x and y of both ends, px; those along the frame, as scans have them, are left out
[[nodiscard]] std::vector<cv::Vec4f> findLines(const cv::Mat& photo);

/// Pulls the depth on both sides of straight edges to what a straight line in space has: inverse
/// depth that is affine along it, (4.16) and (4.17) of docs/mathematics.md. Surfaces follow as far
/// as they have no step. An edge that departs too far is not one line, and stays.
///
/// @param lines from findLines() of the photo
/// @param depth [rows x cols of the photo, CV_32FC1, finite, about 0..1, 1 = nearest] changed in
///        place. The same bytes for any number of threads.
void straightenLines(const std::vector<cv::Vec4f>& lines, cv::Mat& depth);

} // namespace altiro3D
