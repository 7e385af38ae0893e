#pragma once

#include "altiro3D/quilt.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

/// The data of a NativeLut; shared by native_lut.cpp (building) and native_lut_file.cpp (files).
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

/// On a side of `samples` px, the pixel under the centre of pixel `index` of a side of `count` px:
/// floor((index + 0.5) / count * samples), exact.
inline int nearestSample(int index, int count, int samples) {
    return static_cast<int>((2 * std::int64_t{index} + 1) * samples / (2 * std::int64_t{count}));
}

} // namespace altiro3D
