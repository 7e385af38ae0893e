#pragma once

#include "views/depth_offsets.hpp"

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

/// Without refinement and with shifts below kMaxWholeShift, Fast computes in 16-bit whole numbers:
/// shifts in steps of 1/128 px, offsets in steps of 1/8192 (kOffsetSteps), and places in steps of
/// 1/32 px, as 32 column + (shift offset + 2^14) >> 15, clamped to the row. A place differs from
/// the exact one by 1/64 px (rounding) and at most 1/128 px (steps of shift and offset).
constexpr float kMaxWholeShift = 64;
constexpr float kShiftSteps = 128;

/// Pixels that read one channel of a row of the photo. All arrays are padded (kRowPadding); the
/// padding is read.
struct FastRow {
    const std::uint8_t* plane = nullptr; ///< The channel; its last px is repeated at least 4 times.
    const std::int32_t* columns = nullptr;  ///< 32 times the column of each of `count` pixels.
    const std::int16_t* inWindow = nullptr; ///< The same from the start of the pixel's window.
    const std::int16_t* offsets = nullptr;  ///< wholeOffsets() of that column.
    const std::int32_t* windows = nullptr;  ///< RowWindows::starts
    int tables = 2;                         ///< RowWindows::tables
    int width = 0;                          ///< Columns of the photo.
    std::size_t count = 0;
};

/// Samples a plane linearly at places in whole numbers, with the rounding of cv::remap.
///
/// @param shifts wholeShift() of each pixel, in kShiftSteps
/// @param values result, `count` and padding
void fastWholeSamples(const FastRow& row, const std::int16_t* shifts, std::uint8_t* values);

/// Samples a plane linearly at given places, rounded to 1/32 px, with the rounding of cv::remap.
///
/// @param places from fastPlaces()
/// @param values result, `count` and padding
void fastSamplesAt(const FastRow& row, const float* places, std::uint8_t* values);

} // namespace altiro3D
