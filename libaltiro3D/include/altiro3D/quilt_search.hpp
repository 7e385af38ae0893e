#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Compares a quilt with its layout, which its name or an option states.
/// @param picture [rows x cols, CV_8UC3, BGR]
/// @param layout columns, rows and number of views
/// @return remarks, usually none: views of one colour (AsItIs), rows that run from the top to the
///         bottom or another layout that is in the picture (Doubtful)
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT Notes checkQuiltLayout(const cv::Mat& picture,
                                                     const QuiltLayout& layout);

} // namespace altiro3D
