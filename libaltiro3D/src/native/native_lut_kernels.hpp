#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// Positions of the tiles of a quilt as numbers with X in the lower and Y in the upper 16 bits:
/// view v begins at first + v * perView + (v / columns) * perRow modulo 2^32.
struct TilePlaces {
    std::uint32_t first = 0;
    std::uint32_t perView = 0;
    std::uint32_t perRow = 0;
    std::uint32_t reciprocal = 0; ///< (v * reciprocal) >> 32 is v / columns, for v < 2^20.
};

/// @param columns, rows tiles of the quilt, 1..1024
/// @param tileWidth, tileHeight size of a tile in px
TilePlaces tilePlaces(int columns, int rows, int tileWidth, int tileHeight);

/// Quilt pixels of a row of sub-pixels: the tile of the view plus the place inside it. The result
/// is the same on every instruction set.
///
/// @param views view of each sub-pixel, 0..2^20-1
/// @param inTile X inside the tile of each sub-pixel
/// @param yInTile Y inside the tile
/// @param out X and Y of each sub-pixel
void quiltPixels(const std::uint32_t* views, const std::uint32_t* inTile, std::size_t count,
                 const TilePlaces& places, int yInTile, std::uint16_t* out);

/// Largest X and Y of `count` pairs.
struct LargestPair {
    std::uint16_t x = 0;
    std::uint16_t y = 0;
};
LargestPair largestPair(const std::uint16_t* pairs, std::size_t count);

/// The tiles of a quilt, to find the tile of a quilt pixel.
struct TileGrid {
    std::uint32_t columns = 0;
    std::uint32_t rows = 0;
    std::uint16_t tileWidth = 0;  ///< 2 or more
    std::uint16_t tileHeight = 0; ///< 2 or more
};

/// The inverse of quiltPixels(): views of a row of sub-pixels.
///
/// @param pairs X and Y of each sub-pixel
/// @param inTile X inside the tile of each sub-pixel, below the tile's width
/// @param yInTile Y inside the tile, below the tile's height
/// @param views one per sub-pixel; columns x rows is at most 256 or 65536, depending on its type
/// @return whether every sub-pixel is at that place inside a tile; if not, `views` is invalid
bool viewsOfQuiltPixels(const std::uint16_t* pairs, const std::uint32_t* inTile, std::size_t count,
                        const TileGrid& grid, std::uint32_t yInTile, std::uint8_t* views);
bool viewsOfQuiltPixels(const std::uint16_t* pairs, const std::uint32_t* inTile, std::size_t count,
                        const TileGrid& grid, std::uint32_t yInTile, std::uint16_t* views);

} // namespace altiro3D
