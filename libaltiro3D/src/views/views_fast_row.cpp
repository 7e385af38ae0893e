#include "views/views_fast_row.hpp"

#include <algorithm>

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

// One gather of four bytes per sample, of which two are used, limits the speed; without a gather,
// arithmetic does.
void fastSamplesOn(const std::uint8_t* HWY_RESTRICT plane, const float* HWY_RESTRICT places,
                   const float* HWY_RESTRICT columns, int reach, std::size_t count,
                   std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const auto steps = hn::Set(d, 32.0F);
    const auto lowBits = hn::Set(whole, 31);
    const auto byte = hn::Set(whole, 255);
    const auto round = hn::Set(whole, 16);
    const std::size_t lanes = hn::Lanes(d);
    const auto gathered = [&](std::size_t i) {
        const auto place = smallNearestInt(d, hn::Mul(hn::LoadU(d, places + i), steps));
        const auto four = gatherBytes4(whole, plane, hn::ShiftRight<5>(place));
        const auto first = hn::And(four, byte);
        const auto second = hn::And(hn::ShiftRight<8>(four), byte);
        const auto product = hn::Mul(hn::Sub(second, first), hn::And(place, lowBits));
        const auto sum = hn::Add(hn::ShiftLeft<5>(first), product);
        storeBytes(whole, hn::ShiftRight<5>(hn::Add(sum, round)), values + i);
    };
#if ALTIRO3D_AVX512
    for (std::size_t begin = 0; begin < count; begin += kVectorsPerWindow * lanes) {
        const std::size_t end = std::min(begin + kVectorsPerWindow * lanes, count);
        const int from = windowOf(columns[begin], columns[end - 1], reach);
        if (from < 0) {
            for (std::size_t i = begin; i < end; i += lanes)
                gathered(i);
            continue;
        }
        const Window window(plane + from);
        const auto vFrom = hn::Set(whole, from);
        for (std::size_t i = begin; i < end; i += lanes) {
            const auto place = smallNearestInt(d, hn::Mul(hn::LoadU(d, places + i), steps));
            const auto index = hn::Sub(hn::ShiftRight<5>(place), vFrom);
            const auto sum =
                Window::mix<5>(window.pairs(Window::withNext(index)), hn::And(place, lowBits));
            storeBytes(whole, hn::ShiftRight<5>(hn::Add(sum, round)), values + i);
        }
    }
#else
    static_cast<void>(columns);
    static_cast<void>(reach);
    for (std::size_t i = 0; i < count; i += lanes)
        gathered(i);
#endif
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(fastPlacesOn);
HWY_EXPORT(fastSamplesOn);

void fastPlaces(const float* columns, const float* ownOffsets, const float* shifts,
                std::size_t count, const float* offsets, int width, int refinement, float* places) {
    HWY_DYNAMIC_DISPATCH(fastPlacesOn)
    (columns, ownOffsets, shifts, count, offsets, width, refinement, places);
}

void fastSamples(const std::uint8_t* plane, const float* places, const float* columns, int reach,
                 std::size_t count, std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(fastSamplesOn)(plane, places, columns, reach, count, values);
}

} // namespace altiro3D
#endif
