#include "views/fast/fast_row.hpp"

#include "views/fast/row_pixels.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/fast/fast_row.cpp"
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

// Samples at places in 1/32 px. One gather of four bytes per sample, of which two are used, limits
// the speed.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void gatherSamples(D whole, const std::uint8_t* plane, V place,
                              std::uint8_t* HWY_RESTRICT values) {
    const auto byte = hn::Set(whole, 255);
    const auto four = gatherBytes4(whole, plane, hn::ShiftRight<5>(place));
    const auto first = hn::And(four, byte);
    const auto second = hn::And(hn::ShiftRight<8>(four), byte);
    const auto product = hn::Mul(hn::Sub(second, first), hn::And(place, hn::Set(whole, 31)));
    const auto sum = hn::Add(hn::ShiftLeft<5>(first), product);
    storeBytes(whole, hn::ShiftRight<5>(hn::Add(sum, hn::Set(whole, 16))), values);
}

#if HWY_TARGET != HWY_SCALAR
// The same at places in 1/32 px from the start of a window.
template <int kTables, class V>
HWY_INLINE void windowSamples(const ByteWindow<kTables>& window, V place,
                              std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int16_t> narrow;
    const hn::Rebind<std::uint8_t, decltype(narrow)> bytes;
    const auto pairs = window.pairs(hn::ShiftRight<5>(place));
    const auto sum = mixPairs<5>(pairs, hn::And(place, hn::Set(narrow, 31)));
    // (sum + 16) >> 5, as (sum 2^10 + 2^14) >> 15
    const auto value = hn::MulFixedPoint15(sum, hn::Set(narrow, 1 << 10));
    hn::StoreU(hn::DemoteTo(bytes, value), bytes, values);
}
#endif

// Calls inWindow(window, first pixel, column where it starts) and elsewhere(first pixel) for runs
// of kWindowPixels pixels.
template <int kTables, class W, class E>
HWY_INLINE void forWindowsOf(const FastRow& row, [[maybe_unused]] const W& inWindow,
                             const E& elsewhere) {
    for (std::size_t begin = 0; begin < row.count; begin += kWindowPixels) {
        [[maybe_unused]] const std::int32_t from = row.windows[begin / kWindowPixels];
#if HWY_TARGET != HWY_SCALAR
        if (HWY_LIKELY(from >= 0)) {
            inWindow(ByteWindow<kTables>(row.plane + from), begin, from);
            continue;
        }
#endif
        elsewhere(begin);
    }
}

template <class W, class E>
HWY_INLINE void forWindows(const FastRow& row, const W& inWindow, const E& elsewhere) {
    switch (row.tables) {
    case 2:
        return forWindowsOf<2>(row, inWindow, elsewhere);
    case 3:
        return forWindowsOf<3>(row, inWindow, elsewhere);
    default:
        return forWindowsOf<4>(row, inWindow, elsewhere);
    }
}

// Arithmetic limits the speed: some 25 operations per vector of 16-bit lanes.
void fastWholeSamplesOn(const FastRow& row, const std::int16_t* HWY_RESTRICT shifts,
                        std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int16_t> d;
    const int last = 32 * (row.width - 1);
    forWindows(
        row,
        [&](const auto& window, std::size_t begin, std::int32_t from) HWY_ATTR {
            const auto left = hn::Set(d, static_cast<std::int16_t>(std::max(-32 * from, -32768)));
            const auto right =
                hn::Set(d, static_cast<std::int16_t>(std::min(last - 32 * from, 32767)));
            for (std::size_t i = begin; i < begin + kWindowPixels; i += hn::Lanes(d)) {
                const auto away =
                    hn::MulFixedPoint15(hn::LoadU(d, shifts + i), hn::LoadU(d, row.offsets + i));
                const auto place = hn::Add(hn::LoadU(d, row.inWindow + i), away);
                windowSamples(window, hn::Min(hn::Max(place, left), right), values + i);
            }
        },
        [&](std::size_t begin) HWY_ATTR {
            const hn::ScalableTag<std::int32_t> whole;
            const hn::Rebind<std::int16_t, decltype(whole)> narrow;
            const auto left = hn::Zero(whole);
            const auto right = hn::Set(whole, last);
            for (std::size_t i = begin; i < begin + kWindowPixels; i += hn::Lanes(whole)) {
                const auto away = hn::MulFixedPoint15(hn::LoadU(narrow, shifts + i),
                                                      hn::LoadU(narrow, row.offsets + i));
                const auto place =
                    hn::Add(hn::LoadU(whole, row.columns + i), hn::PromoteTo(whole, away));
                gatherSamples(whole, row.plane, hn::Min(hn::Max(place, left), right), values + i);
            }
        });
}

void fastSamplesAtOn(const FastRow& row, const float* HWY_RESTRICT places,
                     std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const std::size_t lanes = hn::Lanes(d);
    const auto placesAt = [&](std::size_t i) HWY_ATTR {
        return smallNearestInt(d, hn::Mul(hn::LoadU(d, places + i), hn::Set(d, 32.0F)));
    };
    forWindows(
        row,
        [&]([[maybe_unused]] const auto& window, [[maybe_unused]] std::size_t begin,
            [[maybe_unused]] std::int32_t from) HWY_ATTR {
#if HWY_TARGET != HWY_SCALAR
            const OrderedPack pack;
            const auto start = hn::Set(whole, 32 * from);
            for (std::size_t i = begin; i < begin + kWindowPixels; i += 2 * lanes)
                windowSamples(
                    window, pack(hn::Sub(placesAt(i), start), hn::Sub(placesAt(i + lanes), start)),
                    values + i);
#endif
        },
        [&](std::size_t begin) HWY_ATTR {
            for (std::size_t i = begin; i < begin + kWindowPixels; i += lanes)
                gatherSamples(whole, row.plane, placesAt(i), values + i);
        });
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(fastPlacesOn);
HWY_EXPORT(fastWholeSamplesOn);
HWY_EXPORT(fastSamplesAtOn);

void fastPlaces(const float* columns, const float* ownOffsets, const float* shifts,
                std::size_t count, const float* offsets, int width, int refinement, float* places) {
    HWY_DYNAMIC_DISPATCH(fastPlacesOn)
    (columns, ownOffsets, shifts, count, offsets, width, refinement, places);
}

void fastWholeSamples(const FastRow& row, const std::int16_t* shifts, std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(fastWholeSamplesOn)(row, shifts, values);
}

void fastSamplesAt(const FastRow& row, const float* places, std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(fastSamplesAtOn)(row, places, values);
}

} // namespace altiro3D
#endif
