#pragma once

#include "views/view_renderer.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Makes the renderer of a method. Photo and depth must live as long as it does.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1], clamped to 0..1, NaN counts as 0
/// @param options method and knobs, valid
/// @param reach largest |position| that views will be asked for
/// @throws Error InvalidArgument (types, sizes), Mismatch, TooLarge, OutOfMemory
std::unique_ptr<ViewRenderer> makeRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                           const ViewOptions& options, double reach);

/// Method Fast. Photo and depth must live as long as the renderer.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1], clamped to 0..1, NaN counts as 0
std::unique_ptr<ViewRenderer> makeFastRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               const ViewOptions& options);

/// Method Real for cameras on one horizontal line. Photo and depth must live as long as the
/// renderer.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1], clamped to 0..1, NaN counts as 0
/// @param focus depth of zero parallax, 0..1
std::unique_ptr<ViewRenderer> makeRealRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               double focus, const RealOptions& options);

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
