#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/quilt.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Which views a sub-pixel shows.
enum class ViewFilter {
    Nearest, ///< The one view whose cell the lens phase falls into. Crisp; the default.
    Linear   ///< The two views nearest to the phase, blended; soft transitions, slight ghosting.
};

/// Which pixels inside a view a sub-pixel shows.
enum class TileSampling {
    Nearest, ///< The pixel under it, as a `.map` does; the default.
    Linear   ///< The four around it, blended; never across the border of the view.
};

/// How a quilt is sampled.
struct QuiltSampling {
    ViewFilter views = ViewFilter::Nearest;      ///< Between views.
    TileSampling inTile = TileSampling::Nearest; ///< Inside a view.
};

/// The part of a picture that a layout describes: all of it, or without the unused columns at the
/// right and rows at the top where its size is not divisible (4096 px hold 5 tiles of 819 px).
///
/// @param quilt [rows x cols, any type]
/// @param layout the layout it should have
/// @param notes if given, a remark is added when something is cut off
/// @return [layout size], sharing memory with `quilt`
/// @throws Error Mismatch that names both sizes; InvalidArgument or TooLarge (layout)
ALTIRO3D_EXPORT cv::Mat fitQuilt(const cv::Mat& quilt, const QuiltLayout& layout,
                                 Notes* notes = nullptr);

/// Turns quilts into Natives: each sub-pixel takes its own colour from its own view
/// (docs/mathematics.md, 1 and 2).
///
/// Immutable; render() may run on any number of threads at once and gives the same bytes for any
/// number of threads.
class ALTIRO3D_EXPORT Quilt2Native {
  public:
    /// Renders through a look-up table: nearest view, nearest pixel.
    ///
    /// @param lut the table; display and layout are those that it was built for
    /// @throws Error OutOfMemory
    explicit Quilt2Native(NativeLut lut);

    /// Renders from the calibration itself; needed for blended sampling, which a table cannot hold.
    ///
    /// @param calibration the display
    /// @param quilt layout of the quilts to come
    /// @param sampling nearest or blended, between views and inside them
    /// @param invert whether the order of views is reversed
    /// @throws Error BadFormat (calibration), InvalidArgument or TooLarge (layout), OutOfMemory
    Quilt2Native(const Calibration& calibration, const QuiltLayout& quilt, QuiltSampling sampling,
                 InvertViews invert = InvertViews::Auto);

    /// Size of the Native. @return columns x rows in px
    cv::Size panelSize() const;
    /// Layout of the quilts that render() takes. @return the layout
    const QuiltLayout& quilt() const;

    /// Renders one Native.
    ///
    /// @param quilt [quilt rows x quilt cols, CV_8UC3, BGR]; sub-matrices and fitQuilt()'s unused
    ///        borders are fine
    /// @param native [panel rows x panel cols, CV_8UC3, BGR]; reused if it fits, must share no
    ///        memory with the quilt
    /// @throws Error InvalidArgument (type, shared memory), Mismatch (size)
    void render(const cv::Mat& quilt, cv::Mat& native) const;

  private:
    struct Impl;
    std::shared_ptr<const Impl> impl_;
};

} // namespace altiro3D
