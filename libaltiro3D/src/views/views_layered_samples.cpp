// The values that the places of a row show: layeredSamples().

#include "views/views_layered_row.hpp"

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/views_layered_samples.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

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

HWY_EXPORT(layeredSamplesOn);

void layeredSamples(const std::uint8_t* plane, const std::int32_t* places, std::size_t count,
                    std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(layeredSamplesOn)(plane, places, count, values);
}

} // namespace altiro3D
#endif
