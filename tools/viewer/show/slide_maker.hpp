#pragma once

#include "viewer/model/studio.hpp"
#include "viewer/show/slide_show.hpp"

#include <memory>
#include <optional>

namespace altiro3D::viewer {

/// Makes the slides of a show: the Native of each file as the window makes it without changed
/// settings. One thread at a time.
class SlideMaker {
  public:
    /// @param display the display; nothing if its calibration is not known: then only Natives can
    ///        be shown
    /// @param screen size of the screen, px
    SlideMaker(std::shared_ptr<const Display> display, cv::Size screen);

    /// @return a slide with a picture of the screen's size, or with a problem
    Slide make(const Source& source);

  private:
    cv::Mat nativeOf(const std::shared_ptr<const Document>& document);

    std::shared_ptr<const Display> display_;
    cv::Size screen_;
    std::shared_ptr<DepthMaker> depthMaker_;
    Studio studio_;
};

} // namespace altiro3D::viewer
