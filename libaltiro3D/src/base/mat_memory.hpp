#pragma once

#include <cstddef>
#include <functional>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Whether two pictures have bytes in common. Parts of one canvas that lie apart have none, though
/// their rows take turns in memory; pictures of different steps count as if they had no gaps.
inline bool shareMemory(const cv::Mat& a, const cv::Mat& b) {
    if (a.empty() || b.empty()) return false;
    const auto used = [](const cv::Mat& m) { // of a row
        return static_cast<std::ptrdiff_t>(m.elemSize()) * m.cols;
    };
    const auto end = [&](const cv::Mat& m) {
        return m.dims > 2 ? m.dataend : m.ptr(m.rows - 1) + used(m);
    };
    const std::less<> before; // also of pointers into different pictures
    if (!before(a.data, end(b)) || !before(b.data, end(a))) return false;
    if (a.dims > 2 || b.dims > 2 || (a.rows == 1 && b.rows == 1)) return true;
    const auto step = static_cast<std::ptrdiff_t>((a.rows > 1 ? a : b).step[0]);
    const bool oneCanvas = a.rows == 1 || b.rows == 1 || a.step[0] == b.step[0];
    if (!oneCanvas || used(a) > step || used(b) > step) return true;
    // Row j of b begins `across` bytes behind row j + down of a, and less than a step before the
    // next one.
    const std::ptrdiff_t apart = b.data - a.data;
    const std::ptrdiff_t across = (apart % step + step) % step;
    const std::ptrdiff_t down = (apart - across) / step;
    const auto meet = [&](std::ptrdiff_t rows) { return rows > -b.rows && rows < a.rows; };
    return (across < used(a) && meet(down)) || (across + used(b) > step && meet(down + 1));
}

/// Lets go of a picture's memory if anybody else holds it, too, so that it can be written to.
///
/// Another thread may have let go of it a moment ago (OpenCV counts atomically): what it read there
/// comes before what is written here.
inline void releaseIfShared(cv::Mat& picture) {
    if (picture.u == nullptr) return;
    if (__atomic_load_n(&picture.u->refcount, __ATOMIC_ACQUIRE) > 1) picture.release();
}

} // namespace altiro3D
