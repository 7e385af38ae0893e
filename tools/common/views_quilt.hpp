#pragma once

#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "common/run_tool.hpp"

#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D::tools {

/// A quilt and the size of its views in their files.
struct ViewsQuilt {
    cv::Mat quilt;     ///< [layout size, CV_8UC3, BGR]
    cv::Size viewSize; ///< Px.
};

/// Reads sorted views into a quilt. If their number differs from the layout's, each tile takes the
/// view of the nearest position.
///
/// @param files from the leftmost camera to the rightmost, at least one
/// @param aspect width : height of the panel, to which `mode` fits each view
/// @param atFile called once with each file, before it is read; its exceptions end the work. A file
///        that no tile shows is not read.
/// @throws Error as readPhoto(), Mismatch (views of different sizes), BadFormat (Natives)
ViewsQuilt quiltOfViews(const std::vector<std::filesystem::path>& files, const QuiltLayout& layout,
                        double aspect, FitMode mode, Messages& messages,
                        const std::function<void(const std::filesystem::path&)>& atFile);

} // namespace altiro3D::tools
