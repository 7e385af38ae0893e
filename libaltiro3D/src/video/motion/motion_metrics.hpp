#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Error of the moved picture: mean over 3 x 3 px of |gain before(x + motion) - now|. The gain is
/// the median over all cells, so exposure and fades do not count.
/// @param before, now [CV_8UC1]
/// @param motion [as now, CV_32FC2, px]
/// @return [CV_32FC1, 0..255]
cv::Mat misfit(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion);

/// Difference of two pictures after motion compensation: the misfit relative to the contrast of the
/// less contrasty picture, plus the share of cells whose motion differs from that of their
/// neighbours. Motion between unrelated pictures is wild. Values above kNewScene are a new scene.
/// @param motion, misfits from findMotion() and misfit()
/// @return 0 = the same picture
double dissimilarity(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion,
                     const cv::Mat& misfits);

/// Neighbouring pictures of one shot have at most .23, at double speed .34; pictures of different
/// scenes have .42 or more (docs/lab/video.md).
constexpr double kNewScene = 0.37;

} // namespace altiro3D
