#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// A picture of many MB for a result that is written once from end to end, which fresh memory in
/// pages of 4 KiB makes several times slower. The system is asked for large pages where it has
/// them; the contents are not set.
///
/// @return [rows x cols, type], continuous
cv::Mat largeMat(int rows, int cols, int type);

} // namespace altiro3D
