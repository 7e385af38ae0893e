#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// Side of the squares in which splats are blended, px.
constexpr int kSplatTile = 16;

/// A splat as a view shows it.
struct ProjectedSplat {
    float x, y;               ///< Its centre, px.
    float xx, xy, yy;         ///< Inverse of its covariance, 1/px^2.
    float opacity;            ///< In its centre.
    float limit;              ///< Exponent of what is too faint to be drawn: -ln(255 opacity).
    float red, green, blue;   ///< 0 or more.
    float distance;           ///< Along the view.
    std::int32_t left, right; ///< Columns that it reaches, the last one included.
    std::int32_t top, bottom; ///< Rows, likewise.
};

/// What is seen so far in a tile, by rows.
struct alignas(64) SplatTile {
    static constexpr std::size_t kPixels = std::size_t{kSplatTile} * kSplatTile;
    float clear[kPixels]; ///< Share of light from behind that passes; negative: no more is added.
    float red[kPixels];
    float green[kPixels];
    float blue[kPixels];
    float distance[kPixels]; ///< Where half of the light is stopped; NaN before.
};

/// Blends splats into a tile, nearest first.
/// @param order indices into `splats`
/// @param left, top px of the tile's upper left corner
void blendSplats(const ProjectedSplat* splats, const std::uint32_t* order, std::size_t count,
                 int left, int top, SplatTile& tile);

} // namespace altiro3D
