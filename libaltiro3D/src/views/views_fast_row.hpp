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

/// Pixels that read one channel of a row of the photo. All arrays are padded (kRowPadding); the
/// padding is read.
struct FastRow {
    const std::uint8_t* plane = nullptr; ///< The channel; its last px is repeated at least 4 times.
    const float* columns = nullptr;      ///< 32 times the column of each of `count` pixels.
    const float* ownOffsets = nullptr;   ///< 32 times depth - focus in that column.
    const std::int32_t* windows = nullptr; ///< RowWindows::starts
    int tables = 2;                        ///< RowWindows::tables
    int width = 0;                         ///< Columns of the photo.
    std::size_t count = 0;
};

/// Samples a plane linearly at column + shift * offset, clamped to the row and rounded to 1/32 px,
/// with the rounding of cv::remap. Equals fastPlaces() without refinement and fastSamplesAt().
///
/// @param shifts p S/2 of each pixel, px, finite
/// @param values result, `count` and padding
void fastSamples(const FastRow& row, const float* shifts, std::uint8_t* values);

/// Samples a plane as fastSamples(), at given places. @param places from fastPlaces()
void fastSamplesAt(const FastRow& row, const float* places, std::uint8_t* values);

} // namespace altiro3D
