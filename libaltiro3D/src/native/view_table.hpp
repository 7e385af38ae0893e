#pragma once

#include "altiro3D/native_lut.hpp"

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace altiro3D {

/// A look-up table in a quarter of the memory: as a table that was built from a calibration takes,
/// for all sub-pixels of a column (row) of the panel, the same column (row) inside the tile, the
/// view of each sub-pixel says the rest.
struct ViewTable {
    cv::Size panelSize;
    QuiltLayout quilt;
    cv::Mat views; ///< [3 panel rows x panel cols, CV_8U or CV_16U]: row 3 y + c is colour c of the
                   ///< panel's row y; blue, green, red. CV_8U up to 256 tiles.
    std::vector<std::uint32_t> columns; ///< X inside the tile, per panel column.
    std::vector<std::uint32_t> rows;    ///< Y inside the tile, per panel row.

    /// Takes from a quilt what each sub-pixel shows.
    /// @param source [quilt.size(), CV_8UC3]
    /// @param native [panelSize, CV_8UC3]
    void render(const cv::Mat& source, cv::Mat& native) const;
};

/// The table of a display, the same as that of NativeLut; none beyond 65536 tiles.
/// @param geometry the display @param quilt a valid layout
std::optional<ViewTable> viewTable(const LensGeometry& geometry, const QuiltLayout& quilt);

/// The same table as a NativeLut; none if that is not of this form, as a `.map` of another program
/// may be.
std::optional<ViewTable> viewTable(const NativeLut& lut);

} // namespace altiro3D
