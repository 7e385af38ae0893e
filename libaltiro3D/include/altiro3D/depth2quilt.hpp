#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/view_options.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Makes the views of a photo with depth and lays them out as a quilt.
///
/// Content at depth d appears in view p (-1 leftmost .. +1 rightmost) shifted by -p (d - focus) S/2
/// px with S = strength % of the picture's width: nearer content moves against the camera
/// (positions: docs/mathematics.md, (3.1); displacement and methods: docs/mathematics.md, (3.2)).
/// At p = 0, and for a depth map that is `focus` everywhere, the view equals the photo bit for bit.
/// Depth outside 0..1 is clamped, NaN counts as 0.
///
/// Immutable and thread-safe. Results are the same bytes for any number of threads.
class ALTIRO3D_EXPORT Depth2Quilt {
  public:
    /// @param layout layout of the quilts
    /// @param options method, strength, focus and the options of each method
    /// @throws Error InvalidArgument (layout, options) or TooLarge (layout)
    explicit Depth2Quilt(const QuiltLayout& layout, const ViewOptions& options = {});

    /// The layout of the quilts. @return as given to the constructor
    const QuiltLayout& layout() const { return layout_; }
    /// The options in use. @return as given to the constructor
    const ViewOptions& options() const { return options_; }

    /// Makes all views. They are rendered at the photo's size and area-averaged into the tiles if
    /// the sizes differ. Unused tiles are black.
    ///
    /// @param photo [rows x cols, CV_8UC3, BGR], sides at most 32766 px
    /// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]
    /// @param quilt [quilt rows x quilt cols, CV_8UC3, BGR]; reused if it fits; must not share
    ///        memory with photo and depth
    /// @throws Error InvalidArgument (type, shared memory), TooLarge, Mismatch (photo and depth
    ///         differ in size), OutOfMemory
    void render(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& quilt) const;

    /// Makes one view.
    ///
    /// @param photo as for render()
    /// @param depth as for render()
    /// @param position p, camera position, -1 leftmost .. +1 rightmost; any finite number
    /// @param view [as photo, CV_8UC3, BGR]; always newly allocated
    /// @throws Error InvalidArgument (position) and as render()
    void renderView(const cv::Mat& photo, const cv::Mat& depth, double position,
                    cv::Mat& view) const;

  private:
    QuiltLayout layout_;
    ViewOptions options_;
};

} // namespace altiro3D
