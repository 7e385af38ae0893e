#pragma once

#include "altiro3D/view_options.hpp"

#include <algorithm>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// Beyond this nothing of the photo is left in any view; it keeps all places finite, px.
constexpr double kLargestShift = 1e9;

/// Depth as offset from the focus, clamped, NaN as 0; exactly 0 at the focus.
inline float offsetFromFocus(float depth, double focus) {
    const float d = depth > 0 ? (depth < 1 ? depth : 1.0F) : 0.0F;
    if (d == static_cast<float>(focus)) return 0; // also where the focus is not a float
    return static_cast<float>(static_cast<double>(d) - focus);
}

/// Reads single sub-pixels out of views that are never made as a whole. One for each thread.
class SubpixelSampler {
  public:
    SubpixelSampler() = default;
    SubpixelSampler(const SubpixelSampler&) = delete;
    SubpixelSampler& operator=(const SubpixelSampler&) = delete;
    virtual ~SubpixelSampler() = default;

    /// Makes a row of the photo ready. @param row 0..photo rows - 1
    virtual void open(int row) = 0;

    /// Whether the open row is the photo's in every view.
    virtual bool still() const = 0;

    /// Reads one channel of the open row, which is not still, the same value as
    /// ViewRenderer::render() gives.
    ///
    /// @param channel 0 blue, 1 green, 2 red
    /// @param shifts for each column that the sampler was made for, and kRowPadding more: p S/2 in
    ///        px of the view that is asked for
    /// @param values result, as many, and kRowPadding more
    virtual void sample(int channel, const float* shifts, std::uint8_t* values) = 0;
};

/// Makes the same row of several views, so that what a row costs once is done once. One for each
/// thread.
class RowRenderer {
  public:
    RowRenderer() = default;
    RowRenderer(const RowRenderer&) = delete;
    RowRenderer& operator=(const RowRenderer&) = delete;
    virtual ~RowRenderer() = default;

    /// @param row 0..photo rows - 1
    /// @param shifts p S/2 in px of each view
    /// @param views for each view where its row goes, B G R, as many px as the photo has
    virtual void render(int row, const std::vector<double>& shifts,
                        const std::vector<std::uint8_t*>& views) = 0;
};

/// Makes views of one photo with its depth by one method. What all views share is done once, when
/// it is made. Its functions may run on any number of threads at once.
class ViewRenderer {
  public:
    ViewRenderer() = default;
    ViewRenderer(const ViewRenderer&) = delete;
    ViewRenderer& operator=(const ViewRenderer&) = delete;
    virtual ~ViewRenderer() = default;

    /// Makes the view in which content at depth d is moved by -shiftPixels (d - focus) px.
    ///
    /// @param shiftPixels p S/2 in px, any finite number; 0 gives the photo, bit for bit
    /// @param view [as the photo, CV_8UC3, BGR], allocated, not the photo
    virtual void render(double shiftPixels, cv::Mat& view) const = 0;

    /// Makes the views at shiftPixels and -shiftPixels, which may have work in common.
    /// @param shiftPixels not 0 @param view, opposite as for render()
    virtual void renderPair(double shiftPixels, cv::Mat& view, cv::Mat& opposite) const {
        render(shiftPixels, view);
        render(-shiftPixels, opposite);
    }

    /// Whether rowRenderer() gives one; else the method makes views one by one.
    virtual bool makesRows() const { return false; }
    virtual std::unique_ptr<RowRenderer> rowRenderer() const { return nullptr; }

    /// Reads sub-pixels at the given columns of the photo; they may repeat. Null if the method
    /// makes whole views only.
    /// @param columns in order; must outlive the sampler
    /// @param largestShift of all |shift| that will be asked for, px
    virtual std::unique_ptr<SubpixelSampler> sampler(const std::vector<int>& columns,
                                                     double largestShift) const {
        static_cast<void>(columns);
        static_cast<void>(largestShift);
        return nullptr;
    }
};

/// ViewRenderer::render() on all threads, if the method makes rows.
void renderWhole(const ViewRenderer& renderer, double shiftPixels, cv::Mat& view);

/// S/2 in px for pictures of a width.
float halfParallaxOf(const ViewOptions& options, int width);

/// p S/2 in px, the product of two floats as in shiftsOfViews().
double shiftOf(const ViewOptions& options, int width, double position);

} // namespace altiro3D
