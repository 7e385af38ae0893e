#include "display/lens_phase.hpp"

#include "base/pixel_rows.hpp"
#include "display/lens_phase_kernels.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D {

namespace {

// a modulo 1 in units of 2^-32, rounded to nearest.
std::uint32_t fixedPoint(double a) {
    const double fraction = a - std::floor(a); // may round to 1, which correctly wraps to 0
    return static_cast<std::uint32_t>(static_cast<std::uint64_t>(fraction * 4294967296.0 + 0.5));
}

// Bound of |columns + row - LensGeometry::phase| in 2^-32. Both computations of the phase make at
// most 8 roundings, each by half a unit in the 53rd bit of at most `largest`. The two conversions
// to fixed point add 0.5 each.
std::uint32_t errorBound(const LensGeometry& g) {
    const double largest =
        2 * (1 + std::abs(g.tilt)) * std::abs(g.periodsPerWidth) + std::abs(g.center) + 1;
    return static_cast<std::uint32_t>(std::ceil(1 + largest * 16 * 0x1p-53 * 0x1p32)) + 1;
}

} // namespace

LensPhases::LensPhases(LensGeometry geometry) : geometry_(std::move(geometry)) {
    const LensGeometry& g = geometry_;
    const bool cells = !g.cells.empty();
    const double periods = g.inverted ? -g.periodsPerWidth : g.periodsPerWidth; // z -> 1 - z
    const double center = g.inverted ? -g.center : g.center;
    phaseError_ = errorBound(g);

    columns_.resize(cells ? 3 * kRowPatterns : 1);
    for (std::size_t table = 0; table < columns_.size(); ++table) {
        const int channel = static_cast<int>(table % 3);
        const auto k = static_cast<std::size_t>(g.blueFirst ? 2 - channel : channel);
        const int y = g.panelHeight - 1 - static_cast<int>(table / 3); // some row with this pattern
        columns_[table] = paddedRow<std::uint32_t>(static_cast<std::size_t>(g.panelWidth));
        for (int x = 0; x < g.panelWidth; ++x) {
            double u = (x + 0.5) / g.panelWidth;
            if (cells) {
                const SubpixelCell& cell = g.cells[static_cast<std::size_t>(g.cellIndex(x, y))];
                u += (g.mirrorX ? -1 : 1) * cell.x[k] / g.panelWidth +
                     cell.y[k] / g.panelHeight * g.tilt;
            }
            columns_[table][static_cast<std::size_t>(x)] = fixedPoint(u * periods);
        }
    }
    for (const std::vector<std::uint32_t>& table : columns_) {
        std::vector<std::uint16_t>& high = highHalves_.emplace_back(table.size());
        std::transform(table.begin(), table.end(), high.begin(),
                       [](std::uint32_t phase) { return static_cast<std::uint16_t>(phase >> 16); });
    }
    for (int channel = 0; channel < 3; ++channel) {
        const int k = g.blueFirst ? 2 - channel : channel;
        const double step = cells ? 0 : k * g.subpixelStep;
        auto& row = rows_[static_cast<std::size_t>(channel)];
        row.resize(static_cast<std::size_t>(g.panelHeight));
        for (int y = 0; y < g.panelHeight; ++y) {
            const double v = 1 - (y + 0.5) / g.panelHeight;
            row[static_cast<std::size_t>(y)] = fixedPoint((step + v * g.tilt) * periods - center);
        }
    }
}

template <class T>
void LensPhases::fillViews(int y, int channel, int views, T* out) const {
    const std::uint32_t* columns = columnPhases(y, channel);
    const std::uint16_t* highHalves = columnHalves(y, channel);
    const std::uint32_t row = rowPhase(y, channel);
    const auto count = static_cast<std::uint32_t>(views);
    const auto width = static_cast<std::size_t>(geometry_.panelWidth);
    if (!viewsOfPhases(columns, highHalves, row, width, count, phaseError_, out)) return;
    for (int x = 0; x < geometry_.panelWidth; ++x) {
        if (!nearBorder(columns[x] + row, count, phaseError_)) continue;
        out[x] = static_cast<T>(LensGeometry::viewOfPhase(geometry_.phase(x, y, channel), views));
    }
}

void LensPhases::viewsOfRow(int y, int channel, int views, std::uint8_t* out) const {
    fillViews(y, channel, views, out);
}

void LensPhases::viewsOfRow(int y, int channel, int views, std::uint16_t* out) const {
    fillViews(y, channel, views, out);
}

void LensPhases::viewsOfRow(int y, int channel, int views, std::uint32_t* out) const {
    fillViews(y, channel, views, out);
}

} // namespace altiro3D
