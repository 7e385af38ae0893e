// The search of listed pixels, column by column: layeredWalk().

#include "views/views_layered_row.hpp"

#include "base/pixel_rows.hpp"
#include "views/row_pixels.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/views_layered_walk.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"
#include "views/views_layered_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// Walks from a bound to the left until a column appears at x or left of it; this finds the
// front-most surface first. Gathers limit the speed of a round. One round is enough where depth is
// smooth; near steps a few more are needed.
template <class D, class F, class I>
class Walk {
  public:
    Walk(D d, const LayeredTables& tables, const Lanes<F, I>& lanes)
        : d_(d), tables_(tables), lanes_(lanes), from(hn::Zero(d)), to(hn::Zero(d)),
          found(hn::Zero(whole_)), word(hn::Zero(whole_)) {}

    HWY_INLINE void run(bool bounded) {
        const F zero = hn::Zero(d_);
        const F lastColumn = hn::Set(d_, static_cast<float>(tables_.width - 1));
        I boundWord = hn::Set(whole_, columnWord(kMaxOffset, false, false));
        if (bounded) boundWord = wordAt(tables_.bounds, hn::ConvertTo(whole_, lanes_.x));
        runFrom(hn::Floor(hn::Max(hn::Min(farthest(boundWord), lastColumn), zero)));
    }

    // @param column start, a whole number: no column to its right reaches x
    HWY_INLINE void runFrom(F column) {
        const I none = hn::Zero(whole_);
        const I one = hn::Set(whole_, 1);
        const I two = hn::Set(whole_, 2);
        const F zero = hn::Zero(d_);
        auto open = hn::Eq(none, none); // all
        for (;;) {
            const I columnWhole = hn::ConvertTo(whole_, column);
            // the words of the columns -2, -1 | 0, 1 relative to it
            const I index = hn::Add(lanes_.base, hn::Sub(columnWhole, two));
            const auto words = gatherBytes8(whole_, tables_.words, hn::ShiftLeft<1>(index));
            const F starts[4] = {start(column, -2, lowOffset(d_, words.low)),
                                 start(column, -1, highOffset(d_, words.low)),
                                 start(column, 0, lowOffset(d_, words.high)),
                                 start(column, 1, highOffset(d_, words.high))};
            const I own[3] = {words.low, hn::ShiftRight<16>(words.low), words.high};
            for (int k = 2; k >= 0; --k) {
                const F begin = hn::Sub(starts[k], slack(own[k]));
                const auto hit = hn::And(open, hn::RebindMask(whole_, hn::Le(begin, lanes_.x)));
                const auto hitF = hn::RebindMask(d_, hit);
                from = hn::IfThenElse(hitF, starts[k], from);
                to = hn::IfThenElse(hitF, starts[k + 1], to);
                found = hn::IfThenElse(hit, hn::Add(columnWhole, hn::Set(whole_, k - 2)), found);
                word = hn::IfThenElse(hit, own[k], word);
                open = hn::AndNot(hit, open);
            }
            if (hn::AllFalse(whole_, open)) return;
            const F rest = hn::Sub(column, hn::Set(d_, 3.0F));
            const I restWhole = hn::Max(hn::Sub(columnWhole, hn::Set(whole_, 3)), hn::Neg(one));
            const F next = hn::Max(hn::Floor(farthest(wordAt(tables_.left, restWhole))),
                                   hn::Sub(rest, hn::Set(d_, static_cast<float>(kLeftColumns))));
            column = hn::Max(hn::Min(next, rest), zero);
        }
    }

  private:
    HWY_INLINE I wordAt(const std::int16_t* table, I column) const {
        return gatherBytes4(whole_, table, hn::ShiftLeft<1>(hn::Add(lanes_.base, column)));
    }
    // Largest extent of the border of a surface that begins here.
    HWY_INLINE F slack(I columnWords) const {
        const I first = hn::Set(whole_, kFirstFlag);
        return hn::IfThenElseZero(hn::RebindMask(d_, hn::Eq(hn::And(columnWords, first), first)),
                                  hn::Set(d_, static_cast<float>(kEndReach)));
    }
    // The rightmost column that an offset up to this word's can move to x.
    HWY_INLINE F farthest(I boundWord) const {
        return hn::Add(hn::Add(lanes_.x, hn::Mul(lanes_.unit, lowOffset(d_, boundWord))),
                       hn::Set(d_, static_cast<float>(kEndReach)));
    }
    HWY_INLINE F start(F column, int steps, F offset) const {
        return hn::Sub(hn::Add(column, hn::Set(d_, static_cast<float>(steps))),
                       hn::Mul(lanes_.unit, offset));
    }

    D d_;
    hn::RebindToSigned<D> whole_;
    const LayeredTables& tables_;
    const Lanes<F, I>& lanes_;

  public:
    F from;  // position of the column found
    F to;    // position of the next column
    I found; // the column
    I word;  // its word; only the flags are used
};

// Finds the columns that reach the listed pixels. Pixels at the ends of surfaces stay in the list.
std::size_t placesByWalk(const LayeredTables& tables, bool bounded, std::size_t openCount,
                         const LayeredList& list, const LayeredRoom& room) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    using F = hn::Vec<decltype(d)>;
    using I = hn::Vec<decltype(whole)>;
    const std::size_t lanesPerVector = hn::Lanes(d);
    const I lastFlag = hn::Set(whole, kLastFlag);
    std::size_t endCount = 0; // never ahead of the read position
    for (std::size_t i = 0; i < openCount; i += lanesPerVector) {
        const I number = hn::LoadU(whole, list.pixels + i);
        const F columns = hn::LoadU(d, list.columns + i);
        const F shift = hn::LoadU(d, list.shifts + i);
        const auto lanes = lanesOf(d, tables, columns, shift);
        Walk<decltype(d), F, I> walk(d, tables, lanes);
        walk.run(bounded);
        const auto inside = hn::And(hn::Eq(hn::And(walk.word, lastFlag), hn::Zero(whole)),
                                    hn::RebindMask(whole, hn::Le(walk.from, lanes.x)));
        HWY_ALIGN std::int32_t results[HWY_LANES(std::int32_t)];
        const I place = placeBetween(d, lanes, walk.found, walk.from, walk.to);
        hn::Store(plainPlace(tables, lanes, place), whole, results);
        const std::size_t count = std::min(lanesPerVector, openCount - i);
        for (std::size_t k = 0; k < count; ++k)
            room.places[list.pixels[i + k]] = results[k];
        const ChosenLanes outside(whole, hn::AndNot(inside, hn::FirstN(whole, count)));
        outside.store(number, list.pixels + endCount);
        outside.store(columns, list.columns + endCount);
        outside.store(shift, list.shifts + endCount);
        outside.store(walk.found, room.endColumns + endCount);
        endCount += outside.count();
    }
    return endCount;
}

// Reads the data of pixels at the ends of surfaces.
template <class D>
class EndsOfWalk {
    using Whole = hn::RebindToSigned<D>;
    using F = hn::Vec<D>;
    using I = hn::Vec<Whole>;
    using M = hn::Mask<Whole>;

  public:
    HWY_INLINE EndsOfWalk(D d, const LayeredTables& tables, const LayeredSurfaces& surfaces,
                          const Lanes<F, I>& lanes)
        : d_(d), tables_(tables), surfaces_(surfaces), lanes_(lanes) {
        const M mirrored = hn::Ne(lanes_.base, none());
        firstSurface_ = hn::IfThenElseZero(mirrored, hn::Set(whole_, surfaces.begin[1]));
        endSurface_ = hn::IfThenElse(mirrored, hn::Set(whole_, surfaces.begin[2]),
                                     hn::Set(whole_, surfaces.begin[1]));
    }

    // @param column where the walk ended, in the direction of each
    HWY_INLINE void read(I column, EndPixels<D>& ends) const {
        ends.coverColumn = column;
        ends.frame = hn::Lt(column, none());
        column = lookBehindBorder(column, ends);
        const I surface = surfaceOf(column);
        const auto right = gatherRows(d_, &surfaces_.right->column, surface);
        ends.lastStart = startOf(right.floats[0]);
        ends.beyond = right.floats[1];
        ends.rightBorder = right.floats[2];
        ends.strip = right.floats[3];
        const I row = hn::Add(surface, hn::ShiftLeft<1>(surface)); // of three floats
        ends.passing = hn::IfThenElse(hn::RebindMask(d_, ends.frame), hn::Set(d_, kNeverPasses),
                                      gatherFloats(d_, &surfaces_.offsets->passing, row));
        const I next =
            hn::IfThenElse(ends.frame, firstSurface_, hn::Add(surface, hn::Set(whole_, 1)));
        ends.hasNext = hn::Lt(next, endSurface_);
        const I safeNext = hn::IfThenElse(ends.hasNext, next, firstSurface_);
        const auto left = gatherRows(d_, &surfaces_.left->column, safeNext);
        ends.nextStart = startOf(left.floats[0]);
        ends.nextHidden = left.floats[1];
        ends.nextStrip = left.floats[3];
    }

  private:
    // Where a border from the right covers part of the pixel: the column behind it.
    HWY_INLINE I lookBehindBorder(I column, EndPixels<D>& ends) const {
        const F start = startOf(hn::ConvertTo(d_, hn::Max(column, none())));
        const M border = hn::AndNot(ends.frame, hn::RebindMask(whole_, hn::Gt(start, lanes_.x)));
        if (hn::AllFalse(whole_, border)) return column;
        const float* borders = &surfaces_.left->border;
        const F leftBorder = gatherFloats(d_, borders, hn::ShiftLeft<2>(surfaceOf(column)));
        const F covered = hn::Max(hn::Sub(hn::Add(lanes_.x, leftBorder), start), hn::Zero(d_));
        ends.coverLeft = hn::IfThenElseZero(border, ends.partOf(covered));
        const I one = hn::Set(whole_, 1);
        const I next = hn::Sub(column, one);
        Walk<D, F, I> walk(d_, tables_, lanes_);
        walk.runFrom(hn::ConvertTo(d_, hn::Max(hn::IfThenElseZero(border, next), none())));
        const I found = hn::IfThenElse(hn::Lt(next, none()), next, walk.found);
        const M reached = hn::RebindMask(whole_, hn::Le(walk.from, lanes_.x));
        const M within = hn::Eq(hn::And(walk.word, one), none());
        const M behind = hn::And(border, hn::Gt(found, hn::Neg(one)));
        ends.inside = hn::And(behind, hn::And(reached, within));
        ends.hard = hn::AndNot(reached, behind);
        ends.place = placeBetween(d_, lanes_, found, walk.from, walk.to);
        column = hn::IfThenElse(border, found, column);
        ends.frame = hn::Lt(column, none());
        return column;
    }

    HWY_INLINE I none() const { return hn::Zero(whole_); }
    HWY_INLINE I surfaceOf(I column) const {
        const I bytes = hn::ShiftLeft<1>(hn::Add(lanes_.base, hn::Max(column, none())));
        const I pair = gatherBytes4(whole_, tables_.surfaces, bytes);
        return hn::Add(firstSurface_, hn::And(pair, hn::Set(whole_, 0xFFFF)));
    }
    // Where a column appears in the view.
    HWY_INLINE F startOf(F column) const {
        const I bytes = hn::ShiftLeft<1>(hn::Add(lanes_.base, hn::ConvertTo(whole_, column)));
        const I words = gatherBytes4(whole_, tables_.words, bytes);
        return hn::Sub(column, hn::Mul(lanes_.unit, lowOffset(d_, words)));
    }

    D d_;
    Whole whole_;
    const LayeredTables& tables_;
    const LayeredSurfaces& surfaces_;
    const Lanes<F, I>& lanes_;
    I firstSurface_ = hn::Zero(Whole()); // of the direction
    I endSurface_ = hn::Zero(Whole());
};

void layeredWalkOn(const LayeredTables& tables, const LayeredSurfaces& surfaces, bool bounded,
                   std::size_t openCount, const LayeredList& list, const LayeredRoom& room,
                   LayeredCounts& counts) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const std::size_t lanesPerVector = hn::Lanes(d);
    for (std::size_t i = 0; i < lanesPerVector; ++i) {
        list.columns[openCount + i] = 0; // any pixel
        list.shifts[openCount + i] = 0;
    }
    const std::size_t endCount = placesByWalk(tables, bounded, openCount, list, room);
    for (std::size_t i = 0; i < endCount; i += lanesPerVector) {
        const std::size_t count = std::min(lanesPerVector, endCount - i);
        const auto valid = hn::FirstN(whole, count);
        const auto validF = hn::RebindMask(d, valid);
        const auto column = hn::IfThenElseZero(valid, hn::LoadU(whole, room.endColumns + i));
        const auto lanes =
            lanesOf(d, tables, hn::IfThenElseZero(validF, hn::LoadU(d, list.columns + i)),
                    hn::IfThenElseZero(validF, hn::LoadU(d, list.shifts + i)));
        EndPixels<hn::ScalableTag<float>> ends(d, lanes);
        EndsOfWalk<hn::ScalableTag<float>>(d, tables, surfaces, lanes).read(column, ends);
        storeEnds(d, ends, list, i, count, column, room, counts);
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(layeredWalkOn);

void layeredWalk(const LayeredTables& tables, const LayeredSurfaces& surfaces, bool bounded,
                 std::size_t openCount, const LayeredList& list, const LayeredRoom& room,
                 LayeredCounts& counts) {
    HWY_DYNAMIC_DISPATCH(layeredWalkOn)
    (tables, surfaces, bounded, openCount, list, room, counts);
}

} // namespace altiro3D
#endif
