#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Turns the soft steps of a depth map into hard contours where there is evidence for them: the
/// step is steep, and the colours of the photo tell its two sides apart. Other steps stay as soft
/// as they are: views stretch a slope, but tear a step. Steps of differing softness, as depth
/// networks leave them. (4.12) to (4.15) of docs/mathematics.md.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, finite, about 0..1, 1 = nearest] changed in place. The same
///        bytes for any number of threads.
void decideContours(const cv::Mat& photo, cv::Mat& depth);

} // namespace altiro3D
