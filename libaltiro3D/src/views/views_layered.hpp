#pragma once

#include "views/view_renderer.hpp"

namespace altiro3D {

/// What method Layered needs to know besides photo and depth.
struct LayeredSettings : LayeredOptions {
    /// Largest |shift| that will be asked for (S/2), px, >= 0: hidden background is prepared so
    /// far. Beyond, views are still whole; their gaps repeat the last prepared pixel.
    double reachPixels = 32;

    /// The step of depth that is torn: one that moves apart by tearPixels in the outermost view.
    double tearStep() const { return tearPixels / reachPixels; }
};

/// Method Layered. Photo and depth must live as long as the renderer.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1], clamped to 0..1, NaN counts as 0
/// @param focus depth of zero parallax, 0..1
std::unique_ptr<ViewRenderer> makeLayeredRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                                  double focus, const LayeredSettings& options);

} // namespace altiro3D
