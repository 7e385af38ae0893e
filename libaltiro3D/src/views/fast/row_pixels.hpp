#pragma once

#include "base/pixel_rows.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

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
