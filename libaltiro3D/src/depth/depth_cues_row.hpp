#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// Rows of the built-in estimator. All results have the same bits on all instruction sets. Arrays
// have kRowPadding elements more than named.

namespace altiro3D {

/// Colour differences are counted in this many steps.
constexpr std::size_t kColourSteps = 65536;
/// 255 * sqrt(3) is the difference of black and white.
constexpr auto kColourStepsPerLevel =
    static_cast<float>((kColourSteps - 1) / (255 * 1.7320508075688772));

/// Blue, green and red of a row.
template <class T>
using RowOf3 = std::array<const T*, 3>;

/// The difference of each px from the px of another row, in steps: Euclidean, rounded.
/// @param a @param b 0..255
void colourSteps(const RowOf3<float>& a, const RowOf3<float>& b, std::size_t count,
                 std::uint16_t* steps);

/// 2^-26: sums of its multiples are exact in double up to 2^27.
constexpr double kGrid = 1.0 / (1 << 26);
/// Adding this number and subtracting it rounds to a multiple of kGrid.
constexpr double kToGrid = 1.5 * (1LL << 52) * kGrid;

// The guided filter. Sums over columns of px become sums over windows, which are exact.

/// Windows have 2 * kGuideRadius + 1 px a side.
constexpr std::size_t kGuideRadius = 8;
/// Windows whose colours vary less are smoothed.
constexpr double kGuideFlatVariance = 0.003 * 255 * 255;
/// A row of sums over columns begins and ends with this many zeros.
constexpr std::size_t kGuideMargin = kGuideRadius;

/// Sums of a guide's row, per px.
struct GuideSums {
    std::array<double*, 4> depth{};         ///< Of depth, and of B, G and R times depth.
    std::array<std::int32_t*, 9> colours{}; ///< Of B, G, R, BB, GG, RR, BG, BR, GR.
};

/// Adds a row of px to sums over columns, without the margins, or subtracts it.
/// @param guide 0 beyond the row
/// @param depth multiples of kGrid, 0 beyond the row
void addGuideRow(const RowOf3<std::uint8_t>& guide, const float* depth, std::size_t count,
                 bool subtract, const GuideSums& columns);

/// The numbers of a row of windows.
struct WindowRow {
    std::size_t count = 0;
    const double* widths = nullptr; ///< Px in a row of each window.
    double height = 0;              ///< Rows.
};

/// The depth of each window as a linear function of the colours, rounded to multiples of kGrid.
/// @param columns with margins
/// @param windows memory for sums, without margins
/// @param lines results: factors of B, G and R, and what is added; 0 beyond the row
void fitGuideRow(const WindowRow& row, const GuideSums& columns, const GuideSums& windows,
                 const std::array<float*, 4>& lines);

/// Adds a row of these functions to sums over columns, without the margins, or subtracts it.
void addLinesRow(const std::array<const float*, 4>& lines, std::size_t count, bool subtract,
                 const std::array<double*, 4>& columns);

/// The mean of what the windows around each px give for its colour.
/// @param columns with margins
/// @param windows memory for sums, without margins
void guidedRow(const WindowRow& row, const RowOf3<std::uint8_t>& guide,
               const std::array<double*, 4>& columns, const std::array<double*, 4>& windows,
               float* depth);

} // namespace altiro3D
