#pragma once

#include "base/pixel_rows.hpp"

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// Shifts p S/2 of sub-pixels that show whole views: p = (2 view - (views - 1)) / (views - 1), 0
/// for a single view. Reads and writes up to kRowPadding beyond `count`.
/// @param views view of each of `count` sub-pixels
/// @param viewCount number of views, >= 1
/// @param halfParallax S/2 in px
/// @param shifts result in px
void shiftsOfViews(const std::uint16_t* views, std::size_t count, int viewCount, float halfParallax,
                   float* shifts);

/// Shifts p S/2 of sub-pixels with continuous positions: p = (2 N z - N) / (N - 1), clamped to +-1,
/// for the phase z = (columns[i] + row) / 2^32. Reads and writes up to kRowPadding beyond `count`.
/// @param columns, row phases from LensPhases
/// @param viewCount N >= 1
/// @param halfParallax S/2 in px
/// @param shifts result in px
void shiftsOfPhases(const std::uint32_t* columns, std::uint32_t row, std::size_t count,
                    int viewCount, float halfParallax, float* shifts);

} // namespace altiro3D
