#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/export.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Camera position of a sub-pixel.
enum class ViewPositions {
    Discrete,  ///< The position of one of N views, as in a quilt: docs/mathematics.md, (3.1).
    Continuous ///< Follows its phase z under the lens: p = (2Nz - N)/(N-1), -1..1
               ///< (docs/conventions.md); N = number of views of the display.
};

/// Renders Natives directly from photos with depth: each sub-pixel of the panel reads the photo at
/// the place that its view shows there. The renderer makes no quilt, no views and no look-up table,
/// and computes only what the panel shows.
///
/// With discrete views and a photo of the tile's size, the Native equals that of Depth2Quilt and
/// Quilt2Native bit for bit. With a photo of the panel's size, no detail is lost to smaller tiles.
///
/// Supports methods Fast and Layered; method Real makes whole views only. Phases and views follow
/// docs/mathematics.md, (1.1) to (1.10), displacements follow docs/mathematics.md, (3.2).
///
/// Immutable; render() is thread-safe. Results are the same bytes for any number of threads and on
/// any processor.
class ALTIRO3D_EXPORT NativeRenderer {
  public:
    static constexpr int kMaxViews = 65536; ///< Largest number of views.

    /// @param calibration the display
    /// @param viewCount N, number of views of the display, 1..kMaxViews
    /// @param options method, strength, focus and the options of each method
    /// @param positions discrete or continuous
    /// @param invert whether the order of views is reversed
    /// @throws Error BadFormat (calibration), InvalidArgument (options, method Real, viewCount)
    NativeRenderer(const Calibration& calibration, int viewCount, const ViewOptions& options = {},
                   ViewPositions positions = ViewPositions::Discrete,
                   InvertViews invert = InvertViews::Auto);

    /// Size of the Native. @return columns x rows in px
    [[nodiscard]] cv::Size panelSize() const;
    /// Number of views. @return as given to the constructor
    [[nodiscard]] int viewCount() const;
    /// The options in use. @return as given to the constructor
    [[nodiscard]] const ViewOptions& options() const;

    /// Renders one Native. Sub-pixels read the photo's px under the centre of their panel px.
    ///
    /// @param photo [rows x cols, CV_8UC3, BGR], sides at most 32766 px; it fills the panel at any
    ///        size
    /// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; NaN counts as 0
    /// @param native [panel rows x panel cols, CV_8UC3, BGR]; reused if it fits; must not share
    ///        memory with photo and depth
    /// @throws Error InvalidArgument (empty or wrong type, shared memory), TooLarge, Mismatch
    ///         (photo and depth differ in size), OutOfMemory
    void render(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& native) const;

  private:
    struct Impl;
    std::shared_ptr<const Impl> impl_;
};

} // namespace altiro3D
