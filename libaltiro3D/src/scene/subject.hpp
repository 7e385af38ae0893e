#pragma once

#include "altiro3D/photo_fit.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// How likely each place of a scene belongs to its subject: places that are sharp, near, nearer
/// than others in their row, and close to the middle have large weights; (7.1).
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [any size, CV_32FC1, 0..1, 1 = nearest]; shows all of the photo. NaN counts as 0.
/// @param weights [size of the photo, scaled down to at most 320 px per side, CV_32SC1, 1..65535];
///        the same for any number of threads and on any processor
/// @throws Error InvalidArgument (empty or wrong type)
void subjectWeights(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& weights);

/// The part of a scene that fills the panel and has the largest weights; (7.2).
///
/// @param weights from subjectWeights()
/// @param picture size of the photo in px
/// @param panelAspect width : height of the panel, 0.01..100
/// @param zoom 1..1000
/// @return the framing, for FitMode::Cover, with this zoom
/// @throws Error as fitPhoto(), InvalidArgument (weights)
Framing frameSubject(const cv::Mat& weights, cv::Size picture, double panelAspect, double zoom = 1);

/// Depth of the subject: the median of the depth, weighted with the squares of the weights.
///
/// @param weights from subjectWeights()
/// @param depth of the same scene
/// @param part the part of the scene that is shown, in its widths and heights
/// @return 0..1
/// @throws Error InvalidArgument (types, a part that is not inside)
double subjectDepth(const cv::Mat& weights, const cv::Mat& depth,
                    const cv::Rect2d& part = {0, 0, 1, 1});

} // namespace altiro3D
