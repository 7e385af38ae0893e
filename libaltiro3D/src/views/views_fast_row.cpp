#include "views/views_fast_row.hpp"

#include "views/row_pixels.hpp"

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/views_fast_row.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// Loads and stores limit the speed; with refinement, one gather of two offsets per step.
void fastPlacesOn(const float* HWY_RESTRICT columns, const float* HWY_RESTRICT ownOffsets,
                  const float* HWY_RESTRICT shifts, std::size_t count,
                  const float* HWY_RESTRICT offsets, int width, int refinement,
                  float* HWY_RESTRICT places) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const auto left = hn::Zero(d);
    const auto right = hn::Set(d, static_cast<float>(width - 1));
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto column = hn::LoadU(d, columns + i);
        const auto shift = hn::LoadU(d, shifts + i);
        auto place = hn::Add(column, hn::Mul(shift, hn::LoadU(d, ownOffsets + i)));
        place = hn::Min(hn::Max(place, left), right);
        for (int step = 0; step < refinement; ++step) {
            const auto before = hn::ConvertTo(whole, place);
            const auto both = gatherBytes8(whole, offsets, hn::ShiftLeft<2>(before));
            const auto first = hn::BitCast(d, both.low);
            const auto second = hn::BitCast(d, both.high);
            const auto part = hn::Sub(place, hn::ConvertTo(d, before));
            const auto offset = hn::Add(first, hn::Mul(part, hn::Sub(second, first)));
            place = hn::Add(column, hn::Mul(shift, offset));
            place = hn::Min(hn::Max(place, left), right);
        }
        hn::StoreU(place, d, places + i);
    }
}

// Samples at places, which `placesAt(i)` gives as floats in 1/32 px. Without a window, one gather
// of four bytes per sample, of which two are used, limits the speed; without a gather, arithmetic
// does.
template <class P>
HWY_INLINE void gatherSamples(const FastRow& row, std::size_t begin, std::size_t end,
                              const P& placesAt, std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const auto byte = hn::Set(whole, 255);
    const auto round = hn::Set(whole, 16);
    for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
        const auto place = smallNearestInt(d, placesAt(i));
        const auto four = gatherBytes4(whole, row.plane, hn::ShiftRight<5>(place));
        const auto first = hn::And(four, byte);
        const auto second = hn::And(hn::ShiftRight<8>(four), byte);
        const auto product = hn::Mul(hn::Sub(second, first), hn::And(place, hn::Set(whole, 31)));
        const auto sum = hn::Add(hn::ShiftLeft<5>(first), product);
        storeBytes(whole, hn::ShiftRight<5>(hn::Add(sum, round)), values + i);
    }
}

// The same, from windows of the row in registers. Arithmetic limits the speed: some 45 operations
// per vector of 16-bit lanes.
template <int kTables, class P>
HWY_INLINE void windowSamples(const FastRow& row, const P& placesAt,
                              std::uint8_t* HWY_RESTRICT values) {
#if HWY_TARGET == HWY_SCALAR
    gatherSamples(row, 0, row.count, placesAt, values);
#else
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const hn::ScalableTag<std::int16_t> narrow;
    const hn::Rebind<std::uint8_t, decltype(narrow)> bytes;
    const std::size_t lanes = hn::Lanes(d);
    const OrderedPack pack;
    for (std::size_t begin = 0; begin < row.count; begin += kWindowPixels) {
        const std::int32_t from = row.windows[begin / kWindowPixels];
        if (HWY_UNLIKELY(from < 0)) {
            gatherSamples(row, begin, begin + kWindowPixels, placesAt, values);
            continue;
        }
        const ByteWindow<kTables> window(row.plane + from);
        // 2^23 + 2^22 + place has the place in its lowest bits
        const auto magic = hn::Set(d, 0x1.8p23F);
        const auto start = hn::Add(hn::BitCast(whole, magic), hn::Set(whole, 32 * from));
        for (std::size_t i = begin; i < begin + kWindowPixels; i += 2 * lanes) {
            const auto low = hn::BitCast(whole, hn::Add(placesAt(i), magic));
            const auto high = hn::BitCast(whole, hn::Add(placesAt(i + lanes), magic));
            const auto place = pack(hn::Sub(low, start), hn::Sub(high, start));
            const auto pairs = window.pairs(hn::ShiftRight<5>(place));
            const auto sum = mixPairs<5>(pairs, hn::And(place, hn::Set(narrow, 31)));
            const auto value = hn::ShiftRight<5>(hn::Add(sum, hn::Set(narrow, 16)));
            hn::StoreU(hn::DemoteTo(bytes, value), bytes, values + i);
        }
    }
#endif
}

template <class P>
HWY_INLINE void samples(const FastRow& row, const P& placesAt, std::uint8_t* values) {
    switch (row.tables) {
    case 2:
        return windowSamples<2>(row, placesAt, values);
    case 3:
        return windowSamples<3>(row, placesAt, values);
    default:
        return windowSamples<4>(row, placesAt, values);
    }
}

// The factors are powers of two times those of fastPlacesOn(), so rounding is the same.
void fastSamplesOn(const FastRow& row, const float* HWY_RESTRICT shifts,
                   std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<float> d;
    const auto left = hn::Zero(d);
    const auto right = hn::Set(d, 32.0F * static_cast<float>(row.width - 1));
    samples(
        row,
        [&](std::size_t i) HWY_ATTR {
            const auto away = hn::Mul(hn::LoadU(d, shifts + i), hn::LoadU(d, row.ownOffsets + i));
            const auto place = hn::Add(hn::LoadU(d, row.columns + i), away);
            return hn::Min(hn::Max(place, left), right);
        },
        values);
}

void fastSamplesAtOn(const FastRow& row, const float* HWY_RESTRICT places,
                     std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<float> d;
    const auto steps = hn::Set(d, 32.0F);
    samples(
        row, [&](std::size_t i) HWY_ATTR { return hn::Mul(hn::LoadU(d, places + i), steps); },
        values);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(fastPlacesOn);
HWY_EXPORT(fastSamplesOn);
HWY_EXPORT(fastSamplesAtOn);

void fastPlaces(const float* columns, const float* ownOffsets, const float* shifts,
                std::size_t count, const float* offsets, int width, int refinement, float* places) {
    HWY_DYNAMIC_DISPATCH(fastPlacesOn)
    (columns, ownOffsets, shifts, count, offsets, width, refinement, places);
}

void fastSamples(const FastRow& row, const float* shifts, std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(fastSamplesOn)(row, shifts, values);
}

void fastSamplesAt(const FastRow& row, const float* places, std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(fastSamplesAtOn)(row, places, values);
}

} // namespace altiro3D
#endif
