#include "image/downscale.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

cv::Size downscaledSize(cv::Size size, int longestSide) {
    const int longSide = std::max(size.width, size.height);
    if (longSide <= longestSide) return size;
    const auto scaled = [&](int side) {
        const double exact = static_cast<double>(side) * longestSide / longSide;
        return std::max(1, static_cast<int>(std::lround(exact)));
    };
    return {scaled(size.width), scaled(size.height)};
}

// Reads the photo and writes its area average with at most `longestSide` px per side; memory limits
// the speed. Integer sums make the result exact. The blocks are placed symmetrically, so a mirrored
// photo gives the mirrored result.
cv::Mat downscale(const cv::Mat& photo, int longestSide) {
    const cv::Size size = downscaledSize(photo.size(), longestSide);
    if (size == photo.size()) return photo.clone();
    cv::Mat small(size, CV_8UC3);
    const auto blockBegin = [](int i, int from, int to) {
        return static_cast<int>(static_cast<std::int64_t>(i) * from / to);
    };
    const auto blockEnd = [](int i, int from, int to) {
        return static_cast<int>((static_cast<std::int64_t>(i + 1) * from + to - 1) / to);
    };
    cv::parallel_for_(cv::Range(0, small.rows), [&](const cv::Range& range) {
        std::vector<std::uint32_t> sums(static_cast<std::size_t>(photo.cols) * 3);
        for (int y = range.start; y < range.end; ++y) {
            std::fill(sums.begin(), sums.end(), 0U);
            const int top = blockBegin(y, photo.rows, small.rows);
            const int bottom = blockEnd(y, photo.rows, small.rows);
            for (int sourceY = top; sourceY < bottom; ++sourceY) {
                const uchar* source = photo.ptr<uchar>(sourceY);
                for (std::size_t i = 0; i < sums.size(); ++i)
                    sums[i] += source[i];
            }
            uchar* out = small.ptr<uchar>(y);
            for (int x = 0; x < small.cols; ++x) {
                const int left = blockBegin(x, photo.cols, small.cols);
                const int right = blockEnd(x, photo.cols, small.cols);
                std::array<std::uint64_t, 3> total{};
                for (int sourceX = left; sourceX < right; ++sourceX) {
                    const std::size_t i = static_cast<std::size_t>(sourceX) * 3;
                    for (std::size_t c = 0; c < 3; ++c)
                        total[c] += sums[i + c];
                }
                const std::uint64_t count = static_cast<std::uint64_t>(right - left) *
                                            static_cast<std::uint64_t>(bottom - top);
                for (std::size_t c = 0; c < 3; ++c)
                    out[3 * x + static_cast<int>(c)] =
                        static_cast<uchar>((total[c] + count / 2) / count);
            }
        }
    });
    return small;
}

} // namespace altiro3D
