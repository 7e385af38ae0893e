#include "base/large_mat.hpp"

#include <cstdint>
#include <opencv2/core.hpp>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace altiro3D {

cv::Mat largeMat(int rows, int cols, int type) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    // The first access to a 4 KiB page takes about 1.5 us, half of the time to build a table of 38
    // MB. The first access to a 2 MiB page takes about 60 us.
    constexpr std::size_t kPage = std::size_t{2} << 20;
    const std::size_t elementSize = CV_ELEM_SIZE(type);
    const std::size_t count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
    const std::size_t padding = kPage / elementSize + 1;
    if (count * elementSize >= 2 * kPage && count + padding < std::size_t{1} << 31) {
        const cv::Mat block(1, static_cast<int>(count + padding), type);
        const auto at = reinterpret_cast<std::uintptr_t>(block.data);
        const std::size_t skip = (kPage - at % kPage) % kPage;
        if (skip % elementSize == 0) {
            const auto begin = static_cast<int>(skip / elementSize);
            const cv::Mat part = block.colRange(begin, begin + static_cast<int>(count));
            // A hint; the system may refuse it.
            ::madvise(part.data, count * elementSize / kPage * kPage, MADV_HUGEPAGE);
            cv::Mat whole = part.reshape(0, rows);
            // OpenCV's filters read the pixels around a part of a larger picture.
            whole.flags &= ~cv::Mat::SUBMATRIX_FLAG;
            whole.datastart = whole.data;
            whole.dataend = whole.datalimit = whole.data + count * elementSize;
            return whole;
        }
    }
#endif
    return cv::Mat(rows, cols, type);
}

} // namespace altiro3D
