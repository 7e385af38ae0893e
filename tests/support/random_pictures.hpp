#pragma once

#include <opencv2/core.hpp>

namespace altiro3D::test {

/// Noise of any type, from `low` to below `high`, the same for the same seed. [size, type]
cv::Mat randomPicture(cv::Size size, int type, int seed = 1, double low = 0, double high = 256);

/// A photo of noise, the same for the same seed.
/// @param blur sigma of a blur in px, 0 = none
/// @return [size, CV_8UC3]
cv::Mat randomPhoto(cv::Size size, int seed = 1, double blur = 1.2);

/// Large soft blotches of full contrast, the same for the same seed, like a scene without detail.
/// @return [size, CV_8UC3]
cv::Mat scenery(cv::Size size, int seed);

/// A depth map of noise, 0..1, the same for the same seed. [size, CV_32FC1]
cv::Mat randomDepth(cv::Size size, int seed = 2);

} // namespace altiro3D::test
