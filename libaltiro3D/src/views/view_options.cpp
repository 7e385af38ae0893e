#include "altiro3D/view_options.hpp"

#include "base/checks.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D {

void validate(const RealOptions& options) {
    checkNumber(options.inpaintingRadius >= 1 && options.inpaintingRadius <= 20, "inpaintingRadius",
                options.inpaintingRadius, "1..20 px");
}

void validate(const ViewOptions& options) {
    checkNumber(options.strengthPercent >= 0 && options.strengthPercent <= 10000, "strength",
                options.strengthPercent, "0..10000 % of the width");
    checkNumber(options.focus >= 0 && options.focus <= 1, "focus", options.focus,
                "a depth of 0 (farthest) .. 1 (nearest)");
    checkNumber(options.refinement >= 0 && options.refinement <= 16, "refinement",
                options.refinement, "0..16 steps");
    validate(options.real);
    checkNumber(options.layered.tearPixels > 0 && options.layered.tearPixels <= 1000, "tear",
                options.layered.tearPixels, "more than 0 and at most 1000 px");
    checkNumber(options.layered.edgeDilationPixels >= 0 && options.layered.edgeDilationPixels <= 8,
                "edge dilation", options.layered.edgeDilationPixels, "0..8 px");
}

AdjacentParallax adjacentParallax(const ViewOptions& options, const QuiltLayout& quilt,
                                  cv::Size panelSize, cv::Vec2d depthRange) {
    if (quilt.viewCount < 2) return {};
    const double reach =
        std::max(std::abs(depthRange[0] - options.focus), std::abs(depthRange[1] - options.focus));
    const double widths = options.strengthPercent / 100 * reach / (quilt.viewCount - 1);
    return {widths * quilt.tileSize.width, widths * panelSize.width};
}

} // namespace altiro3D
