// Pixels on no line: layeredGuesses() and, among the ends of surfaces, layeredAmongSurfaces(); what
// all pixels show: layeredSamples().

#include "views/layered/layered_row.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/layered/layered_guesses.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"
#include "views/layered/layered_parts_inl.hpp"

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

// A vector of pixels that are searched among the surfaces of a row, from right to left. The first
// surface that begins at a pixel or left of it is in front.
template <class D>
class AmongSurfaces {
    using Whole = hn::RebindToSigned<D>;
    using F = hn::Vec<D>;
    using I = hn::Vec<Whole>;
    using M = hn::Mask<Whole>;

  public:
    HWY_INLINE AmongSurfaces(D d, const LayeredTables& tables, const LayeredSurfaces& surfaces,
                             const Lanes<F, I>& lanes)
        : d_(d), tables_(tables), surfaces_(surfaces), lanes_(lanes) {}

    // @param nearest, first index of the rightmost surface that can be in front, and of the first
    //        surface of the direction
    // @param end index behind the last surface of the direction
    HWY_INLINE void run(int nearest, int first, int end, EndPixels<D>& ends) {
        M open = hn::Eq(hn::Zero(whole_), hn::Zero(whole_)); // all
        F nextStart = hn::Zero(d_);
        F nextHidden = hn::Zero(d_); // none
        F nextStrip = hn::Zero(d_);
        if (nearest + 1 < end) {
            const LayeredEnd& next = surfaces_.left[nearest + 1];
            nextStart = startOf(next.column, surfaces_.offsets[nearest + 1].first);
            nextHidden = hn::Set(d_, next.painted);
            nextStrip = hn::Set(d_, next.strip);
        }
        for (int k = nearest; k >= first; --k) {
            const LayeredEnd& left = surfaces_.left[k];
            const LayeredEnd& right = surfaces_.right[k];
            const LayeredEndOffsets& offsets = surfaces_.offsets[k];
            const F start = startOf(left.column, offsets.first);
            const M reached = hn::RebindMask(whole_, hn::Le(start, lanes_.x));
            const M hit = hn::And(open, reached);
            if (!hn::AllFalse(whole_, hit)) {
                const auto hitF = hn::RebindMask(d_, hit);
                const auto choose = [&](F value, F& to)
                                        HWY_ATTR { to = hn::IfThenElse(hitF, value, to); };
                choose(startOf(right.column, offsets.last), ends.lastStart);
                choose(hn::Set(d_, right.painted), ends.beyond);
                choose(hn::Set(d_, right.border), ends.rightBorder);
                choose(hn::Set(d_, right.strip), ends.strip);
                choose(hn::Set(d_, offsets.passing), ends.passing);
                choose(nextStart, ends.nextStart);
                choose(nextHidden, ends.nextHidden);
                choose(nextStrip, ends.nextStrip);
                choose(hn::Set(d_, left.column), first_);
                choose(hn::Set(d_, right.column), last_);
                choose(hn::Set(d_, offsets.first), offset_);
            }
            open = hn::AndNot(reached, open);
            nextStart = start;
            nextHidden = hn::Set(d_, left.painted);
            nextStrip = hn::Set(d_, left.strip);
            if (hn::AllFalse(whole_, open)) break;
            // a border that covers part of a pixel; what is behind it is searched further
            const F covered = hn::Sub(hn::Add(lanes_.x, hn::Set(d_, left.border)), start);
            const M border = hn::And(open, hn::RebindMask(whole_, hn::Gt(covered, hn::Zero(d_))));
            if (HWY_LIKELY(hn::AllFalse(whole_, border))) continue;
            const I part = ends.partOf(hn::Max(covered, hn::Zero(d_)));
            const M covers = hn::And(border, hn::Gt(part, hn::Zero(whole_)));
            const M again = hn::And(covers, hn::Gt(ends.coverLeft, hn::Zero(whole_)));
            ends.hard = hn::Or(ends.hard, again);
            const M isFirst = hn::AndNot(again, covers);
            ends.coverLeft = hn::IfThenElse(isFirst, part, ends.coverLeft);
            ends.coverColumn = hn::IfThenElse(
                isFirst, hn::Set(whole_, static_cast<std::int32_t>(left.column)), ends.coverColumn);
        }
        ends.frame = open;
        const auto openF = hn::RebindMask(d_, open); // left of everything: beside the first surface
        ends.passing = hn::IfThenElse(openF, hn::Set(d_, kNeverPasses), ends.passing);
        ends.nextStart = hn::IfThenElse(openF, nextStart, ends.nextStart);
        ends.nextHidden = hn::IfThenElse(openF, nextHidden, ends.nextHidden);
        ends.nextStrip = hn::IfThenElse(openF, nextStrip, ends.nextStrip);
        findColumns(ends);
    }

  private:
    // Where a column appears in the view.
    HWY_INLINE F startOf(float column, float offset) const {
        return hn::Sub(hn::Set(d_, column), hn::Mul(lanes_.unit, hn::Set(d_, offset)));
    }

    // For pixels within surfaces: the two columns that a pixel lies between. From a guess, each
    // step follows the line through two columns.
    HWY_INLINE void findColumns(EndPixels<D>& ends) const {
        constexpr int kMaxSteps = 8;
        const F one = hn::Set(d_, 1.0F);
        const M within = hn::RebindMask(whole_, hn::Lt(lanes_.x, ends.lastStart));
        M open = hn::AndNot(ends.frame, within);
        ends.inside = open;
        F guess = hn::Add(lanes_.x, hn::Mul(lanes_.unit, offset_));
        for (int step = 0; step < kMaxSteps && !hn::AllFalse(whole_, open); ++step) {
            const F inside = hn::Min(hn::Max(guess, first_), hn::Sub(last_, one));
            const I column = hn::ConvertTo(whole_, hn::Max(inside, hn::Zero(d_)));
            const F columnF = hn::ConvertTo(d_, column);
            const I words =
                gatherBytes4(whole_, tables_.words, hn::ShiftLeft<1>(hn::Add(lanes_.base, column)));
            const F from = hn::Sub(columnF, hn::Mul(lanes_.unit, lowOffset(d_, words)));
            const F to =
                hn::Sub(hn::Add(columnF, one), hn::Mul(lanes_.unit, highOffset(d_, words)));
            const auto between = hn::And(hn::Le(from, lanes_.x), hn::Lt(lanes_.x, to));
            const M found = hn::And(open, hn::RebindMask(whole_, between));
            ends.place =
                hn::IfThenElse(found, placeBetween(d_, lanes_, column, from, to), ends.place);
            open = hn::AndNot(found, open);
            const F width = hn::Max(hn::Sub(to, from), hn::Set(d_, 0.125F)); // never NaN
            guess = hn::Add(columnF, hn::Div(hn::Sub(lanes_.x, from), width));
        }
        ends.hard = hn::Or(ends.hard, open);
        // near the places of other pixels
        ends.place = plainPlace(tables_, lanes_, ends.place);
    }

    D d_;
    Whole whole_;
    const LayeredTables& tables_;
    const LayeredSurfaces& surfaces_;
    const Lanes<F, I>& lanes_;
    // of the surface found
    F first_ = hn::Zero(D());
    F last_ = hn::Zero(D());
    F offset_ = hn::Zero(D()); // of its first column
};

// Arithmetic limits the speed: some ten operations for each surface near a vector of pixels, and
// a gather of four bytes where they lie within surfaces.
void layeredAmongSurfacesOn(const LayeredTables& tables, const LayeredSurfaces& surfaces, int reach,
                            int direction, LayeredRoom& room) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const std::size_t lanesPerVector = hn::Lanes(d);
    LayeredList& list = room.open[direction];
    const std::int16_t* surfaceOf = tables.surfaces + direction * tables.stride;
    for (std::size_t i = 0; i < list.size; i += lanesPerVector) {
        const std::size_t count = std::min(lanesPerVector, list.size - i);
        for (std::size_t k = list.size; k < i + lanesPerVector; ++k) { // padding
            list.columns[k] = list.columns[list.size - 1];
            list.shifts[k] = list.shifts[list.size - 1];
        }
        const auto lanes = lanesOf(d, tables, hn::LoadU(d, list.columns.data() + i),
                                   hn::LoadU(d, list.shifts.data() + i));
        const float rightmost = hn::GetLane(hn::MaxOfLanes(d, hn::Ceil(lanes.x)));
        const int farthest = std::min(static_cast<int>(rightmost) + reach, tables.width - 1);
        const int first = surfaces.begin[direction];
        EndPixels<hn::ScalableTag<float>> ends(d, lanes);
        AmongSurfaces<hn::ScalableTag<float>>(d, tables, surfaces, lanes)
            .run(first + surfaceOf[farthest], first, surfaces.begin[direction + 1], ends);
        const auto fromColumn = hn::Set(whole, farthest);
        storeEnds(d, ends, list, i, count, fromColumn, room);
    }
}

// One gather of four bytes per sample, of which two are used, limits the speed.
void layeredSamplesOn(const std::uint8_t* plane, const std::int32_t* HWY_RESTRICT places,
                      std::size_t count, std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int32_t> d;
    using I = hn::Vec<decltype(d)>;
    const I byte = hn::Set(d, 255);
    const I subColumns = hn::Set(d, (1 << kSubColumnBits) - 1);
    const I round = hn::Set(d, 1 << (kSubColumnBits - 1));
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const I place = hn::Max(hn::LoadU(d, places + i), hn::Zero(d));
        const I four = gatherBytes4(d, plane, hn::ShiftRight<kSubColumnBits>(place));
        const I first = hn::And(four, byte);
        const I second = hn::And(hn::ShiftRight<8>(four), byte);
        const I product = hn::Mul(hn::Sub(second, first), hn::And(place, subColumns));
        const I sum = hn::Add(hn::ShiftLeft<kSubColumnBits>(first), product);
        storeBytes(d, hn::ShiftRight<kSubColumnBits>(hn::Add(sum, round)), values + i);
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(layeredGuessesOn);
HWY_EXPORT(layeredAmongSurfacesOn);
HWY_EXPORT(layeredSamplesOn);

void layeredGuesses(const LayeredTables& tables, const LayeredPixels& pixels, LayeredRoom& room) {
    HWY_DYNAMIC_DISPATCH(layeredGuessesOn)(tables, pixels, room);
}

void layeredAmongSurfaces(const LayeredTables& tables, const LayeredSurfaces& surfaces, int reach,
                          int direction, LayeredRoom& room) {
    HWY_DYNAMIC_DISPATCH(layeredAmongSurfacesOn)(tables, surfaces, reach, direction, room);
}

void layeredSamples(const std::uint8_t* plane, const std::int32_t* places, std::size_t count,
                    std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(layeredSamplesOn)(plane, places, count, values);
}

} // namespace altiro3D
#endif
