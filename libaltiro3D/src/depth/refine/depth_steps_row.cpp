#include "depth/refine/depth_steps_row.hpp"

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/refine/depth_steps_row.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Wholes = hn::RebindToSigned<Floats>;

// One vector of px. Arithmetic limits the speed, some 25 operations per tap and a table look-up.
// @tparam kInside all taps are columns of the row
// @tparam kSure row.sure is given
template <bool kInside, bool kSure>
HWY_INLINE void sumVector(const StepRow& row, const float* HWY_RESTRICT colorWeight, std::size_t x,
                          const StepSums& nearSide, const StepSums& farSide) {
    const Floats d;
    const Wholes whole;
    const auto middle = hn::LoadU(d, row.middle + x);
    const auto scale = hn::LoadU(d, row.scale + x);
    const auto blueGreen = hn::LoadU(whole, row.blueGreen + x);
    const auto red = hn::LoadU(whole, row.red + x);
    const auto lastStep = hn::Set(whole, kStepColors);
    [[maybe_unused]] const auto columns = hn::Iota(whole, static_cast<std::int32_t>(x));
    [[maybe_unused]] const auto end = hn::Set(whole, static_cast<std::int32_t>(row.count));
    auto nearDepth = hn::Zero(d);
    auto nearWeight = hn::Zero(d);
    auto nearColor = hn::Zero(d);
    auto farDepth = hn::Zero(d);
    auto farWeight = hn::Zero(d);
    auto farColor = hn::Zero(d);
    for (std::size_t i = 0; i < row.tapCount; ++i) {
        const StepTap& tap = row.taps[i];
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(x) + tap.offset;
        const auto depth = hn::LoadU(d, row.depth + at);
        const auto side = hn::Mul(hn::Sub(depth, middle), scale);
        auto weight = hn::Mul(hn::Mul(side, side), hn::Set(d, tap.weight));
        if (kSure) {
            const auto isClose = hn::Lt(hn::Abs(side), hn::Set(d, 2.0F));
            weight = hn::IfThenElseZero(isClose, hn::Mul(weight, hn::LoadU(d, row.sure + at)));
        }
        if (!kInside) {
            const auto column = hn::Add(columns, hn::Set(whole, tap.column));
            const auto inside = hn::AndNot(hn::Lt(column, hn::Zero(whole)), hn::Lt(column, end));
            weight = hn::IfThenElseZero(hn::RebindMask(d, inside), weight);
        }
        const auto square =
            hn::Add(squaresOfPair(whole, hn::LoadU(whole, row.blueGreen + at), blueGreen),
                    squaresOfPair(whole, hn::LoadU(whole, row.red + at), red));
        const auto step = hn::Min(hn::ShiftRight<kStepColorShift>(square), lastStep);
        const auto similarity = gatherFloats(d, colorWeight, step);
        const auto isNear = hn::Gt(side, hn::Zero(d));
        const auto ofNear = hn::IfThenElseZero(isNear, weight);
        const auto ofFar = hn::IfThenZeroElse(isNear, weight);
        nearDepth = hn::Add(nearDepth, hn::Mul(ofNear, depth));
        nearWeight = hn::Add(nearWeight, ofNear);
        nearColor = hn::Add(nearColor, hn::Mul(ofNear, similarity));
        farDepth = hn::Add(farDepth, hn::Mul(ofFar, depth));
        farWeight = hn::Add(farWeight, ofFar);
        farColor = hn::Add(farColor, hn::Mul(ofFar, similarity));
    }
    hn::StoreU(nearDepth, d, nearSide.depth + x);
    hn::StoreU(nearWeight, d, nearSide.weight + x);
    hn::StoreU(nearColor, d, nearSide.color + x);
    hn::StoreU(farDepth, d, farSide.depth + x);
    hn::StoreU(farWeight, d, farSide.weight + x);
    hn::StoreU(farColor, d, farSide.color + x);
}

template <bool kSure>
HWY_INLINE void sumRow(const StepRow& row, const float* HWY_RESTRICT colorWeight,
                       const StepSums& nearSide, const StepSums& farSide) {
    const std::size_t lanes = hn::Lanes(Floats());
    const auto reach = static_cast<std::size_t>(row.reach);
    for (std::size_t x = 0; x < row.count; x += lanes) {
        unsigned wanted = 0;
        for (std::size_t i = x; i < x + lanes; ++i)
            wanted |= row.wanted[i];
        if (wanted == 0) continue;
        if (x >= reach && x + lanes + reach <= row.count) {
            sumVector<true, kSure>(row, colorWeight, x, nearSide, farSide);
        } else {
            sumVector<false, kSure>(row, colorWeight, x, nearSide, farSide);
        }
    }
}

void sumStepSidesOn(const StepRow& row, const float* HWY_RESTRICT colorWeight,
                    const StepSums& nearSide, const StepSums& farSide) {
    if (row.sure != nullptr) {
        sumRow<true>(row, colorWeight, nearSide, farSide);
    } else {
        sumRow<false>(row, colorWeight, nearSide, farSide);
    }
}

// Reads the rows of the filter, writes one row. Loads limit the speed, two per weight.
void filterRowOn(const float* HWY_RESTRICT middle, const float* const* before,
                 const float* const* after, const float* HWY_RESTRICT weights, std::size_t reach,
                 std::size_t count, float* HWY_RESTRICT to) {
    const auto filter = [&](auto d, std::size_t x) HWY_ATTR {
        auto sum = hn::Mul(hn::Set(d, weights[0]), hn::LoadU(d, middle + x));
        for (std::size_t k = 1; k <= reach; ++k) {
            const auto both = hn::Add(hn::LoadU(d, before[k] + x), hn::LoadU(d, after[k] + x));
            sum = hn::Add(sum, hn::Mul(hn::Set(d, weights[k]), both));
        }
        hn::StoreU(sum, d, to + x);
    };
    const Floats d;
    std::size_t x = 0;
    for (; x + hn::Lanes(d) <= count; x += hn::Lanes(d))
        filter(d, x);
    for (; x < count; ++x)
        filter(hn::CappedTag<float, 1>(), x);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(sumStepSidesOn);
HWY_EXPORT(filterRowOn);

void sumStepSides(const StepRow& row, const float* colorWeight, const StepSums& nearSide,
                  const StepSums& farSide) {
    HWY_DYNAMIC_DISPATCH(sumStepSidesOn)(row, colorWeight, nearSide, farSide);
}

void filterRow(const float* middle, const float* const* before, const float* const* after,
               const float* weights, std::size_t reach, std::size_t count, float* to) {
    HWY_DYNAMIC_DISPATCH(filterRowOn)(middle, before, after, weights, reach, count, to);
}

} // namespace altiro3D
#endif
