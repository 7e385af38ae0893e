#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

constexpr std::size_t kFitTaps = 4; ///< Along each axis: the cubic B-spline's support.

/// Weights by squared colour distance, in steps of 8; beyond the table (5.6 sigma) the weight is
/// the floor that lets plain interpolation win where no sample resembles the pixel.
constexpr int kColorShift = 3;
constexpr int kColorSteps = 1024;

/// Depth samples and the colours of the guide there. Of each plane, which is padded (kRowPadding),
/// the first of the four rows that a row of the guide reads.
struct FitSamples {
    std::ptrdiff_t stride = 0;               ///< From row to row, of all planes.
    const float* depth = nullptr;            ///< The samples.
    const std::int32_t* blueGreen = nullptr; ///< Their colours: blue + 65536 green, each 0..255.
    const std::int32_t* red = nullptr;       ///< Their colours: red, 0..255.
    const float* least = nullptr;            ///< The least of the 4 x 4 depths from here on.
    const float* most = nullptr;             ///< The most of the 4 x 4 depths from here on.
};

/// What is known of each column of the guide. Rows of all columns, padded (kRowPadding).
struct FitColumns {
    const std::int32_t* tap = nullptr;  ///< Column of the first of its samples, ascending.
    const float* weight[kFitTaps] = {}; ///< Of each of its samples, by nearness.
};

/// A row of the guide: its channels, padded (kRowPadding).
struct FitGuide {
    const std::uint8_t* blue = nullptr;
    const std::uint8_t* green = nullptr;
    const std::uint8_t* red = nullptr;
};

/// The mean depth of the 4 x 4 samples around each px of a row, weighed by nearness and by likeness
/// of colour. The four columns of samples are summed apart, then in pairs: the same to the bit on
/// all instruction sets.
///
/// @param rowWeight weights of the four rows of samples
/// @param colorWeight kColorSteps + 1 weights, by squared colour distance >> kColorShift
/// @param fitted result, `count` and no more
void fitDepthRow(const FitSamples& samples, const FitColumns& columns, const float* rowWeight,
                 const float* colorWeight, const FitGuide& guide, std::size_t count, float* fitted);

} // namespace altiro3D
