#pragma once

#include "base/pixel_rows.hpp"
#include "views/depth_offsets.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// Without refinement and with shifts below kMaxWholeShift, Fast computes in 16-bit whole numbers:
/// shifts in steps of 1/128 px, offsets in steps of 1/8192 (kOffsetSteps), and places in steps of
/// 1/32 px, as 32 column + (shift offset + 2^14) >> 15, clamped to the row. A place differs from
/// the exact one by 1/64 px (rounding) and at most 1/128 px (steps of shift and offset).
constexpr float kMaxWholeShift = 64;
constexpr float kShiftSteps = 128;

/// Pixels that read a channel of a row. All arrays are padded (kRowPadding) and read there.
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

/// Pixels that share a window.
constexpr std::size_t kWindowPixels = 32;

/// Parts of a row of the photo that fit into a few registers.
struct RowWindows {
    /// For each kWindowPixels pixels, the first of 16 * `tables` columns of the photo that hold
    /// everything these pixels may read; -1 if it is more.
    std::vector<std::int32_t> starts;
    int tables = 2; ///< 2..4

    /// @param columns columns of the pixels, in order
    /// @param reach largest distance of what a pixel reads from its column, px
    RowWindows(const std::vector<int>& columns, int reach)
        : starts(columns.size() / kWindowPixels + 1, -1) {
        constexpr int kMaxTables = 4;
        for (std::size_t begin = 0; begin < columns.size(); begin += kWindowPixels) {
            const std::size_t last = std::min(begin + kWindowPixels, columns.size()) - 1;
            const auto [left, right] = std::minmax(columns[begin], columns[last]);
            const std::int64_t from = std::max<std::int64_t>(std::int64_t{left} - reach, 0);
            const std::int64_t size =
                std::int64_t{right} + reach + 2 - from; // with the next column
            if (size > 16 * kMaxTables) continue;
            starts[begin / kWindowPixels] = static_cast<std::int32_t>(from);
            tables = std::max(tables, static_cast<int>(size - 1) / 16 + 1);
        }
    }
};

} // namespace altiro3D
