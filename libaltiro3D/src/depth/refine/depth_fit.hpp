#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

/// Resampling of depth, with and without a picture.
namespace altiro3D {

/// As fitDepth() without a guide: enlarges by linear interpolation, without regard to edges. Method
/// Fast makes views of the same accuracy from it (docs/lab/edges.md), in less time. The same bytes
/// on all processors, and in a quarter of the time of cv::warpAffine().
/// @param size of the result
/// @throws Error as fitDepth()
void interpolateDepth(const cv::Mat& depth, const cv::Rect2d& part, cv::Size size, cv::Mat& fitted);

/// As fitDepth(), but hard steps stay hard, where fitDepth() makes depths between their sides.
/// Depth lies within the range of the 2 x 2 samples around it. If these differ by 0.03 and by 0.6
/// of the range of the 4 x 4 samples around, the depth is their least or largest one, whichever is
/// nearer to that of fitDepth().
/// @throws Error as fitDepth()
void fitRefinedDepth(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide,
                     cv::Mat& fitted);

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

} // namespace altiro3D
