#pragma once

#include "altiro3D/scene.hpp"
#include "views/view_renderer.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Checks what methods read of a scene.
/// @throws Error InvalidArgument (empty, types, mixed px, shown columns), Mismatch (sizes)
void checkScene(const Scene& scene);

/// Checks that a result shares no memory with a scene. @throws Error InvalidArgument
void checkApart(const cv::Mat& result, const Scene& scene, const char* subject);

/// Creates the renderer of a method. The scene must outlive it.
/// @param scene photo [rows x cols, CV_8UC3, BGR]; depth [as the photo, CV_32FC1], clamped to 0..1,
///        NaN counts as 0; hidden layer of the photo's size or empty
/// @param options method and its options; must be valid
/// @param outermost largest |position| of the views
/// @return renders all columns of the photo; its shifts are for the width of the shown ones
/// @throws Error InvalidArgument (types, sizes, shown columns), Mismatch, TooLarge, OutOfMemory
std::unique_ptr<ViewRenderer> makeRenderer(const Scene& scene, const ViewOptions& options,
                                           double outermost);

/// Method Fast. Photo and depth as for makeRenderer(); they must outlive the renderer.
/// @param largestShift largest |shift| of the views, px
std::unique_ptr<ViewRenderer> makeFastRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               const ViewOptions& options, double largestShift);

/// Method Real for cameras on one horizontal line. Photo and depth as for makeFastRenderer().
/// @param focus depth of zero parallax, 0..1
std::unique_ptr<ViewRenderer> makeRealRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               double focus, const RealOptions& options);

/// Parameters of method Layered.
struct LayeredSettings : LayeredOptions {
    /// What is known about the hidden background, of the photo's size.
    HiddenLayer hidden{};

    /// Scene::mixedPixels
    int mixedPixels = 0;

    /// Largest |shift| of the views (S/2), px, >= 0. Hidden background is prepared up to this
    /// shift. Views beyond are still complete; their gaps repeat the last prepared pixel.
    double reachPixels = 32;

    /// Depth step above which a surface tears: it moves apart by tearPixels in the outermost view.
    double tearStep() const { return tearPixels / reachPixels; }
};

/// Method Layered. Photo and depth as for makeFastRenderer().
/// @param focus depth of zero parallax, 0..1
std::unique_ptr<ViewRenderer> makeLayeredRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                                  double focus, const LayeredSettings& options);

} // namespace altiro3D
