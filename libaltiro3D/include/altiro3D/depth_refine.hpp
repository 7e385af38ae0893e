#pragma once

#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>

namespace altiro3D {

/// How a depth map as a whole differs from its photo. All zero: no flaw was found.
struct DepthFlaws {
    /// Width over which depth steps are spread, px, 0..64; 0 for hard steps. A Gaussian blur of
    /// sigma s gives 2.5 s - 1.
    double softnessPixels = 0;
    /// Soft steps overshoot on both sides, by this part of their height, -1..1. Enlarged depth
    /// does, blurred depth does not (0 or less).
    double overshoot = 0;
    /// Near things are too large by this on each side, px, -7..7; negative: too small.
    double growthPixels = 0;
    /// The depth map lies this far to the right of the photo and below it, px, each -7..7.
    cv::Point shiftPixels;
    /// Standard deviation of the noise on surfaces, in units of depth, 0..1.
    double noise = 0;
};

/// Options of refineDepth().
struct DepthRefineOptions {
    /// false: the depth map is exact and stays as it is.
    bool enabled = true;
    /// Flaws to correct, for example those of an earlier frame of a scene; not set: they are
    /// measured.
    std::optional<DepthFlaws> flaws;
};

/// Measures how a depth map differs from its photo. A flaw counts if many edges of the picture show
/// it; single edges may differ. Flaws that are too small to matter are reported as 0
/// (docs/mathematics.md, 4a).
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; values beyond are clamped, NaN counts as 0
/// @return the flaws; the same for any number of threads
/// @throws Error InvalidArgument (empty, wrong type), Mismatch (sizes differ)
[[nodiscard]] ALTIRO3D_EXPORT DepthFlaws measureDepthFlaws(const cv::Mat& photo,
                                                           const cv::Mat& depth);

/// Corrects the flaws of a depth map: smooths noise on surfaces, moves edges to the edges of the
/// photo, and turns soft steps into hard ones where the photo has an edge. A depth map without
/// flaws stays as it is.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; values beyond are clamped, NaN counts as 0
/// @param refined [as depth]; may be `depth` itself. The same bytes for any number of threads.
/// @param options which flaws; with `enabled` false the depth is copied unchanged
/// @throws Error InvalidArgument (empty, wrong type, flaws out of range), Mismatch (sizes differ)
ALTIRO3D_EXPORT void refineDepth(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& refined,
                                 const DepthRefineOptions& options = {});

} // namespace altiro3D
