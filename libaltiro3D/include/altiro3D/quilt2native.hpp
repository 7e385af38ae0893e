#pragma once

#include "altiro3D/depth_network.hpp"
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
#include <string>
#include <vector>

namespace altiro3D {

/// How a sub-pixel samples the views. Its lens phase, 0..1, is its position under its lens
/// (LensGeometry::phase()); view i of N has the interval [i, i + 1) / N.
enum class ViewFilter {
    Nearest, ///< The view whose interval contains the lens phase. Sharp; the default.
    Linear   ///< The two views nearest to the phase, blended. Soft transitions, slight ghosting.
             ///< With Calibration::viewOrder, the same as Nearest.
};

/// How a sub-pixel samples the pixels inside a view.
enum class TileSampling {
    Nearest, ///< The nearest pixel, as in a `.map`; the default.
    Linear   ///< The four pixels around it, blended; never across the border of the view.
};

/// How a quilt is sampled.
struct QuiltSampling {
    ViewFilter views = ViewFilter::Nearest;      ///< Between views.
    TileSampling inTile = TileSampling::Nearest; ///< Inside a view.

    /// Whether px are mixed. @return true unless both are nearest
    [[nodiscard]] bool blends() const {
        return views != ViewFilter::Nearest || inTile != TileSampling::Nearest;
    }
};

/// Resamples a quilt so that its views have whole px. If the quilt's size is not a multiple of its
/// columns and rows, views have a fractional size and position: 819.2 px each for 4096 px with 5
/// columns. Each view is sampled at its own position, at the nearest px. Nothing is cut off.
/// @param quilt [rows x cols, any type]
/// @param layout the layout that the quilt should have; its views have the quilt's size divided by
///        columns and rows, rounded down
/// @return [layout.size(), type of `quilt`]; `quilt` itself if it has this size
/// @throws Error Mismatch (the quilt does not have this layout; names both sizes);
///         InvalidArgument or TooLarge (layout)
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat fitQuilt(const cv::Mat& quilt, const QuiltLayout& layout);

/// Crops a quilt to views of whole px, which a `.map` requires. If the quilt's size is not a
/// multiple of its columns and rows, the remainder counts as an unused border: 4096 px hold 5 views
/// of 819 px and one unused px. Unused columns are at the right, unused rows at the top.
/// @param quilt as for fitQuilt()
/// @param layout as for fitQuilt()
/// @param notes if given, receives a remark if a border is cut off
/// @return [layout.size(), type of `quilt`]; shares memory with `quilt`
/// @throws Error as fitQuilt()
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat cropQuilt(const cv::Mat& quilt, const QuiltLayout& layout,
                                                Notes* notes = nullptr);

/// Renders Natives from quilts: each sub-pixel takes its colour from the view that its lens phase
/// selects (docs/mathematics.md, 1 and 2).
///
/// Immutable; render() is thread-safe. Results are the same bytes for any number of threads.
class ALTIRO3D_EXPORT Quilt2Native {
  public:
    /// Renders through a look-up table: nearest view, nearest pixel.
    /// @param lut the table; it determines display and layout
    /// @throws Error OutOfMemory
    explicit Quilt2Native(NativeLut lut);

    /// Renders from the calibration. Linear sampling requires this constructor, because a look-up
    /// table holds a single px per sub-pixel.
    /// @param calibration the display
    /// @param quilt layout of the quilts
    /// @param sampling nearest or linear, between views and inside them
    /// @param invert whether the order of views is reversed; usually Display::invert
    /// @throws Error BadFormat (calibration), InvalidArgument or TooLarge (layout), OutOfMemory
    Quilt2Native(const Calibration& calibration, const QuiltLayout& quilt, QuiltSampling sampling,
                 InvertViews invert = InvertViews::Auto);

    /// Renders one Native.
    /// @param quilt [size of the layout, CV_8UC3, `order`], or a size that fitQuilt() accepts
    /// @param native [panel rows x panel cols, CV_8UC3, `order`]; must not share the quilt's memory
    /// @param order of the channels of both
    /// @throws Error InvalidArgument (type, shared memory), Mismatch (size)
    void render(const cv::Mat& quilt, cv::Mat& native,
                ChannelOrder order = ChannelOrder::Bgr) const;

    /// As above, in bands for prints and for linear sampling, so that these Natives need not fit
    /// into memory; other Natives, and all with a NativeLut, are passed whole.
    /// @param quilt as above
    /// @param sink receives the Native [rows x panel cols, CV_8UC3, BGR]; the same bytes as above
    /// @throws Error as above, and what `sink` throws
    void render(const cv::Mat& quilt, const RowSink& sink) const;

  private:
    struct Impl;
    std::shared_ptr<const Impl> impl_;
};

/// Removes from views the detail that the lenses of a display cannot show in one direction.
/// Otherwise it becomes coloured noise: docs/mathematics.md, (2.10). Rendered and photographed
/// views need this filter; for views of Depth2Quilt, NativeOptions::lensFilter applies it.
/// @param quilt [layout.size(), CV_8UC3, BGR]
/// @param layout its layout
/// @param calibration the display; nothing is removed for horizontal lenses
/// @return the filtered quilt
/// @throws Error BadFormat (calibration), InvalidArgument (type, layout), Mismatch (size)
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat filterForLens(const cv::Mat& quilt, const QuiltLayout& layout,
                                                    const Calibration& calibration);

/// A shader that renders Natives from quilts on the graphics card, for mpv and other players with
/// libplacebo. The quilt may have any size. The text contains no strings of the calibration.
///
/// On all known displays, fewer than 0.1 % of the sub-pixels show a different view from that of
/// Quilt2Native, because of 32-bit floats. Within a view, a sub-pixel is off by at most one px.
/// @param calibration the display
/// @param quilt columns, rows and number of views; the size of a view has no effect
/// @param sampling nearest or linear, between views and inside them
/// @param invert whether the order of views is reversed; usually Display::invert
/// @return text of a user shader of mpv (GLSL 1.30)
/// @throws Error BadFormat (calibration), InvalidArgument or TooLarge (layout)
[[nodiscard]] ALTIRO3D_EXPORT std::string quiltShader(const Calibration& calibration,
                                                      const QuiltLayout& quilt,
                                                      QuiltSampling sampling = {},
                                                      InvertViews invert = InvertViews::Auto);

/// Whether two shapes count as equal: their aspects differ by at most 5 %.
/// @param aspect width : height, > 0; not checked
/// @param other width : height, > 0; not checked
/// @return true if they count as equal
[[nodiscard]] ALTIRO3D_EXPORT bool haveSameShape(double aspect, double other);

/// How the views of a quilt file are fitted to the panel if their shapes differ.
///
/// The shape of the views is the aspect in the file's name (`_qs8x6a0.75`), without one their
/// width : height in px. Immutable and thread-safe.
class ALTIRO3D_EXPORT QuiltShape {
  public:
    /// @param file the quilt file; only its name is used
    /// @param layout layout of the quilt
    /// @param display the display on which the quilt is shown
    /// @param fit how the views are fitted. If not given: Contain (black bars) if the name states
    ///        an aspect that differs from the panel's (haveSameShape()), as the display maker's
    ///        players do; else Stretch.
    /// @throws Error as parseQuiltName()
    QuiltShape(const std::filesystem::path& file, const QuiltLayout& layout, const Display& display,
               std::optional<FitMode> fit = std::nullopt);

    /// Resamples the views to whole px, see fitQuilt(), and fits them to the panel.
    /// @param picture the quilt [a size that fitQuilt() accepts, CV_8UC3, BGR]
    /// @return [layout size, CV_8UC3, BGR] for Quilt2Native; may share memory with `picture`
    /// @throws Error as fitQuilt()
    [[nodiscard]] cv::Mat apply(const cv::Mat& picture) const;

    /// The shape in which a view appears on the panel. @return width : height; differs from
    ///         aspect() only if the views are stretched
    [[nodiscard]] double shownAspect() const {
        return fit_ == FitMode::Stretch ? panelAspect_ : aspect_;
    }

    /// The shape for which the views were made. @return width : height
    [[nodiscard]] double aspect() const { return aspect_; }

    /// How the views are fitted. @return as given to the constructor, else as chosen by it
    [[nodiscard]] FitMode fit() const { return fit_; }

    /// Whether the constructor chose to stretch the views, because the name does not state their
    /// shape and their width : height in px differs from the panel's. Tools report this.
    /// @return true if `fit` was not given, the fit is Stretch, and the shapes differ
    [[nodiscard]] bool stretchesUnasked() const { return isStretchedUnasked_; }

    /// Whether the constructor chose black bars itself. Tools report this.
    /// @return true if `fit` was not given and the fit is Contain
    [[nodiscard]] bool fitsUnasked() const { return isFittedUnasked_; }

  private:
    QuiltLayout layout_;
    double aspect_;
    double panelAspect_;
    bool isFittedUnasked_;
    bool isStretchedUnasked_;
    FitMode fit_;
};

/// What findQuiltLayout() found.
enum class QuiltVerdict {
    Quilt,  ///< A quilt; its layout is certain enough to be used.
    Unsure, ///< Parts of the picture resemble each other, but the layout is not certain.
    NoQuilt ///< No parts of the picture resemble each other as views do: a photo, for example.
};

/// The layout that a picture seems to have.
struct FoundQuilt {
    QuiltVerdict verdict = QuiltVerdict::NoQuilt; ///< How far the layout can be trusted.
    /// The most likely layout; meaningless for NoQuilt, and if the confidence is 0. Its tiles have
    /// the size of the picture divided by columns and rows, rounded down.
    QuiltLayout layout;
    double confidence = 0;  ///< Similarity of neighbouring views, 0..1, lowered if another layout
                            ///< fits as well, or if the views hold nothing but a regular pattern.
    bool isFromTop = false; ///< The layout is clear, but its rows run downwards: Unsure.
};

/// Finds the columns and rows of a quilt by comparing parts of the picture.
///
/// Neighbouring views of a quilt resemble each other: those side by side, and the last one of a row
/// and the first one of the row above. The function searches divisions of the picture of up to 20
/// columns and 20 rows, and takes the finest one whose parts resemble each other in this way.
/// Quilts may be scaled, compressed, and cropped by some px, and have lines between their views. If
/// no row continues another, the function looks for a single row of 4 or more views. The verdict is
/// Unsure if the camera moves along the rows, but no row continues in the row above. It is also
/// Unsure for drawn grids and other regular patterns, because any multiple of their period fits.
/// @param picture [rows x cols, CV_8UC3, BGR]
/// @return verdict, layout and confidence; Unsure, with confidence 0, for pictures of one colour,
///         or with a side below 128 px
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT FoundQuilt findQuiltLayout(const cv::Mat& picture);

/// Compares a quilt with the layout that its name or an option states.
/// @param picture [rows x cols, CV_8UC3, BGR]
/// @param layout columns, rows and number of views
/// @return remarks, usually none: views of one colour (AsItIs), rows that run downwards, another
///         layout in the picture, or views that do not resemble each other (Doubtful)
/// @throws Error InvalidArgument (empty or wrong type; layout), TooLarge (layout)
[[nodiscard]] ALTIRO3D_EXPORT Notes checkQuiltLayout(const cv::Mat& picture,
                                                     const QuiltLayout& layout);

/// Makes a Native for one viewer: sub-pixels whose light passes to the left of the viewer show the
/// left eye's picture, the others the right eye's: docs/mathematics.md, (2.12).
/// @param left, right what each eye sees [of one size, stretched to the panel, CV_8UC3, BGR]
/// @param display its calibration and order of views; if Calibration::viewOrder is set, the border
///        between the eyes stays in the middle
/// @param position of the viewer, -1 left edge of the cone .. +1 right edge
/// @param native [panel, CV_8UC3, BGR]; reused if it fits
/// @throws Error InvalidArgument, Mismatch, BadFormat (the calibration)
ALTIRO3D_EXPORT void eyesToNative(const cv::Mat& left, const cv::Mat& right, const Display& display,
                                  double position, cv::Mat& native);

/// How much consecutive pictures resemble each other, as the views of neighbouring cameras do.
/// Shifts up to a tenth of the width do not count. Measured: 0.9 and more for rendered and captured
/// views, below 0.1 for unrelated photos.
/// @param pictures in camera order [any size, CV_8UC3, BGR]; small copies are sufficient
/// @return 0..1; 1 if there is nothing to compare: fewer than two pictures, or no contrast
/// @throws Error InvalidArgument (an empty picture or a wrong type)
[[nodiscard]] ALTIRO3D_EXPORT double likenessOfViews(const std::vector<cv::Mat>& pictures);

/// Neighbours below this likenessOfViews() are not views of one scene. Measured for neighbours of
/// real light fields: 0.97 and more.
constexpr double kMinLikenessOfViews = 0.35;

} // namespace altiro3D
