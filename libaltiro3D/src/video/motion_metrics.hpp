#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// How badly the moved picture fits: mean over 3 x 3 px of |gain before(x + motion) - now|, with
/// the gain of all cells' median, so that exposure and fades do not count.
/// @param before, now [CV_8UC1] @param motion [as now, CV_32FC2, px] @return [CV_32FC1, 0..255]
cv::Mat misfit(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion);

/// How unlike two pictures are once what moved is put back: misfit beside the contrast of the
/// plainer one, and the share of places whose motion differs from their neighbours' (in pictures
/// that have nothing in common it is wild). A new scene is more than kNewScene.
/// @param motion, misfits as findMotion() and misfit() give them @return 0 = the same picture
double unlikeness(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion,
                  const cv::Mat& misfits);

/// Pictures of one shot have at most .23 between neighbours and .34 at double speed, those of
/// different scenes .42 and more (docs/lab/video.md says which).
constexpr double kNewScene = 0.37;

} // namespace altiro3D
