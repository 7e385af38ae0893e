#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/native_renderer.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt2native.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

/// How Natives are made of photos with depth.
struct NativeOptions {
    ViewOptions views;            ///< Method and knobs.
    FitMode fit = FitMode::Cover; ///< How photos of another shape are brought to the panel's.
    bool keepResolution = false;  ///< The photo is read at the panel's resolution, not a tile's.
    ViewPositions positions = ViewPositions::Discrete; ///< Where cameras stand.
    QuiltSampling sampling; ///< How a quilt is sampled; other than nearest needs a quilt.
};

/// The way from a photo to its Native.
enum class NativePath {
    Direct,   ///< Each sub-pixel is read from the photo (NativeRenderer).
    OverQuilt ///< All views are made first (Depth2Quilt, Quilt2Native).
};

/// Makes Natives of photos with depth for one display: directly where the options allow it, else
/// over a quilt. Both ways give the same bytes for equal options.
///
/// Cheap to copy. Immutable; its functions may run on any number of threads at once and give the
/// same bytes for any number of threads.
class ALTIRO3D_EXPORT NativeMaker {
  public:
    /// @param display the display; its default quilt says how many views there are
    /// @param options method, knobs, fit
    /// @throws Error BadFormat (calibration), InvalidArgument (options; continuous positions where
    ///         a quilt is needed, see obstacle()), TooLarge (quilt), OutOfMemory
    explicit NativeMaker(const Display& display, const NativeOptions& options = {});
    /// @param display the display
    /// @param layout layout of its quilts
    /// @param options method, knobs, fit
    /// @throws Error as above
    NativeMaker(const Display& display, const QuiltLayout& layout, const NativeOptions& options);
    /// Over quilts, through a look-up table that is there already.
    /// @param map the table of display and layout
    /// @param options method, knobs, fit; sampling must be nearest, positions discrete
    /// @throws Error InvalidArgument (options), OutOfMemory
    NativeMaker(NativeLut map, const NativeOptions& options);

    /// Why a Native needs a quilt, for people.
    /// @param layout layout of the quilts
    /// @param options method, sampling
    /// @return empty if it can be made directly
    [[nodiscard]] static std::string obstacle(const QuiltLayout& layout,
                                              const NativeOptions& options);

    /// The same maker with other views: another strength or focus for one photo.
    /// @param views method and knobs; the method must need a quilt or not, as the one before
    /// @return the maker; look-up tables are shared
    /// @throws Error InvalidArgument (views)
    [[nodiscard]] NativeMaker withViews(const ViewOptions& views) const;

    /// The way that is taken. @return direct or over a quilt
    [[nodiscard]] NativePath path() const;
    /// The options in use. @return as given to the constructor
    [[nodiscard]] const NativeOptions& options() const;
    /// Layout of the quilts. @return the layout
    [[nodiscard]] const QuiltLayout& layout() const;
    /// Size of the Native. @return columns x rows in px
    [[nodiscard]] cv::Size panelSize() const;
    /// Size that photos are fitted to. @return that of a tile, or the panel's
    [[nodiscard]] cv::Size workSize() const;

    /// The fit of a photo.
    /// @param photo its size in px
    /// @param aspect width : height of what the viewer sees; 0: the panel's
    /// @return the fit, for fitScene()
    /// @throws Error as fitPhoto()
    [[nodiscard]] PhotoFit fit(cv::Size photo, double aspect = 0) const;

    /// Makes the quilt of a fitted photo.
    /// @param fitted of workSize()
    /// @param quilt [layout().size(), CV_8UC3, BGR]; reused if it fits
    /// @throws Error as Depth2Quilt::render()
    void makeQuilt(const Scene& fitted, cv::Mat& quilt) const;

    /// Makes the Native of a fitted photo.
    /// @param fitted of workSize(); read by the direct way
    /// @param quilt from makeQuilt(); read by the way over the quilt, else it may be empty
    /// @param native [panelSize(), CV_8UC3, BGR]; reused if it fits
    /// @throws Error as NativeRenderer::render() and Quilt2Native::render()
    void makeNative(const Scene& fitted, const cv::Mat& quilt, cv::Mat& native) const;

    /// Fits a photo and makes its Native.
    /// @param scene photo of any size and its depth map of any size
    /// @param native [panelSize(), CV_8UC3, BGR]; reused if it fits
    /// @throws Error as fitPhoto(), fitScene(), makeQuilt() and makeNative()
    void makeNative(const Scene& scene, cv::Mat& native) const;

  private:
    struct Impl;
    explicit NativeMaker(std::shared_ptr<const Impl> impl);
    std::shared_ptr<const Impl> impl_;
};

} // namespace altiro3D
