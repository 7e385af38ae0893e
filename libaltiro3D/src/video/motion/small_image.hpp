#pragma once

#include <opencv2/core/mat.hpp>

/// Small grey copies of the images of a video, for the motion search. The code is serial, so
/// results are the same for any number of threads.
namespace altiro3D {

/// Longest side of the small image, px.
constexpr int kSmallSide = 192;

/// The picture's area average with at most kSmallSide px per side.
/// @param picture [rows x cols, CV_8UC3, BGR]
/// @return [small rows x cols, CV_8UC3, BGR]
cv::Mat smallImage(const cv::Mat& picture);

/// Half the size, each px the mean of four. @param grey [CV_8UC1] @return [CV_8UC1]
cv::Mat halved(const cv::Mat& grey);

/// Scales a grey image to the brightness of `now`, by the median of their ratio over cells of 4 x 4
/// px. Differences of exposure and fades are thus removed.
/// @param grey, now [equal sizes, CV_8UC1]
/// @return [CV_8UC1]
cv::Mat matchedBrightness(const cv::Mat& grey, const cv::Mat& now);

/// Standard deviation of a picture's brightness. @param grey [CV_8UC1]
double contrastOf(const cv::Mat& grey);

} // namespace altiro3D
