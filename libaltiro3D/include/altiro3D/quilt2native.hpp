#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace altiro3D {

/// How a sub-pixel samples the views.
enum class ViewFilter {
    Nearest, ///< The view whose interval contains the lens phase. Sharp; the default.
    Linear   ///< The two views nearest to the phase, blended. Soft transitions, slight ghosting.
};

/// How a sub-pixel samples the pixels inside a view.
enum class TileSampling {
    Nearest, ///< The pixel under it, as in a `.map`; the default.
    Linear   ///< The four pixels around it, blended; never across the border of the view.
};

/// How a quilt is sampled.
struct QuiltSampling {
    ViewFilter views = ViewFilter::Nearest;      ///< Between views.
    TileSampling inTile = TileSampling::Nearest; ///< Inside a view.
};

/// Crops a picture to the part that a layout describes. If the size is not divisible, unused
/// columns at the right and unused rows at the top are removed (4096 px hold 5 tiles of 819 px).
///
/// @param quilt [rows x cols, any type]
/// @param layout the layout it should have
/// @param notes if given, receives a remark if something is removed
/// @return [layout size]; shares memory with `quilt`
/// @throws Error Mismatch that names both sizes; InvalidArgument or TooLarge (layout)
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat fitQuilt(const cv::Mat& quilt, const QuiltLayout& layout,
                                               Notes* notes = nullptr);

/// Renders Natives from quilts: each sub-pixel takes its own colour from its own view
/// (docs/mathematics.md, 1 and 2).
///
/// Immutable; render() is thread-safe. Results are the same bytes for any number of threads.
class ALTIRO3D_EXPORT Quilt2Native {
  public:
    /// Renders through a look-up table: nearest view, nearest pixel.
    ///
    /// @param lut the table; it determines display and layout
    /// @throws Error OutOfMemory
    explicit Quilt2Native(NativeLut lut);

    /// Renders from the calibration. Blended sampling requires this, because a table cannot hold
    /// it.
    ///
    /// @param calibration the display
    /// @param quilt layout of the quilts
    /// @param sampling nearest or blended, between views and inside them
    /// @param invert whether the order of views is reversed
    /// @throws Error BadFormat (calibration), InvalidArgument or TooLarge (layout), OutOfMemory
    Quilt2Native(const Calibration& calibration, const QuiltLayout& quilt, QuiltSampling sampling,
                 InvertViews invert = InvertViews::Auto);

    /// Size of the Native. @return columns x rows in px
    [[nodiscard]] cv::Size panelSize() const;
    /// Layout of the quilts that render() accepts. @return the layout
    [[nodiscard]] const QuiltLayout& quilt() const;

    /// Renders one Native.
    ///
    /// @param quilt [quilt rows x quilt cols, CV_8UC3, BGR]; sub-matrices are accepted, and the
    ///        unused borders that fitQuilt() describes
    /// @param native [panel rows x panel cols, CV_8UC3, BGR]; reused if it fits; must not share
    ///        memory with the quilt
    /// @throws Error InvalidArgument (type, shared memory), Mismatch (size)
    void render(const cv::Mat& quilt, cv::Mat& native) const;

  private:
    struct Impl;
    std::shared_ptr<const Impl> impl_;
};

/// Whether pictures of two shapes can stand for each other: they differ by 5 % at most.
/// @param aspect width : height, more than 0
/// @param other width : height, more than 0
/// @return true if they can
[[nodiscard]] ALTIRO3D_EXPORT bool haveSameShape(double aspect, double other);

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
    [[nodiscard]] cv::Mat apply(const cv::Mat& picture, Notes* notes = nullptr) const;

    /// The shape in which a view is shown. @return width : height
    [[nodiscard]] double shownAspect() const {
        return fit_ == FitMode::Stretch ? panelAspect_ : aspect_;
    }

    /// The shape of what a view shows. @return width : height
    [[nodiscard]] double aspect() const { return aspect_; }

    /// How views of another shape are brought to the panel's. @return as given, or as chosen
    [[nodiscard]] FitMode fit() const { return fit_; }

    /// Whether black bars keep the shape of the views without having been asked for.
    /// @return true if they do
    [[nodiscard]] bool fitsUnasked() const { return isFittedUnasked_; }

  private:
    QuiltLayout layout_;
    double aspect_;
    double panelAspect_;
    bool isFittedUnasked_;
    FitMode fit_;
};

} // namespace altiro3D
