#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// Views of `count` sub-pixels: floor(phase * views / 2^32) for the phase (columns[i] + row) modulo
/// 2^32. The result is the same on every instruction set.
///
/// @param columns, row parts of the phase, in 2^-32 lens periods
/// @param highHalves the upper 16 bits of each of `columns`
/// @param views number of views, 1..2^20; at most 256 or 65536 for 8-bit or 16-bit `out`
/// @param phaseError largest error of a phase, in 2^-32
/// @param out one view per sub-pixel
/// @return whether a true phase may lie on the other side of a border between two views
bool viewsOfPhases(const std::uint32_t* columns, const std::uint16_t* highHalves, std::uint32_t row,
                   std::size_t count, std::uint32_t views, std::uint32_t phaseError,
                   std::uint8_t* out);
bool viewsOfPhases(const std::uint32_t* columns, const std::uint16_t* highHalves, std::uint32_t row,
                   std::size_t count, std::uint32_t views, std::uint32_t phaseError,
                   std::uint16_t* out);
bool viewsOfPhases(const std::uint32_t* columns, const std::uint16_t* highHalves, std::uint32_t row,
                   std::size_t count, std::uint32_t views, std::uint32_t phaseError,
                   std::uint32_t* out);

/// Whether the true phase may lie on the other side of a border between two views.
inline bool nearBorder(std::uint32_t phase, std::uint32_t views, std::uint32_t phaseError) {
    const std::uint32_t margin = phaseError * views;
    return phase * views + margin < 2 * margin; // modulo 2^32: the fraction of phase * views
}

} // namespace altiro3D
