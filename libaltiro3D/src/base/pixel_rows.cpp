#include "base/pixel_rows.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "base/pixel_rows.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// The columns of neighbouring pixels lie close together: one vector of values holds most of them,
// and each pixel picks its own.
template <class D, class T, class U>
HWY_INLINE void pickColumnsAs(D d, const std::int32_t* HWY_RESTRICT columns, std::size_t count,
                              const T* HWY_RESTRICT values, U* HWY_RESTRICT out) {
    const hn::RebindToSigned<D> whole;
    const hn::Rebind<U, D> result;
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    std::size_t i = 0;
    for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) {
        const auto [from, to] = std::minmax(columns[i], columns[i + hn::Lanes(d) - 1]);
        if (to - from >= lanes) {
            for (std::size_t k = i; k < i + hn::Lanes(d); ++k)
                out[k] = static_cast<U>(values[columns[k]]);
            continue;
        }
        const auto index = hn::Sub(hn::LoadU(whole, columns + i), hn::Set(whole, from));
        const auto picked = lanesAt(d, hn::LoadU(d, values + from), index);
        if constexpr (sizeof(U) == sizeof(T)) {
            hn::StoreU(picked, result, out + i);
        } else {
            hn::StoreU(hn::DemoteTo(result, picked), result, out + i);
        }
    }
    for (; i < count; ++i)
        out[i] = static_cast<U>(values[columns[i]]);
}

void pickFloatsOn(const std::int32_t* columns, std::size_t count, const float* values, float* out) {
    pickColumnsAs(hn::ScalableTag<float>(), columns, count, values, out);
}

void pickShortsOn(const std::int32_t* columns, std::size_t count, const std::int32_t* values,
                  std::int16_t* out) {
    pickColumnsAs(hn::ScalableTag<std::int32_t>(), columns, count, values, out);
}

void interleaveRowOn(const std::uint8_t* HWY_RESTRICT blue, const std::uint8_t* HWY_RESTRICT green,
                     const std::uint8_t* HWY_RESTRICT red, std::size_t count,
                     std::uint8_t* HWY_RESTRICT bgr) {
    const hn::ScalableTag<std::uint8_t> d;
    const std::size_t lanes = hn::Lanes(d);
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
        hn::StoreInterleaved3(hn::LoadU(d, blue + i), hn::LoadU(d, green + i),
                              hn::LoadU(d, red + i), d, bgr + 3 * i);
    }
    for (; i < count; ++i) {
        bgr[3 * i] = blue[i];
        bgr[3 * i + 1] = green[i];
        bgr[3 * i + 2] = red[i];
    }
}

void splitRowOn(const std::uint8_t* HWY_RESTRICT bgr, std::size_t count,
                std::uint8_t* HWY_RESTRICT blue, std::uint8_t* HWY_RESTRICT green,
                std::uint8_t* HWY_RESTRICT red) {
    const hn::ScalableTag<std::uint8_t> d;
    const std::size_t lanes = hn::Lanes(d);
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
        hn::Vec<decltype(d)> b;
        hn::Vec<decltype(d)> g;
        hn::Vec<decltype(d)> r;
        hn::LoadInterleaved3(d, bgr + 3 * i, b, g, r);
        hn::StoreU(b, d, blue + i);
        hn::StoreU(g, d, green + i);
        hn::StoreU(r, d, red + i);
    }
    for (; i < count; ++i) {
        blue[i] = bgr[3 * i];
        green[i] = bgr[3 * i + 1];
        red[i] = bgr[3 * i + 2];
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(pickFloatsOn);
HWY_EXPORT(pickShortsOn);
HWY_EXPORT(interleaveRowOn);
HWY_EXPORT(splitRowOn);

void pickColumns(const std::int32_t* columns, std::size_t count, const float* values, float* out) {
    HWY_DYNAMIC_DISPATCH(pickFloatsOn)(columns, count, values, out);
}

void pickColumns(const std::int32_t* columns, std::size_t count, const std::int32_t* values,
                 std::int16_t* out) {
    HWY_DYNAMIC_DISPATCH(pickShortsOn)(columns, count, values, out);
}

void interleaveRow(const std::uint8_t* blue, const std::uint8_t* green, const std::uint8_t* red,
                   std::size_t count, std::uint8_t* bgr) {
    HWY_DYNAMIC_DISPATCH(interleaveRowOn)(blue, green, red, count, bgr);
}

void splitRow(const std::uint8_t* bgr, std::size_t count, std::uint8_t* blue, std::uint8_t* green,
              std::uint8_t* red) {
    HWY_DYNAMIC_DISPATCH(splitRowOn)(bgr, count, blue, green, red);
}

} // namespace altiro3D
#endif
