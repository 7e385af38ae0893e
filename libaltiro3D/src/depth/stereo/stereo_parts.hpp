#pragma once

#include "altiro3D/scene.hpp"

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// How the rows of the right picture of a pair lie beside those of the left one: the point
/// (x, y + offset + slope x + stretch y) of the right picture is in row y of the left one. x and y
/// count from the middle of the pictures, in px.
struct RowFit {
    double offset = 0;  ///< px, downwards
    double slope = 0;   ///< px per px, from a rotation
    double stretch = 0; ///< px per px, from a difference of scale
    int blocks = 0;     ///< matched blocks that agree with the fit
    int textured = 0;   ///< blocks of the left picture that have texture
};

/// Finds the fit by matching blocks of the left picture in the right one (normalized
/// cross-correlation in whole numbers) and a fit that ignores outliers. Exact on any processor.
///
/// Limits: rows are searched within 4 % of the height, columns within 35 % of the width.
/// @param left [rows x cols, CV_8UC1]
/// @param right as left, of the same size
/// @return the fit; all 0 if fewer than 12 blocks or a quarter of the textured ones agree
RowFit fitRows(const cv::Mat& left, const cv::Mat& right);

/// Moves the rows of the right picture to those of the left one. The slope is undone as a rotation,
/// which moves columns as well.
/// @param right [rows x cols, CV_8UC1 or CV_8UC3] @return the same size and type
cv::Mat moveRows(const cv::Mat& right, const RowFit& fit);

/// The disparities of the px of two pictures whose rows lie beside each other.
struct RowDisparities {
    cv::Mat left;  ///< [size of the pictures, CV_32FC1, px, NaN = unknown]: x in the left picture -
                   ///< x in the right one
    cv::Mat right; ///< The same for the px of the right picture.
};

/// Matches two pictures semi-globally in both directions and keeps what both agree on.
/// @param left,right [rows x cols, CV_8UC1]
/// @param low,high range of the disparities, px
RowDisparities matchRows(const cv::Mat& left, const cv::Mat& right, double low, double high);

/// What only the left eye sees lies beside a nearer thing, at its left, and belongs to what is
/// behind. If most such places look like the nearer side instead, the eyes are swapped:
///
///     right order    behind | hidden | in front         "hidden" looks like its left side
///     swapped      in front | hidden | behind           disparities are negated: it looks like its
///                                                       right side
struct HiddenLooks {
    std::int64_t behind = 0; ///< Rows of such places that look like their left side.
    std::int64_t front = 0;  ///< And like their right side.
};
/// @param disparity of the left picture [rows x cols, CV_32FC1, NaN = unknown]
/// @param grey the left picture [as disparity, CV_8UC1]
/// @param pixels px of disparity of a unit of `disparity`
HiddenLooks looksOfHidden(const cv::Mat& disparity, const cv::Mat& grey, double pixels);

/// Fills the unknown disparities of a pair. Each takes the farther of the nearest known values to
/// its left and right in the row, because what one eye misses lies behind. Then each filled px
/// takes the median of its surroundings, weighted by the likeness of the colours (bilateral
/// weights, as in Hosni et al. 2013), twice, which removes streaks along the rows.
/// @param disparity [rows x cols, CV_32FC1, NaN = unknown], at least one known; filled in place
/// @param photo [as disparity, CV_8UC3, BGR]
void fillFromBehind(cv::Mat& disparity, const cv::Mat& photo);

/// What only the right eye of a pair sees, where the left eye would see it if nothing hid it:
///
///     right picture      b b b b h h h T T T b b     h: seen by the right eye only
///     left picture       b b b T T T b b b b b b     T: a thing, b: background
///     hidden layer       . . . . h h . . . . . .     of the left picture: behind T
///
/// @param right [rows x cols, CV_8UC3, BGR], its rows moved to those of the left picture
/// @param leftDisparity [as right, CV_32FC1], shares of the width, all known
/// @param rightDisparity the same for the px of the right picture
/// @return colours, and their disparities as HiddenLayer::depth
HiddenLayer hiddenByRight(const cv::Mat& right, const cv::Mat& leftDisparity,
                          const cv::Mat& rightDisparity);

} // namespace altiro3D
