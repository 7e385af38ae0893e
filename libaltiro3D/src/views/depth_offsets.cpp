#include "views/depth_offsets.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/depth_offsets.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// About ten operations per vector of doubles limit the speed.
void offsetsFromFocusOn(const float* HWY_RESTRICT depth, std::size_t count, double focus,
                        float* HWY_RESTRICT offsets) {
    std::size_t i = 0;
#if HWY_HAVE_FLOAT64 // WebAssembly's set of Highway has no doubles
    const hn::ScalableTag<double> wide;
    const hn::Rebind<float, decltype(wide)> d;
    const auto zero = hn::Zero(d);
    const auto one = hn::Set(d, 1.0F);
    const auto middle = hn::Set(d, static_cast<float>(focus));
    const auto exactMiddle = hn::Set(wide, focus);
    for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) {
        const auto value = hn::LoadU(d, depth + i);
        const auto positive = hn::IfThenElseZero(hn::Gt(value, zero), value); // not NaN
        const auto inRange = hn::Min(positive, one);
        const auto away = hn::DemoteTo(d, hn::Sub(hn::PromoteTo(wide, inRange), exactMiddle));
        hn::StoreU(hn::IfThenZeroElse(hn::Eq(inRange, middle), away), d, offsets + i);
    }
#endif
    for (; i < count; ++i)
        offsets[i] = offsetFromFocus(depth[i], focus);
}

// About ten operations per depth limit the speed.
bool wholeOffsetsOn(const float* HWY_RESTRICT depth, std::size_t count, double focus,
                    std::int32_t* HWY_RESTRICT offsets) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const auto zero = hn::Zero(d);
    const auto one = hn::Set(d, 1.0F);
    const auto middle = hn::Set(d, static_cast<float>(focus));
    const auto steps = hn::Set(d, kOffsetSteps);
    auto any = hn::Zero(whole);
    const auto convert = [&](const float* from, std::int32_t* to) HWY_ATTR {
        const auto value = hn::LoadU(d, from);
        const auto positive = hn::IfThenElseZero(hn::Gt(value, zero), value); // not NaN
        const auto away = hn::Mul(hn::Sub(hn::Min(positive, one), middle), steps);
        const auto offset = smallNearestInt(d, away);
        any = hn::Or(any, offset);
        hn::StoreU(offset, whole, to);
    };
    std::size_t i = 0;
    for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d))
        convert(depth + i, offsets + i);
    if (i < count) { // the depth has no padding
        HWY_ALIGN float rest[HWY_LANES(float)];
        for (std::size_t k = 0; k < hn::Lanes(d); ++k)
            rest[k] = depth[std::min(i + k, count - 1)];
        convert(rest, offsets + i);
    }
    return hn::AllTrue(whole, hn::Eq(any, hn::Zero(whole)));
}

// Three operations per vector limit the speed, where there are no steps.
void findStepsOn(const float* HWY_RESTRICT offsets, std::size_t count, double tear,
                 std::vector<int>& steps) {
    const hn::ScalableTag<float> d;
    steps.clear();
    const auto check = [&](std::size_t x) {
        const double step = static_cast<double>(offsets[x + 1]) - static_cast<double>(offsets[x]);
        if (std::abs(step) > tear) steps.push_back(static_cast<int>(x));
    };
    const auto nearly = hn::Set(d, static_cast<float>(tear * 0.999)); // less than any step
    std::size_t x = 0;
    for (; x + 1 + hn::Lanes(d) <= count; x += hn::Lanes(d)) {
        const auto step = hn::Sub(hn::LoadU(d, offsets + x + 1), hn::LoadU(d, offsets + x));
        if (HWY_LIKELY(hn::AllFalse(d, hn::Ge(hn::Abs(step), nearly)))) continue;
        for (std::size_t k = x; k < x + hn::Lanes(d); ++k)
            check(k);
    }
    for (; x + 1 < count; ++x)
        check(x);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(offsetsFromFocusOn);
HWY_EXPORT(wholeOffsetsOn);
HWY_EXPORT(findStepsOn);

void offsetsFromFocus(const float* depth, std::size_t count, double focus, float* offsets) {
    HWY_DYNAMIC_DISPATCH(offsetsFromFocusOn)(depth, count, focus, offsets);
}

bool wholeOffsets(const float* depth, std::size_t count, double focus, std::int32_t* offsets) {
    return HWY_DYNAMIC_DISPATCH(wholeOffsetsOn)(depth, count, focus, offsets);
}

void findSteps(const float* offsets, std::size_t count, double tear, std::vector<int>& steps) {
    HWY_DYNAMIC_DISPATCH(findStepsOn)(offsets, count, tear, steps);
}

} // namespace altiro3D
#endif
