// Building blocks of the kernels of method Layered; included once per instruction set, after
// hwy/highway.h.

#if defined(ALTIRO3D_LAYERED_PARTS_INL_HPP) == defined(HWY_TARGET_TOGGLE) // NOLINT
#ifdef ALTIRO3D_LAYERED_PARTS_INL_HPP
#undef ALTIRO3D_LAYERED_PARTS_INL_HPP
#else
#define ALTIRO3D_LAYERED_PARTS_INL_HPP
#endif

#include "base/kernel_parts_inl.hpp"
#include "views/layered/layered_row.hpp"

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

    // In a gap: what is painted left of the next surface, unless a surface further left also
    // reaches the gap.
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

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#endif
