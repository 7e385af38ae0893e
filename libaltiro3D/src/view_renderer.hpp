#pragma once

#include "altiro3D/depth2quilt.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Makes views of one photo with its depth by one method. What all views share is done once, when
/// it is made. render() may run on any number of threads at once.
class ViewRenderer {
  public:
    ViewRenderer() = default;
    ViewRenderer(const ViewRenderer&) = delete;
    ViewRenderer& operator=(const ViewRenderer&) = delete;
    virtual ~ViewRenderer() = default;

    /// Makes the view in which content at depth d is moved by -shiftPixels (d - focus) px.
    ///
    /// @param shiftPixels p S/2 in px, any finite number; 0 gives the photo, bit for bit
    /// @param view [as the photo, CV_8UC3, BGR], allocated, not the photo
    virtual void render(double shiftPixels, cv::Mat& view) const = 0;
};

/// Method Fast. Photo and depth must live as long as the renderer.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1], clamped to 0..1, NaN counts as 0
std::unique_ptr<ViewRenderer> makeFastRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               const ViewOptions& options);

} // namespace altiro3D
