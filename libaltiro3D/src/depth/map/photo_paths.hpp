#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// The photo as pathCosts() needs it, with less noise. @param photo [CV_8UC3] @return the same size
cv::Mat withoutGrain(const cv::Mat& photo);

/// Finds the cost of the cheapest path to each px from the px that have a cost already: a step
/// costs what the colours differ (largest channel, less 3 for noise; docs/mathematics.md, 4b).
/// Approximate: two rounds over the picture.
/// @param photo [rows x cols, CV_8UC3], from withoutGrain()
/// @param perPixel what a step costs in addition
/// @param costs [as photo, CV_32FC1]: 0 or more where paths begin, kFarAway elsewhere
void pathCosts(const cv::Mat& photo, float perPixel, cv::Mat& costs);

/// The cost of a px that no path has reached.
constexpr float kFarAway = 1e9F;

} // namespace altiro3D
