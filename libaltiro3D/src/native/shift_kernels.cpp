#include "native/shift_kernels.hpp"

#include "views/view_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "native/shift_kernels.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// One division per sub-pixel limits the speed.
void shiftsOfViewsOn(const std::uint16_t* HWY_RESTRICT views, std::size_t count, int viewCount,
                     float halfParallax, float* HWY_RESTRICT shifts) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const hn::Rebind<std::uint16_t, decltype(d)> narrow;
    const auto last = hn::Set(whole, viewCount - 1);
    const auto half = hn::Set(d, halfParallax);
    const auto divisor = hn::Set(d, static_cast<float>(std::max(viewCount - 1, 1)));
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto view = hn::PromoteTo(whole, hn::LoadU(narrow, views + i));
        const auto twice = hn::ConvertTo(d, hn::Sub(hn::Add(view, view), last));
        hn::StoreU(hn::Mul(hn::Div(twice, divisor), half), d, shifts + i);
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

// Loads and stores limit the speed.
void wholeShiftsOfViewsOn(const std::uint16_t* HWY_RESTRICT views, std::size_t count,
                          std::int16_t last, std::int16_t perStep, std::int16_t fraction,
                          std::int16_t* HWY_RESTRICT shifts) {
    const hn::ScalableTag<std::int16_t> d;
    const hn::RebindToUnsigned<decltype(d)> bits;
    const auto vLast = hn::Set(d, last);
    const auto vPerStep = hn::Set(d, perStep);
    const auto vFraction = hn::Set(d, fraction);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto view = hn::BitCast(d, hn::LoadU(bits, views + i));
        const auto steps = hn::Sub(hn::Add(view, view), vLast);
        const auto part = hn::MulFixedPoint15(steps, vFraction);
        hn::StoreU(hn::Add(hn::Mul(steps, vPerStep), part), d, shifts + i);
    }
}

// Loads and stores limit the speed.
void wholeShiftsOfPhasesOn(const std::uint16_t* HWY_RESTRICT columnHalves, std::uint16_t row,
                           std::size_t count, std::int16_t scale, std::int16_t largest,
                           std::int16_t* HWY_RESTRICT shifts) {
    const hn::ScalableTag<std::int16_t> d;
    const hn::RebindToUnsigned<decltype(d)> bits;
    // moves the phase 1/2 to 0
    const auto vRow = hn::Set(bits, static_cast<std::uint16_t>(row + 0x8000));
    const auto vScale = hn::Set(d, scale);
    const auto right = hn::Set(d, largest);
    const auto left = hn::Neg(right);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto place = hn::BitCast(d, hn::Add(hn::LoadU(bits, columnHalves + i), vRow));
        const auto wide = hn::MulFixedPoint15(place, vScale);
        hn::StoreU(hn::Max(hn::Min(wide, right), left), d, shifts + i);
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(shiftsOfViewsOn);
HWY_EXPORT(shiftsOfPhasesOn);
HWY_EXPORT(wholeShiftsOfViewsOn);
HWY_EXPORT(wholeShiftsOfPhasesOn);

void shiftsOfViews(const std::uint16_t* views, std::size_t count, int viewCount, float halfParallax,
                   float* shifts) {
    HWY_DYNAMIC_DISPATCH(shiftsOfViewsOn)(views, count, viewCount, halfParallax, shifts);
}

void shiftsOfPhases(const std::uint32_t* columns, std::uint32_t row, std::size_t count,
                    int viewCount, float halfParallax, float* shifts) {
    HWY_DYNAMIC_DISPATCH(shiftsOfPhasesOn)(columns, row, count, viewCount, halfParallax, shifts);
}

WholeShifts::WholeShifts(const std::vector<double>& shifts, double steps) : ofView_(shifts.size()) {
    std::transform(shifts.begin(), shifts.end(), ofView_.begin(),
                   [steps](double shift) { return wholeShift(shift, steps); });
    const auto last = static_cast<int>(shifts.size()) - 1;
    // steps of up to 2^10 keep the error of the fraction small, so almost every parallax succeeds
    constexpr int kMaxSteps = 1 << 10;
    constexpr double kLargest = 1 << 14;
    if (last > kMaxSteps || shifts.back() * steps > kLargest) return;
    const double perStep = last > 0 ? shifts.back() * steps / last : 0;
    const double whole = std::nearbyint(perStep);
    perStep_ = static_cast<std::int16_t>(whole);
    fraction_ = static_cast<std::int16_t>(
        std::clamp(std::round((perStep - whole) * 32768), -32767.0, 32767.0));
    std::vector<std::uint16_t> views = paddedRow<std::uint16_t>(shifts.size());
    std::iota(views.begin(), views.end(), std::uint16_t{0});
    std::vector<std::int16_t> products = paddedRow<std::int16_t>(shifts.size());
    byProduct_ = true;
    ofViews(views.data(), shifts.size(), products.data());
    byProduct_ = std::equal(ofView_.begin(), ofView_.end(), products.begin());
}

void WholeShifts::ofViews(const std::uint16_t* views, std::size_t count,
                          std::int16_t* shifts) const {
    if (!byProduct_) {
        for (std::size_t i = 0; i < count; ++i)
            shifts[i] = ofView_[views[i]];
        return;
    }
    const auto last = static_cast<std::int16_t>(ofView_.size() - 1);
    HWY_DYNAMIC_DISPATCH(wholeShiftsOfViewsOn)(views, count, last, perStep_, fraction_, shifts);
}

void wholeShiftsOfPhases(const std::uint16_t* columnHalves, std::uint32_t row, std::size_t count,
                         int viewCount, float halfParallax, double steps, std::int16_t* shifts) {
    const double stretch = viewCount > 1 ? viewCount / (viewCount - 1.0) : 0;
    const double largest = static_cast<double>(halfParallax) * steps;
    const auto scale = static_cast<std::int16_t>(std::min(std::lround(largest * stretch), 32767L));
    // the halves of column and row are each too small by half a step on average: adds one
    const auto half = static_cast<std::uint16_t>((row >> 16) + 1);
    HWY_DYNAMIC_DISPATCH(wholeShiftsOfPhasesOn)
    (columnHalves, half, count, scale, wholeShift(static_cast<double>(halfParallax), steps),
     shifts);
}

} // namespace altiro3D
#endif
