// The values that the places of a row show: layeredSamples().

#include "views/views_layered_row.hpp"

#include "views/row_pixels.hpp"

#include <algorithm>
#include <cstring>

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

// One gather of four bytes per sample, of which two are used, limits the speed; without a gather,
// arithmetic does.
HWY_INLINE void gatherSamples(std::size_t begin, std::size_t end, const std::uint8_t* plane,
                              const std::int32_t* HWY_RESTRICT places,
                              std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int32_t> d;
    using I = hn::Vec<decltype(d)>;
    const I byte = hn::Set(d, 255);
    const I subColumns = hn::Set(d, (1 << kSubColumnBits) - 1);
    const I round = hn::Set(d, 1 << (kSubColumnBits - 1));
    for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
        const I place = hn::Max(hn::LoadU(d, places + i), hn::Zero(d));
        const I four = gatherBytes4(d, plane, hn::ShiftRight<kSubColumnBits>(place));
        const I first = hn::And(four, byte);
        const I second = hn::And(hn::ShiftRight<8>(four), byte);
        const I product = hn::Mul(hn::Sub(second, first), hn::And(place, subColumns));
        const I sum = hn::Add(hn::ShiftLeft<kSubColumnBits>(first), product);
        storeBytes(d, hn::ShiftRight<kSubColumnBits>(hn::Add(sum, round)), values + i);
    }
}

#if HWY_TARGET != HWY_SCALAR

// The values at places in 1/256 px from the start of a window.
template <int kTables, class V>
HWY_INLINE void sampleWindow(const ByteWindow<kTables>& window, V place,
                             std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int16_t> narrow;
    const hn::ScalableTag<std::uint16_t> bits;
    const hn::Rebind<std::uint8_t, decltype(narrow)> bytes;
    const auto byte = hn::Set(narrow, 255);
    const auto both = window.pairs(hn::ShiftRight<kSubColumnBits>(place));
    const auto first = hn::And(both, byte);
    const auto second = hn::BitCast(narrow, hn::ShiftRight<8>(hn::BitCast(bits, both)));
    // (difference part + 128) / 256, rounded down
    const auto change =
        hn::MulFixedPoint15(hn::ShiftLeft<7>(hn::Sub(second, first)), hn::And(place, byte));
    hn::StoreU(hn::DemoteTo(bytes, hn::Add(first, change)), bytes, values);
}

// As gatherSamples() for the kWindowPixels pixels from `begin`, from 16 kTables columns of the
// plane in registers, the first of which is `from`; the few places outside of them one by one.
// Arithmetic limits the speed: about thirty operations per vector of 16-bit lanes.
template <int kTables>
HWY_INLINE void windowSamples(std::int32_t from, std::size_t begin, std::size_t count,
                              const std::uint8_t* HWY_RESTRICT plane,
                              const std::int32_t* HWY_RESTRICT places,
                              std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int32_t> whole;
    const hn::ScalableTag<std::uint16_t> bits;
    const std::size_t lanes = hn::Lanes(whole);
    const OrderedPack pack;
    // the next column must also be in the window
    const auto lastPlace = hn::Set(bits, ((16 * kTables - 1) << kSubColumnBits) - 1);
    const ByteWindow<kTables> window(plane + from);
    const auto start = hn::Set(whole, from << kSubColumnBits);
    for (std::size_t i = begin; i < begin + kWindowPixels; i += 2 * lanes) {
        const auto place = pack(hn::Sub(hn::LoadU(whole, places + i), start),
                                hn::Sub(hn::LoadU(whole, places + i + lanes), start));
        sampleWindow(window, place, values + i);
        // places left of the window are large as well
        const auto away = hn::Gt(hn::BitCast(bits, place), lastPlace);
        if (HWY_LIKELY(hn::AllFalse(bits, away))) continue;
        alignas(8) std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(bits, away, bytes);
        std::uint64_t rest = 0;
        std::memcpy(&rest, bytes, sizeof rest);
        for (; rest != 0; rest &= rest - 1) {
            const std::size_t k = i + hwy::Num0BitsBelowLS1Bit_Nonzero64(rest);
            if (k < count && places[k] >= 0) // negative for kSeeEnds
                values[k] = static_cast<std::uint8_t>(sampleAt(plane, places[k]));
        }
    }
}

// The same for a block whose places are those of lines. Arithmetic limits the speed: some twenty
// operations per vector of 16-bit lanes.
template <int kTables>
HWY_INLINE void lineSamples(const LayeredPixels& pixels, std::size_t begin,
                            const std::uint8_t* HWY_RESTRICT plane,
                            std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int16_t> d;
    const std::size_t block = begin / kWindowPixels;
    const std::int32_t from = pixels.windows[block];
    const ByteWindow<kTables> window(plane + from);
    const auto start = hn::Set(
        d, static_cast<std::int16_t>((pixels.starts[block] - from) * (1 << kSubColumnBits)));
    for (std::size_t i = begin; i < begin + kWindowPixels; i += hn::Lanes(d)) {
        const auto column = hn::Add(hn::LoadU(d, pixels.inBlock + i), start);
        sampleWindow(window, hn::Add(column, hn::LoadU(d, pixels.away + i)), values + i);
    }
}

// First of 64 columns that hold what all of kWindowPixels places read; -1 if there are none, or no
// place.
HWY_INLINE std::int32_t windowOfPlaces(const std::int32_t* HWY_RESTRICT places) {
    const hn::ScalableTag<std::int32_t> d;
    const hn::RebindToUnsigned<decltype(d)> asUnsigned;
    auto most = hn::Zero(d);
    auto least = hn::Set(asUnsigned, INT32_MAX); // kSeeEnds is larger as an unsigned number
    for (std::size_t i = 0; i < kWindowPixels; i += hn::Lanes(d)) {
        const auto place = hn::LoadU(d, places + i);
        most = hn::Max(most, place);
        least = hn::Min(least, hn::BitCast(asUnsigned, place));
    }
    const auto from = static_cast<std::int32_t>(hn::GetLane(hn::MinOfLanes(asUnsigned, least)) >>
                                                static_cast<unsigned>(kSubColumnBits));
    const std::int32_t last = hn::GetLane(hn::MaxOfLanes(d, most)) >> kSubColumnBits;
    return from <= last && last - from <= 16 * 4 - 2 ? from : -1;
}
#endif

// As gatherSamples() for all pixels, from windows where they fit.
template <int kTables>
void layeredSamplesBy(const LayeredPixels& pixels, const std::uint8_t* HWY_RESTRICT plane,
                      const std::int32_t* HWY_RESTRICT places, std::uint8_t* HWY_RESTRICT values) {
#if HWY_TARGET == HWY_SCALAR
    gatherSamples(0, pixels.count, plane, places, values);
#else
    for (std::size_t begin = 0; begin < pixels.count; begin += kWindowPixels) {
        const std::size_t block = begin / kWindowPixels;
        const std::int32_t from = pixels.fixed[block];
        if (HWY_LIKELY(pixels.windows[block] != kOpenBlock)) {
            if (HWY_LIKELY(from >= 0)) {
                lineSamples<kTables>(pixels, begin, plane, values);
            } else {
                lineSamples<4>(pixels, begin, plane, values);
            }
            continue;
        }
        if (from >= 0) {
            windowSamples<kTables>(from, begin, pixels.count, plane, places, values);
            continue;
        }
        const std::int32_t found = windowOfPlaces(places + begin);
        if (found >= 0) {
            windowSamples<4>(found, begin, pixels.count, plane, places, values);
        } else {
            gatherSamples(begin, begin + kWindowPixels, plane, places, values);
        }
    }
#endif
}

void layeredSamplesOn(const LayeredPixels& pixels, const std::uint8_t* HWY_RESTRICT plane,
                      const std::int32_t* HWY_RESTRICT places, std::uint8_t* HWY_RESTRICT values) {
    switch (pixels.tables) {
    case 2:
        return layeredSamplesBy<2>(pixels, plane, places, values);
    case 3:
        return layeredSamplesBy<3>(pixels, plane, places, values);
    default:
        return layeredSamplesBy<4>(pixels, plane, places, values);
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(layeredSamplesOn);

void layeredSamples(const LayeredPixels& pixels, const std::uint8_t* plane,
                    const std::int32_t* places, std::uint8_t* values) {
    HWY_DYNAMIC_DISPATCH(layeredSamplesOn)(pixels, plane, places, values);
}

} // namespace altiro3D
#endif
