#pragma once

#include "views/views_layered_row.hpp"

#include <cstddef>
#include <cstdint>

namespace altiro3D {

constexpr double kWholeReach = 16384; ///< The largest shift in whole steps.

/// Finds the pixels whose place a line gives. All arrays are padded (kRowPadding).
///
/// @param offsets, slopes, from, to LayeredLines of each of `count` pixels; from and to of the
///        padding must not be negative
/// @param columns places of their columns
/// @param shifts of the pixels, in steps of kWholeReach, within the largest shift
/// @param reachPixels largest shift, px
struct LayeredLinePixels {
    const std::int16_t* offsets = nullptr;
    const std::int16_t* slopes = nullptr;
    const std::int16_t* from = nullptr;
    const std::int16_t* to = nullptr;
    const std::int32_t* columns = nullptr;
    const std::int16_t* shifts = nullptr;
    float reachPixels = 0;
    std::size_t count = 0;
};

/// @param room result: places, open blocks and the shifts of their pixels
/// @return whether any block is open
bool layeredLines(const LayeredLinePixels& pixels, LayeredRoom& room);

} // namespace altiro3D
