#pragma once

#include <cstddef>
#include <functional>
#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// Whether two pictures have bytes in common. Disjoint regions of one canvas have none, although
/// their rows alternate in memory. Pictures with different steps are treated as if they had no
/// gaps.
inline bool shareMemory(const cv::Mat& a, const cv::Mat& b) {
    if (a.empty() || b.empty()) return false;
    const auto used = [](const cv::Mat& m) { // of a row
        return static_cast<std::ptrdiff_t>(m.elemSize()) * m.cols;
    };
    const auto end = [&](const cv::Mat& m) {
        return m.dims > 2 ? m.dataend : m.ptr(m.rows - 1) + used(m);
    };
    const std::less<> before; // defined also for pointers into different pictures
    if (!before(a.data, end(b)) || !before(b.data, end(a))) return false;
    if (a.dims > 2 || b.dims > 2 || (a.rows == 1 && b.rows == 1)) return true;
    const auto step = static_cast<std::ptrdiff_t>((a.rows > 1 ? a : b).step[0]);
    const bool oneCanvas = a.rows == 1 || b.rows == 1 || a.step[0] == b.step[0];
    if (!oneCanvas || used(a) > step || used(b) > step) return true;
    // Row j of b begins `across` bytes after the start of row j + down of a, and less than a step
    // before the next row.
    const std::ptrdiff_t apart = b.data - a.data;
    const std::ptrdiff_t across = (apart % step + step) % step;
    const std::ptrdiff_t down = (apart - across) / step;
    const auto meet = [&](std::ptrdiff_t rows) { return rows > -b.rows && rows < a.rows; };
    return (across < used(a) && meet(down)) || (across + used(b) > step && meet(down + 1));
}

/// Releases a picture's memory if it is shared, so the picture can be written to.
///
/// Another thread may have just released it (OpenCV counts references atomically). The acquire load
/// orders its reads before our writes.
inline void releaseIfShared(cv::Mat& picture) {
    if (picture.u == nullptr) return;
    if (__atomic_load_n(&picture.u->refcount, __ATOMIC_ACQUIRE) > 1) picture.release();
}

} // namespace altiro3D
