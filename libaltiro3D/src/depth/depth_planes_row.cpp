#include "depth/depth_planes_row.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

// This file is compiled once per instruction set; the best one is chosen at run time. No sum runs
// over columns, so the bits are the same.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/depth_planes_row.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using F = hn::Vec<Floats>;

// About exp(-x); 0 from 8 on. The compiler makes vectors of it.
HWY_INLINE float falling(float x) {
    const float rest = 1 - x * 0.125F;
    const float part = rest > 0 ? rest : 0;
    const float square = part * part;
    const float fourth = square * square;
    return fourth * fourth;
}

HWY_INLINE float weightOf(const PlaneWeights& weights, float place, float depth, float blue,
                          float green, float red) {
    const float color = (blue * blue + green * green + red * red) * weights.color;
    return falling(place + depth * depth * weights.depth +
                   (color < weights.colorMost ? color : weights.colorMost));
}

// The weight of falling() for a vector of knots.
HWY_INLINE F fallingVector(F x) {
    const F one = hn::Set(Floats(), 1.0F);
    const F part = hn::Max(hn::Sub(one, hn::Mul(x, hn::Set(Floats(), 0.125F))), hn::Zero(Floats()));
    const F square = hn::Mul(part, part);
    const F fourth = hn::Mul(square, square);
    return hn::Mul(fourth, fourth);
}

// The px of one vector of knots: their own values, and the sums over one row of neighbours.
struct KnotVector {
    HWY_INLINE KnotVector(const KnotRow& mine, int start, const PlaneWeights& factors)
        : first(start), weights(factors), guide(load(mine.guide)), myBlue(load(mine.color[0])),
          myGreen(load(mine.color[1])), myRed(load(mine.color[2])) {}

    HWY_INLINE void add(const KnotRow& other, int side, float dy) {
        one = x = xx = v = xv = hn::Zero(Floats());
        for (int shift = -kPlaneReach; shift <= kPlaneReach; shift += kPlaneStep) {
            const auto dx = static_cast<float>(shift * side);
            const F blue = hn::Sub(load(other.color[0] + shift), myBlue);
            const F green = hn::Sub(load(other.color[1] + shift), myGreen);
            const F red = hn::Sub(load(other.color[2] + shift), myRed);
            const F away = hn::Sub(load(other.guide + shift), guide);
            const F color =
                hn::Min(hn::Mul(hn::Add(hn::Add(hn::Mul(blue, blue), hn::Mul(green, green)),
                                        hn::Mul(red, red)),
                                set(weights.color)),
                        set(weights.colorMost));
            const F depth = hn::Mul(hn::Mul(away, away), set(weights.depth));
            const F weight = fallingVector(
                hn::Add(hn::Add(set((dx * dx + dy * dy) * weights.place), depth), color));
            const F value = hn::Mul(weight, hn::Sub(load(other.depth + shift), guide));
            const F right = set(dx);
            const F weightX = hn::Mul(weight, right);
            one = hn::Add(one, weight);
            x = hn::Add(x, weightX);
            xx = hn::Add(xx, hn::Mul(weightX, right));
            v = hn::Add(v, value);
            xv = hn::Add(xv, hn::Mul(value, right));
        }
    }

    static HWY_INLINE F set(float value) { return hn::Set(Floats(), value); }

    HWY_INLINE F load(const float* row) const { return hn::LoadU(Floats(), row + first); }

    int first;
    const PlaneWeights& weights;
    F guide;
    F myBlue, myGreen, myRed;
    F one, x, xx, v, xv;
};

// The planes of one vector of knots.
HWY_INLINE void fitVector(const PlaneRow& row, int first, const PlaneWeights& weights, float* guide,
                          float* slopeX, float* slopeY) {
    const Floats d;
    KnotVector knots(row.mine, first, weights);
    F one = hn::Zero(d);
    F sumX = one, sumY = one, sumXx = one, sumXy = one, sumYy = one;
    F sumV = one, sumXv = one, sumYv = one;
    for (int i = 0; i < row.count; ++i) {
        knots.add(row.others[static_cast<std::size_t>(i)], row.side,
                  row.down[static_cast<std::size_t>(i)]);
        const F dy = KnotVector::set(row.down[static_cast<std::size_t>(i)]);
        const F weightY = hn::Mul(knots.one, dy);
        one = hn::Add(one, knots.one);
        sumX = hn::Add(sumX, knots.x);
        sumY = hn::Add(sumY, weightY);
        sumXx = hn::Add(sumXx, knots.xx);
        sumXy = hn::Add(sumXy, hn::Mul(knots.x, dy));
        sumYy = hn::Add(sumYy, hn::Mul(weightY, dy));
        sumV = hn::Add(sumV, knots.v);
        sumXv = hn::Add(sumXv, knots.xv);
        sumYv = hn::Add(sumYv, hn::Mul(knots.v, dy));
    }
    // Least squares. The ridge keeps planes level that few knots decide on.
    const F ridge = KnotVector::set(3 * static_cast<float>(row.side * row.side));
    const F x = hn::Div(sumX, one);
    const F y = hn::Div(sumY, one);
    const F v = hn::Div(sumV, one);
    const F xx = hn::Add(hn::Sub(hn::Div(sumXx, one), hn::Mul(x, x)), ridge);
    const F xy = hn::Sub(hn::Div(sumXy, one), hn::Mul(x, y));
    const F yy = hn::Add(hn::Sub(hn::Div(sumYy, one), hn::Mul(y, y)), ridge);
    const F xv = hn::Sub(hn::Div(sumXv, one), hn::Mul(x, v));
    const F yv = hn::Sub(hn::Div(sumYv, one), hn::Mul(y, v));
    const F area = hn::Sub(hn::Mul(xx, yy), hn::Mul(xy, xy));
    const F toRight = hn::Div(hn::Sub(hn::Mul(xv, yy), hn::Mul(yv, xy)), area);
    const F down = hn::Div(hn::Sub(hn::Mul(yv, xx), hn::Mul(xv, xy)), area);
    const F tilt = hn::Add(hn::Mul(toRight, x), hn::Mul(down, y));
    hn::StoreU(hn::Sub(hn::Add(knots.guide, v), tilt), d, guide + first);
    hn::StoreU(toRight, d, slopeX + first);
    hn::StoreU(down, d, slopeY + first);
}

void fitPlaneRow(const PlaneRow& row, int columns, const PlaneWeights& weights, float* guide,
                 float* slopeX, float* slopeY) {
    for (int first = 0; first < columns; first += static_cast<int>(hn::Lanes(Floats())))
        fitVector(row, first, weights, guide, slopeX, slopeY);
}

void blendPlanes(const PlanePixels& pixels, const KnotRow& other, int width, int shift, float dy,
                 const PlaneWeights& weights, float* HWY_RESTRICT sum, float* HWY_RESTRICT weight) {
    const PlaneWeights by = weights;
    const float* HWY_RESTRICT guide = other.guide + shift;
    const float* HWY_RESTRICT slopeX = other.slopeX + shift;
    const float* HWY_RESTRICT slopeY = other.slopeY + shift;
    const float* HWY_RESTRICT blue = other.color[0] + shift;
    const float* HWY_RESTRICT green = other.color[1] + shift;
    const float* HWY_RESTRICT red = other.color[2] + shift;
    const float* HWY_RESTRICT depth = pixels.depth;
    const float* HWY_RESTRICT inCell = pixels.inCell;
    const std::uint8_t* HWY_RESTRICT myBlue = pixels.color[0];
    const std::uint8_t* HWY_RESTRICT myGreen = pixels.color[1];
    const std::uint8_t* HWY_RESTRICT myRed = pixels.color[2];
    const float away = static_cast<float>(shift);
    const int end = std::min(pixels.count, width - shift);
    for (int i = std::max(0, -shift); i < end; ++i) {
        const float dx = inCell[i] - away;
        const float value = guide[i] + (slopeX[i] * dx + slopeY[i] * dy);
        const float part = weightOf(by, (dx * dx + dy * dy) * by.place, value - depth[i],
                                    blue[i] - static_cast<float>(myBlue[i]),
                                    green[i] - static_cast<float>(myGreen[i]),
                                    red[i] - static_cast<float>(myRed[i]));
        sum[i] += part * value;
        weight[i] += part;
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace altiro3D {

HWY_EXPORT(fitPlaneRow);
HWY_EXPORT(blendPlanes);

void fitPlaneRow(const PlaneRow& row, int columns, const PlaneWeights& weights, float* guide,
                 float* slopeX, float* slopeY) {
    HWY_DYNAMIC_DISPATCH(fitPlaneRow)(row, columns, weights, guide, slopeX, slopeY);
}

void blendPlanes(const PlanePixels& pixels, const KnotRow& other, int width, int shift, float dy,
                 const PlaneWeights& weights, float* sum, float* weight) {
    HWY_DYNAMIC_DISPATCH(blendPlanes)(pixels, other, width, shift, dy, weights, sum, weight);
}

} // namespace altiro3D

#endif
