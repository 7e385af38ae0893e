#include "media/yuv_kernels.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "media/yuv_kernels.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#ifndef ALTIRO3D_YUV_KERNELS_ONCE
#define ALTIRO3D_YUV_KERNELS_ONCE
namespace altiro3D {
// Half for rounding; rounding down two or three numbers loses 1 to 1.5 on average.
constexpr int kBgrOffset = 16 + 1;
} // namespace altiro3D
#endif

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// Reads 3 bytes per pixel, writes 3 or 6. Memory limits the speed from about 4 cores on, else the
// nine multiplications.
template <int kShift, class T>
HWY_INLINE void bgrToYuvOn(const std::uint8_t* HWY_RESTRICT bgr, std::size_t count,
                           const YuvWeights& weights, T* HWY_RESTRICT y, T* HWY_RESTRICT u,
                           T* HWY_RESTRICT v) {
    constexpr int kMax = sizeof(T) == 1 ? 255 : 1023;
    T* const out[3] = {y, u, v};
    std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::ScalableTag<std::int16_t> d;
    const hn::Rebind<std::uint8_t, decltype(d)> bytes;
    const hn::RebindToUnsigned<decltype(d)> words;
    const std::size_t lanes = hn::Lanes(d);
    for (; i + lanes <= count; i += lanes) {
        auto blue = hn::Undefined(bytes);
        auto green = hn::Undefined(bytes);
        auto red = hn::Undefined(bytes);
        hn::LoadInterleaved3(bytes, bgr + 3 * i, blue, green, red);
        const auto b = hn::ShiftLeft<7>(hn::PromoteTo(d, blue));
        const auto g = hn::ShiftLeft<7>(hn::PromoteTo(d, green));
        const auto r = hn::ShiftLeft<7>(hn::PromoteTo(d, red));
        for (int k = 0; k < 3; ++k) {
            const std::int16_t* const w = weights.weight[k];
            auto sum = hn::Add(hn::MulHigh(b, hn::Set(d, w[0])), hn::Set(d, weights.offset[k]));
            sum = hn::Add(sum, hn::MulHigh(g, hn::Set(d, w[1])));
            sum = hn::Add(sum, hn::MulHigh(r, hn::Set(d, w[2])));
            const auto value = hn::ShiftRight<kShift>(sum);
            if constexpr (sizeof(T) == 1) {
                hn::StoreU(hn::DemoteTo(bytes, value), bytes, out[k] + i);
            } else {
                const auto inside =
                    hn::Min(hn::Max(value, hn::Zero(d)), hn::Set(d, std::int16_t{kMax}));
                hn::StoreU(hn::BitCast(words, inside), words, out[k] + i);
            }
        }
    }
#endif
    for (; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            int sum = weights.offset[k];
            for (int c = 0; c < 3; ++c)
                sum +=
                    (bgr[3 * i + static_cast<std::size_t>(c)] * 128 * weights.weight[k][c]) >> 16;
            out[k][i] = static_cast<T>(std::clamp(sum >> kShift, 0, kMax));
        }
    }
}

// Reads 3 bytes per pixel, writes 3. Interleaving the result limits the speed.
void yuvToBgrOn(const std::uint8_t* HWY_RESTRICT y, const std::uint8_t* HWY_RESTRICT u,
                const std::uint8_t* HWY_RESTRICT v, std::size_t count, const BgrWeights& w,
                std::uint8_t* HWY_RESTRICT bgr) {
    std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::ScalableTag<std::int16_t> d;
    const hn::Rebind<std::uint8_t, decltype(d)> bytes;
    const std::size_t lanes = hn::Lanes(d);
    const auto black = hn::Set(d, w.black);
    const auto middle = hn::Set(d, std::int16_t{128});
    const auto half = hn::Set(d, std::int16_t{kBgrOffset});
    for (; i + lanes <= count; i += lanes) {
        const auto vy = hn::Sub(hn::PromoteTo(d, hn::LoadU(bytes, y + i)), black);
        const auto vu =
            hn::ShiftLeft<8>(hn::Sub(hn::PromoteTo(d, hn::LoadU(bytes, u + i)), middle));
        const auto vv =
            hn::ShiftLeft<8>(hn::Sub(hn::PromoteTo(d, hn::LoadU(bytes, v + i)), middle));
        const auto base = hn::Add(hn::MulHigh(hn::ShiftLeft<7>(vy), hn::Set(d, w.luma)), half);
        const auto blue = hn::Add(base, hn::MulHigh(vu, hn::Set(d, w.blueOfU)));
        const auto green = hn::Add(hn::Add(base, hn::MulHigh(vu, hn::Set(d, w.greenOfU))),
                                   hn::MulHigh(vv, hn::Set(d, w.greenOfV)));
        const auto red = hn::Add(base, hn::MulHigh(vv, hn::Set(d, w.redOfV)));
        hn::StoreInterleaved3(hn::DemoteTo(bytes, hn::ShiftRight<5>(blue)),
                              hn::DemoteTo(bytes, hn::ShiftRight<5>(green)),
                              hn::DemoteTo(bytes, hn::ShiftRight<5>(red)), bytes, bgr + 3 * i);
    }
#endif
    for (; i < count; ++i) {
        const auto part = [](int value, int weight) { return (value * weight) >> 16; };
        const int base = part((y[i] - w.black) * 128, w.luma) + kBgrOffset;
        const int vu = (u[i] - 128) * 256;
        const int vv = (v[i] - 128) * 256;
        const int sums[3] = {base + part(vu, w.blueOfU),
                             base + part(vu, w.greenOfU) + part(vv, w.greenOfV),
                             base + part(vv, w.redOfV)};
        for (std::size_t c = 0; c < 3; ++c)
            bgr[3 * i + c] = static_cast<std::uint8_t>(std::clamp(sums[c] >> 5, 0, 255));
    }
}

void bgrToYuv8(const std::uint8_t* bgr, std::size_t count, const YuvWeights& weights,
               std::uint8_t* y, std::uint8_t* u, std::uint8_t* v) {
    bgrToYuvOn<6>(bgr, count, weights, y, u, v);
}
void bgrToYuv10(const std::uint8_t* bgr, std::size_t count, const YuvWeights& weights,
                std::uint16_t* y, std::uint16_t* u, std::uint16_t* v) {
    bgrToYuvOn<4>(bgr, count, weights, y, u, v);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

namespace {

HWY_EXPORT(bgrToYuv8);
HWY_EXPORT(bgrToYuv10);
HWY_EXPORT(yuvToBgrOn);

// Weights of red and blue in luma.
struct Luma {
    double red = 0;
    double blue = 0;
};

Luma lumaOf(ColourMatrix matrix) {
    if (matrix == ColourMatrix::Bt709) return {0.2126, 0.0722};
    if (matrix == ColourMatrix::Bt2020) return {0.2627, 0.0593};
    return {0.299, 0.114};
}

} // namespace

YuvWeights yuvWeights(ColourMatrix matrix, ColourRange range, int bits) {
    const auto [kr, kb] = lumaOf(matrix);
    const double kg = 1 - kr - kb;
    const int step = 1 << (bits - 8);
    const bool limited = range == ColourRange::Limited;
    const double most = 256 * step - 1;
    const double lumaScale = (limited ? 219 * step : most) / 255;
    const double chromaScale = (limited ? 224 * step : most) / 255;
    const double exact[3][3] = {{kb, kg, kr},
                                {0.5, -0.5 * kg / (1 - kb), -0.5 * kr / (1 - kb)},
                                {-0.5 * kb / (1 - kr), -0.5 * kg / (1 - kr), 0.5}};
    YuvWeights weights;
    weights.shift = bits == 8 ? 6 : 4;
    const double one = std::ldexp(1.0, 9 + weights.shift);
    for (int k = 0; k < 3; ++k) {
        const double scale = (k == 0 ? lumaScale : chromaScale) * one;
        // Green takes the remainder of rounding, so grey stays grey and white stays white.
        int left = static_cast<int>(std::lround((k == 0 ? 1.0 : 0.0) * scale));
        for (const int c : {0, 2}) {
            const int value = static_cast<int>(std::lround(exact[k][c] * scale));
            weights.weight[k][c] = static_cast<std::int16_t>(value);
            left -= value;
        }
        weights.weight[k][1] = static_cast<std::int16_t>(left);
        const int zero = k == 0 ? (limited ? 16 * step : 0) : 128 * step;
        // Half for rounding; rounding down three products loses 1.5 on average.
        weights.offset[k] =
            static_cast<std::int16_t>((zero << weights.shift) + (1 << (weights.shift - 1)) + 1);
    }
    return weights;
}

void bgrToYuv(const std::uint8_t* bgr, std::size_t count, const YuvWeights& weights,
              std::uint8_t* y, std::uint8_t* u, std::uint8_t* v) {
    HWY_DYNAMIC_DISPATCH(bgrToYuv8)(bgr, count, weights, y, u, v);
}

void bgrToYuv(const std::uint8_t* bgr, std::size_t count, const YuvWeights& weights,
              std::uint16_t* y, std::uint16_t* u, std::uint16_t* v) {
    HWY_DYNAMIC_DISPATCH(bgrToYuv10)(bgr, count, weights, y, u, v);
}

BgrWeights bgrWeights(ColourMatrix matrix, ColourRange range) {
    const auto [kr, kb] = lumaOf(matrix);
    const double kg = 1 - kr - kb;
    const bool limited = range == ColourRange::Limited;
    const double chroma = (limited ? 255.0 / 224 : 1) * (1 << 13);
    const auto whole = [](double value) { return static_cast<std::int16_t>(std::lround(value)); };
    BgrWeights weights;
    weights.black = limited ? 16 : 0;
    weights.luma = whole((limited ? 255.0 / 219 : 1) * (1 << 14));
    weights.blueOfU = whole(2 * (1 - kb) * chroma);
    weights.greenOfU = whole(-2 * kb * (1 - kb) / kg * chroma);
    weights.greenOfV = whole(-2 * kr * (1 - kr) / kg * chroma);
    weights.redOfV = whole(2 * (1 - kr) * chroma);
    return weights;
}

void yuvToBgr(const std::uint8_t* y, const std::uint8_t* u, const std::uint8_t* v,
              std::size_t count, const BgrWeights& weights, std::uint8_t* bgr) {
    HWY_DYNAMIC_DISPATCH(yuvToBgrOn)(y, u, v, count, weights, bgr);
}

} // namespace altiro3D
#endif
