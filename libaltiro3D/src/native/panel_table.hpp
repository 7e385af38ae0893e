#pragma once

#include "altiro3D/display.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace altiro3D {

/// Allocates three rows of a table for each row of a panel. @throws Error OutOfMemory
inline cv::Mat panelTable(cv::Size panel, int type) {
    const auto bytes = 3LL * CV_ELEM_SIZE(type) * panel.width * panel.height;
    return orOutOfMemory("look-up table",
                         "no memory for a panel of " + sizeText(panel) + ", expected " +
                             std::to_string(bytes / 1000000) + " MB to be free",
                         [&] { return cv::Mat(3 * panel.height, panel.width, type); });
}

/// Refuses prints that are larger than panels. @throws Error TooLarge
/// @param what "look-up table", for the message
inline void requirePanelSize(const LensGeometry& g, const char* what) {
    if (g.panelWidth <= kMaxPanelSide && g.panelHeight <= kMaxPanelSide) return;
    throw Error(ErrorCode::TooLarge, what,
                "would have " + sizeText(cv::Size(g.panelWidth, g.panelHeight)) +
                    ", expected at most " + std::to_string(kMaxPanelSide) +
                    " px a side; larger prints are made without");
}

/// For each px of a side of the panel, the px of a side of a view under its centre.
/// @param mirrored the panel shows views mirrored along this side
inline std::vector<int> samplesUnder(int panel, int samples, bool mirrored) {
    std::vector<int> result(static_cast<std::size_t>(panel));
    for (int i = 0; i < panel; ++i)
        result[static_cast<std::size_t>(mirrored ? panel - 1 - i : i)] =
            nearestSample(i, panel, samples);
    return result;
}

} // namespace altiro3D
