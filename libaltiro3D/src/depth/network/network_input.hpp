#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

/// Inputs of networks, made from photos. The source is depth_network.cpp.
namespace altiro3D {

struct NetworkProfile;

/// Size of the input of a network for a photo.
/// @param nominal the size that was chosen for the network
/// @param photo size of the photo, px
/// @param side with InputShape::Photo: the longer side
[[nodiscard]] cv::Size networkInputSize(const NetworkProfile& profile, cv::Size nominal,
                                        cv::Size photo, int side);

/// Makes the input of a network. Keeps its memory for the next photo.
class NetworkInput {
  public:
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param size from networkInputSize()
    /// @return [1 x 3 x size, CV_32F, planes in the profile's order]; valid until the next call
    const cv::Mat& make(const NetworkProfile& profile, const cv::Mat& photo, cv::Size size);

  private:
    void resample(const NetworkProfile& profile, const cv::Mat& photo, cv::Size size);

    cv::Mat narrowed_; // [photo's rows x input's cols, CV_32FC3, BGR, 8-bit values times scale]
    cv::Mat resized_;  // [input's size, CV_32FC3, BGR, as narrowed_]
    cv::Mat blob_;
};

} // namespace altiro3D
