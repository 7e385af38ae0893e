#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

/// Method Real: projection of photo pixels into a view and accumulation in the view's pixels.
namespace altiro3D {

constexpr int kOne = 256; // one pixel; also the weight of a whole pixel
constexpr int kCovered =
    kOne / 2; // minimum weight of a covered pixel; less is the fringe of an edge
constexpr int kOutside = std::numeric_limits<int>::min(); // place of a point outside the view
constexpr std::uint32_t kFull = 1U << 23U; // weight at which a sum stops: 255 kFull < 2^31
constexpr double kNearest = 1e30;          // limit of nearness, representable as float
constexpr float kNothing = -1e30F;

// Surfaces less than this apart (px of parallax) are blended. Values of 0.5 to 2 px differ by at
// most 0.05 dB.
constexpr float kSameSurface = 1;

// A weighted sum of colours.
struct Sum {
    std::uint32_t weight = 0;
    std::uint32_t colour[3] = {0, 0, 0};

    void add(const uchar* pixel, int by) {
        if (weight >= kFull) return;
        const auto w = static_cast<std::uint32_t>(by);
        weight += w;
        for (int k = 0; k < 3; ++k)
            colour[k] += w * pixel[k];
    }
};

// Accumulated contents of a view pixel. `surface` is the nearest content that falls onto the pixel.
// `fringe` is nearer content that only reaches into the pixel from beside it: an edge, blended by
// its weight.
struct Cell {
    float nearest = kNothing;
    Sum surface;
    Sum fringe;
    float fringeNearest = kNothing;
};

// The two pixels around a place, and the weight of the second one.
struct Split {
    int first;
    int secondWeight;

    explicit Split(int place)
        : first((place + kOne) / kOne - 1), // floor: places are > -kOne
          secondWeight(place - first * kOne) {}
};

// The place of a coordinate; kOutside if it touches no pixel of 0..size-1.
inline int placeOf(double coordinate, int size) {
    if (!(coordinate > -1 && coordinate < size)) return kOutside; // also NaN
    const int place = static_cast<int>(std::floor(coordinate * kOne + 0.5));
    return place > -kOne && place < size * kOne ? place : kOutside;
}

inline void offer(Cell& cell, float nearness) {
    cell.nearest = std::max(cell.nearest, nearness);
}

inline void collect(Cell& cell, float nearness, const uchar* pixel, int weight) {
    if (nearness < cell.nearest - kSameSurface) return;
    if (nearness <= cell.nearest + kSameSurface) {
        cell.surface.add(pixel, weight);
    } else {
        cell.fringe.add(pixel, weight);
        cell.fringeNearest = std::max(cell.fringeNearest, nearness);
    }
}

// The mean colour of a sum, in 1/16 levels.
inline std::uint32_t mean16(const Sum& sum, int k) {
    return static_cast<std::uint32_t>((std::uint64_t{16} * sum.colour[k] + sum.weight / 2) /
                                      sum.weight);
}

// Writes the pixel of a cell; false if it is a hole.
inline bool resolve(const Cell& cell, uchar* pixel, float* nearness) {
    const bool seen = cell.surface.weight > 0;
    const bool fringed = cell.fringe.weight > 0;
    if (!seen && cell.fringe.weight < kCovered) {
        std::fill_n(pixel, 3, uchar{0});
        *nearness = kNothing;
        return false;
    }
    *nearness = seen ? cell.nearest : cell.fringeNearest;
    const std::uint32_t share =
        !seen
            ? kOne
            : std::min<std::uint32_t>(cell.fringe.weight, kOne); // weight of the fringe, in 1/kOne
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t below = seen ? mean16(cell.surface, k) * (kOne - share) : 0;
        const std::uint32_t above = fringed ? mean16(cell.fringe, k) * share : 0;
        pixel[k] = static_cast<uchar>((below + above + 8 * kOne) / (16 * kOne));
    }
    return true;
}

} // namespace altiro3D
