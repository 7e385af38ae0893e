// Bounds of the search column by column: LayeredBounds.

#include "base/pixel_rows.hpp"
#include "views/views_layered_scene.hpp"

#include <algorithm>

namespace altiro3D {

namespace {

// Replaces each value by the maximum of the `size` values that start with it, clipped at the end.
// Each of the log2(size) passes doubles the length of the runs.
void slideMaximum(std::vector<std::int16_t>& values, int size) {
    const auto count = static_cast<int>(values.size());
    const auto combine = [&](int step) {
        for (int i = 0; i + step < count; ++i)
            values[static_cast<std::size_t>(i)] = std::max(
                values[static_cast<std::size_t>(i)], values[static_cast<std::size_t>(i + step)]);
    };
    int length = 1;
    for (; 2 * length <= size; length *= 2)
        combine(length);
    if (length < size) combine(std::min(size, count) - length);
}

} // namespace

void LayeredBounds::describe(int reach, LayeredTables& tables) {
    const auto width = static_cast<std::size_t>(tables.width);
    const auto stride = static_cast<std::size_t>(tables.stride);
    for (std::vector<std::int16_t>* table : {&bounds_, &left_})
        table->resize(2 * stride + kRowPadding);
    const int size = std::min(reach, tables.width) + 1;
    for (std::size_t direction = 0; direction < 2; ++direction) {
        const std::int16_t* words = tables.words + direction * stride;
        const std::size_t begin = direction * stride + kTablePadding;
        ahead_.resize(width);
        std::transform(words, words + width, ahead_.begin(), [](std::int16_t word) {
            return columnWord(wordOffset(word), false, false);
        });
        behind_.assign(ahead_.rbegin(), ahead_.rend());
        window_ = behind_;
        slideMaximum(window_, kLeftColumns); // reversed: covers the columns that end at each
        std::reverse_copy(window_.begin(), window_.end(),
                          left_.begin() + static_cast<std::ptrdiff_t>(begin));
        slideMaximum(ahead_, size);
        slideMaximum(behind_, size);
        for (std::size_t x = 0; x < width; ++x) { // columns to the left are searched anyway, unless
            const int ahead = ahead_[x];          // all content moves to the right
            const int behind = behind_[width - 1 - x];
            bounds_[begin + x] = static_cast<std::int16_t>(std::max(ahead, std::min(behind, 0)));
        }
    }
    tables.bounds = bounds_.data() + kTablePadding;
    tables.left = left_.data() + kTablePadding;
}

} // namespace altiro3D
