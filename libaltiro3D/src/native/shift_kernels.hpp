#pragma once

#include "base/pixel_rows.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// Shifts p S/2 of sub-pixels that show whole views: p = (2 view - (views - 1)) / (views - 1), 0
/// for a single view. All functions here read and write up to kRowPadding beyond `count`.
/// @param views view of each of `count` sub-pixels
/// @param halfParallax S/2 in px
/// @param shifts result in px
void shiftsOfViews(const std::uint16_t* views, std::size_t count, int viewCount, float halfParallax,
                   float* shifts);

/// Shifts p S/2 of sub-pixels with continuous positions: p = (2 N z - N) / (N - 1), clamped to +-1,
/// for the phase z = (columns[i] + row) / 2^32, N = viewCount >= 1.
/// @param columns, row phases from LensPhases
void shiftsOfPhases(const std::uint32_t* columns, std::uint32_t row, std::size_t count,
                    int viewCount, float halfParallax, float* shifts);

/// wholeShift() of p S/2 for sub-pixels that show whole views.
class WholeShifts {
  public:
    /// @param shifts p S/2 of each view in px; 1..65536 views
    /// @param steps per px; 0 if ofViews() will not be called
    WholeShifts(const std::vector<double>& shifts, double steps);

    void ofViews(const std::uint16_t* views, std::size_t count, std::int16_t* shifts) const;

  private:
    std::vector<std::int16_t> ofView_;
    // The shift of a view is 2 view - (views - 1) times the sum of these.
    std::int16_t perStep_ = 0;
    std::int16_t fraction_ = 0; // in units of 2^-15
    bool byProduct_ = false;    // whether this gives the shifts of all views
};

/// wholeShift() of p S/2 for sub-pixels with continuous positions, as shiftsOfPhases(), from the
/// upper halves of phases: exact to 2^-14.
/// @param columnHalves LensPhases::columnHalves()
/// @param halfParallax S/2 in px, at most 16384 steps
/// @param steps per px
void wholeShiftsOfPhases(const std::uint16_t* columnHalves, std::uint32_t row, std::size_t count,
                         int viewCount, float halfParallax, double steps, std::int16_t* shifts);

} // namespace altiro3D
