#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Allocates a picture of many MB for a result that is written once from end to end. Fresh memory
/// in pages of 4 KiB makes this several times slower, so large pages are requested if the system
/// has them. The contents are not initialized.
///
/// @return [rows x cols, type], continuous
cv::Mat largeMat(int rows, int cols, int type);

} // namespace altiro3D
