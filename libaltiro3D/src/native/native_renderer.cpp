#include "altiro3D/native_maker.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "base/text.hpp"
#include "display/lens_phase.hpp"
#include "native/panel_table.hpp"
#include "native/shift_kernels.hpp"
#include "native/view_columns.hpp"
#include "views/view_methods.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace altiro3D {

namespace {

// With Layered, rendering rows of views is faster if the panel has more than four sub-pixels per
// pixel of all views (measured: docs/performance.md).
constexpr double kSamplesPerSubpixel = 0.25;

constexpr double kOutermost = 1; // position

// For each px of a side of the panel, the px of the photo under it.
// @param shown px of the photo that the panel shows
std::vector<int> samplesOf(int panel, const cv::Range& shown, bool mirrored) {
    std::vector<int> samples = samplesUnder(panel, shown.size(), mirrored);
    for (int& sample : samples)
        sample += shown.start;
    return samples;
}

// Where a row of the panel lies in the photo: columns, and parts of a px to their right.
struct Places {
    std::vector<int> columns;
    std::vector<std::uint8_t> parts; // 1/256 px; empty for none
};

// As samplesOf(), for places between px. Places beside the photo are at its border.
// @param photo its px
Places placesOf(int panel, const cv::Range& shown, int photo, bool mirrored) {
    Places places;
    for (int i = 0; i < panel; ++i) {
        const double at = (mirrored ? panel - i - 0.5 : i + 0.5) * shown.size() / panel;
        const auto place = std::lround(std::clamp(shown.start + at - 0.5, 0.0, photo - 1.0) * 256);
        places.columns.push_back(static_cast<int>(place >> 8));
        places.parts.push_back(static_cast<std::uint8_t>(place & 255));
    }
    return places;
}

// @param order blue is 0, red 2
void copyPlaces(const std::uint8_t* bgr, const Places& places, const std::size_t (&order)[3],
                std::uint8_t* out) {
    for (std::size_t i = 0; i < places.columns.size(); ++i) {
        const std::uint8_t* const first = bgr + 3 * static_cast<std::ptrdiff_t>(places.columns[i]);
        const int part = places.parts.empty() ? 0 : places.parts[i];
        for (const std::size_t c : order) {
            const int rise = part == 0 ? 0 : first[c + 3] - first[c];
            *out++ = static_cast<std::uint8_t>((256 * first[c] + rise * part + 128) >> 8);
        }
    }
}

} // namespace

struct NativeRenderer::Impl {
    LensPhases lens;
    int viewCount;
    ViewOptions options;
    ViewPositions positions;

    // p S/2 in px of each view of a photo
    std::vector<double> shiftsOfAllViews(int shownWidth) const {
        std::vector<double> shifts;
        for (int i = 0; i < viewCount; ++i)
            shifts.push_back(shiftOf(options, shownWidth, viewPosition(i, viewCount)));
        return shifts;
    }

    // Where the photo is on the panel.
    struct Samples {
        int shownWidth;        // px of the photo that the panel shows
        Places columns;        // places under the columns of the panel
        std::vector<int> rows; // row of the photo under each row of the panel
        std::size_t order[3];  // order of the Native's channels: blue is 0, red 2
    };
    Samples samplesOn(const Scene& scene, const ViewRenderer& renderer, ChannelOrder order) const;
    // Fills rows of the panel from `first` on.
    void renderBand(const ViewRenderer& renderer, const cv::Mat& photo, const Samples& samples,
                    int first, cv::Mat& native) const;
    void renderSubpixels(const ViewRenderer& renderer, const cv::Mat& photo, const Samples& samples,
                         int first, cv::Mat& native) const;
    void renderRows(const ViewRenderer& renderer, const cv::Mat& photo, const Samples& samples,
                    int first, cv::Mat& native) const;
};

NativeRenderer::NativeRenderer(const Calibration& calibration, int viewCount,
                               const ViewOptions& options, ViewPositions positions,
                               InvertViews invert) {
    validate(options);
    checkRange("view count", viewCount, 1, kMaxViews);
    check(options.method != ViewMethod::Real, "method",
          "is real, which makes only whole views, expected fast or layered, or a quilt");
    if (!calibration.viewOrder.empty()) positions = ViewPositions::Discrete; // not in a row
    impl_ = std::make_shared<const Impl>(
        Impl{LensPhases(lensGeometry(calibration, invert)), viewCount, options, positions});
}

// Reads each sub-pixel separately.
void NativeRenderer::Impl::renderSubpixels(const ViewRenderer& renderer, const cv::Mat& photo,
                                           const Samples& samples, int first,
                                           cv::Mat& native) const {
    const Places& places = samples.columns;
    const auto& order = samples.order;
    const float halfParallax = halfParallaxOf(options, samples.shownWidth);
    const auto width = static_cast<std::size_t>(native.cols);
    const auto largestShift = static_cast<double>(halfParallax);
    const double steps = renderer.shiftSteps(largestShift);
    // for discrete positions; continuous ones take wholeShiftsOfPhases()
    const WholeShifts wholeShiftsOfViews(shiftsOfAllViews(samples.shownWidth), steps);
    forRows(native.rows, [&](const cv::Range& rows) {
        const std::unique_ptr<SubpixelSampler> sampler =
            renderer.sampler(places.columns, places.parts, largestShift);
        std::vector<std::uint16_t> views = paddedRow<std::uint16_t>(width);
        std::vector<float> shifts = paddedRow<float>(width);
        std::array<std::vector<std::int16_t>, 3> wholeShifts; // blue, green, red
        wholeShifts.fill(paddedRow<std::int16_t>(width));
        std::array<std::vector<std::uint8_t>, 3> planes; // blue, green, red
        planes.fill(paddedRow<std::uint8_t>(width));
        const bool discrete = positions == ViewPositions::Discrete;
        const auto sampleRow = [&](int y) {
            for (int colour = 0; colour < 3; ++colour) {
                const int channel = 2 - colour;
                if (discrete) {
                    lens.viewsOfRow(y, colour, viewCount, views.data());
                    shiftsOfViews(views.data(), width, viewCount, halfParallax, shifts.data());
                } else {
                    shiftsOfPhases(lens.columnPhases(y, colour), lens.rowPhase(y, colour), width,
                                   viewCount, halfParallax, shifts.data());
                }
                sampler->sample(channel, shifts.data(),
                                planes[static_cast<std::size_t>(channel)].data());
            }
        };
        const auto sampleRowBySteps = [&](int y) {
            for (int colour = 0; colour < 3; ++colour) {
                std::int16_t* const to = wholeShifts[static_cast<std::size_t>(2 - colour)].data();
                if (discrete) {
                    lens.viewsOfRow(y, colour, viewCount, views.data());
                    wholeShiftsOfViews.ofViews(views.data(), width, to);
                } else {
                    wholeShiftsOfPhases(lens.columnHalves(y, colour), lens.rowPhase(y, colour),
                                        width, viewCount, halfParallax, steps, to);
                }
            }
            sampler->sampleBySteps(
                {wholeShifts[0].data(), wholeShifts[1].data(), wholeShifts[2].data()},
                {planes[0].data(), planes[1].data(), planes[2].data()});
        };
        int open = -1;
        for (int at = rows.start; at < rows.end; ++at) {
            const int y = first + at;
            const int row = samples.rows[static_cast<std::size_t>(y)];
            auto* pixels = native.ptr<std::uint8_t>(at);
            if (row != open) sampler->open(row);
            if (sampler->still()) {
                if (row == open && at > rows.start) {
                    std::memcpy(pixels, native.ptr<std::uint8_t>(at - 1), 3 * width);
                } else {
                    copyPlaces(photo.ptr<std::uint8_t>(row), places, order, pixels);
                }
                open = row;
                continue;
            }
            open = row;
            if (steps > 0) { // Layered nearly always, see ViewRenderer::shiftSteps()
                sampleRowBySteps(y);
            } else {
                sampleRow(y);
            }
            interleaveRow(planes[order[0]].data(), planes[order[1]].data(), planes[order[2]].data(),
                          width, pixels);
        }
    });
}

// Renders one row of all views at a time and picks sub-pixels from it. For panels that show most
// pixels of the views more than once.
void NativeRenderer::Impl::renderRows(const ViewRenderer& renderer, const cv::Mat& photo,
                                      const Samples& samples, int first, cv::Mat& native) const {
    const std::vector<double> shifts = shiftsOfAllViews(samples.shownWidth);
    const auto& order = samples.order;
    const auto width = static_cast<std::size_t>(native.cols);
    const auto rowBytes = 3 * static_cast<std::size_t>(photo.cols);
    forRows(native.rows, [&](const cv::Range& rows) {
        const std::unique_ptr<RowRenderer> rowRenderer = renderer.rowRenderer();
        std::vector<std::uint8_t> viewRows =
            paddedRow<std::uint8_t>(rowBytes * static_cast<std::size_t>(viewCount));
        std::vector<std::uint8_t*> targets;
        for (std::size_t i = 0; i < static_cast<std::size_t>(viewCount); ++i)
            targets.push_back(viewRows.data() + i * rowBytes);
        ViewColumns viewColumns(samples.columns.columns);
        std::vector<std::uint8_t> views = paddedRow<std::uint8_t>(width);
        std::array<std::vector<std::uint8_t>, 3> planes; // blue, green, red
        planes.fill(paddedRow<std::uint8_t>(width));
        int open = -1;
        for (int at = rows.start; at < rows.end; ++at) {
            const int y = first + at;
            const int row = samples.rows[static_cast<std::size_t>(y)];
            if (row != open) {
                rowRenderer->render(row, shifts, targets);
                viewColumns.set(targets, rowBytes);
            }
            open = row;
            for (std::size_t channel = 0; channel < 3; ++channel) {
                lens.viewsOfRow(y, 2 - static_cast<int>(channel), viewCount, views.data());
                viewColumns.pick(channel, views.data(), planes[channel].data());
            }
            interleaveRow(planes[order[0]].data(), planes[order[1]].data(), planes[order[2]].data(),
                          width, native.ptr<std::uint8_t>(at));
        }
    });
}

NativeRenderer::Impl::Samples NativeRenderer::Impl::samplesOn(const Scene& scene,
                                                              const ViewRenderer& renderer,
                                                              ChannelOrder order) const {
    const LensGeometry& geometry = lens.geometry();
    const cv::Mat& photo = scene.photo;
    const cv::Range shown = shownColumns(scene);
    const bool isExact = positions == ViewPositions::Continuous && renderer.readsBetweenColumns();
    const int columns = geometry.panelWidth;
    const std::size_t plane = order == ChannelOrder::Bgr ? 0 : 2;
    return {shown.size(),
            isExact ? placesOf(columns, shown, photo.cols, geometry.mirrorX)
                    : Places{samplesOf(columns, shown, geometry.mirrorX), {}},
            samplesOf(geometry.panelHeight, cv::Range(0, photo.rows), geometry.mirrorY),
            {plane, 1, 2 - plane}};
}

void NativeRenderer::Impl::renderBand(const ViewRenderer& renderer, const cv::Mat& photo,
                                      const Samples& samples, int first, cv::Mat& native) const {
    const LensGeometry& geometry = lens.geometry();
    const double viewPixels = 1.0 * viewCount * photo.rows * samples.shownWidth;
    const double subpixels = 3.0 * geometry.panelWidth * geometry.panelHeight;
    const bool mostAreShown = kSamplesPerSubpixel * subpixels > viewPixels &&
                              viewCount <= static_cast<int>(ViewColumns::kMaxViews);
    if (positions == ViewPositions::Discrete && mostAreShown &&
        options.method == ViewMethod::Layered) {
        renderRows(renderer, photo, samples, first, native);
    } else {
        renderSubpixels(renderer, photo, samples, first, native);
    }
}

void NativeRenderer::render(const Scene& scene, cv::Mat& native, ChannelOrder order) const try {
    const Impl& self = *impl_;
    const std::unique_ptr<ViewRenderer> renderer = makeRenderer(scene, self.options, kOutermost);
    const LensGeometry& geometry = self.lens.geometry();
    checkApart(native, scene, "native");
    native.create(geometry.panelHeight, geometry.panelWidth, CV_8UC3);
    self.renderBand(*renderer, scene.photo, self.samplesOn(scene, *renderer, order), 0, native);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void NativeRenderer::render(const Scene& scene, const RowSink& sink) const try {
    checkFunction(sink, "sink");
    const Impl& self = *impl_;
    const std::unique_ptr<ViewRenderer> renderer = makeRenderer(scene, self.options, kOutermost);
    const Impl::Samples samples = self.samplesOn(scene, *renderer, ChannelOrder::Bgr);
    const LensGeometry& geometry = self.lens.geometry();
    const int count = rowsInBand(geometry.panelWidth, geometry.panelHeight);
    cv::Mat rows;
    for (int first = 0; first < geometry.panelHeight; first += count) {
        rows.create(std::min(count, geometry.panelHeight - first), geometry.panelWidth, CV_8UC3);
        self.renderBand(*renderer, scene.photo, samples, first, rows);
        sink(rows);
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
