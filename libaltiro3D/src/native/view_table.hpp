#pragma once

#include "altiro3D/native_lut.hpp"

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace altiro3D {

/// A look-up table in a quarter of the memory. In a table built from a calibration, all sub-pixels
/// of a panel column (row) have the same column (row) inside the tile, so only the view of each
/// sub-pixel is stored.
struct ViewTable {
    cv::Size panelSize;
    QuiltLayout quilt;
    cv::Mat views; ///< [3 panel rows x panel cols, CV_8U or CV_16U]: row 3 y + c is colour c of the
                   ///< panel's row y; blue, green, red. CV_8U up to 256 tiles.
    std::vector<std::uint32_t> columns; ///< X inside the tile, per panel column.
    std::vector<std::uint32_t> rows;    ///< Y inside the tile, per panel row.

    /// Renders a Native from a quilt.
    /// @param source [quilt.size(), CV_8UC3]
    /// @param native [panelSize, CV_8UC3]
    void render(const cv::Mat& source, cv::Mat& native) const;
};

/// Builds the table of a display, equivalent to NativeLut; none beyond 65536 tiles.
/// @param geometry the display
/// @param quilt a valid layout
std::optional<ViewTable> viewTable(const LensGeometry& geometry, const QuiltLayout& quilt);

/// Converts a NativeLut; none if it does not have this form, for example in a `.map` of another
/// program.
std::optional<ViewTable> viewTable(const NativeLut& lut);

} // namespace altiro3D
