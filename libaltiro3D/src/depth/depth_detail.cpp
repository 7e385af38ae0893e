#include "depth/depth_detail.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kReach = 2; // of the binomial kernel, standard deviation 1 px

// One value of the kernel (1 4 6 4 1) / 16.
float blurred(float a, float b, float c, float d, float e) {
    return ((a + e) + 4 * (b + d) + 6 * c) * 0.0625F;
}

// The difference of two rows, with the px at the ends repeated kReach times.
void differenceRow(const float* measured, const float* smooth, int count, float* row) {
    float* const first = row + kReach;
    for (int x = 0; x < count; ++x)
        first[x] = measured[x] - smooth[x];
    std::fill_n(row, kReach, first[0]);
    std::fill_n(first + count, kReach, first[count - 1]);
}

// What the smoothing took, less its blur.
cv::Mat takenDetail(const cv::Mat& measured, const cv::Mat& smooth) {
    cv::Mat detail(measured.size(), CV_32FC1);
    cv::parallel_for_(cv::Range(0, detail.rows), [&](const cv::Range& range) {
        constexpr int kRows = 2 * kReach + 1;
        const auto width = static_cast<std::size_t>(detail.cols + 2 * kReach);
        std::vector<float> rows[kRows]; // of the differences, by turns
        std::vector<float> down(width);
        const auto prepare = [&](int y) { // y may lie beyond the map
            std::vector<float>& row = rows[(y + kRows) % kRows];
            row.resize(width);
            const int inside = std::clamp(y, 0, detail.rows - 1);
            differenceRow(measured.ptr<float>(inside), smooth.ptr<float>(inside), detail.cols,
                          row.data());
        };
        for (int y = range.start - kReach; y < range.start + kReach; ++y)
            prepare(y);
        for (int y = range.start; y < range.end; ++y) {
            prepare(y + kReach);
            const float* around[kRows];
            for (int k = 0; k < kRows; ++k)
                around[k] = rows[(y - kReach + k + kRows) % kRows].data();
            for (std::size_t x = 0; x < width; ++x)
                down[x] =
                    blurred(around[0][x], around[1][x], around[2][x], around[3][x], around[4][x]);
            auto* const to = detail.ptr<float>(y);
            const float* const here = around[kReach] + kReach;
            for (int x = 0; x < detail.cols; ++x)
                to[x] = here[x] - blurred(down[static_cast<std::size_t>(x)],
                                          down[static_cast<std::size_t>(x + 1)],
                                          down[static_cast<std::size_t>(x + 2)],
                                          down[static_cast<std::size_t>(x + 3)],
                                          down[static_cast<std::size_t>(x + 4)]);
        }
    });
    return detail;
}

// The standard deviation of most of the detail, from every fourth px of every fourth row.
float usualDetail(const cv::Mat& detail) {
    constexpr int kStep = 4;
    constexpr float kDeviation = 1.4826F; // per median of a normal distribution
    std::vector<float> sizes;
    for (int y = 0; y < detail.rows; y += kStep)
        for (int x = 0; x < detail.cols; x += kStep)
            sizes.push_back(std::abs(detail.at<float>(y, x)));
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    return kDeviation * *middle;
}

} // namespace

void returnDetail(const cv::Mat& measured, cv::Mat& smooth) {
    const cv::Mat detail = takenDetail(measured, smooth);
    constexpr float kDeviations = 2;
    const float limit = kDeviations * usualDetail(detail);
    cv::parallel_for_(cv::Range(0, detail.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const auto* const from = detail.ptr<float>(y);
            auto* const to = smooth.ptr<float>(y);
            for (int x = 0; x < detail.cols; ++x) {
                if (std::abs(from[x]) <= limit) continue;
                const float ratio = limit / from[x]; // the squares could both underflow
                to[x] = std::clamp(to[x] + (1 - ratio * ratio) * from[x], 0.0F, 1.0F);
            }
        }
    });
}

} // namespace altiro3D
