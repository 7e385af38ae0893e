#pragma once

#include "views/views_layered_row.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace altiro3D {

// Most pixels need no search: no other surface comes near them, and the offsets around their column
// follow a line, offset(c) = o + m (c - x). They show c = x + s o / (1 - s m), which is computed in
// 16-bit whole numbers (views_layered_lines.hpp).

constexpr int kMaxLineMovement = 32; ///< px; content that moves farther is searched for.

/// What lines need, for each column or for each pixel.
template <class T>
struct LayeredLines {
    std::vector<T> offsets; ///< Movement at the largest shift without the slope, 1/512 px.
    std::vector<T> slopes;  ///< Its change from column to column, 1/32768 px.
    /// Within shifts of -from..to, in 1/32768 of the largest one, the line holds and no other
    /// surface reaches the column; both are -1 if the column follows no line.
    std::vector<T> from;
    std::vector<T> to;

    std::array<std::vector<T>*, 4> all() { return {&offsets, &slopes, &from, &to}; }
};

/// What is known of the columns of a row before any search. Arrays of one value per column, and
/// kRowPadding more.
struct LayeredColumns {
    std::vector<float> offsets; ///< Movement in px per px of shift.
    std::vector<float> slopes;  ///< Change of the offset from column to column.
    /// Within these shifts (px, from <= 0 <= to), no other surface reaches the column.
    std::vector<float> from;
    std::vector<float> to;
    std::vector<float> first;         ///< First column of its surface.
    std::vector<float> mirroredFirst; ///< The same in the mirrored row.
    LayeredLines<std::int32_t> lines;

    std::array<std::vector<float>*, 6> all() {
        return {&offsets, &slopes, &from, &to, &first, &mirroredFirst};
    }
};

/// Describes the columns of a row.
/// @param scratch resized and overwritten
/// @param columns result, resized and overwritten
void layeredColumns(const LayeredTables& tables, std::vector<float>& scratch,
                    LayeredColumns& columns);

} // namespace altiro3D
