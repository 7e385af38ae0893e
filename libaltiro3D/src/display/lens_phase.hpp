#pragma once

#include "altiro3D/display.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// LensGeometry::phase in fixed point: the phase of sub-pixel (x, y, colour) is columnPhases(y,
/// colour)[x] + rowPhase(y, colour) modulo 2^32, in 2^-32 lens periods. It differs from the double
/// value by at most phaseError(). View order, mirroring and cells are included. Rows y count from
/// the top; colour is 0 red, 1 green, 2 blue.
///
/// Immutable; safe to use from any number of threads.
class LensPhases {
  public:
    /// @param geometry from lensGeometry()
    explicit LensPhases(LensGeometry geometry);

    const LensGeometry& geometry() const { return geometry_; }

    /// The column's part of the phase, without an order of views: `panelWidth` numbers, padded
    /// (kRowPadding). On stripe panels all rows and colours share them, on panels with cells every
    /// fourth row.
    const std::uint32_t* columnPhases(int y, int colour) const {
        return columns_[tableOf(y, colour)].data();
    }

    /// The upper 16 bits of columnPhases().
    const std::uint16_t* columnHalves(int y, int colour) const {
        return highHalves_[tableOf(y, colour)].data();
    }

    /// The part of the phase that depends on the row.
    std::uint32_t rowPhase(int y, int colour) const {
        return rows_[static_cast<std::size_t>(colour)][static_cast<std::size_t>(y)];
    }

    /// Largest error in 2^-32 lens periods: 3 on real displays, at most 40.
    std::uint32_t phaseError() const { return phaseError_; }

    /// Views of a row, equal to LensGeometry::view. Sub-pixels too
    /// near to the border between two views are recomputed in double precision.
    /// @param views number of views: 1..256, 1..65536 or 1..2^20, by the type of `out`
    /// @param out `panelWidth` views
    void viewsOfRow(int y, int colour, int views, std::uint8_t* out) const;
    void viewsOfRow(int y, int colour, int views, std::uint16_t* out) const;
    void viewsOfRow(int y, int colour, int views, std::uint32_t* out) const;

  private:
    template <class Kernel, class T>
    void fillViews(const Kernel& viewsOfPhases, int y, int colour, int views, T* out) const;

    std::size_t tableOf(int y, int colour) const {
        if (geometry_.cells.empty()) return 0;
        const int pattern = (geometry_.panelHeight - 1 - y) % kRowPatterns;
        return static_cast<std::size_t>(3 * pattern + colour);
    }

    // Cells repeat after 4 rows at most, counted from the bottom.
    static constexpr int kRowPatterns = 4;

    LensGeometry geometry_;
    std::vector<std::vector<std::uint32_t>> columns_;    // one, or 3 per row pattern
    std::vector<std::vector<std::uint16_t>> highHalves_; // upper halves of columns_
    std::array<std::vector<std::uint32_t>, 3> rows_;     // per colour
    std::uint32_t phaseError_ = 0;
};

} // namespace altiro3D
