#pragma once

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Lets go of a picture's memory if anybody else holds it, too, so that it can be written to.
///
/// Another thread may have let go of it a moment ago (OpenCV counts atomically): what it read there
/// comes before what is written here.
inline void releaseIfShared(cv::Mat& picture) {
    if (picture.u == nullptr) return;
    if (__atomic_load_n(&picture.u->refcount, __ATOMIC_ACQUIRE) > 1) picture.release();
}

} // namespace altiro3D
