#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// Offset of a depth from the focus, exactly 0 there. Depth is clamped to 0..1, NaN counts as 0.
inline float offsetFromFocus(float depth, double focus) {
    const float d = depth > 0 ? (depth < 1 ? depth : 1.0F) : 0.0F;
    if (d == static_cast<float>(focus)) return 0; // also if the focus is not representable as float
    return static_cast<float>(static_cast<double>(d) - focus);
}

/// offsetFromFocus() of a row. @param depth `count` values @param offsets result, `count` values
void offsetsFromFocus(const float* depth, std::size_t count, double focus, float* offsets);

/// Steps of wholeOffsets() per unit of depth.
constexpr float kOffsetSteps = 8192;

/// Offsets of a row from the focus as whole numbers, to the nearest step.
/// @param depth `count` values @param offsets result, `count` and up to kRowPadding more
/// @return whether all of them are 0
bool wholeOffsets(const float* depth, std::size_t count, double focus, std::int32_t* offsets);

/// Finds the columns of a row whose offset differs from the next one's by more than `tear`.
/// @param steps result, ascending
void findSteps(const float* offsets, std::size_t count, double tear, std::vector<int>& steps);

} // namespace altiro3D
