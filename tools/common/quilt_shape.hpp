#pragma once

#include "altiro3D/image_io.hpp"
#include "altiro3D/photo_fit.hpp"
#include "common/display_options.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace altiro3D::tools {

/// How the views of a quilt file become the panel's shape.
class QuiltShape {
  public:
    /// @param file whose name may tell which shape the views are meant for
    /// @param fit nothing: with black bars where the name tells another shape than the panel's, as
    ///        the displays' own players show it, else stretched
    QuiltShape(const std::filesystem::path& file, const QuiltLayout& layout, const Display& display,
               std::optional<FitMode> fit);

    /// The quilt without unused px, its views of the panel's shape.
    /// @param notes what was left out; may be null
    cv::Mat apply(const cv::Mat& picture, Notes* notes) const;

    /// Width : height in which a view is shown.
    double shownAspect() const { return fit_ == FitMode::Stretch ? panelAspect_ : aspect_; }

    /// Whether black bars keep the shape of the views without having been asked for.
    bool fitsUnasked() const { return isFittedUnasked_; }
    /// Says so.
    void tell(Messages& messages) const;

  private:
    QuiltLayout layout_;
    double aspect_;
    double panelAspect_;
    bool isFittedUnasked_;
    FitMode fit_;
};

} // namespace altiro3D::tools
