#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// A Depth2Quilt that estimates depth by a network: it turns photos of any size into quilts.
///
/// Owns its network. One thread at a time per object.
class ALTIRO3D_EXPORT Network2Quilt {
  public:
    /// @param network a loaded network
    /// @param layout layout of the quilts
    /// @param options method, strength, focus and the options of each method
    /// @param panelAspect width : height of the picture on the panel, 0.01..100
    /// @param fit how photos of another shape are fitted to the panel
    /// @throws Error InvalidArgument (layout, options, panelAspect) or TooLarge (layout)
    Network2Quilt(DepthNetwork network, const QuiltLayout& layout, const ViewOptions& options,
                  double panelAspect, FitMode fit = FitMode::Cover);

    /// Estimates the depth of the whole photo, fits photo and depth to the view's size and renders
    /// the views. The depth may differ in the last digits for different numbers of threads, see
    /// DepthNetwork::infer().
    ///
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param quilt [quilt rows x quilt cols, CV_8UC3, BGR]; reused if it fits
    /// @throws Error as fitPhoto() (an extreme aspect), DepthNetwork::estimate() and
    ///         Depth2Quilt::render()
    void render(const cv::Mat& photo, cv::Mat& quilt);

    /// The depth of the last photo.
    /// @return [network's output size, CV_32FC1, 0..1, 1 = nearest]; empty before the first photo
    const cv::Mat& depth() const { return depth_; }

  private:
    DepthNetwork network_;
    Depth2Quilt depth2quilt_;
    double panelAspect_;
    FitMode fit_;
    cv::Mat depth_;
};

} // namespace altiro3D
