#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// Where the pixels of views come from in a row of the photo, by method Fast: column + shift *
/// offset, clamped to the row; each refinement step reads the offset again, linearly, at the place
/// found so far. All rows are padded (kRowPadding); reads and writes that much more.
///
/// @param columns column of each of `count` pixels
/// @param ownOffsets depth - focus in that column
/// @param shifts p S/2 of each, px, finite
/// @param offsets depth - focus of each column of the photo, the last one twice
/// @param width columns of the photo
/// @param refinement number of steps, >= 0
/// @param places result, 0..width-1
void fastPlaces(const float* columns, const float* ownOffsets, const float* shifts,
                std::size_t count, const float* offsets, int width, int refinement, float* places);

/// Linear samples of a plane, at places in whole 1/32 px and with the rounding of cv::remap.
///
/// @param plane one channel of a row of the photo, the last px at least four times more, padded
/// @param places columns, 0..width-1, `count` and padding
/// @param columns what the places belong to, in order (ascending or descending) but for the padding
/// @param reach how far places lie from their columns at most, px
/// @param values result, `count` and padding
void fastSamples(const std::uint8_t* plane, const float* places, const float* columns, int reach,
                 std::size_t count, std::uint8_t* values);

} // namespace altiro3D
