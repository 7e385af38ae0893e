#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Memory that renderFast() reuses from call to call; one per thread.
struct FastBuffers {
    cv::Mat mapX;
    cv::Mat mapY;
};

/// Method Fast: view(x, y) = photo(x + shift (depth(x, y) - focus), y), linear, borders repeated.
///
/// @param photo [rows x cols, CV_8UC3]
/// @param depth [as photo, CV_32FC1]
/// @param shiftPixels p S/2: displacement in px for one whole depth range
/// @param focus depth of zero parallax
/// @param view [as photo, CV_8UC3], allocated, not the photo
/// @param buffers memory to reuse
void renderFast(const cv::Mat& photo, const cv::Mat& depth, double shiftPixels, double focus,
                cv::Mat& view, FastBuffers& buffers);

} // namespace altiro3D
