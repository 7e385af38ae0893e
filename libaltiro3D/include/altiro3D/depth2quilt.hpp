#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/scene.hpp"
#include "altiro3D/view_options.hpp"

#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace altiro3D {

class DepthSource;

/// Receives the share of a quilt that is made, 0..1. Returns true to continue, false to stop. It is
/// called from several threads, but never from two at a time.
using QuiltProgressFunction = std::function<bool(double share)>;

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
    /// and scaled to the tiles (by area averages if they shrink). Unused tiles are black.
    /// @param scene photo [rows x cols, CV_8UC3, BGR], sides at most 32766 px; depth [as the photo,
    ///        CV_32FC1, 0..1, 1 = nearest]; hidden layer of the photo's size or empty
    /// @param quilt [quilt rows x quilt cols, CV_8UC3, BGR]; must not share memory with the scene
    /// @throws Error InvalidArgument (type, shared memory), TooLarge, Mismatch (sizes differ),
    ///         OutOfMemory
    void render(const Scene& scene, cv::Mat& quilt) const;

    /// Makes all views, with progress.
    /// @param scene, quilt as above; a part of the quilt is made if the work is stopped
    /// @param goOn receives the progress; may be empty
    /// @return false if `goOn` has stopped the work
    /// @throws Error as above; exceptions of `goOn` stop the work and pass through
    bool render(const Scene& scene, cv::Mat& quilt, const QuiltProgressFunction& goOn) const;

    /// Makes one view.
    /// @param scene as for render()
    /// @param position p, camera position, -1 leftmost .. +1 rightmost; any finite number
    /// @param view [as the photo without margins, CV_8UC3, BGR]; always newly allocated
    /// @throws Error InvalidArgument (position) and as render()
    void renderView(const Scene& scene, double position, cv::Mat& view) const;

  private:
    QuiltLayout layout_;
    ViewOptions options_;
};

/// PSNR of two pictures: 10 log10(255² / mean squared difference), over all channels.
/// @param picture [rows x cols, 8-bit, any number of channels]
/// @param truth [as picture]
/// @return dB; +infinity if they are equal
/// @throws Error InvalidArgument (empty, not 8-bit), Mismatch (size or type differ)
[[nodiscard]] ALTIRO3D_EXPORT double psnr(const cv::Mat& picture, const cv::Mat& truth);

/// Structural similarity of two pictures: Wang et al. 2004 with an 11 x 11 Gaussian window (sigma
/// 1.5), K1 = 0.01, K2 = 0.03, range 255, reflected borders. Mean over all px and channels.
/// @param picture [rows x cols, 8-bit, 1..4 channels]
/// @param truth [as picture]
/// @return -1..1, 1 = equal
/// @throws Error InvalidArgument (empty, not 8-bit, more than 4 channels), Mismatch (size or type
///         differ)
[[nodiscard]] ALTIRO3D_EXPORT double ssim(const cv::Mat& picture, const cv::Mat& truth);

/// Spearman's rank correlation of two pictures: to what extent both put the pixels in the same
/// order. Equal values share the mean of their ranks.
/// @param a [rows x cols, CV_32FC1], finite
/// @param b [as a], finite
/// @param mask [as a, CV_8UC1], 0: the pixel does not count; empty: all count
/// @return -1 (reversed) .. 1 (the same order); 0 if the values of one picture are all equal
/// @throws Error InvalidArgument (empty, wrong type, not finite), Mismatch (sizes differ)
[[nodiscard]] ALTIRO3D_EXPORT double rankCorrelation(const cv::Mat& a, const cv::Mat& b,
                                                     const cv::Mat& mask = {});

/// Scales and shifts an estimated depth map to fit the true one (least squares), because relative
/// depth has an unknown scale and shift (Ranftl et al. 2020).
/// @param estimate [any size, CV_32FC1, 0..1], resampled to the size of `truth`
/// @param truth [rows x cols, CV_32FC1, 0..1]
/// @param aligned [as truth], clamped to 0..1; the mean of `truth` if the estimate has no range or
///        exchanges near and far
/// @throws Error InvalidArgument (empty, wrong type)
ALTIRO3D_EXPORT void alignDepth(const cv::Mat& estimate, const cv::Mat& truth, cv::Mat& aligned);

/// Options of a view method, with a name for tables.
struct NamedViewOptions {
    std::string name;    ///< For example "fast" or "layered".
    ViewOptions options; ///< Method and its options.
};

/// The settings worth comparing: each method with the options of `base` (Fast with refinement 0),
/// and also with one of its options changed. The last setting is the most accurate one.
/// @param base the options that a setting does not vary, such as strength and focus
/// @return the settings; their names are unique
[[nodiscard]] ALTIRO3D_EXPORT std::vector<NamedViewOptions>
tradeSettings(const ViewOptions& base = {});

/// Each method with the options of `base`, cheapest first, named after the method.
/// @param base strength, focus and method options of all settings
/// @return "fast", "layered", "real"
[[nodiscard]] ALTIRO3D_EXPORT std::vector<NamedViewOptions>
defaultSettings(const ViewOptions& base = {});

/// Time to render views.
struct ViewCost {
    double millisecondsPerView = 0; ///< Wall time of a set of views divided by their number.
    /// Wall time of the work that all views of a photo share (edges, the hidden background). It is
    /// done once and is part of the set's time.
    double preparationMilliseconds = 0;
};

/// Measures the time to render views on this machine, with the threads of `cv::setNumThreads()`.
/// @param scene as for Depth2Quilt::render()
/// @param options method and its options
/// @param views number of views in a set, 1..1024, evenly spaced
/// @param repetitions sets to render, 1..1000; the fastest one counts
/// @return the times
/// @throws Error InvalidArgument (views, repetitions, options), TooLarge (the quilt of all views),
///         and as Depth2Quilt::render()
[[nodiscard]] ALTIRO3D_EXPORT ViewCost measureViews(const Scene& scene, const ViewOptions& options,
                                                    int views, int repetitions);

/// Accuracy of a view.
struct ViewAccuracy {
    double psnrWhole = 0;  ///< PSNR of the whole picture in dB.
    double ssimWhole = 0;  ///< SSIM of the whole picture.
    double psnrInside = 0; ///< PSNR without the bands at both sides in dB.
    double ssimInside = 0; ///< SSIM without the bands at both sides.
};

/// Compares a view with the ground truth.
/// @param view [rows x cols, CV_8UC3, BGR]
/// @param truth [as view]
/// @param band width in px of the bands at the left and right that "inside" excludes, 0 or more;
///        they are included if nothing else would be left
/// @return psnr() and ssim()
/// @throws Error Mismatch (sizes or types differ), InvalidArgument (empty, not 8-bit, band)
[[nodiscard]] ALTIRO3D_EXPORT ViewAccuracy compareViews(const cv::Mat& view, const cv::Mat& truth,
                                                        int band);

/// A stereo scene: the photo, its depth (the true disparity divided by the largest one) and the
/// second camera's photo.
struct ALTIRO3D_EXPORT StereoScene : Scene {
    std::string name; ///< Name for tables.
    cv::Mat truth;    ///< [as photo]: the second camera's photo.
    /// Largest disparity in px. In `truth`, content at depth d lies farther left by d times this.
    double largestDisparity = 0;

    /// Options for which the view at position +1 is that of the second camera: focus 0 and S/2 =
    /// largestDisparity, docs/mathematics.md, (3.2).
    /// @param knobs all other options
    /// @return the options
    [[nodiscard]] ViewOptions options(const ViewOptions& knobs) const;
    /// Width of the bands that "inside" excludes. @return ceil(largest disparity) + 2 px
    [[nodiscard]] int band() const;
};

/// Builds a scene from its pictures.
/// @param name name in tables and errors
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param rawDisparity [as photo, CV_32FC1]; 0, negative and non-finite values are unknown. An
///        unknown value takes the next valid value to its left or right, whichever is smaller; a
///        row without valid values becomes 0.
/// @param scale raw values per px of disparity, > 0
/// @param truth [as photo], the photo of the second camera
/// @return the scene; photo and truth share memory with the arguments
/// @throws Error Mismatch (sizes differ), InvalidArgument (empty, wrong type, scale, disparities
///         above the photo's width)
[[nodiscard]] ALTIRO3D_EXPORT StereoScene makeStereoScene(const std::string& name,
                                                          const cv::Mat& photo,
                                                          const cv::Mat& rawDisparity, double scale,
                                                          const cv::Mat& truth);

} // namespace altiro3D
