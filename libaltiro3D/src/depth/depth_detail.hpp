#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Returns the fine detail of a depth map that smoothing took: noise has hardly any detail of a few
/// px, but the steps have (docs/mathematics.md, 4a.1). What is as weak as usual stays away.
///
/// @param measured [rows x cols, CV_32FC1, 0..1] before smoothing
/// @param smooth [as measured] after smoothing, changed in place; the same bytes for any number of
///        threads and all instruction sets
void returnDetail(const cv::Mat& measured, cv::Mat& smooth);

} // namespace altiro3D
