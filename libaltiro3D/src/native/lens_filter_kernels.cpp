#include "native/lens_filter_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "native/lens_filter_kernels.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// One load, multiplication and addition per weight and vector limits the speed. Sums are not fused,
// so that they are the same on any processor.
void weightedSumsOn(const float* const* rows, const cv::Mat& weights, std::size_t count,
                    float* HWY_RESTRICT sums) {
    const hn::ScalableTag<float> d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t i = 0; i < count; i += 4 * lanes) {
        auto first = hn::Zero(d);
        auto second = hn::Zero(d);
        auto third = hn::Zero(d);
        auto fourth = hn::Zero(d);
        for (int y = 0; y < weights.rows; ++y) {
            const float* const values = rows[y] + i;
            const auto* const weight = weights.ptr<float>(y);
            for (int x = 0; x < weights.cols; ++x) {
                const auto w = hn::Set(d, weight[x]);
                first = hn::Add(first, hn::Mul(w, hn::LoadU(d, values + x)));
                second = hn::Add(second, hn::Mul(w, hn::LoadU(d, values + x + lanes)));
                third = hn::Add(third, hn::Mul(w, hn::LoadU(d, values + x + 2 * lanes)));
                fourth = hn::Add(fourth, hn::Mul(w, hn::LoadU(d, values + x + 3 * lanes)));
            }
        }
        hn::StoreU(first, d, sums + i);
        hn::StoreU(second, d, sums + i + lanes);
        hn::StoreU(third, d, sums + i + 2 * lanes);
        hn::StoreU(fourth, d, sums + i + 3 * lanes);
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(weightedSumsOn);

void weightedSums(const float* const* rows, const cv::Mat& weights, std::size_t count,
                  float* sums) {
    HWY_DYNAMIC_DISPATCH(weightedSumsOn)(rows, weights, count, sums);
}

} // namespace altiro3D
#endif
