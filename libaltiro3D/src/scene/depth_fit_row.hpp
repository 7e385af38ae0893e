#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

constexpr std::size_t kFitTaps = 4; ///< Along each axis: the cubic B-spline's support.

/// Weights by squared colour distance, in steps of 8; beyond the table (5.6 sigma) the weight is a
/// floor, so plain interpolation results where no sample resembles the pixel.
constexpr int kColorShift = 3;
constexpr int kColorSteps = 1024;

/// Depth samples and the colours of the guide there. Pointers are to the first of the four rows
/// that a row of the guide reads. The planes are padded (kRowPadding).
struct FitSamples {
    std::ptrdiff_t stride = 0;               ///< Elements from row to row, of all planes.
    const float* depth = nullptr;            ///< The samples.
    const std::int32_t* blueGreen = nullptr; ///< Their colours: blue + 65536 green, each 0..255.
    const std::int32_t* red = nullptr;       ///< Their colours: red, 0..255.
    const float* least = nullptr;            ///< The minimum of the 4 x 4 depths that start here.
    const float* most = nullptr;             ///< The maximum of the 4 x 4 depths that start here.
};

/// Taps and weights of each column of the guide, padded (kRowPadding).
struct FitColumns {
    const std::int32_t* tap = nullptr;  ///< Column of its first sample, ascending.
    const float* weight[kFitTaps] = {}; ///< Weights of its samples by distance.
};

/// A row of the guide: its channels, padded (kRowPadding).
struct FitGuide {
    const std::uint8_t* blue = nullptr;
    const std::uint8_t* green = nullptr;
    const std::uint8_t* red = nullptr;
};

/// The mean depth of the 4 x 4 samples around each px of a row, weighted by distance and by
/// similarity of colour. The four columns of samples are summed separately, then in pairs, so the
/// result has the same bits on all instruction sets.
///
/// @param rowWeight weights of the four rows of samples
/// @param colorWeight kColorSteps + 1 weights, by squared colour distance >> kColorShift
/// @param fitted result, exactly `count`
void fitDepthRow(const FitSamples& samples, const FitColumns& columns, const float* rowWeight,
                 const float* colorWeight, const FitGuide& guide, std::size_t count, float* fitted);

} // namespace altiro3D
