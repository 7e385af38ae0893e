#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

/// Method Real: where pixels of the photo fall in a view, and what a pixel of the view gets of
/// them.
namespace altiro3D {

constexpr int kOne = 256;          // one pixel; also the weight of a whole pixel
constexpr int kCovered = kOne / 2; // a pixel is seen from this weight on; less is an edge's fringe
constexpr int kOutside = std::numeric_limits<int>::min(); // place of what is not seen
constexpr std::uint32_t kFull = 1U << 23U; // weight after which a sum is closed: 255 kFull < 2^31
constexpr double kNearest = 1e30;          // a float's worth of nearness
constexpr float kNothing = -1e30F;

// Surfaces less than this apart (px of parallax) mix; measured: 0.5 .. 2 px are within 0.05 dB.
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

// What a pixel of the view has got. `surface` is the nearest of what falls onto the pixel itself,
// `fringe` what only reaches in from beside it and is nearer still: an edge, mixed by its weight.
struct Cell {
    float nearest = kNothing;
    Sum surface;
    Sum fringe;
    float fringeNearest = kNothing;
};

// The two pixels between which a place lies, and the second one's weight.
struct Split {
    int first;
    int secondWeight;

    explicit Split(int place)
        : first((place + kOne) / kOne - 1), // floor: places are > -kOne
          secondWeight(place - first * kOne) {}
};

// The place of a coordinate, kOutside if it touches no pixel of 0..size-1.
inline int placeOf(double coordinate, int size) {
    if (!(coordinate > -1 && coordinate < size)) return kOutside; // NaN too
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

// The mean colour of a sum, 16 times as fine as a pixel's.
inline std::uint32_t mean16(const Sum& sum, int k) {
    return static_cast<std::uint32_t>((std::uint64_t{16} * sum.colour[k] + sum.weight / 2) /
                                      sum.weight);
}

// Writes a pixel from its cell; false if it is a hole.
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
        !seen ? kOne : std::min<std::uint32_t>(cell.fringe.weight, kOne); // of the fringe, in kOne
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t below = seen ? mean16(cell.surface, k) * (kOne - share) : 0;
        const std::uint32_t above = fringed ? mean16(cell.fringe, k) * share : 0;
        pixel[k] = static_cast<uchar>((below + above + 8 * kOne) / (16 * kOne));
    }
    return true;
}

} // namespace altiro3D
