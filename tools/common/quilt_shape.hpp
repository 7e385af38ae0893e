#pragma once

#include "altiro3D/image_io.hpp"
#include "altiro3D/photo_fit.hpp"
#include "common/display_options.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace altiro3D::tools {

/// How the views of a quilt file become the panel's shape.
class QuiltShape {
  public:
    /// @param file whose name may tell what the views show
    QuiltShape(const std::filesystem::path& file, const QuiltLayout& layout, const Display& display,
               FitMode fit);

    /// The quilt without unused px, its views fitted if that was asked for.
    /// @param notes what was left out; may be null
    cv::Mat apply(const cv::Mat& picture, Notes* notes) const;

    /// Width : height in which a view is shown.
    double shownAspect() const { return fit_ == FitMode::Stretch ? panelAspect_ : aspect_; }

    /// Warns of views that the file's name means for another shape.
    void warnIfStretched(Messages& messages) const;

  private:
    QuiltLayout layout_;
    double aspect_;
    double panelAspect_;
    bool isStated_;
    FitMode fit_;
};

} // namespace altiro3D::tools
