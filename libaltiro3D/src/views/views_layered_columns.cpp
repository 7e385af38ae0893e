// Where the depth of a row follows a line: layeredColumns().

#include "views/views_layered_columns.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/views_layered_columns.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// The offset of a column and where the next columns lie: see LayeredColumns. Arithmetic limits the
// speed: some ten operations for each column and each px by which content can move.
void layeredColumnsOn(const LayeredTables& tables, std::vector<float>& scratch,
                      LayeredColumns& columns) {
    constexpr int kMargin = kMaxLineMovement + 2;
    constexpr float kTolerance = 1.0F / 64;
    constexpr float kLargestTurn = 0.25F; // the slope at the largest shift
    constexpr float kNowhere = 1e6F;
    const auto width = static_cast<std::size_t>(tables.width);
    const std::size_t size = width + 2 * kMargin + kRowPadding;
    scratch.assign(2 * size, kNowhere);
    float* const offsets = scratch.data() + kMargin;
    float* const tears = offsets + size; // large where the next column is of another surface
    for (int x = 0; x < tables.width; ++x) {
        offsets[x] = tables.scale * static_cast<float>(wordOffset(tables.words[x]));
        tears[x] = (tables.words[x] & kLastFlag) != 0 ? kNowhere : 0;
    }
    const auto forSoftColumns = [&](const auto& use) {
        for (int x = 0; tables.shares != nullptr && x < tables.width; ++x)
            if (tables.shares[x] != 0) use(x);
    };
    forSoftColumns([&](int x) { tears[x - 1] = tears[x] = kNowhere; });
    for (std::vector<float>* values : columns.all())
        values->resize(width + kRowPadding);
    for (std::vector<std::int32_t>* values : columns.lines.all())
        values->resize(width + kRowPadding);
    std::copy_n(offsets, width, columns.offsets.begin());
    const float perUnit =
        tables.reachPixels / 65534.9F; // so the largest shift is within 65535 units
    const std::uint16_t* const mirroredClear = tables.clear + tables.stride + width - 1;
    for (std::size_t x = 0; x < width; ++x) {
        columns.to[x] = perUnit * static_cast<float>(tables.clear[x]);
        columns.lines.to[x] = tables.clear[x] >> 1;
    }
    for (std::size_t x = 0; x < width; ++x) {
        columns.from[x] = -perUnit * static_cast<float>(*(mirroredClear - x));
        columns.lines.from[x] = *(mirroredClear - x) >> 1;
    }
    // px of soft borders are on no line, even if they do not move, so their block is open
    forSoftColumns([&](int x) {
        columns.lines.from[static_cast<std::size_t>(x)] = -1;
        columns.lines.to[static_cast<std::size_t>(x)] = -1;
    });
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    using F = hn::Vec<decltype(d)>;
    const F largestShift = hn::Set(d, tables.reachPixels);
    const F tolerance = hn::Set(d, kTolerance);
    const F largestTurn = hn::Set(d, kLargestTurn);
    const F most = hn::Set(d, static_cast<float>(kMaxLineMovement));
    const F one = hn::Set(d, 1.0F);
    const F quarter = hn::Set(d, 0.25F);
    const auto missing = hn::Set(whole, -1);
    for (std::size_t x = 0; x < width; x += hn::Lanes(d)) {
        const F offset = hn::LoadU(d, offsets + x);
        const F rise = hn::Sub(hn::LoadU(d, offsets + x + 2), hn::LoadU(d, offsets + x - 2));
        const F slope = hn::Mul(rise, quarter);
        const F turn = hn::Mul(slope, largestShift);
        const F straight = hn::Mul(offset, largestShift);
        const F movement = hn::Div(hn::Abs(straight), hn::Sub(one, hn::Abs(turn)));
        auto isLine = hn::And(hn::Le(hn::Abs(turn), largestTurn), hn::Lt(movement, most));
        // columns up to the one beyond the movement
        F step = one;
        for (int k = 1; k <= kMaxLineMovement + 1; ++k, step = hn::Add(step, one)) {
            const auto reached = hn::And(isLine, hn::Lt(hn::Sub(step, one), movement));
            if (hn::AllFalse(d, reached)) break;
            const F change = hn::Mul(slope, step);
            const F right = hn::Sub(hn::LoadU(d, offsets + x + k), hn::Add(offset, change));
            const F left = hn::Sub(hn::LoadU(d, offsets + x - k), hn::Sub(offset, change));
            const F torn = hn::Max(hn::LoadU(d, tears + x + k - 1), hn::LoadU(d, tears + x - k));
            const F difference = hn::Max(hn::Abs(right), hn::Abs(left));
            const F off = hn::Mul(hn::Max(difference, torn), largestShift);
            isLine = hn::AndNot(hn::And(reached, hn::Gt(off, tolerance)), isLine);
        }
        hn::StoreU(slope, d, columns.slopes.data() + x);
        const auto store = [&](F value, float steps, std::vector<std::int32_t>& to) HWY_ATTR {
            const F inRange = hn::IfThenElseZero(isLine, hn::Mul(value, hn::Set(d, steps)));
            hn::StoreU(smallNearestInt(d, inRange), whole, to.data() + x);
        };
        store(straight, 512, columns.lines.offsets);
        store(turn, 32768, columns.lines.slopes);
        const auto valid = hn::RebindMask(whole, isLine);
        for (std::vector<std::int32_t>* limits : {&columns.lines.from, &columns.lines.to}) {
            const auto limit = hn::LoadU(whole, limits->data() + x);
            hn::StoreU(hn::IfThenElse(valid, limit, missing), whole, limits->data() + x);
        }
    }
    // calls use(begin, end) for each surface, with the px between it and the next one
    const auto forSurfaces = [&](const std::int16_t* surfaces, const auto& use) {
        for (std::size_t begin = 0; begin < width;) {
            std::size_t end = begin + 1;
            while (end < width && surfaces[end] == surfaces[begin])
                ++end;
            use(begin, end);
            begin = end;
        }
    };
    forSurfaces(tables.surfaces, [&](std::size_t begin, std::size_t end) {
        std::fill(columns.first.data() + begin, columns.first.data() + end,
                  static_cast<float>(begin));
    });
    forSurfaces(tables.surfaces + tables.stride, [&](std::size_t begin, std::size_t end) {
        float* const to = columns.mirroredFirst.data();
        std::fill(to + (width - end), to + (width - begin), static_cast<float>(begin));
    });
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(layeredColumnsOn);

void layeredColumns(const LayeredTables& tables, std::vector<float>& scratch,
                    LayeredColumns& columns) {
    HWY_DYNAMIC_DISPATCH(layeredColumnsOn)(tables, scratch, columns);
}

} // namespace altiro3D
#endif
