// Pixels on no line: layeredGuesses() and, among the ends of surfaces, layeredAmongSurfaces().

#include "views/layered/layered_row.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/layered/layered_guesses.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// Offsets are the upper 14 bits of a word. As 32-bit numbers they have 18 zero bits below them and
// a unit that is smaller by the same factor.
constexpr float kWordUnit = 0x1p-18F;

template <class D>
HWY_INLINE hn::Vec<D> lowOffset(D d, hn::Vec<hn::RebindToSigned<D>> words) {
    const hn::RebindToSigned<D> whole;
    const auto bits = hn::Set(whole, static_cast<std::int32_t>(0xFFFC0000));
    return hn::ConvertTo(d, hn::And(hn::ShiftLeft<16>(words), bits));
}

template <class D>
HWY_INLINE hn::Vec<D> highOffset(D d, hn::Vec<hn::RebindToSigned<D>> words) {
    const hn::RebindToSigned<D> whole;
    const auto bits = hn::Set(whole, static_cast<std::int32_t>(0xFFFC0000));
    return hn::ConvertTo(d, hn::And(words, bits));
}

// A vector of pixels, each in the coordinates of its direction.
template <class F, class I>
struct Lanes {
    F x;
    F unit; // px per unit of the offsets, scaled by kWordUnit, >= 0
    I base; // start of the direction's tables
};

template <class D, class F, class I = hn::Vec<hn::RebindToSigned<D>>>
HWY_INLINE Lanes<F, I> lanesOf(D d, const LayeredTables& tables, F column, F shift) {
    const hn::RebindToSigned<D> whole;
    const auto mirrored = hn::Lt(shift, hn::Zero(d));
    const F last = hn::Set(d, static_cast<float>(tables.width - 1));
    return {hn::IfThenElse(mirrored, hn::Sub(last, column), column),
            hn::Mul(hn::Abs(shift), hn::Set(d, tables.scale * kWordUnit)),
            hn::IfThenElseZero(hn::RebindMask(whole, mirrored), hn::Set(whole, tables.stride))};
}

// The place of x between two columns that appear at `from` and `to`.
template <class D, class F, class I>
HWY_INLINE I placeBetween(D d, const Lanes<F, I>& lanes, I column, F from, F to) {
    const F steps = hn::Set(d, static_cast<float>(1 << kSubColumnBits));
    const F part = hn::Div(hn::Mul(hn::Sub(lanes.x, from), steps), hn::Sub(to, from));
    return hn::Add(hn::ShiftLeft<kSubColumnBits>(hn::Add(lanes.base, column)),
                   smallNearestInt(d, part));
}

// A place in the row instead of the same one in the mirrored row.
template <class F, class I>
HWY_INLINE I plainPlace(const LayeredTables& tables, const Lanes<F, I>& lanes, I place) {
    const hn::DFromV<I> whole;
    const I ends = hn::Set(whole, (tables.stride + tables.width - 1) << kSubColumnBits);
    return hn::IfThenElse(hn::Gt(lanes.base, hn::Zero(whole)), hn::Sub(ends, place), place);
}

// Finds places in open blocks. Pixels on a line have theirs already. For others, if no other
// surface comes near, a guess from the pixel's own depth and slope is verified: within a surface
// the contents are in order, so there is only one solution. Arithmetic limits the speed: some
// seventy operations and a gather of four bytes.
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
        // With AVX-512, compressing is one instruction, cheaper than an unpredictable branch.
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

// A vector of pixels at the ends of surfaces: what is painted beside a surface or, behind a border
// that covers part of the pixel, the next surface. After the data is set, the steps run in the
// order of the functions.
template <class D>
class EndPixels {
    using Whole = hn::RebindToSigned<D>;
    using F = hn::Vec<D>;
    using I = hn::Vec<Whole>;
    using M = hn::Mask<Whole>;

  public:
    EndPixels(D d, const Lanes<F, I>& lanes) : d_(d), lanes_(lanes) {}

    // Beside the end of a surface: what is painted there.
    HWY_INLINE void lookBeyondSurface() {
        const M atEnd = hn::Not(hn::Or(frame, inside));
        const F distance = hn::Sub(lanes_.x, lastStart);
        const F zero = hn::Zero(d_);
        hard = hn::Or(hard, hn::And(atEnd, hn::RebindMask(whole_, hn::Lt(distance, zero))));
        const M isBeyond = hn::And(atEnd, hn::RebindMask(whole_, hn::Le(distance, beyond)));
        lastPlace_ = hn::ShiftLeft<kSubColumnBits>(hn::Add(hn::ConvertTo(whole_, strip), one()));
        place = hn::IfThenElse(isBeyond, hn::Add(lastPlace_, subColumns(hn::Max(distance, zero))),
                               place);
        inGap_ = hn::Or(frame, hn::AndNot(isBeyond, atEnd));
        const F covered = hn::Max(hn::Sub(hn::Add(beyond, rightBorder), distance), zero);
        coverRight_ = hn::IfThenElseZero(hn::AndNot(frame, inGap_), partOf(covered));
    }

    // In a gap: what is painted left of the next surface, unless one further left also reaches it.
    HWY_INLINE void lookIntoGap() {
        const F away = hn::Sub(nextStart, lanes_.x);
        const F zero = hn::Zero(d_);
        const auto prepared = hn::And(hn::Ge(away, zero),
                                      hn::And(hn::Le(away, nextHidden), hn::Gt(nextHidden, zero)));
        const auto isAlone = hn::Le(lanes_.unit, passing);
        const M isHidden = hn::And(inGap_, hn::RebindMask(whole_, hn::And(prepared, isAlone)));
        const I firstPlace = hn::ShiftLeft<kSubColumnBits>(hn::ConvertTo(whole_, nextStrip));
        place =
            hn::IfThenElse(isHidden, hn::Sub(firstPlace, subColumns(hn::Max(away, zero))), place);
        hard = hn::Or(hard, hn::AndNot(isHidden, inGap_));
    }

    // What covers the pixel, and how much of it. Covers from both sides are left to LayeredSearch.
    HWY_INLINE void chooseCover() {
        const M byLeft = hn::Gt(coverLeft, none());
        const M byRight = hn::Gt(coverRight_, none());
        hard = hn::AndNot(hn::Eq(coverLeft, all()), hn::Or(hard, hn::And(byLeft, byRight)));
        cover = hn::IfThenElse(
            byLeft, hn::ShiftLeft<kSubColumnBits>(hn::Add(lanes_.base, coverColumn)),
            hn::Add(lastPlace_, hn::ShiftLeft<kSubColumnBits>(hn::ConvertTo(whole_, beyond))));
        part = hn::IfThenElse(byLeft, coverLeft, coverRight_);
        place = hn::IfThenElse(hn::Eq(part, all()), cover, place);
    }

    // Where the view does not move: the photo itself.
    HWY_INLINE void keepStill() {
        const M isStill = hn::RebindMask(whole_, hn::Eq(lanes_.unit, hn::Zero(d_)));
        place = hn::IfThenElse(isStill, subColumns(lanes_.x), place);
        part = hn::IfThenZeroElse(isStill, part);
        hard = hn::AndNot(isStill, hard);
    }

    // Pixels that a border covers in part.
    HWY_INLINE M isMixed() const { return hn::And(hn::Gt(part, none()), hn::Lt(part, all())); }

    // The part of a pixel that a border covers, in 1/256.
    HWY_INLINE I partOf(F covered) const { return hn::Min(subColumns(covered), all()); }

  private:
    HWY_INLINE I none() const { return hn::Zero(whole_); }
    HWY_INLINE I one() const { return hn::Set(whole_, 1); }
    HWY_INLINE I all() const { return hn::Set(whole_, 1 << kSubColumnBits); }
    HWY_INLINE I subColumns(F distance) const {
        const F steps = hn::Set(d_, static_cast<float>(1 << kSubColumnBits));
        return hn::ConvertTo(whole_, hn::Add(hn::Mul(distance, steps), hn::Set(d_, 0.5F)));
    }

    D d_;
    Whole whole_;
    const Lanes<F, I>& lanes_;
    M inGap_ = hn::MaskFromVec(hn::Zero(Whole()));
    I coverRight_ = hn::Zero(Whole()); // in 1/256 of the pixel
    I lastPlace_ = hn::Zero(Whole());

  public:
    // data
    M frame = inGap_;            // left of everything
    M inside = inGap_;           // a surface: place is set
    F lastStart = hn::Zero(D()); // where the last column of the surface appears
    F beyond = hn::Zero(D());    // LayeredEnd of its right end
    F rightBorder = hn::Zero(D());
    F strip = hn::Zero(D());
    F passing = hn::Zero(D()); // LayeredEndOffsets of the surface
    // the surface to its right, if there is one
    F nextStart = hn::Zero(D());  // where its first column appears
    F nextHidden = hn::Zero(D()); // LayeredEnd of its left end, 0 without it
    F nextStrip = hn::Zero(D());
    I coverLeft = hn::Zero(Whole()); // part that a border from the right covers, in 1/256
    I coverColumn = hn::Zero(Whole());
    // data and results
    M hard = inGap_;             // pixels for LayeredSearch
    I place = hn::Zero(Whole()); // what they show
    // results
    I cover = hn::Zero(Whole()); // place of what covers them
    I part = hn::Zero(Whole());  // how much of them, in 1/256
};

// Runs the steps and stores the results of `count` pixels.
// @param entry the first one in the list
// @param column from which LayeredSearch must go on
template <class D, class I>
HWY_INLINE void storeEnds(D d, EndPixels<D>& ends, const LayeredList& list, std::size_t entry,
                          std::size_t count, I column, LayeredRoom& room) {
    const hn::RebindToSigned<D> whole;
    ends.lookBeyondSurface();
    ends.lookIntoGap();
    ends.chooseCover();
    ends.keepStill();
    const auto valid = hn::FirstN(whole, count);
    const auto hard = hn::And(valid, ends.hard);
    HWY_ALIGN std::int32_t results[HWY_LANES(std::int32_t)];
    hn::Store(hn::IfThenElse(hard, hn::Set(whole, kSeeEnds), ends.place), whole, results);
    const std::int32_t* const pixels = list.pixels.data() + entry;
    std::int32_t* const places = room.places.data();
    for (std::size_t k = 0; k < count; ++k)
        places[pixels[k]] = results[k];
    const ChosenLanes hardOnes(whole, hard);
    hardOnes.store(hn::LoadU(whole, pixels), room.hard.pixels.data() + room.hard.size);
    hardOnes.store(hn::LoadU(d, list.columns.data() + entry),
                   room.hard.columns.data() + room.hard.size);
    hardOnes.store(hn::LoadU(d, list.shifts.data() + entry),
                   room.hard.shifts.data() + room.hard.size);
    hardOnes.store(column, room.hardColumns.data() + room.hard.size);
    room.hard.size += hardOnes.count();
    const ChosenLanes mixed(whole, hn::And(hn::AndNot(hard, valid), ends.isMixed()));
    mixed.store(hn::LoadU(whole, pixels), room.mixed.data() + room.mixedCount);
    mixed.store(ends.cover, room.covers.data() + room.mixedCount);
    mixed.store(ends.part, room.parts.data() + room.mixedCount);
    room.mixedCount += mixed.count();
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
        // as places in the row, nearer in memory to those of other pixels than mirrored ones
        ends.place = plainPlace(tables_, lanes_, ends.place);
    }

    D d_;
    Whole whole_;
    const LayeredTables& tables_;
    const LayeredSurfaces& surfaces_;
    const Lanes<F, I>& lanes_;
    // the surface found
    F first_ = hn::Zero(D());
    F last_ = hn::Zero(D());
    F offset_ = hn::Zero(D()); // offset of its first column
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

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(layeredGuessesOn);
HWY_EXPORT(layeredAmongSurfacesOn);

void layeredGuesses(const LayeredTables& tables, const LayeredPixels& pixels, LayeredRoom& room) {
    HWY_DYNAMIC_DISPATCH(layeredGuessesOn)(tables, pixels, room);
}

void layeredAmongSurfaces(const LayeredTables& tables, const LayeredSurfaces& surfaces, int reach,
                          int direction, LayeredRoom& room) {
    HWY_DYNAMIC_DISPATCH(layeredAmongSurfacesOn)(tables, surfaces, reach, direction, room);
}

} // namespace altiro3D
#endif
