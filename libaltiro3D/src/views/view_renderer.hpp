#pragma once

#include "altiro3D/view_options.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// Limit of shifts, px, which keeps all positions finite. Beyond it no view shows any of the photo.
constexpr double kMaxShift = 1e9;

/// A shift in whole steps. Opposite shifts have opposite steps. @param steps per px
inline std::int16_t wholeShift(double shiftPixels, double steps) {
    return static_cast<std::int16_t>(
        std::round(std::clamp(shiftPixels * steps, -32640.0, 32640.0)));
}

/// Reads single sub-pixels of views without rendering whole views. One object per thread.
class SubpixelSampler {
  public:
    SubpixelSampler() = default;
    SubpixelSampler(const SubpixelSampler&) = delete;
    SubpixelSampler& operator=(const SubpixelSampler&) = delete;
    virtual ~SubpixelSampler() = default;

    /// Prepares a row of the photo. @param row 0..photo rows - 1
    virtual void open(int row) = 0;

    /// Whether the open row equals the photo's row in every view.
    virtual bool still() const = 0;

    /// Reads one channel of the open row, which must not be still. The values equal those of
    /// ViewRenderer::render().
    /// @param channel 0 blue, 1 green, 2 red
    /// @param shifts p S/2 in px of the requested view, for each column that the sampler was made
    ///        for, and kRowPadding more
    /// @param values result, the same number, and kRowPadding more
    virtual void sample(int channel, const float* shifts, std::uint8_t* values) = 0;

    /// Reads all three channels, for methods with ViewRenderer::shiftSteps().
    /// @param shifts for each channel: wholeShift() of p S/2 in these steps, as for sample()
    /// @param values for each channel, as for sample()
    virtual void sampleBySteps(const std::array<const std::int16_t*, 3>& shifts,
                               const std::array<std::uint8_t*, 3>& values) {
        static_cast<void>(shifts);
        static_cast<void>(values);
    }
};

/// Renders a row of several views and shares the work of a row. One object per thread.
class RowRenderer {
  public:
    RowRenderer() = default;
    RowRenderer(const RowRenderer&) = delete;
    RowRenderer& operator=(const RowRenderer&) = delete;
    virtual ~RowRenderer() = default;

    /// @param row 0..photo rows - 1
    /// @param shifts p S/2 in px of each view
    /// @param views destination of each view's row, B G R, as many px as the photo has columns
    virtual void render(int row, const std::vector<double>& shifts,
                        const std::vector<std::uint8_t*>& views) = 0;
};

/// Renders views of one photo by one method. The constructor does the shared work. Thread-safe.
class ViewRenderer {
  public:
    ViewRenderer() = default;
    ViewRenderer(const ViewRenderer&) = delete;
    ViewRenderer& operator=(const ViewRenderer&) = delete;
    virtual ~ViewRenderer() = default;

    /// Renders the view in which content at depth d is moved by -shiftPixels (d - focus) px.
    /// @param shiftPixels p S/2 in px, any finite number; 0 gives the photo bit for bit
    /// @param view [as the photo, CV_8UC3, BGR], allocated; must not be the photo
    virtual void render(double shiftPixels, cv::Mat& view) const = 0;

    /// Renders the views at shiftPixels and -shiftPixels, which may share work.
    /// @param shiftPixels not 0
    /// @param view, opposite as for render()
    virtual void renderPair(double shiftPixels, cv::Mat& view, cv::Mat& opposite) const {
        render(shiftPixels, view);
        render(-shiftPixels, opposite);
    }

    /// Whether the method supports rowRenderer(); else it renders views one by one.
    virtual bool makesRows() const { return false; }
    virtual std::unique_ptr<RowRenderer> rowRenderer() const { return nullptr; }

    /// Steps per px of shifts that a sampler takes by sampleBySteps(), because it computes in whole
    /// numbers; 0 if it takes them by sample().
    /// @param largestShift as for sampler()
    virtual double shiftSteps(double largestShift) const {
        static_cast<void>(largestShift);
        return 0;
    }

    /// Whether samplers read between columns.
    virtual bool readsBetweenColumns() const { return false; }

    /// Creates a sampler for the given columns of the photo, which may repeat. Null if the method
    /// renders whole views only.
    /// @param columns in order; must outlive the sampler
    /// @param parts how far each place is right of its column, in 1/256 px: 0 at the last column;
    ///        empty for places at columns, as methods need that do not read between them
    /// @param largestShift largest |shift| of the requested views, px
    virtual std::unique_ptr<SubpixelSampler> sampler(const std::vector<int>& columns,
                                                     const std::vector<std::uint8_t>& parts,
                                                     double largestShift) const {
        static_cast<void>(columns);
        static_cast<void>(parts);
        static_cast<void>(largestShift);
        return nullptr;
    }
};

// The following are in view_methods.cpp.

/// ViewRenderer::render(), on all threads if the method supports rows.
void renderWhole(const ViewRenderer& renderer, double shiftPixels, cv::Mat& view);

/// renderWhole(), without the margins of the photo.
/// @param photo its size @param shown columns that the panel shows
/// @param view [photo rows x shown columns, CV_8UC3, BGR], allocated
void renderShown(const ViewRenderer& renderer, cv::Size photo, cv::Range shown, double shiftPixels,
                 cv::Mat& view);

/// S/2 in px for pictures of the given width.
float halfParallaxOf(const ViewOptions& options, int width);

/// p S/2 in px, the product of two floats, as in shiftsOfViews().
double shiftOf(const ViewOptions& options, int width, double position);

} // namespace altiro3D
