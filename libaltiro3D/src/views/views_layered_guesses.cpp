// Places of pixels that no other surface comes near: layeredGuesses().

#include "views/views_layered_row.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/views_layered_guesses.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"
#include "views/views_layered_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// For open blocks. Pixels on a line have their place. If no other surface comes near, a
// guess from the pixel's own depth and slope is verified: within a surface the contents are in
// order, so it is the only solution. Arithmetic limits the speed: some seventy operations and a
// gather of four bytes.
void layeredGuessesOn(const LayeredTables& tables, const LayeredPixels& pixels, LayeredRoom& room) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    using F = hn::Vec<decltype(d)>;
    using I = hn::Vec<decltype(whole)>;
    const F one = hn::Set(d, 1.0F);
    const F half = hn::Set(d, 0.5F);
    const F lastColumn = hn::Set(d, static_cast<float>(tables.width) - 0.5F);
    const I none = hn::Zero(whole);
    const I lastFlag = hn::Set(whole, kLastFlag);
    std::int32_t* HWY_RESTRICT places = room.places.data();
    const float* HWY_RESTRICT shifts = room.shifts.data();
    const auto guessVector = [&](std::size_t i) HWY_ATTR {
        const I onLine = hn::LoadU(whole, places + i);
        const auto isLine = hn::Ne(onLine, hn::Set(whole, kSeeEnds));
        if (hn::AllTrue(whole, isLine)) return;
        const F shift = hn::LoadU(d, shifts + i);
        const F movement = hn::Mul(shift, hn::LoadU(d, pixels.offsets + i));
        const F steep = hn::Sub(one, hn::Mul(shift, hn::LoadU(d, pixels.slopes + i)));
        const auto clear = hn::And(hn::Le(shift, hn::LoadU(d, pixels.to + i)),
                                   hn::Ge(shift, hn::LoadU(d, pixels.from + i)));
        const auto lanes = lanesOf(d, tables, hn::LoadU(d, pixels.columns + i), shift);
        const auto mirrored = hn::Gt(lanes.base, none);
        // solves x = c - s (offset + slope (c - x)) for c; a guess may be wrong, but not NaN, which
        // would read from any address
        const F guess =
            hn::Mul(movement, hn::ApproximateReciprocal(hn::Max(steep, hn::Set(d, 0.125F))));
        const F forward = hn::IfThenElse(hn::RebindMask(d, mirrored), hn::Neg(guess), guess);
        // a surface further left may also reach the pixel, behind its own one
        const F first =
            hn::IfThenElse(hn::RebindMask(d, mirrored), hn::LoadU(d, pixels.mirroredFirst + i),
                           hn::LoadU(d, pixels.first + i));
        const F near =
            hn::Min(hn::Max(hn::Add(lanes.x, forward), hn::Add(first, half)), lastColumn);
        const I column = smallNearestInt(d, hn::Sub(near, half)); // rounded down, except for ties
        const F columnPlace = hn::ConvertTo(d, column);
        // the word of the column in the lower, the next one's in the upper 16 bits
        const I words =
            gatherBytes4(whole, tables.words, hn::ShiftLeft<1>(hn::Add(lanes.base, column)));
        const F from = hn::Sub(columnPlace, hn::Mul(lanes.unit, lowOffset(d, words)));
        const F to = hn::Sub(hn::Add(columnPlace, one), hn::Mul(lanes.unit, highOffset(d, words)));
        const auto between = hn::And(hn::Le(from, lanes.x), hn::Lt(lanes.x, to));
        const auto verified = hn::And(hn::RebindMask(whole, hn::And(between, clear)),
                                      hn::Eq(hn::And(words, lastFlag), none));
        const I found = placeBetween(d, lanes, column, from, to);
        hn::StoreU(hn::IfThenElse(isLine, onLine, plainPlace(tables, lanes, found)), whole,
                   places + i);
        const auto sure = hn::Or(isLine, verified);
#if !ALTIRO3D_AVX512
        // With AVX-512, compressing takes one instruction and is cheaper than an unpredictable
        // branch.
        if (hn::AllTrue(whole, sure)) return;
#endif
        const I pixel = hn::Iota(whole, static_cast<std::int32_t>(i));
        const F column0 = hn::LoadU(d, pixels.columns + i);
        for (int direction = 0; direction < 2; ++direction) {
            LayeredList& list = room.open[direction];
            const auto own =
                direction == 0 ? hn::Not(hn::Or(sure, mirrored)) : hn::AndNot(sure, mirrored);
            const ChosenLanes unsure(whole, own);
            unsure.store(pixel, list.pixels.data() + list.size);
            unsure.store(column0, list.columns.data() + list.size);
            unsure.store(shift, list.shifts.data() + list.size);
            list.size += unsure.count();
        }
    };
    for (std::size_t begin = 0; begin < pixels.count; begin += kBlockPixels) {
        if (room.openBlocks[begin / kBlockPixels] == 0) continue;
        const std::size_t blockEnd = std::min(begin + kBlockPixels, pixels.count);
        for (std::size_t i = begin; i < blockEnd; i += hn::Lanes(d))
            guessVector(i);
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(layeredGuessesOn);

void layeredGuesses(const LayeredTables& tables, const LayeredPixels& pixels, LayeredRoom& room) {
    HWY_DYNAMIC_DISPATCH(layeredGuessesOn)(tables, pixels, room);
}

} // namespace altiro3D
#endif
