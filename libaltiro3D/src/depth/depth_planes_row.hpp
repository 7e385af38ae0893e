#pragma once

#include <array>
#include <cstdint>

namespace altiro3D {

/// What the weights of depth_planes.hpp are made of. Each factor is 1 / (2 sigma²).
struct PlaneWeights {
    float place = 0;     ///< per px²
    float depth = 0;     ///< per squared unit of depth
    float color = 0;     ///< per squared grey level, summed over the channels
    float colorMost = 0; ///< the most that colour counts, as an exponent
};

constexpr int kPlaneReach = 12; ///< Columns and rows of knots on each side of a plane.
constexpr int kPlaneStep = 2;   ///< Every second knot counts.

/// Columns of knots that are needed before and behind those of a row, for neighbours and whole
/// vectors. Their guide is kNoKnot, so they have no weight.
constexpr int kKnotPadding = kPlaneReach + 64;
constexpr float kNoKnot = 1e9F;

/// A row of knots, padded, or of knots that are repeated for each px of their cells.
struct KnotRow {
    const float* depth = nullptr;  ///< measured; not read by blendPlanes()
    const float* guide = nullptr;  ///< smooth
    const float* slopeX = nullptr; ///< per px; read by blendPlanes() only
    const float* slopeY = nullptr; ///< as slopeX
    std::array<const float*, 3> color{};
};

/// A row of knots and the rows around it.
struct PlaneRow {
    int side = 0; ///< px from knot to knot
    KnotRow mine;
    int count = 0; ///< of the other rows; the own row is one of them
    std::array<KnotRow, 2 * kPlaneReach / kPlaneStep + 1> others;
    std::array<float, 2 * kPlaneReach / kPlaneStep + 1> down{}; ///< px from `mine`
};

/// Fits a plane around each knot of a row, by weighted least squares.
/// @param guide value of the plane at the knot @param slopeX per px; all three are padded behind
void fitPlaneRow(const PlaneRow& row, int columns, const PlaneWeights& weights, float* guide,
                 float* slopeX, float* slopeY);

constexpr int kPlaneNear = 2; ///< Columns and rows of knots on each side that decide on a px.

/// A row of the picture, and the planes of the rows of knots around it. What belongs to px is
/// padded behind by kRowPadding, the knots by this and kPlaneNear cells on both sides.
struct PlanePixels {
    int side = 0; ///< px from knot to knot
    const float* depth = nullptr;
    std::array<const float*, 3> color{};
    const float* inCell = nullptr; ///< px to the right of the middle of the cell
    int count = 0;                 ///< of the rows of knots
    std::array<KnotRow, 2 * kPlaneNear + 1> others;
    std::array<float, 2 * kPlaneNear + 1> down{}; ///< px from the knots to the row
};

/// The means of the planes around each px, with some weight of its own depth.
/// @param blended padded as what belongs to px
void blendPlanes(const PlanePixels& pixels, int columns, const PlaneWeights& weights,
                 float* blended);

} // namespace altiro3D
