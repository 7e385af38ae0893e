#include "splats/splat_kernels.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splats/splat_kernels.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// e^x for x in -8..0 with an error of 2e-7; no fused sums, so that all processors give the same.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V expOf(D d, V x) {
    const hn::RebindToSigned<D> whole;
    const V steps = hn::Mul(x, hn::Set(d, 1.44269504F)); // 2^steps
    const V step = hn::Round(steps);
    const V t = hn::Mul(hn::Sub(steps, step), hn::Set(d, 0.693147181F));
    V sum = hn::Set(d, 1.0F / 720); // the series of e^t, |t| < 0.35
    for (const float factor : {1.0F / 120, 1.0F / 24, 1.0F / 6, 0.5F, 1.0F, 1.0F})
        sum = hn::Add(hn::Mul(sum, t), hn::Set(d, factor));
    const auto exponent = hn::ShiftLeft<23>(hn::ConvertTo(whole, step));
    return hn::BitCast(d, hn::Add(hn::BitCast(whole, sum), exponent));
}

// Whether no more light passes a tile.
bool isFullOn(const SplatTile& tile) {
    const hn::CappedTag<float, kSplatTile> d;
    auto most = hn::Load(d, tile.clear);
    for (std::size_t i = hn::Lanes(d); i < SplatTile::kPixels; i += hn::Lanes(d))
        most = hn::Max(most, hn::Load(d, tile.clear + i));
    return hn::AllTrue(d, hn::Lt(most, hn::Zero(d)));
}

void blendSplatsOn(const ProjectedSplat* splats, const std::uint32_t* order, std::size_t count,
                   int left, int top, SplatTile& tile) {
    const hn::CappedTag<float, kSplatTile> d;
    using V = hn::Vec<decltype(d)>;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const V zero = hn::Zero(d);
    const V one = hn::Set(d, 1.0F);
    const V half = hn::Set(d, 0.5F);
    // as in 3DGS: largest opacity of a splat, and least light that may be left after drawing one
    const V densest = hn::Set(d, 0.99F);
    const V darkest = hn::Set(d, 1e-4F);
    constexpr std::size_t kTestedEvery = 32;
    alignas(64) float columns[kSplatTile];
    for (int i = 0; i < kSplatTile; ++i)
        columns[i] = static_cast<float>(left + i);
    for (std::size_t n = 0; n < count; ++n) {
        if (n % kTestedEvery == 0 && n > 0 && isFullOn(tile)) return;
        const ProjectedSplat& splat = splats[order[n]];
        const int firstRow = std::max(splat.top - top, 0);
        const int lastRow = std::min(splat.bottom - top, kSplatTile - 1);
        const int first = std::max(splat.left - left, 0) / lanes * lanes;
        const int last = std::min(splat.right - left, kSplatTile - 1);
        const V x = hn::Set(d, splat.x);
        const V xx = hn::Set(d, -0.5F * splat.xx);
        const V opacity = hn::Set(d, splat.opacity);
        const V limit = hn::Set(d, splat.limit);
        for (int row = firstRow; row <= lastRow; ++row) {
            const float down = static_cast<float>(top + row) - splat.y;
            const V slant = hn::Set(d, splat.xy * down);
            const V level = hn::Set(d, -0.5F * splat.yy * down * down);
            for (int column = first; column <= last; column += lanes) {
                const auto at = static_cast<std::size_t>(row * kSplatTile + column);
                const V clear = hn::Load(d, tile.clear + at);
                const V across = hn::Sub(hn::Load(d, columns + column), x);
                const V power =
                    hn::Add(hn::Mul(across, hn::Sub(hn::Mul(xx, across), slant)), level);
                const auto seen = hn::And(hn::Ge(power, limit), hn::Gt(clear, zero));
                if (hn::AllFalse(d, seen)) continue;
                // finite exponents, as denormals are slow
                const V e = expOf(d, hn::Max(hn::Min(power, zero), limit));
                const V alpha = hn::Min(hn::Mul(opacity, e), densest);
                const V next = hn::Mul(clear, hn::Sub(one, alpha));
                const auto ends = hn::And(seen, hn::Lt(next, darkest));
                const auto drawn = hn::AndNot(ends, seen);
                const V weight = hn::IfThenElseZero(drawn, hn::Mul(alpha, clear));
                const auto add = [&](float* sums, float value) HWY_ATTR {
                    hn::Store(hn::Add(hn::Load(d, sums + at), hn::Mul(weight, hn::Set(d, value))),
                              d, sums + at);
                };
                add(tile.red, splat.red);
                add(tile.green, splat.green);
                add(tile.blue, splat.blue);
                const auto passesHalf =
                    hn::And(drawn, hn::And(hn::Gt(clear, half), hn::Le(next, half)));
                if (HWY_UNLIKELY(!hn::AllFalse(d, passesHalf))) {
                    const V known = hn::Load(d, tile.distance + at);
                    hn::Store(hn::IfThenElse(passesHalf, hn::Set(d, splat.distance), known), d,
                              tile.distance + at);
                }
                hn::Store(hn::IfThenElse(drawn, next, hn::IfThenElse(ends, hn::Neg(clear), clear)),
                          d, tile.clear + at);
            }
        }
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(blendSplatsOn);

void blendSplats(const ProjectedSplat* splats, const std::uint32_t* order, std::size_t count,
                 int left, int top, SplatTile& tile) {
    HWY_DYNAMIC_DISPATCH(blendSplatsOn)(splats, order, count, left, top, tile);
}

} // namespace altiro3D
#endif
