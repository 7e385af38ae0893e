#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace altiro3D {

/// Whether pictures of two shapes can stand for each other: they differ by 5 % at most.
/// @param aspect width : height, more than 0
/// @param other width : height, more than 0
/// @return true if they can
ALTIRO3D_EXPORT bool haveSameShape(double aspect, double other);

/// How the views of a quilt file become the panel's shape.
class ALTIRO3D_EXPORT QuiltShape {
  public:
    /// @param file its name may tell which shape the views are meant for (parseQuiltName())
    /// @param layout of the quilt
    /// @param display whose panel the views are for
    /// @param fit nothing: with black bars where the name tells another shape than the panel's, as
    ///        the displays' own players show it, else stretched
    /// @throws Error as parseQuiltName()
    QuiltShape(const std::filesystem::path& file, const QuiltLayout& layout, const Display& display,
               std::optional<FitMode> fit = std::nullopt);

    /// The quilt without unused px, its views of the panel's shape.
    /// @param picture [of layout.size() or with unused px, CV_8UC3, BGR]
    /// @param notes if given, a remark is added when something is cut off
    /// @return [layout.size(), CV_8UC3, BGR]; may share memory with `picture`
    /// @throws Error as fitQuilt() and applyFitToViews()
    cv::Mat apply(const cv::Mat& picture, Notes* notes = nullptr) const;

    /// The shape in which a view is shown. @return width : height
    double shownAspect() const { return fit_ == FitMode::Stretch ? panelAspect_ : aspect_; }

    /// The shape of what a view shows. @return width : height
    double aspect() const { return aspect_; }

    /// How views of another shape are brought to the panel's. @return as given, or as chosen
    FitMode fit() const { return fit_; }

    /// Whether black bars keep the shape of the views without having been asked for.
    /// @return true if they do
    bool fitsUnasked() const { return isFittedUnasked_; }

  private:
    QuiltLayout layout_;
    double aspect_;
    double panelAspect_;
    bool isFittedUnasked_;
    FitMode fit_;
};

} // namespace altiro3D
