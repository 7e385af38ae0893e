#pragma once

#include "altiro3D/depth2quilt.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace altiro3D::test {

/// The files of one stereo pair with true disparity.
struct MiddleburyFiles {
    std::string name;
    std::filesystem::path left;
    std::filesystem::path right;
    std::filesystem::path disparity; ///< Of the left picture; 0 and non-finite are unknown.
    double scale = 1;                ///< Values in `disparity` per px.
};

/// The pairs that scenes.csv lists; empty if there is no such file.
std::vector<MiddleburyFiles> listMiddlebury(const std::filesystem::path& folder);

/// One pair of the large test data; throws std::runtime_error if it is missing or unreadable.
StereoScene middleburyScene(const std::string& name);

} // namespace altiro3D::test
