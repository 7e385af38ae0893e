// Places of pixels whose depth follows a line: layeredLines().

#include "views/views_layered_lines.hpp"

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

// Reads 14 bytes and writes 4 per pixel. Arithmetic limits the speed: some 25 operations for each
// vector of 16-bit lanes.
bool layeredLinesOn(const LayeredLinePixels& pixels, LayeredRoom& room) {
    std::int32_t* HWY_RESTRICT places = room.places.data();
    float* HWY_RESTRICT shifts = room.shifts.data();
    const hn::ScalableTag<std::int16_t> d;
    const hn::ScalableTag<float> wide;
    const hn::RebindToSigned<decltype(wide)> whole;
    const hn::Rebind<std::int16_t, decltype(wide)> narrow;
    const auto zero = hn::Zero(d);
    const auto one = hn::Set(d, 1);
    const auto missing = hn::Set(d, INT16_MIN);
    const auto perStep = hn::Set(wide, pixels.reachPixels * static_cast<float>(1 / kWholeReach));
    bool anyOpen = false;
    for (std::size_t begin = 0; begin < pixels.count; begin += kBlockPixels) {
        auto unknown = hn::MaskFromVec(zero);
        HWY_ALIGN std::int16_t away[kBlockPixels]; // from the pixel's column, 1/256 px
        for (std::size_t i = begin; i < begin + kBlockPixels; i += hn::Lanes(d)) {
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
            unknown = hn::Or(unknown, beyond);
            const auto place = hn::IfThenElse(left, hn::Neg(steps), steps);
            hn::Store(hn::IfThenElse(beyond, missing, place), d, away + (i - begin));
        }
        for (std::size_t i = 0; i < kBlockPixels; i += hn::Lanes(wide)) {
            const auto column = hn::LoadU(whole, pixels.columns + begin + i);
            const auto place = hn::Add(column, hn::PromoteTo(whole, hn::Load(narrow, away + i)));
            hn::StoreU(place, whole, places + begin + i);
        }
        const bool isOpen = !hn::AllFalse(d, unknown);
        room.openBlocks[begin / kBlockPixels] = isOpen ? 1 : 0;
        if (HWY_LIKELY(!isOpen)) continue;
        anyOpen = true;
        for (std::size_t i = 0; i < kBlockPixels; i += hn::Lanes(wide)) {
            const auto steps = hn::PromoteTo(whole, hn::LoadU(narrow, pixels.shifts + begin + i));
            hn::StoreU(hn::Mul(hn::ConvertTo(wide, steps), perStep), wide, shifts + begin + i);
            const auto isMissing =
                hn::Eq(hn::PromoteTo(whole, hn::Load(narrow, away + i)), hn::Set(whole, INT16_MIN));
            const auto place = hn::LoadU(whole, places + begin + i);
            hn::StoreU(hn::IfThenElse(isMissing, hn::Set(whole, kSeeEnds), place), whole,
                       places + begin + i);
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

bool layeredLines(const LayeredLinePixels& pixels, LayeredRoom& room) {
    return HWY_DYNAMIC_DISPATCH(layeredLinesOn)(pixels, room);
}

} // namespace altiro3D
#endif
