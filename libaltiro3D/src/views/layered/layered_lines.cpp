// Pixels whose depth follows a line: layeredColumns() and layeredLines(). What all pixels show, on
// a line or not: layeredSamples().

#include "views/layered/layered_row.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/layered/layered_lines.cpp"
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
    const std::uint16_t* const mirroredFree = tables.freeUpTo + tables.stride + width - 1;
    for (std::size_t x = 0; x < width; ++x) {
        columns.to[x] = perUnit * static_cast<float>(tables.freeUpTo[x]);
        columns.lines.to[x] = tables.freeUpTo[x] >> 1;
    }
    for (std::size_t x = 0; x < width; ++x) {
        columns.from[x] = -perUnit * static_cast<float>(*(mirroredFree - x));
        columns.lines.from[x] = *(mirroredFree - x) >> 1;
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

HWY_EXPORT(layeredColumnsOn);
HWY_EXPORT(layeredLinesOn);
HWY_EXPORT(layeredSamplesOn);

void layeredColumns(const LayeredTables& tables, std::vector<float>& scratch,
                    LayeredColumns& columns) {
    HWY_DYNAMIC_DISPATCH(layeredColumnsOn)(tables, scratch, columns);
}

bool layeredLines(const LayeredLinePixels& pixels, LayeredRoom& room) {
    return HWY_DYNAMIC_DISPATCH(layeredLinesOn)(pixels, room);
}

void layeredSamples(const std::uint8_t* plane, const std::int32_t* places, std::size_t count,
                    std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(layeredSamplesOn)(plane, places, count, values);
}

} // namespace altiro3D
#endif
