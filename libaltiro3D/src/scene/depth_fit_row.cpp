#include "scene/depth_fit_row.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scene/depth_fit_row.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Wholes = hn::RebindToSigned<Floats>;
using F = hn::Vec<Floats>;
using I = hn::Vec<Wholes>;

// Reads the taps of neighbouring px. If the guide has more columns than samples, the taps are so
// close together that one load is enough.
class Taps {
  public:
    HWY_INLINE explicit Taps(const std::int32_t* taps)
        : first_(*taps), taps_(hn::LoadU(Wholes(), taps)),
          inside_(hn::Sub(taps_, hn::Set(Wholes(), first_))) {}

    HWY_INLINE bool near() const {
        const auto lanes = static_cast<std::int32_t>(hn::Lanes(Wholes()));
        return hn::AllTrue(Wholes(), hn::Lt(inside_, hn::Set(Wholes(), lanes)));
    }

    // @tparam kNear near()
    template <bool kNear, typename T, class D = hn::ScalableTag<T>>
    HWY_INLINE hn::Vec<D> read(const T* row) const {
        const D d;
        if (kNear) {
            return hn::TableLookupLanes(hn::LoadU(d, row + first_), hn::IndicesFromVec(d, inside_));
        }
        return hn::BitCast(d, gatherBytes4(Wholes(), row, hn::ShiftLeft<2>(taps_)));
    }

  private:
    std::int32_t first_;
    I taps_;
    I inside_; // relative to the first tap
};

// One vector of px. The 16 table look-ups per px limit the speed.
template <bool kNear>
HWY_INLINE F fitVector(const Taps& taps, const FitSamples& samples, const F* columnWeight,
                       const F* rowWeight, const float* colorWeight, I blueGreen, I red) {
    const Floats d;
    const Wholes whole;
    const I lastStep = hn::Set(whole, kColorSteps);
    F sum[kFitTaps] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    F weights[kFitTaps] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    std::ptrdiff_t row = 0;
    for (std::size_t i = 0; i < kFitTaps; ++i, row += samples.stride) {
        for (std::size_t j = 0; j < kFitTaps; ++j) {
            const std::ptrdiff_t at = row + static_cast<std::ptrdiff_t>(j);
            const I square =
                hn::Add(squaresOfPair(whole, taps.read<kNear>(samples.blueGreen + at), blueGreen),
                        squaresOfPair(whole, taps.read<kNear>(samples.red + at), red));
            const I step = hn::Min(hn::ShiftRight<kColorShift>(square), lastStep);
            const F weight =
                hn::Mul(gatherFloats(d, colorWeight, step), hn::Mul(rowWeight[i], columnWeight[j]));
            const F depth = taps.read<kNear>(samples.depth + at);
            sum[j] = hn::Add(sum[j], hn::Mul(weight, depth));
            weights[j] = hn::Add(weights[j], weight);
        }
    }
    const F mean =
        hn::Div(hn::Add(hn::Add(sum[0], sum[1]), hn::Add(sum[2], sum[3])),
                hn::Add(hn::Add(weights[0], weights[1]), hn::Add(weights[2], weights[3])));
    // Rounding must not leave the range of the samples: constant depth stays constant.
    const F least = taps.read<kNear>(samples.least);
    const F most = taps.read<kNear>(samples.most);
    return hn::Min(hn::Max(mean, least), most);
}

void fitDepthRowOn(const FitSamples& samples, const FitColumns& columns,
                   const float* HWY_RESTRICT rowWeight, const float* HWY_RESTRICT colorWeight,
                   const FitGuide& guide, std::size_t count, float* HWY_RESTRICT fitted) {
    const Floats d;
    const Wholes whole;
    const hn::Rebind<std::uint8_t, Floats> bytes;
    const std::size_t lanes = hn::Lanes(d);
    const F rows[kFitTaps] = {hn::Set(d, rowWeight[0]), hn::Set(d, rowWeight[1]),
                              hn::Set(d, rowWeight[2]), hn::Set(d, rowWeight[3])};
    for (std::size_t x = 0; x < count; x += lanes) {
        const I blue = hn::PromoteTo(whole, hn::LoadU(bytes, guide.blue + x));
        const I green = hn::PromoteTo(whole, hn::LoadU(bytes, guide.green + x));
        const I red = hn::PromoteTo(whole, hn::LoadU(bytes, guide.red + x));
        const I blueGreen = hn::Or(blue, hn::ShiftLeft<16>(green));
        const F weights[kFitTaps] = {
            hn::LoadU(d, columns.weight[0] + x), hn::LoadU(d, columns.weight[1] + x),
            hn::LoadU(d, columns.weight[2] + x), hn::LoadU(d, columns.weight[3] + x)};
        const Taps taps(columns.tap + x);
        const F result =
            taps.near()
                ? fitVector<true>(taps, samples, weights, rows, colorWeight, blueGreen, red)
                : fitVector<false>(taps, samples, weights, rows, colorWeight, blueGreen, red);
        if (x + lanes <= count) {
            hn::StoreU(result, d, fitted + x);
        } else {
            HWY_ALIGN float last[HWY_LANES(float)];
            hn::Store(result, d, last);
            std::copy_n(last, count - x, fitted + x);
        }
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(fitDepthRowOn);

void fitDepthRow(const FitSamples& samples, const FitColumns& columns, const float* rowWeight,
                 const float* colorWeight, const FitGuide& guide, std::size_t count,
                 float* fitted) {
    HWY_DYNAMIC_DISPATCH(fitDepthRowOn)
    (samples, columns, rowWeight, colorWeight, guide, count, fitted);
}

} // namespace altiro3D
#endif
