#pragma once

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
///
/// @param left [rows x cols, CV_8UC1]
/// @param right as left, of the same size
/// @return the fit; all 0 if fewer than 12 blocks or fewer than a quarter of the textured ones
/// agree
RowFit fitRows(const cv::Mat& left, const cv::Mat& right);

/// Moves the rows of the right picture to those of the left one. The slope is undone as a rotation,
/// which moves columns as well.
/// @param right [rows x cols, CV_8UC1 or CV_8UC3] @return the same size and type
cv::Mat moveRows(const cv::Mat& right, const RowFit& fit);

} // namespace altiro3D
