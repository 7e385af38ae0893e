#pragma once

#include "altiro3D/quilt.hpp"
#include "base/pixel_rows.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

/// The data of a NativeLut.
struct NativeLutTables {
    cv::Size panelSize;
    QuiltLayout quilt;
    std::uint64_t calibrationFingerprint = 0;
    std::string serial;
    bool inverted = true;
    /// R, G, B: [panel rows x cols, CV_16UC2, (X, Y)], continuous, one after the other.
    std::array<cv::Mat, 3> channels;

    /// Allocates the three tables. @throws Error OutOfMemory
    void allocate();

    /// All three tables in the order of the file.
    std::uint8_t* data() const { return channels[0].data; }
    std::size_t size() const { return 3 * channels[0].total() * channels[0].elemSize(); }
};

} // namespace altiro3D
