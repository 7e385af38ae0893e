#pragma once

#include "altiro3D/depth_network.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace altiro3D {

/// A run of a network.
struct NetworkRun {
    cv::Mat photo;      ///< [rows x cols, CV_8UC3, BGR]
    int longerSide = 0; ///< As for DepthNetwork::estimate().
};

/// The runs of a network for a photo.
/// @param inputSize as DepthNetwork::inputSize()
/// @return one run of the photo, of at most 1024 px; and two of larger mirrored copies for networks
///         that follow the photo's shape
[[nodiscard]] std::vector<NetworkRun> runsOfPhoto(const NetworkProfile& profile, cv::Size inputSize,
                                                  const cv::Mat& photo);

/// The depth of a photo from the results of runsOfPhoto(), as by estimatePhoto().
/// @param photo its size, px
/// @param read NetworkRun::photo of the first run
/// @param depths depth of each run, as from DepthNetwork::estimate()
[[nodiscard]] cv::Mat depthOfRuns(cv::Size photo, const cv::Mat& read,
                                  const std::vector<cv::Mat>& depths);

/// Depth of a photo. Networks that follow the photo's shape run three times: on the photo and on a
/// larger mirrored copy, whose mean is the layout, and on a still larger one, which adds detail.
/// Then straight lines become straight, and steps for which there is evidence become hard (below,
/// and depth_steps.hpp).
/// @param network its inputSize() is that of the largest copy, if it is larger than the profile's;
///        if it is smaller, the network runs once
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @return [photo's shape, longer side at most 512 px, CV_32FC1, about 0..1, 1 = nearest]
/// @throws Error as DepthNetwork::estimate()
[[nodiscard]] cv::Mat estimatePhoto(DepthNetwork& network, const cv::Mat& photo);

/// Depth of a frame of a video: one run, without work on lines, at most 320 px.
[[nodiscard]] cv::Mat estimateFrame(DepthNetwork& network, const cv::Mat& frame);

/// The long straight edges of a photo.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @return x and y of both ends, px; those along the frame, as scans have them, are left out
[[nodiscard]] std::vector<cv::Vec4f> findLines(const cv::Mat& photo);

/// Corrects the depth on both sides of straight edges to that of a straight line in space: inverse
/// depth that is affine along it, (4.16) and (4.17) of docs/mathematics.md. Surfaces follow as far
/// as they have no step. An edge that departs too far is not one line and is not changed.
/// @param lines from findLines() of the photo
/// @param depth [as the photo, CV_32FC1, finite, about 0..1, 1 = nearest] changed in place
void straightenLines(const std::vector<cv::Vec4f>& lines, cv::Mat& depth);

} // namespace altiro3D
