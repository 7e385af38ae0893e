#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// Rows that kernels work on are this much longer than what they hold, so that whole vectors fit.
constexpr std::size_t kRowPadding = 64;

/// A row of `count` zeros, padded.
template <class T>
std::vector<T> paddedRow(std::size_t count) {
    return std::vector<T>(count + kRowPadding);
}

/// Shifts p S/2 of sub-pixels that show whole views: p = (2 view - (views - 1)) / (views - 1), 0 if
/// there is one view. Reads and writes up to kRowPadding more.
/// @param views view of each of `count` sub-pixels @param viewCount number of views, >= 1
/// @param halfParallax S/2 in px @param shifts result in px
void shiftsOfViews(const std::uint16_t* views, std::size_t count, int viewCount, float halfParallax,
                   float* shifts);

/// Shifts p S/2 of sub-pixels that show any position: p = (2 N z - N) / (N - 1), clamped to +-1,
/// for the phase z = (columns[i] + row) / 2^32. Reads and writes up to kRowPadding more.
/// @param columns, row as LensPhases gives them @param viewCount N >= 1
/// @param halfParallax S/2 in px @param shifts result in px
void shiftsOfPhases(const std::uint32_t* columns, std::uint32_t row, std::size_t count,
                    int viewCount, float halfParallax, float* shifts);

/// Planes to B G R pixels. Reads up to kRowPadding more, writes 3 * count bytes.
void interleaveRow(const std::uint8_t* blue, const std::uint8_t* green, const std::uint8_t* red,
                   std::size_t count, std::uint8_t* bgr);

/// B G R pixels to planes. Reads 3 * count bytes, writes `count` each.
void splitRow(const std::uint8_t* bgr, std::size_t count, std::uint8_t* blue, std::uint8_t* green,
              std::uint8_t* red);

} // namespace altiro3D
