#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/placement.hpp"
#include "altiro3D/quilt2native.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <tuple>

namespace altiro3D {

/// Camera position of a sub-pixel, and the column of the view that it shows.
enum class ViewPositions {
    /// The position of one of N views, as in a quilt: docs/mathematics.md, (3.1). Shows the px of
    /// the view under the centre of the panel px.
    Discrete,
    /// Follows its phase z under the lens: p = (2Nz - N)/(N-1), limited to -1..1
    /// (docs/conventions.md); N = number of views of the display. Method Layered interpolates
    /// between columns of the view, at the centre of the panel px; rows are those of Discrete.
    /// With Calibration::viewOrder, the same as Discrete.
    Continuous
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
/// Its source is native_renderer.cpp. Immutable; render() is thread-safe. Results are the same
/// bytes for any number of threads and on any processor.
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

    /// Renders one Native.
    /// @param scene photo [rows x cols, CV_8UC3, BGR], sides at most 32766 px, stretched to the
    ///        panel; depth [as the photo, CV_32FC1, 0..1, 1 = nearest], NaN counts as 0; hidden
    ///        layer of the photo's size or empty
    /// @param native [panel rows x panel cols, CV_8UC3, `order`]; reused if it fits; must not share
    ///        memory with the scene
    /// @param order of the channels of `native`
    /// @throws Error InvalidArgument (empty or wrong type, shared memory), TooLarge, Mismatch
    ///         (sizes differ), OutOfMemory
    void render(const Scene& scene, cv::Mat& native, ChannelOrder order = ChannelOrder::Bgr) const;

    /// As above, in bands, so that the Native need not fit into memory.
    /// @param scene as above
    /// @param sink receives the Native [rows x panel cols, CV_8UC3, BGR]; the same bytes as above
    /// @throws Error as above, and what `sink` throws
    void render(const Scene& scene, const RowSink& sink) const;

  private:
    struct Impl;
    std::shared_ptr<const Impl> impl_;
};

/// The size to which a photo is fitted, and so the detail that its Native keeps.
enum class Detail {
    View, ///< That of a view of the quilt.
    Lens, ///< All that the lenses show in one direction: three px per lens, up to 4K, prints up to
          ///< 12 megapixels.
    Panel ///< That of the panel.
};

/// How a photo with depth becomes a Native. The defaults are method Layered, photos of the size of
/// a view, discrete views and no lens filter. showAs(Detail::Lens) is recommended for photos,
/// showLive() for cameras.
///
/// Time of NativeMaker::makeNative(scene, native) for the sample photo (900 x 1200 px) on a
/// Portrait, one thread of a Zen 4 server, and what `refine` takes of it:
///
/// | options                | time   | refinement |
/// |------------------------|--------|------------|
/// | showLive()             | 5 ms   | off        |
/// | defaults               | 39 ms  | 2 ms       |
/// | showAs(Detail::Lens)   | 82 ms  | 6 ms       |
/// | showAs(Detail::Panel)  | 242 ms | 12 ms      |
struct NativeOptions : PlacementOptions {
    /// Detail above that of a view is shown by the direct path only, because views have fewer px.
    /// In a quilt, Detail::Lens is Detail::View.
    Detail detail = Detail::View;
    /// Whether detail that the lenses cannot show in one direction is removed before the views are
    /// made, docs/mathematics.md, (2.10). Otherwise it becomes coloured noise. Needs a display, not
    /// a look-up table.
    bool lensFilter = false;
    /// Whether each sub-pixel shows one of the views of the layout (Discrete) or the view exactly
    /// in its own direction (Continuous). Continuous positions require the direct path.
    ViewPositions positions = ViewPositions::Discrete;
    /// How a quilt is sampled. Linear sampling requires the path over a quilt.
    QuiltSampling sampling;

    /// All fields, to save them. @param o the options @return references to its fields
    template <typename Options>
    static auto fields(Options& o) {
        return std::tuple_cat(
            PlacementOptions::fields(o),
            std::tie(o.detail, o.lensFilter, o.positions, o.sampling.views, o.sampling.inTile));
    }

    /// Sets detail, filter and positions for the most accurate picture through the lenses.
    /// @param most the detail. Lens is recommended: Panel takes 3 times the time and is no more
    ///        accurate (docs/tradeoff.md).
    void showAs(Detail most) {
        detail = most;
        lensFilter = true;
        positions = ViewPositions::Continuous;
    }

    /// Chooses settings that are fast enough for every frame of a camera or a program: method Fast
    /// at the size of the views, discrete positions, no lens filter and no refinement of depth.
    /// Edges of near objects repeat columns instead of showing a painted background, and fine
    /// detail becomes coloured noise. Compared with showAs(Detail::Lens), the picture through the
    /// lenses has 2 dB less PSNR for photos and 6 dB less for deep scenes (docs/tradeoff.md).
    void showLive() {
        views.method = ViewMethod::Fast;
        detail = Detail::View;
        lensFilter = false;
        positions = ViewPositions::Discrete;
        refine.flaws = DepthFlaws();
    }
};

/// The path from a photo to its Native.
enum class NativePath {
    Direct,   ///< Reads each sub-pixel from the photo (NativeRenderer).
    OverQuilt ///< Makes all views first (Depth2Quilt), then interlaces them (Quilt2Native).
};

/// Makes Natives of photos with depth for one display. It uses the direct path if the options allow
/// it, else the path through a quilt. With discrete positions, nearest sampling and Detail::View,
/// both paths give the same bytes.
///
/// makeNative(scene, native) does all steps. To also get the quilt, do the steps one by one:
///
///     const double aspect = display.aspect();
///     const Placement placed = placeScene(scene, aspect, maker.workSize(), maker.options());
///     cv::Mat quilt;
///     maker.makeQuilt(placed.scene, quilt);          // not needed if path() is Direct
///     maker.makeNative(placed.scene, quilt, native);
///
/// makeQuilt() needs a scene of quiltSize(), where it differs from workSize().
///
/// Cheap to copy. Immutable and thread-safe. Results are the same bytes for any number of threads.
class ALTIRO3D_EXPORT NativeMaker {
  public:
    /// @param display the display; its default layout sets the number and the size of the views
    /// @param options see NativeOptions
    /// @throws Error BadFormat (calibration), InvalidArgument (options; continuous positions
    ///         although a quilt is needed, see obstacle()), TooLarge (quilt), OutOfMemory
    explicit NativeMaker(const Display& display, const NativeOptions& options = {});
    /// @param display the display
    /// @param layout number and size of the views, instead of the display's default layout
    /// @param options see NativeOptions
    /// @throws Error as above
    NativeMaker(const Display& display, const QuiltLayout& layout, const NativeOptions& options);
    /// Uses an existing look-up table, which says where in a quilt each sub-pixel lies. The path is
    /// therefore always OverQuilt, which takes longer. Check that the table is of your display:
    /// requireSameDisplay().
    /// @param map the table; it determines display and layout
    /// @param options sampling must be nearest, positions discrete, lensFilter off
    /// @throws Error InvalidArgument (options), OutOfMemory
    NativeMaker(NativeLut map, const NativeOptions& options);

    /// Why the direct path is not possible.
    /// @param layout layout of the quilts
    /// @param options only method and sampling matter
    /// @return a clause for people, such as "views are blended"; empty if the direct path is
    ///         possible
    [[nodiscard]] static std::string obstacle(const QuiltLayout& layout,
                                              const NativeOptions& options);

    /// A maker with other view options, for example another strength or focus for one photo. It
    /// keeps path() and shares the look-up table.
    /// @param views see ViewOptions
    /// @return the new maker
    /// @throws Error InvalidArgument (views; method Real if path() is Direct)
    [[nodiscard]] NativeMaker withViews(const ViewOptions& views) const;

    /// The path in use. @return Direct or OverQuilt
    [[nodiscard]] NativePath path() const;
    /// The options in use. @return as given to the constructor or to withViews(); lensFilter is off
    /// for horizontal lenses
    [[nodiscard]] const NativeOptions& options() const;
    /// Layout of the quilts. @return the layout
    [[nodiscard]] const QuiltLayout& layout() const;
    /// Size of the Native. @return columns x rows in px
    [[nodiscard]] cv::Size panelSize() const;
    /// Size to which photos are fitted for a Native, as NativeOptions::detail says.
    /// @return columns x rows in px
    [[nodiscard]] cv::Size workSize() const;
    /// Size to which photos are fitted for a quilt.
    /// @return columns x rows in px: the size of a view, or the panel's if the constructor was
    ///         given Detail::Panel without lensFilter
    [[nodiscard]] cv::Size quiltSize() const;

    /// Makes the quilt of a fitted photo, whatever path() is.
    /// @param fitted photo and depth map of quiltSize(), from placeScene()
    /// @param quilt [layout().size(), CV_8UC3, BGR]; reused if it fits
    /// @throws Error Mismatch (another size), as Depth2Quilt::render()
    void makeQuilt(const Scene& fitted, cv::Mat& quilt) const;

    /// As above, with progress: Depth2Quilt::render().
    /// @param fitted, quilt as above
    /// @param goOn receives the progress; may be empty
    /// @return false if `goOn` has stopped the work
    /// @throws Error as above; exceptions of `goOn` stop the work and pass through
    bool makeQuilt(const Scene& fitted, cv::Mat& quilt, const QuiltProgressFunction& goOn) const;

    /// Makes the Native of a fitted photo.
    /// @param fitted photo and depth map of workSize(); used if path() is Direct, else ignored
    /// @param quilt from makeQuilt(); used if path() is OverQuilt, else ignored and may be empty
    /// @param native [panelSize(), CV_8UC3, `order`]; reused if it fits
    /// @param order of the channels of `native`; if path() is OverQuilt, Rgb costs one more pass
    ///        over the Native
    /// @throws Error Mismatch (another size), as NativeRenderer::render() and
    ///         Quilt2Native::render()
    void makeNative(const Scene& fitted, const cv::Mat& quilt, cv::Mat& native,
                    ChannelOrder order = ChannelOrder::Bgr) const;

    /// As above, in bands, so that the Natives of large prints need not fit into memory.
    /// @param fitted, quilt as above
    /// @param sink receives the Native [rows x panel cols, CV_8UC3, BGR]; the same bytes as above
    /// @throws Error as above, and what `sink` throws
    void makeNative(const Scene& fitted, const cv::Mat& quilt, const RowSink& sink) const;

    /// Makes the Native of a placed photo, over a quilt if path() is OverQuilt.
    /// @param placed from placeScene() for workSize(), or for quiltSize() if path() is OverQuilt
    /// @param native, order as above
    /// @throws Error as makeQuilt() and the function above
    void makeNative(const Placement& placed, cv::Mat& native,
                    ChannelOrder order = ChannelOrder::Bgr) const;

    /// Fits a photo and makes its Native.
    /// @param scene a photo of any size and its depth map of any size; see
    ///        DepthSource::readScene()
    /// @param native, order as above
    /// @throws Error as placeScene(), makeQuilt() and makeNative()
    void makeNative(const Scene& scene, cv::Mat& native,
                    ChannelOrder order = ChannelOrder::Bgr) const;

  private:
    struct Impl;
    explicit NativeMaker(std::shared_ptr<const Impl> impl);
    std::shared_ptr<const Impl> impl_;
};

} // namespace altiro3D
