#include "native/shift_kernels.hpp"

#include <cstring>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "native/shift_kernels.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// A float without its lowest 15 bits: 9 are left, so its product with a whole number below 2^15 is
// exact.
float upperBits(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    bits &= ~std::uint32_t{0x7fff};
    std::memcpy(&value, &bits, sizeof bits);
    return value;
}

// Multiplication by the reciprocal of N - 1 in two parts: the upper one has so few bits that its
// product is exact. The sum is the quotient correctly rounded for each view of up to 235 (tried
// all).
constexpr int kMaxViewsByReciprocal = 128;

// Arithmetic limits the speed, or one division per sub-pixel.
void shiftsOfViewsOn(const std::uint16_t* HWY_RESTRICT views, std::size_t count, int viewCount,
                     float halfParallax, float* HWY_RESTRICT shifts) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const hn::Rebind<std::uint16_t, decltype(d)> narrow;
    const auto last = hn::Set(whole, viewCount - 1);
    const auto half = hn::Set(d, halfParallax);
    const auto forAll = [&](const auto& divided) HWY_ATTR {
        for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
            const auto view = hn::PromoteTo(whole, hn::LoadU(narrow, views + i));
            const auto twice = hn::ConvertTo(d, hn::Sub(hn::Add(view, view), last));
            hn::StoreU(hn::Mul(divided(twice), half), d, shifts + i);
        }
    };
    const double divisor = viewCount > 1 ? viewCount - 1 : 1;
    if (viewCount <= kMaxViewsByReciprocal) {
        const float upperPart = upperBits(static_cast<float>(1 / divisor));
        const auto upper = hn::Set(d, upperPart);
        const auto lower = hn::Set(d, static_cast<float>(1 / divisor - double{upperPart}));
        forAll([&](auto twice)
                   HWY_ATTR { return hn::Add(hn::Mul(twice, upper), hn::Mul(twice, lower)); });
    } else {
        const auto all = hn::Set(d, static_cast<float>(divisor));
        forAll([&](auto twice) HWY_ATTR { return hn::Div(twice, all); });
    }
}

void shiftsOfPhasesOn(const std::uint32_t* HWY_RESTRICT columns, std::uint32_t row,
                      std::size_t count, int viewCount, float halfParallax,
                      float* HWY_RESTRICT shifts) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const hn::RebindToUnsigned<decltype(d)> bits;
    const auto vRow = hn::Set(bits, row);
    // N / (N - 1) (2 z - 1), rounded to 24 bits
    const double stretch = viewCount > 1 ? viewCount / (viewCount - 1.0) : 0;
    const auto scale = hn::Set(d, static_cast<float>(stretch * 0x1p-23));
    const auto middle = hn::Set(whole, 1 << 23);
    const auto one = hn::Set(d, 1.0F);
    const auto half = hn::Set(d, halfParallax);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto phase = hn::Add(hn::LoadU(bits, columns + i), vRow);
        const auto place = hn::Sub(hn::BitCast(whole, hn::ShiftRight<8>(phase)), middle);
        const auto wide = hn::Mul(hn::ConvertTo(d, place), scale);
        const auto position = hn::Max(hn::Min(wide, one), hn::Neg(one));
        hn::StoreU(hn::Mul(position, half), d, shifts + i);
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(shiftsOfViewsOn);
HWY_EXPORT(shiftsOfPhasesOn);

void shiftsOfViews(const std::uint16_t* views, std::size_t count, int viewCount, float halfParallax,
                   float* shifts) {
    HWY_DYNAMIC_DISPATCH(shiftsOfViewsOn)(views, count, viewCount, halfParallax, shifts);
}

void shiftsOfPhases(const std::uint32_t* columns, std::uint32_t row, std::size_t count,
                    int viewCount, float halfParallax, float* shifts) {
    HWY_DYNAMIC_DISPATCH(shiftsOfPhasesOn)(columns, row, count, viewCount, halfParallax, shifts);
}

} // namespace altiro3D
#endif
