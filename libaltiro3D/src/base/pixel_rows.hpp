#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// Padding at the end of rows for kernels, so whole vectors can be read and written.
constexpr std::size_t kRowPadding = 64;

/// A row of `count` zeros, padded.
template <class T>
std::vector<T> paddedRow(std::size_t count) {
    return std::vector<T>(count + kRowPadding);
}

/// Planes to B G R pixels. Reads up to kRowPadding beyond `count`, writes 3 * count bytes.
void interleaveRow(const std::uint8_t* blue, const std::uint8_t* green, const std::uint8_t* red,
                   std::size_t count, std::uint8_t* bgr);

/// B G R pixels to planes. Reads 3 * count bytes, writes `count` bytes per plane.
void splitRow(const std::uint8_t* bgr, std::size_t count, std::uint8_t* blue, std::uint8_t* green,
              std::uint8_t* red);

} // namespace altiro3D
