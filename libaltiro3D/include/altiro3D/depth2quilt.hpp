#pragma once

#include "altiro3D/depth_network.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/view_options.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

class DepthSource;

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
    [[nodiscard]] const QuiltLayout& layout() const { return layout_; }
    /// The options in use. @return as given to the constructor
    [[nodiscard]] const ViewOptions& options() const { return options_; }

    /// Makes all views. They are rendered at the photo's size, without its margins (Scene::shown),
    /// and area-averaged into the tiles if the sizes differ. Unused tiles are black.
    ///
    /// @param scene photo [rows x cols, CV_8UC3, BGR], sides at most 32766 px; depth [as the photo,
    ///        CV_32FC1, 0..1, 1 = nearest]; hidden layer of the photo's size or empty
    /// @param quilt [quilt rows x quilt cols, CV_8UC3, BGR]; reused if it fits; must not share
    ///        memory with the scene
    /// @throws Error InvalidArgument (type, shared memory), TooLarge, Mismatch (sizes differ),
    ///         OutOfMemory
    void render(const Scene& scene, cv::Mat& quilt) const;
    /// The same without a hidden layer.
    /// @param photo of the scene @param depth of the scene @param quilt as above
    void render(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& quilt) const {
        render(Scene{photo, depth}, quilt);
    }

    /// Makes one view.
    ///
    /// @param scene as for render()
    /// @param position p, camera position, -1 leftmost .. +1 rightmost; any finite number
    /// @param view [as the photo without margins, CV_8UC3, BGR]; always newly allocated
    /// @throws Error InvalidArgument (position) and as render()
    void renderView(const Scene& scene, double position, cv::Mat& view) const;
    /// The same without a hidden layer.
    /// @param photo of the scene @param depth of the scene @param position as above
    /// @param view as above
    void renderView(const cv::Mat& photo, const cv::Mat& depth, double position,
                    cv::Mat& view) const {
        renderView(Scene{photo, depth}, position, view);
    }

  private:
    QuiltLayout layout_;
    ViewOptions options_;
};

/// A Depth2Quilt that estimates depth with a network. It turns photos of any size into quilts.
///
/// It owns the network. One thread at a time per object.
class ALTIRO3D_EXPORT Network2Quilt {
  public:
    /// @param network a loaded network
    /// @param layout layout of the quilts
    /// @param options method, strength, focus and the options of each method
    /// @param panelAspect width : height of the picture on the panel, 0.01..100
    /// @param fit how photos of another shape are fitted to the panel
    /// @throws Error InvalidArgument (layout, options, panelAspect) or TooLarge (layout)
    Network2Quilt(DepthNetwork network, const QuiltLayout& layout, const ViewOptions& options,
                  double panelAspect, FitMode fit = FitMode::Cover);

    /// Estimates the depth of the whole photo (depthFromNetwork()), fits photo and depth to the
    /// view's size (fitScene()) and renders the views. The depth may differ in the last digits for
    /// different numbers of threads, see DepthNetwork::infer().
    ///
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param quilt [quilt rows x quilt cols, CV_8UC3, BGR]; reused if it fits
    /// @throws Error as fitPhoto() (an extreme aspect), DepthNetwork::estimate() and
    ///         Depth2Quilt::render()
    void render(const cv::Mat& photo, cv::Mat& quilt);

    /// The depth of the last photo as it was estimated, before the fit.
    /// @return [any size, CV_32FC1, 0..1, 1 = nearest]; empty before the first photo
    [[nodiscard]] const cv::Mat& depth() const { return depth_; }

  private:
    std::shared_ptr<DepthSource> source_;
    Depth2Quilt depth2quilt_;
    double panelAspect_;
    FitMode fit_;
    cv::Mat depth_;
};

} // namespace altiro3D
