#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// Similarity of colours by their squared distance >> kStepColorShift, in steps of 16 and at most
/// kStepColors.
constexpr int kStepColorShift = 4;
constexpr int kStepColors = 512;

/// One px of the neighbourhood that decides to which side of a step a px belongs.
struct StepTap {
    int column;            ///< Relative to the px.
    std::ptrdiff_t offset; ///< Elements of a plane from the px to this one.
    float weight;
};

/// A row of px and what surrounds it. Pointers are to the row's first px. The planes are padded on
/// all sides by the reach of the taps, and at the end of a row by kRowPadding; the other arrays
/// also have kRowPadding.
struct StepRow {
    std::size_t count = 0;        ///< Px of the row; taps beyond it are left out.
    const float* depth = nullptr; ///< Plane of depth.
    /// Plane of weights: px as members of a side. Null: all count fully, also those that are
    /// farther from the middle than the height of the step.
    const float* sure = nullptr;
    const std::int32_t* blueGreen = nullptr; ///< Plane of colours: blue + 65536 green.
    const std::int32_t* red = nullptr;       ///< Plane of colours: red.
    const std::uint8_t* wanted = nullptr;    ///< Not 0: the px is wanted.
    const float* middle = nullptr;           ///< Depth between the sides of the step.
    const float* scale = nullptr;            ///< 2 / height of the step.
    const StepTap* taps = nullptr;           ///< Those of which the rows exist.
    std::size_t tapCount = 0;
    int reach = 0; ///< Largest column of the taps, and least, negated.
};

/// Sums over one side of the steps of a row, per px and padded (kRowPadding).
struct StepSums {
    float* depth = nullptr;  ///< Of weighted depth.
    float* weight = nullptr; ///< Of the weights.
    float* color = nullptr;  ///< Of weighted similarities with the px.
};

/// The sums of both sides of each wanted px, (4.8) of docs/mathematics.md. They are added in the
/// order of the taps, so they have the same bits on all instruction sets.
///
/// @param colorWeight kStepColors + 1 similarities
/// @param nearSide @param farSide results; undefined where a px is not wanted
void sumStepSides(const StepRow& row, const float* colorWeight, const StepSums& nearSide,
                  const StepSums& farSide);

/// A symmetric filter of `count` values: to[x] = weights[0] middle[x] + the sum of weights[k]
/// (before[k][x] + after[k][x]) for k = 1..reach, added in this order.
///
/// @param before @param after `reach` + 1 pointers; those at 0 are not used
/// @param to result; must not overlap the others
void filterRow(const float* middle, const float* const* before, const float* const* after,
               const float* weights, std::size_t reach, std::size_t count, float* to);

} // namespace altiro3D
