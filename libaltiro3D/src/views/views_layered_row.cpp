#include "views/views_layered_row.hpp"

#include "base/pixel_rows.hpp"
#include "views/row_pixels.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/views_layered_row.cpp"
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

#if ALTIRO3D_AVX512
// Windows of a table and its mirrored table for the pixels begin..end - 1.
template <class T>
class TwoWindows {
  public:
    HWY_INLINE TwoWindows(const LayeredTables& tables, const LayeredPixels& pixels,
                          std::size_t begin, std::size_t end, const T* table)
        : from_(windowOf(pixels.columns[begin], pixels.columns[end - 1], pixels.reach)),
          mirroredFrom_(tables.stride + std::max(tables.width + 1 - from_ - kWindowColumns, 0)),
          window_(table + std::max(from_, 0)), mirroredWindow_(table + mirroredFrom_) {}

    HWY_INLINE bool fit() const { return from_ >= 0; }

    // The entries of columns and of the next columns. `column` includes the start of its
    // direction's table. Columns outside of the windows give undefined entries.
    template <class V, class M>
    HWY_INLINE V pairs(V column, M mirrored) const {
        const hn::Full512<std::int32_t> d;
        const V from = hn::IfThenElse(mirrored, hn::Set(d, mirroredFrom_), hn::Set(d, from_));
        const V indices = Window::withNext(hn::Sub(column, from));
        return hn::IfThenElse(mirrored, mirroredWindow_.pairs(indices), window_.pairs(indices));
    }

  private:
    int from_;
    int mirroredFrom_;
    Window window_;
    Window mirroredWindow_;
};
#endif

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

// For open blocks. Pixels on a line have their place. If no other surface comes near, a
// guess from the pixel's own depth and slope is verified: within a surface the contents are in
// order, so it is the only solution. Arithmetic limits the speed: some seventy operations and a
// gather of four bytes.
std::size_t layeredGuessesOn(const LayeredTables& tables, const LayeredPixels& pixels,
                             const float* HWY_RESTRICT shifts, std::size_t firstPixel,
                             std::size_t openCount, const LayeredRoom& room) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const hn::Rebind<std::int16_t, decltype(d)> narrow;
    using F = hn::Vec<decltype(d)>;
    using I = hn::Vec<decltype(whole)>;
    const F one = hn::Set(d, 1.0F);
    const F half = hn::Set(d, 0.5F);
    const F lastColumn = hn::Set(d, static_cast<float>(tables.width) - 0.5F);
    const I none = hn::Zero(whole);
    const I lastFlag = hn::Set(whole, kLastFlag);
    const I notOnLine = hn::Set(whole, kNotOnLine);
    std::int32_t* HWY_RESTRICT places = room.places + firstPixel;
    const auto end = static_cast<std::int32_t>(firstPixel + pixels.count);
    const std::size_t openBefore = openCount;
    // @param wordsAt the word of a column in the lower, the next one's in the upper 16 bits
    const auto guessVector = [&](std::size_t i, const auto& wordsAt) HWY_ATTR {
        const I away = hn::PromoteTo(whole, hn::LoadU(narrow, pixels.away + i));
        const I onLine = hn::Add(hn::LoadU(whole, pixels.places + i), away);
        const auto isLine = hn::Ne(away, notOnLine);
        if (hn::AllTrue(whole, isLine)) {
            hn::StoreU(onLine, whole, places + i);
            return;
        }
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
        // a surface further left may reach the pixel, too, behind its own one
        const F first =
            hn::IfThenElse(hn::RebindMask(d, mirrored), hn::LoadU(d, pixels.mirroredFirst + i),
                           hn::LoadU(d, pixels.first + i));
        const F near =
            hn::Min(hn::Max(hn::Add(lanes.x, forward), hn::Add(first, half)), lastColumn);
        const I column = smallNearestInt(d, hn::Sub(near, half)); // rounded down, except for ties
        const F columnPlace = hn::ConvertTo(d, column);
        const I words = wordsAt(hn::Add(lanes.base, column), mirrored);
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
        const ChosenLanes unsure(whole, hn::Not(sure));
        unsure.store(hn::Iota(whole, static_cast<std::int32_t>(firstPixel + i)),
                     room.open.pixels + openCount);
        unsure.store(hn::LoadU(d, pixels.columns + i), room.open.columns + openCount);
        unsure.store(shift, room.open.shifts + openCount);
        openCount += unsure.count();
    };
    const auto gathered = [&](I column, const auto&) HWY_ATTR {
        return gatherBytes4(whole, tables.words, hn::ShiftLeft<1>(column));
    };
    const std::size_t lanesPerVector = hn::Lanes(d);
    for (std::size_t begin = 0; begin < pixels.count; begin += kWindowPixels) {
        if (pixels.windows[begin / kWindowPixels] != kOpenBlock) continue;
        const std::size_t blockEnd = std::min(begin + kWindowPixels, pixels.count);
#if ALTIRO3D_AVX512
        const TwoWindows<std::int16_t> windows(tables, pixels, begin, blockEnd, tables.words);
        if (windows.fit()) {
            for (std::size_t i = begin; i < blockEnd; i += lanesPerVector)
                guessVector(i, [&](I column, const auto& mirrored)
                                   HWY_ATTR { return windows.pairs(column, mirrored); });
            continue;
        }
#endif
        for (std::size_t i = begin; i < blockEnd; i += lanesPerVector)
            guessVector(i, gathered);
    }
    while (openCount > openBefore && room.open.pixels[openCount - 1] >= end)
        --openCount; // padding
    return openCount;
}

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
                         const LayeredRoom& room) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    using F = hn::Vec<decltype(d)>;
    using I = hn::Vec<decltype(whole)>;
    const std::size_t lanesPerVector = hn::Lanes(d);
    const I lastFlag = hn::Set(whole, kLastFlag);
    std::size_t endCount = 0; // never ahead of the read position
    for (std::size_t i = 0; i < openCount; i += lanesPerVector) {
        const I number = hn::LoadU(whole, room.open.pixels + i);
        const F columns = hn::LoadU(d, room.open.columns + i);
        const F shift = hn::LoadU(d, room.open.shifts + i);
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
            room.places[room.open.pixels[i + k]] = results[k];
        const ChosenLanes outside(whole, hn::AndNot(inside, hn::FirstN(whole, count)));
        outside.store(number, room.open.pixels + endCount);
        outside.store(columns, room.open.columns + endCount);
        outside.store(shift, room.open.shifts + endCount);
        outside.store(walk.found, room.endColumns + endCount);
        endCount += outside.count();
    }
    return endCount;
}

// A vector of pixels at the ends of surfaces: what is painted beside a surface or, behind a border
// that covers part of the pixel, the next surface. The steps run in the order of the functions.
template <class D>
class EndPixels {
    using Whole = hn::RebindToSigned<D>;
    using F = hn::Vec<D>;
    using I = hn::Vec<Whole>;
    using M = hn::Mask<Whole>;

  public:
    // @param x, shift column and shift of the pixels
    // @param column where the walk ended, in the direction of each
    HWY_INLINE EndPixels(D d, const LayeredTables& tables, const LayeredSurfaces& surfaces, F x,
                         F shift, I column)
        : d_(d), tables_(tables), surfaces_(surfaces), shift_(shift),
          lanes_(lanesOf(d, tables, x, shift)), givenColumn_(column), column_(column),
          frame_(hn::Lt(column, none())) {
        const M mirrored = hn::Ne(lanes_.base, none());
        firstSurface_ = hn::IfThenElseZero(mirrored, hn::Set(whole_, surfaces.begin[1]));
        endSurface_ = hn::IfThenElse(mirrored, hn::Set(whole_, surfaces.begin[2]),
                                     hn::Set(whole_, surfaces.begin[1]));
    }

    // Where a border from the right covers part of the pixel: what is behind it?
    HWY_INLINE void lookBehindBorder() {
        const F start = startOf(hn::ConvertTo(d_, hn::Max(column_, none())));
        const M border = hn::AndNot(frame_, hn::RebindMask(whole_, hn::Gt(start, lanes_.x)));
        if (hn::AllFalse(whole_, border)) return;
        const float* borders = &surfaces_.left->border;
        const F leftBorder = gatherFloats(d_, borders, hn::ShiftLeft<2>(surfaceOf(column_)));
        const F covered = hn::Max(hn::Sub(hn::Add(lanes_.x, leftBorder), start), hn::Zero(d_));
        coverLeft_ = hn::IfThenElseZero(border, hn::Min(subColumns(covered), all()));
        const I next = hn::Sub(column_, one());
        Walk<D, F, I> walk(d_, tables_, lanes_);
        walk.runFrom(hn::ConvertTo(d_, hn::Max(hn::IfThenElseZero(border, next), none())));
        const I found = hn::IfThenElse(hn::Lt(next, none()), next, walk.found);
        const M reached = hn::RebindMask(whole_, hn::Le(walk.from, lanes_.x));
        const M within = hn::Eq(hn::And(walk.word, one()), none());
        const M behind = hn::And(border, hn::Gt(found, hn::Neg(one())));
        inside_ = hn::And(behind, hn::And(reached, within));
        hard = hn::AndNot(reached, behind);
        place = placeBetween(d_, lanes_, found, walk.from, walk.to);
        column_ = hn::IfThenElse(border, found, column_);
        frame_ = hn::Lt(column_, none());
    }

    // Beside the end of a surface: what is painted there, or the gap behind it.
    HWY_INLINE void lookBeyondSurface() {
        surface_ = surfaceOf(column_);
        const M atEnd = hn::Not(hn::Or(frame_, inside_));
        const auto right = gatherRows(d_, &surfaces_.right->column, surface_);
        const auto& [last, beyond, rightBorder, strip] = right.floats;
        const F distance = hn::Sub(lanes_.x, startOf(last));
        const F zero = hn::Zero(d_);
        hard = hn::Or(hard, hn::And(atEnd, hn::RebindMask(whole_, hn::Lt(distance, zero))));
        beyond_ = beyond;
        const M isBeyond = hn::And(atEnd, hn::RebindMask(whole_, hn::Le(distance, beyond_)));
        lastPlace_ = hn::ShiftLeft<kSubColumnBits>(hn::Add(hn::ConvertTo(whole_, strip), one()));
        place = hn::IfThenElse(isBeyond, hn::Add(lastPlace_, subColumns(hn::Max(distance, zero))),
                               place);
        inGap_ = hn::Or(frame_, hn::AndNot(isBeyond, atEnd));
        const F covered = hn::Max(hn::Sub(hn::Add(beyond_, rightBorder), distance), zero);
        coverRight_ =
            hn::IfThenElseZero(hn::AndNot(frame_, inGap_), hn::Min(subColumns(covered), all()));
    }

    // In a gap: what is painted left of the next surface.
    HWY_INLINE void lookIntoGap() {
        const I next = hn::IfThenElse(frame_, firstSurface_, hn::Add(surface_, one()));
        const M hasNext = hn::Lt(next, endSurface_);
        const I safeNext = hn::IfThenElse(hasNext, next, firstSurface_);
        const auto left = gatherRows(d_, &surfaces_.left->column, safeNext);
        const auto& [first, hidden, border, strip] = left.floats;
        static_cast<void>(border);
        const F away = hn::Sub(startOf(first), lanes_.x);
        const F zero = hn::Zero(d_);
        const auto prepared =
            hn::And(hn::Ge(away, zero), hn::And(hn::Le(away, hidden), hn::Gt(hidden, zero)));
        const M isHidden = hn::And(inGap_, hn::And(hasNext, hn::RebindMask(whole_, prepared)));
        const I firstPlace = hn::ShiftLeft<kSubColumnBits>(hn::ConvertTo(whole_, strip));
        place =
            hn::IfThenElse(isHidden, hn::Sub(firstPlace, subColumns(hn::Max(away, zero))), place);
        hard = hn::Or(hard, hn::AndNot(isHidden, inGap_));
    }

    // What covers the pixel, and how much of it. Covers from both sides are left to LayeredSearch.
    HWY_INLINE void chooseCover() {
        const M byLeft = hn::Gt(coverLeft_, none());
        const M byRight = hn::Gt(coverRight_, none());
        hard = hn::AndNot(hn::Eq(coverLeft_, all()), hn::Or(hard, hn::And(byLeft, byRight)));
        cover = hn::IfThenElse(
            byLeft, hn::ShiftLeft<kSubColumnBits>(hn::Add(lanes_.base, givenColumn_)),
            hn::Add(lastPlace_, hn::ShiftLeft<kSubColumnBits>(hn::ConvertTo(whole_, beyond_))));
        part = hn::IfThenElse(byLeft, coverLeft_, coverRight_);
        place = hn::IfThenElse(hn::Eq(part, all()), cover, place);
    }

    // Where the view does not move: the photo itself.
    HWY_INLINE void keepStill() {
        const M isStill = hn::RebindMask(whole_, hn::Eq(shift_, hn::Zero(d_)));
        const I own = hn::ConvertTo(whole_, lanes_.x);
        place = hn::IfThenElse(isStill, hn::ShiftLeft<kSubColumnBits>(own), place);
        part = hn::IfThenZeroElse(isStill, part);
        hard = hn::AndNot(isStill, hard);
    }

    // Pixels that a border covers in part.
    HWY_INLINE M isMixed() const { return hn::And(hn::Gt(part, none()), hn::Lt(part, all())); }

  private:
    HWY_INLINE I none() const { return hn::Zero(whole_); }
    HWY_INLINE I one() const { return hn::Set(whole_, 1); }
    HWY_INLINE I all() const { return hn::Set(whole_, 1 << kSubColumnBits); }
    HWY_INLINE I subColumns(F distance) const {
        const F steps = hn::Set(d_, static_cast<float>(1 << kSubColumnBits));
        return hn::ConvertTo(whole_, hn::Add(hn::Mul(distance, steps), hn::Set(d_, 0.5F)));
    }
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
    F shift_;
    Lanes<F, I> lanes_;
    I firstSurface_ = hn::Zero(Whole()); // of the direction
    I endSurface_ = hn::Zero(Whole());
    I givenColumn_;
    I column_;
    M frame_;                                       // left of everything
    M inside_ = hn::MaskFromVec(hn::Zero(Whole())); // a surface, behind a border
    M inGap_ = inside_;
    I coverLeft_ = hn::Zero(Whole()); // in 1/256 of the pixel
    I coverRight_ = hn::Zero(Whole());
    I lastPlace_ = hn::Zero(Whole());
    F beyond_ = hn::Zero(D());
    I surface_ = hn::Zero(Whole());

  public:
    M hard = inside_;            // pixels for LayeredSearch
    I place = hn::Zero(Whole()); // what they show
    I cover = hn::Zero(Whole()); // place of what covers them
    I part = hn::Zero(Whole());  // how much of them, in 1/256
};

// For listed pixels at the ends of surfaces. What is more involved is left to LayeredSearch.
LayeredCounts placesAtEnds(const LayeredTables& tables, const LayeredSurfaces& surfaces,
                           std::size_t endCount, const LayeredRoom& room) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    using I = hn::Vec<decltype(whole)>;
    const std::size_t lanesPerVector = hn::Lanes(d);
    LayeredCounts counts;
    for (std::size_t i = 0; i < endCount; i += lanesPerVector) {
        const std::size_t count = std::min(lanesPerVector, endCount - i);
        const auto valid = hn::FirstN(whole, count);
        const auto validF = hn::RebindMask(d, valid);
        const I column = hn::IfThenElseZero(valid, hn::LoadU(whole, room.endColumns + i));
        EndPixels<hn::ScalableTag<float>> ends(
            d, tables, surfaces, hn::IfThenElseZero(validF, hn::LoadU(d, room.open.columns + i)),
            hn::IfThenElseZero(validF, hn::LoadU(d, room.open.shifts + i)), column);
        ends.lookBehindBorder();
        ends.lookBeyondSurface();
        ends.lookIntoGap();
        ends.chooseCover();
        ends.keepStill();
        const auto hard = hn::And(valid, ends.hard);

        HWY_ALIGN std::int32_t results[HWY_LANES(std::int32_t)];
        hn::Store(hn::IfThenElse(hard, hn::Set(whole, kSeeEnds), ends.place), whole, results);
        for (std::size_t k = 0; k < count; ++k)
            room.places[room.open.pixels[i + k]] = results[k];
        const ChosenLanes hardOnes(whole, hard);
        hardOnes.store(hn::Iota(whole, static_cast<std::int32_t>(i)), room.hard + counts.hard);
        hardOnes.store(column, room.hardColumns + counts.hard);
        counts.hard += hardOnes.count();
        const ChosenLanes mixed(whole, hn::And(hn::AndNot(hard, valid), ends.isMixed()));
        mixed.store(hn::LoadU(whole, room.open.pixels + i), room.mixed + counts.mixed);
        mixed.store(ends.cover, room.covers + counts.mixed);
        mixed.store(ends.part, room.parts + counts.mixed);
        counts.mixed += mixed.count();
    }
    return counts;
}

LayeredCounts layeredEndsOn(const LayeredTables& tables, const LayeredSurfaces& surfaces,
                            bool bounded, std::size_t openCount, const LayeredRoom& room) {
    for (std::size_t i = 0; i < hn::Lanes(hn::ScalableTag<float>()); ++i) {
        room.open.columns[openCount + i] = 0; // any pixel
        room.open.shifts[openCount + i] = 0;
    }
    const std::size_t endCount = placesByWalk(tables, bounded, openCount, room);
    return placesAtEnds(tables, surfaces, endCount, room);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(layeredGuessesOn);
HWY_EXPORT(layeredEndsOn);

std::size_t layeredGuesses(const LayeredTables& tables, const LayeredPixels& pixels,
                           const float* shifts, std::size_t first, std::size_t openCount,
                           const LayeredRoom& room) {
    return HWY_DYNAMIC_DISPATCH(layeredGuessesOn)(tables, pixels, shifts, first, openCount, room);
}

LayeredCounts layeredEnds(const LayeredTables& tables, const LayeredSurfaces& surfaces,
                          bool bounded, std::size_t openCount, const LayeredRoom& room) {
    return HWY_DYNAMIC_DISPATCH(layeredEndsOn)(tables, surfaces, bounded, openCount, room);
}

} // namespace altiro3D
#endif
