#pragma once

#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "common/run_tool.hpp"

#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D::tools {

/// A quilt and the size that its views had in their files.
struct ViewsQuilt {
    cv::Mat quilt;     ///< [layout size, CV_8UC3, BGR]
    cv::Size viewSize; ///< Px.
};

/// Reads sorted views into a quilt; where there are more or fewer than the layout has, each of its
/// views takes the nearest.
///
/// @param directory where they lie, for warnings
/// @param files from the leftmost camera to the rightmost, at least one
/// @param aspect width : height of the panel, to which each is fitted by `mode`
/// @param atFile is told each file before it is read; what it throws ends the work
/// @throws Error as readPhoto(), Mismatch (views of different sizes), BadFormat (Natives, pictures
///         that do not resemble each other)
ViewsQuilt quiltOfViews(const std::filesystem::path& directory,
                        const std::vector<std::filesystem::path>& files, const QuiltLayout& layout,
                        double aspect, FitMode mode, Messages& messages,
                        const std::function<void(const std::filesystem::path&)>& atFile);

} // namespace altiro3D::tools
