#include "base/pixel_rows.hpp"

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "base/pixel_rows.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

void interleaveRowOn(const std::uint8_t* HWY_RESTRICT blue, const std::uint8_t* HWY_RESTRICT green,
                     const std::uint8_t* HWY_RESTRICT red, std::size_t count,
                     std::uint8_t* HWY_RESTRICT bgr) {
    const hn::ScalableTag<std::uint8_t> d;
    const std::size_t lanes = hn::Lanes(d);
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes)
        hn::StoreInterleaved3(hn::LoadU(d, blue + i), hn::LoadU(d, green + i),
                              hn::LoadU(d, red + i), d, bgr + 3 * i);
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

HWY_EXPORT(interleaveRowOn);
HWY_EXPORT(splitRowOn);

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
