#pragma once

#include "views/row_pixels.hpp"
#include "views/views_layered_row.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

constexpr double kWholeReach = 16384; ///< The largest shift in whole steps.

/// Blocks of kWindowPixels pixels that lie in a few columns. Arrays of one value per pixel or per
/// block, padded (kRowPadding).
struct LayeredBlocks {
    /// Column of each pixel from the start of its block, in 1/256 px.
    std::vector<std::int16_t> columns;
    std::vector<std::int32_t> starts; ///< One column of each block; -1 if the block is too wide.
};
LayeredBlocks layeredBlocks(const std::vector<int>& columns);

/// Finds the pixels whose place a line gives. All arrays are padded (kRowPadding).
///
/// @param offsets, slopes, from, to LayeredLines of each of `count` pixels; from and to of the
///        padding must not be negative
/// @param columns, starts LayeredBlocks of the pixels
/// @param fixed RowWindows::starts of the pixels
/// @param shifts of the pixels, in steps of kWholeReach, within the largest shift
/// @param reachPixels largest shift, px
struct LayeredLinePixels {
    const std::int16_t* offsets = nullptr;
    const std::int16_t* slopes = nullptr;
    const std::int16_t* from = nullptr;
    const std::int16_t* to = nullptr;
    const std::int16_t* columns = nullptr;
    const std::int32_t* starts = nullptr;
    const std::int32_t* fixed = nullptr;
    const std::int16_t* shifts = nullptr;
    float reachPixels = 0;
    std::size_t count = 0;
};

/// @param away result: distance of each place from the pixel's column, 1/256 px; or kNotOnLine
/// @param windows result, for each block: first of 64 columns that hold all its places; kOpenBlock
///        if there are none or the place of a pixel is not known
/// @param shifts result: shifts in px of the pixels of open blocks
/// @return whether any block is open
bool layeredLines(const LayeredLinePixels& pixels, std::int16_t* away, std::int32_t* windows,
                  float* shifts);

} // namespace altiro3D
