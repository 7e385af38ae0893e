#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// Source positions of view pixels in a row of the photo, by method Fast: column + shift * offset,
/// clamped to the row. Each refinement step reads the offset again, linearly, at the position found
/// so far. All rows are padded (kRowPadding); the padding is read and written.
///
/// @param columns column of each of `count` pixels
/// @param ownOffsets depth - focus in that column
/// @param shifts p S/2 of each, px, finite
/// @param offsets depth - focus of each column of the photo; the last one is repeated
/// @param width columns of the photo
/// @param refinement number of steps, >= 0
/// @param places result, 0..width-1
void fastPlaces(const float* columns, const float* ownOffsets, const float* shifts,
                std::size_t count, const float* offsets, int width, int refinement, float* places);

/// Samples a plane linearly, at positions rounded to 1/32 px and with the rounding of cv::remap.
///
/// @param plane one channel of a row of the photo; its last px is repeated at least four times;
///        padded
/// @param places columns, 0..width-1, `count` and padding
/// @param columns columns of the places, in order (ascending or descending) except for the padding
/// @param reach largest distance of places from their columns, px
/// @param values result, `count` and padding
void fastSamples(const std::uint8_t* plane, const float* places, const float* columns, int reach,
                 std::size_t count, std::uint8_t* values);

} // namespace altiro3D
