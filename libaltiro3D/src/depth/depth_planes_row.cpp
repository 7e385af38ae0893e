#include "depth/depth_planes_row.hpp"

#include <algorithm>
#include <cstddef>

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

HWY_INLINE F set(float value) {
    return hn::Set(Floats(), value);
}

// About exp(-x); 0 from 8 on.
HWY_INLINE F falling(F x) {
    const F part = hn::Max(hn::Sub(set(1), hn::Mul(x, set(0.125F))), hn::Zero(Floats()));
    const F square = hn::Mul(part, part);
    const F fourth = hn::Mul(square, square);
    return hn::Mul(fourth, fourth);
}

// The weight of a plane or a knot.
// @param place squared distance, px² @param depth difference @param blue difference
HWY_INLINE F weightOf(const PlaneWeights& weights, F place, F depth, F blue, F green, F red) {
    const F squares =
        hn::Add(hn::Add(hn::Mul(blue, blue), hn::Mul(green, green)), hn::Mul(red, red));
    const F color = hn::Min(hn::Mul(squares, set(weights.color)), set(weights.colorMost));
    const F depths = hn::Mul(hn::Mul(depth, depth), set(weights.depth));
    return falling(hn::Add(hn::Add(hn::Mul(place, set(weights.place)), depths), color));
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
            const F weight = weightOf(weights, set(dx * dx + dy * dy), away, blue, green, red);
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
        const F dy = set(row.down[static_cast<std::size_t>(i)]);
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
    const F ridge = set(3 * static_cast<float>(row.side * row.side));
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

// The px of one vector.
HWY_INLINE F blendVector(const PlanePixels& pixels, int first, const PlaneWeights& weights) {
    const Floats d;
    const F own = set(0.05F);
    const F depth = hn::LoadU(d, pixels.depth + first);
    const F blue = hn::LoadU(d, pixels.color[0] + first);
    const F green = hn::LoadU(d, pixels.color[1] + first);
    const F red = hn::LoadU(d, pixels.color[2] + first);
    const F inCell = hn::LoadU(d, pixels.inCell + first);
    F sum = hn::Mul(own, depth);
    F all = own;
    for (int i = 0; i < pixels.count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const KnotRow& other = pixels.others[at];
        const F dy = set(pixels.down[at]);
        for (int away = -kPlaneNear; away <= kPlaneNear; ++away) {
            const int shift = away * pixels.side;
            const auto load = [&](const float* row) { return hn::LoadU(d, row + first + shift); };
            const F dx = hn::Sub(inCell, set(static_cast<float>(shift)));
            const F slope =
                hn::Add(hn::Mul(load(other.slopeX), dx), hn::Mul(load(other.slopeY), dy));
            const F value = hn::Add(load(other.guide), slope);
            const F weight =
                weightOf(weights, hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Sub(value, depth),
                         hn::Sub(load(other.color[0]), blue), hn::Sub(load(other.color[1]), green),
                         hn::Sub(load(other.color[2]), red));
            sum = hn::Add(sum, hn::Mul(weight, value));
            all = hn::Add(all, weight);
        }
    }
    return hn::Min(hn::Max(hn::Div(sum, all), hn::Zero(d)), set(1));
}

void blendPlanes(const PlanePixels& pixels, int columns, const PlaneWeights& weights,
                 float* blended) {
    for (int first = 0; first < columns; first += static_cast<int>(hn::Lanes(Floats())))
        hn::StoreU(blendVector(pixels, first, weights), Floats(), blended + first);
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

void blendPlanes(const PlanePixels& pixels, int columns, const PlaneWeights& weights,
                 float* blended) {
    HWY_DYNAMIC_DISPATCH(blendPlanes)(pixels, columns, weights, blended);
}

} // namespace altiro3D

#endif
