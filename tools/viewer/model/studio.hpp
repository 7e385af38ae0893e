#pragma once

#include "viewer/model/making.hpp"

#include <memory>

namespace altiro3D::viewer {

/// A picture for the window.
struct Frame {
    Setup setup;               ///< What is shown, with what was chosen.
    Knobs knobs;               ///< As they were requested.
    cv::Mat picture;           ///< [CV_8UC3, BGR]
    cv::Size target;           ///< Size on the screen, px; the picture's size if shown exactly.
    cv::Mat depth;             ///< Sway, Depth: depth of the fitted photo; else empty.
    double parallaxPixels = 0; ///< A photo's parallax between adjacent views, px of a view.
    double hiddenPercent = 0;  ///< A photo's, see viewer::hiddenPercent().
};

class DepthMaker;

/// Makes the pictures for the window and caches intermediate results for the next one. One thread
/// at a time.
class Studio {
  public:
    /// @param depthMaker for photos without their own depth
    explicit Studio(std::shared_ptr<DepthMaker> depthMaker);
    ~Studio();

    /// Finds the depth of the document. @throws Error and other exceptions of the library
    Setup prepare(const Request& request);
    /// Makes the picture. @throws as prepare()
    Frame render(const Request& request);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The largest size with an aspect that fits into an area.
cv::Size inside(cv::Size area, double aspect);

/// The depth of the photo's px that is visible at a position of a view.
/// @param depth of the fitted photo @param position of the camera @param at in px of the view
double depthSeenAt(const cv::Mat& depth, const ViewOptions& views, double position, cv::Point at);

} // namespace altiro3D::viewer
