#include "display/lens_phase.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "display/lens_phase.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR
template <class D, class V>
HWY_INLINE void storeViews(D d, V views, std::uint32_t* out) {
    hn::StoreU(views, d, out);
}

template <class D, class V, class T>
HWY_INLINE void storeViews(D /*d*/, V views, T* out) {
    const hn::Rebind<T, D> narrow;
    const hn::RebindToSigned<D> asSigned; // views are below 2^31
    hn::StoreU(hn::DemoteTo(narrow, hn::BitCast(asSigned, views)), narrow, out);
}
#endif

// Views by the whole phases. Reads 4 bytes of the column table per sub-pixel and writes 1, 2 or 4.
// The two 32 x 32 bit multiplications limit the speed.
// @return the smallest fraction of a view among all sub-pixels, measured from `margin` below a
//         border between two views. Below 2 margin the border is nearer than the phase's error, so
//         the view is uncertain.
template <class T>
HWY_INLINE std::uint32_t
viewsOfWholePhases(const std::uint32_t* HWY_RESTRICT columns, std::uint32_t row, std::size_t count,
                   std::uint32_t views, std::uint32_t margin, T* HWY_RESTRICT out) {
    std::size_t i = 0;
    std::uint32_t nearest = ~std::uint32_t{0};
#if HWY_TARGET != HWY_SCALAR
    const hn::ScalableTag<std::uint32_t> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    const auto vRow = hn::Set(d, row);
    const auto vViews = hn::Set(d, views);
    const auto vMargin = hn::Set(d, margin);
    auto vNearest = hn::Set(d, nearest);
    const std::size_t lanes = hn::Lanes(d);
    for (; i + lanes <= count; i += lanes) {
        const auto phase = hn::Add(hn::LoadU(d, columns + i), vRow);
        const auto even = hn::MulEven(phase, vViews);
        const auto odd =
            hn::MulEven(hn::BitCast(d, hn::ShiftRight<32>(hn::BitCast(wide, phase))), vViews);
        const auto view =
            hn::OddEven(hn::BitCast(d, odd), hn::BitCast(d, hn::ShiftRight<32>(even)));
        const auto fraction =
            hn::OddEven(hn::BitCast(d, hn::ShiftLeft<32>(odd)), hn::BitCast(d, even));
        vNearest = hn::Min(vNearest, hn::Add(fraction, vMargin));
        storeViews(d, view, out + i);
    }
    nearest = hn::GetLane(hn::MinOfLanes(d, vNearest));
#endif
    for (; i < count; ++i) {
        const std::uint64_t place = std::uint64_t{columns[i] + row} * views;
        nearest = std::min(nearest, static_cast<std::uint32_t>(place) + margin);
        out[i] = static_cast<T>(place >> 32);
    }
    return nearest;
}

#if HWY_TARGET != HWY_SCALAR
HWY_INLINE void storeShortViews(hn::Vec<hn::ScalableTag<std::uint16_t>> views, std::uint16_t* out) {
    hn::StoreU(views, hn::ScalableTag<std::uint16_t>(), out);
}

HWY_INLINE void storeShortViews(hn::Vec<hn::ScalableTag<std::uint16_t>> views, std::uint8_t* out) {
    const hn::ScalableTag<std::int16_t> d;
    const hn::Rebind<std::uint8_t, decltype(d)> narrow;
    hn::StoreU(hn::DemoteTo(narrow, hn::BitCast(d, views)), narrow, out);
}

// Finds views from the upper halves of the phases. Only the few sub-pixels for which these do not
// suffice need whole phases. Reads 2 bytes per sub-pixel. About ten operations per vector limit the
// speed.
//
// The halves leave out less than 2 (from the column and from the row) of 2^-16 lens periods, and
// the error of a phase moves a border by less than `margin` + 1. Farther from a border, the view is
// certain.
// @param views 1..256
template <class T>
HWY_INLINE std::uint32_t viewsOfHalfPhases(const std::uint32_t* HWY_RESTRICT columns,
                                           const std::uint16_t* HWY_RESTRICT highHalves,
                                           std::uint32_t row, std::size_t count,
                                           std::uint32_t views, std::uint32_t margin,
                                           T* HWY_RESTRICT out) {
    const hn::ScalableTag<std::uint16_t> d;
    const auto vRow = hn::Set(d, static_cast<std::uint16_t>(row >> 16));
    const auto vViews = hn::Set(d, static_cast<std::uint16_t>(views));
    const std::uint32_t shortMargin = (margin >> 16) + 1;
    const auto first = hn::Set(d, static_cast<std::uint16_t>(shortMargin));
    const auto last = hn::Set(d, static_cast<std::uint16_t>(65535 - 2 * views - 2 * shortMargin));
    const auto none = hn::Zero(d);
    const std::size_t lanes = hn::Lanes(d);
    std::uint32_t nearest = ~std::uint32_t{0};
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
        const auto phase = hn::Add(hn::LoadU(d, highHalves + i), vRow);
        const auto fraction = hn::Mul(phase, vViews);
        const auto beyond = hn::SaturatedSub(hn::Sub(fraction, first), last);
        if (HWY_LIKELY(hn::AllTrue(d, hn::Eq(beyond, none)))) {
            storeShortViews(hn::MulHigh(phase, vViews), out + i);
        } else {
            nearest = std::min(nearest,
                               viewsOfWholePhases(columns + i, row, lanes, views, margin, out + i));
        }
    }
    return std::min(nearest,
                    viewsOfWholePhases(columns + i, row, count - i, views, margin, out + i));
}
#endif

// Views of `count` sub-pixels: floor(phase * views / 2^32) for the phase (columns[i] + row) modulo
// 2^32. The result is the same on every instruction set.
// @param columns, row parts of the phase, in 2^-32 lens periods
// @param highHalves the upper 16 bits of each of `columns`
// @param phaseError largest error of a phase, in 2^-32
// @return whether a true phase may lie on the other side of a border between two views
template <class T>
HWY_INLINE bool viewsOfPhasesOn(const std::uint32_t* columns,
                                [[maybe_unused]] const std::uint16_t* highHalves, std::uint32_t row,
                                std::size_t count, std::uint32_t views, std::uint32_t phaseError,
                                T* out) {
    const std::uint32_t margin = phaseError * views;
#if HWY_TARGET != HWY_SCALAR
    // With more views, most vectors have a sub-pixel near a border.
    constexpr std::uint32_t kMaxShortViews = 256;
    if constexpr (sizeof(T) <= 2) {
        if (views <= kMaxShortViews) {
            return viewsOfHalfPhases(columns, highHalves, row, count, views, margin, out) <
                   2 * margin;
        }
    }
#endif
    return viewsOfWholePhases(columns, row, count, views, margin, out) < 2 * margin;
}

bool viewsOfPhases8(const std::uint32_t* columns, const std::uint16_t* highHalves,
                    std::uint32_t row, std::size_t count, std::uint32_t views,
                    std::uint32_t phaseError, std::uint8_t* out) {
    return viewsOfPhasesOn(columns, highHalves, row, count, views, phaseError, out);
}
bool viewsOfPhases16(const std::uint32_t* columns, const std::uint16_t* highHalves,
                     std::uint32_t row, std::size_t count, std::uint32_t views,
                     std::uint32_t phaseError, std::uint16_t* out) {
    return viewsOfPhasesOn(columns, highHalves, row, count, views, phaseError, out);
}
bool viewsOfPhases32(const std::uint32_t* columns, const std::uint16_t* highHalves,
                     std::uint32_t row, std::size_t count, std::uint32_t views,
                     std::uint32_t phaseError, std::uint32_t* out) {
    return viewsOfPhasesOn(columns, highHalves, row, count, views, phaseError, out);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(viewsOfPhases8);
HWY_EXPORT(viewsOfPhases16);
HWY_EXPORT(viewsOfPhases32);

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
    const double largest = 2 * (1 + std::abs(g.tilt)) * std::abs(g.periodsPerWidth) +
                           std::abs(g.center) + 1 +
                           (g.lens ? std::abs(g.lens->offset) / g.lens->period : 0);
    return static_cast<std::uint32_t>(std::ceil(1 + largest * 16 * 0x1p-53 * 0x1p32)) + 1;
}

// Whether the true phase may lie on the other side of a border between two views.
bool nearBorder(std::uint32_t phase, std::uint32_t views, std::uint32_t phaseError) {
    const std::uint32_t margin = phaseError * views;
    return phase * views + margin < 2 * margin; // modulo 2^32: the fraction of phase * views
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
        const int colour = static_cast<int>(table % 3);
        const auto k = static_cast<std::size_t>(g.blueFirst ? 2 - colour : colour);
        const int y = g.panelHeight - 1 - static_cast<int>(table / 3); // some row with this pattern
        columns_[table] = paddedRow<std::uint32_t>(static_cast<std::size_t>(g.panelWidth));
        for (int x = 0; x < g.panelWidth; ++x) {
            double u = (x + 0.5) / g.panelWidth;
            if (cells) {
                const SubpixelCell& cell = g.cells[static_cast<std::size_t>(g.cellIndex(x, y))];
                u += (g.mirrorX ? -1 : 1) * cell.x[k] / g.panelWidth +
                     cell.y[k] / g.panelHeight * g.tilt;
            }
            const double phase =
                g.lens ? (g.inverted ? -3.0 : 3.0) * x / g.lens->period : u * periods;
            columns_[table][static_cast<std::size_t>(x)] = fixedPoint(phase);
        }
    }
    for (const std::vector<std::uint32_t>& table : columns_) {
        std::vector<std::uint16_t>& high = highHalves_.emplace_back(table.size());
        std::transform(table.begin(), table.end(), high.begin(),
                       [](std::uint32_t phase) { return static_cast<std::uint16_t>(phase >> 16); });
    }
    for (int colour = 0; colour < 3; ++colour) {
        const int k = g.blueFirst ? 2 - colour : colour;
        const double step = cells ? 0 : k * g.subpixelStep;
        auto& row = rows_[static_cast<std::size_t>(colour)];
        row.resize(static_cast<std::size_t>(g.panelHeight));
        for (int y = 0; y < g.panelHeight; ++y) {
            const double v = 1 - (y + 0.5) / g.panelHeight;
            const double phase =
                g.lens ? (g.inverted ? -1 : 1) * g.lens->wholePlace(0, y, k) / g.lens->period
                       : (step + v * g.tilt) * periods - center;
            row[static_cast<std::size_t>(y)] = fixedPoint(phase);
        }
    }
}

template <class Kernel, class T>
void LensPhases::fillViews(const Kernel& viewsOfPhases, int y, int colour, int views,
                           T* out) const {
    const std::uint32_t* columns = columnPhases(y, colour);
    const std::uint16_t* highHalves = columnHalves(y, colour);
    const std::uint32_t row = rowPhase(y, colour);
    const auto count = static_cast<std::uint32_t>(views);
    const auto width = static_cast<std::size_t>(geometry_.panelWidth);
    const std::vector<int>& order = geometry_.viewOrder;
    if (!order.empty() && order.size() != count) { // rare: another number of views than the lens
        for (int x = 0; x < geometry_.panelWidth; ++x)
            out[x] = static_cast<T>(geometry_.view(x, y, colour, views));
        return;
    }
    const bool isUnsure = viewsOfPhases(columns, highHalves, row, width, count, phaseError_, out);
    if (!isUnsure && order.empty()) return;
    for (int x = 0; x < geometry_.panelWidth; ++x) {
        if (isUnsure && nearBorder(columns[x] + row, count, phaseError_))
            out[x] = static_cast<T>(geometry_.view(x, y, colour, views));
        else if (!order.empty())
            out[x] = static_cast<T>(order[out[x]]);
    }
}

void LensPhases::viewsOfRow(int y, int colour, int views, std::uint8_t* out) const {
    fillViews(HWY_DYNAMIC_DISPATCH(viewsOfPhases8), y, colour, views, out);
}

void LensPhases::viewsOfRow(int y, int colour, int views, std::uint16_t* out) const {
    fillViews(HWY_DYNAMIC_DISPATCH(viewsOfPhases16), y, colour, views, out);
}

void LensPhases::viewsOfRow(int y, int colour, int views, std::uint32_t* out) const {
    fillViews(HWY_DYNAMIC_DISPATCH(viewsOfPhases32), y, colour, views, out);
}

} // namespace altiro3D
#endif
