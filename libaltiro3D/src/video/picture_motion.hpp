#pragma once

#include <opencv2/core/mat.hpp>

/// Motion between two pictures of a video, looked for in small grey copies of them. All of it is
/// plain serial code in whole numbers (motion) and single floats, so results are the same for any
/// number of threads.
namespace altiro3D {

/// Longest side of the small picture, px.
constexpr int kSmallSide = 192;

/// The picture's area average of at most kSmallSide px a side.
/// @param picture [rows x cols, CV_8UC3, BGR] @return [small rows x cols, CV_8UC3, BGR]
cv::Mat smallPicture(const cv::Mat& picture);

/// Its brightness (BT.601). @param small [any size, CV_8UC3, BGR] @return [CV_8UC1]
cv::Mat greyOf(const cv::Mat& small);

/// Where each px of `now` was in `before`: x was at x + motion(x). What stood still has exactly 0.
/// @param before, now [equal sizes, CV_8UC1] @param motion [as now, CV_32FC2, px]
void findMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion);

/// Sets a motion right that is nearly right already, such as one that joinMotion() gave.
/// @param motion in and out [as now, CV_32FC2, px]
void refineMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion);

/// Motion over two steps: x was at x + first + second there. Linear between px, border repeated.
/// @param earlier from the middle to the start @param later from the end to the middle
/// @return from the end to the start [CV_32FC2, px]
cv::Mat joinMotion(const cv::Mat& earlier, const cv::Mat& later);

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
/// different scenes .42 and more (docs/tradeoff.md says which).
constexpr double kNewScene = 0.37;

/// Standard deviation of a picture's brightness. @param grey [CV_8UC1]
double contrastOf(const cv::Mat& grey);

/// Picture values where px were before, linear between px, the border repeated.
/// @param before [any size, CV_32FC1] @param motion [any size, CV_32FC2, px of its own size]
/// @param moved [as before, CV_32FC1]; px that did not move are copied
void carry(const cv::Mat& before, const cv::Mat& motion, cv::Mat& moved);

/// Enlarges or shrinks a picture of single numbers, linear between px, the border repeated.
/// @param values [CV_32FC1] @param rows, cols of the result @return [rows x cols, CV_32FC1]
cv::Mat stretched(const cv::Mat& values, int rows, int cols);

} // namespace altiro3D
