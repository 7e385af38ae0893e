// Places of pixels whose depth follows a line: layeredLines().

#include "views/views_layered_lines.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/views_layered_lines.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// First of 64 columns that hold all places of a block; kOpenBlock if it needs more.
HWY_INLINE std::int32_t windowOfBlock(const std::int16_t* HWY_RESTRICT columns,
                                      const std::int16_t* HWY_RESTRICT away, std::int32_t start) {
    const hn::ScalableTag<std::int16_t> d;
    auto least = hn::Set(d, INT16_MAX);
    auto most = hn::Set(d, INT16_MIN);
    for (std::size_t i = 0; i < kWindowPixels; i += hn::Lanes(d)) {
        const auto place = hn::Add(hn::LoadU(d, columns + i), hn::LoadU(d, away + i));
        least = hn::Min(least, place);
        most = hn::Max(most, place);
    }
    const std::int32_t first = hn::GetLane(hn::MinOfLanes(d, least)) >> kSubColumnBits;
    const std::int32_t last = hn::GetLane(hn::MaxOfLanes(d, most)) >> kSubColumnBits;
    return last - first <= 62 ? start + first : kOpenBlock;
}

// Reads 10 bytes and writes 2 per pixel. Arithmetic limits the speed: some 25 operations for each
// vector of 16-bit lanes.
bool layeredLinesOn(const LayeredLinePixels& pixels, std::int16_t* HWY_RESTRICT away,
                    std::int32_t* HWY_RESTRICT windows, float* HWY_RESTRICT shifts) {
    const hn::ScalableTag<std::int16_t> d;
    const auto zero = hn::Zero(d);
    const auto one = hn::Set(d, 1);
    const auto missing = hn::Set(d, kNotOnLine);
    bool anyOpen = false;
    for (std::size_t begin = 0; begin < pixels.count; begin += kWindowPixels) {
        auto open = hn::MaskFromVec(zero);
        for (std::size_t i = begin; i < begin + kWindowPixels; i += hn::Lanes(d)) {
            const auto signedShift = hn::LoadU(d, pixels.shifts + i);
            const auto left = hn::Lt(signedShift, zero);
            const auto distance = hn::Abs(signedShift);
            const auto shift = hn::SaturatedAdd(distance, distance); // 1/32768 of the largest
            const auto slope = hn::LoadU(d, pixels.slopes + i);
            // 1 / (1 - u) is (1 + u) (1 + u^2) (1 + u^4), up to 2^-16 for the slopes of lines
            const auto u = hn::MulFixedPoint15(shift, hn::IfThenElse(left, hn::Neg(slope), slope));
            const auto u2 = hn::MulFixedPoint15(u, u);
            const auto u4 = hn::MulFixedPoint15(u2, u2);
            auto moved = hn::MulFixedPoint15(shift, hn::LoadU(d, pixels.offsets + i));
            moved = hn::Add(moved, hn::MulFixedPoint15(moved, u));
            moved = hn::Add(moved, hn::MulFixedPoint15(moved, u2));
            moved = hn::Add(moved, hn::MulFixedPoint15(moved, u4));
            const auto steps = hn::ShiftRight<1>(hn::Add(moved, one));
            const auto limit =
                hn::IfThenElse(left, hn::LoadU(d, pixels.from + i), hn::LoadU(d, pixels.to + i));
            const auto beyond = hn::Gt(shift, limit);
            open = hn::Or(open, beyond);
            const auto place = hn::IfThenElse(left, hn::Neg(steps), steps);
            hn::StoreU(hn::IfThenElse(beyond, missing, place), d, away + i);
        }
        const std::size_t block = begin / kWindowPixels;
        windows[block] = kOpenBlock;
        constexpr bool kHasWindows = HWY_TARGET != HWY_SCALAR;
        if (HWY_LIKELY(kHasWindows && pixels.starts[block] >= 0 && hn::AllFalse(d, open))) {
            windows[block] =
                pixels.fixed[block] >= 0
                    ? pixels.fixed[block]
                    : windowOfBlock(pixels.columns + begin, away + begin, pixels.starts[block]);
            if (HWY_LIKELY(windows[block] != kOpenBlock)) continue;
        }
        anyOpen = true;
        const hn::ScalableTag<float> wide;
        const hn::Rebind<std::int16_t, decltype(wide)> narrow;
        const hn::RebindToSigned<decltype(wide)> whole;
        const auto perStep =
            hn::Set(wide, pixels.reachPixels * static_cast<float>(1 / kWholeReach));
        for (std::size_t i = begin; i < begin + kWindowPixels; i += hn::Lanes(wide)) {
            const auto steps = hn::PromoteTo(whole, hn::LoadU(narrow, pixels.shifts + i));
            hn::StoreU(hn::Mul(hn::ConvertTo(wide, steps), perStep), wide, shifts + i);
        }
    }
    return anyOpen;
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(layeredLinesOn);

bool layeredLines(const LayeredLinePixels& pixels, std::int16_t* away, std::int32_t* windows,
                  float* shifts) {
    return HWY_DYNAMIC_DISPATCH(layeredLinesOn)(pixels, away, windows, shifts);
}

LayeredBlocks layeredBlocks(const std::vector<int>& columns) {
    constexpr int kMaxWidth = 62;
    LayeredBlocks blocks;
    blocks.columns = paddedRow<std::int16_t>(columns.size());
    for (std::size_t begin = 0; begin < columns.size(); begin += kWindowPixels) {
        const std::size_t end = std::min(begin + kWindowPixels, columns.size());
        const auto [first, last] = std::minmax(columns[begin], columns[end - 1]);
        blocks.starts.push_back(last - first <= kMaxWidth ? first : -1);
        for (std::size_t i = begin; i < end && last - first <= kMaxWidth; ++i)
            blocks.columns[i] = static_cast<std::int16_t>((columns[i] - first) << kSubColumnBits);
    }
    return blocks;
}

} // namespace altiro3D
#endif
