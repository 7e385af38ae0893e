// Corrects the flaws of a depth map: refineDepth() of depth_map.hpp.

#include "altiro3D/depth_map.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "depth/refine/depth_contours.hpp"
#include "depth/refine/depth_steps.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

constexpr int kBorder = cv::BORDER_REPLICATE | cv::BORDER_ISOLATED;

void validate(const DepthFlaws& flaws) {
    checkNumber(flaws.softnessPixels >= 0 && flaws.softnessPixels <= 64, "softness",
                flaws.softnessPixels, "0..64 px");
    checkNumber(flaws.growthPixels >= -7 && flaws.growthPixels <= 7, "growth", flaws.growthPixels,
                "-7..7 px");
    for (const int shift : {flaws.shiftPixels.x, flaws.shiftPixels.y})
        checkNumber(shift >= -7 && shift <= 7, "shift", shift, "-7..7 px");
    checkNumber(flaws.mixedPixels >= 0 && flaws.mixedPixels <= 7, "mixed px", flaws.mixedPixels,
                "0..7 px");
}

// Moves the map back; px at the border are repeated.
cv::Mat unshifted(const cv::Mat& depth, cv::Point shift) {
    const int margin = std::max(std::abs(shift.x), std::abs(shift.y));
    cv::Mat wide;
    cv::copyMakeBorder(depth, wide, margin, margin, margin, margin, kBorder);
    return wide(cv::Rect({margin + shift.x, margin + shift.y}, depth.size())).clone();
}

// Makes near things smaller on each side, larger if negative.
void shrink(cv::Mat& depth, int pixels) {
    const int side = 2 * std::abs(pixels) + 1;
    const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
    cv::Mat result;
    if (pixels > 0) cv::erode(depth, result, disc, {-1, -1}, 1, kBorder);
    if (pixels < 0) cv::dilate(depth, result, disc, {-1, -1}, 1, kBorder);
    depth = result;
}

} // namespace

DepthFlaws refineDepth(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& refined,
                       const DepthRefineOptions& options) {
    checkPhotoAndDepth(photo, depth, "depth", "CV_32FC1");
    if (options.keepsDepth()) {
        depth.copyTo(refined);
        return {};
    }
    cv::Mat result = withinRange(depth);
    const DepthFlaws flaws = options.flaws ? *options.flaws : measureDepthFlaws(photo, result);
    validate(flaws);
    if (flaws.shiftPixels != cv::Point()) result = unshifted(result, flaws.shiftPixels);
    int growth = static_cast<int>(std::lround(flaws.growthPixels));
    if (flaws.softnessPixels > 0) {
        if (growth != 0) shrink(result, growth);
        if (flaws.isUneven) {
            decideContours(photo, result);
        } else {
            sharpenSteps(photo, flaws, result);
        }
        growth = 0;
    }
    growth -= flaws.mixedPixels; // at once, because thin things do not survive being shrunk first
    if (growth != 0) shrink(result, growth);
    result.copyTo(refined);
    return flaws;
}

} // namespace altiro3D
