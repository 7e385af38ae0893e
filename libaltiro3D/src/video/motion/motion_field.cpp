#include "video/motion/motion_field.hpp"

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

// Where the centres of `count` px are among `values` px of the same length.
std::vector<Between> places(int count, int values) {
    const float scale = static_cast<float>(values) / static_cast<float>(count);
    std::vector<Between> result(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i)
        result[static_cast<std::size_t>(i)] =
            between((static_cast<float>(i) + 0.5F) * scale - 0.5F, values);
    return result;
}

} // namespace

cv::Mat joinMotion(const cv::Mat& earlier, const cv::Mat& later) {
    CV_Assert(earlier.size() == later.size());
    cv::Mat joined(later.size(), CV_32FC2);
    for (int y = 0; y < later.rows; ++y) {
        const auto* same = earlier.ptr<cv::Vec2f>(y);
        const auto* last = later.ptr<cv::Vec2f>(y);
        auto* out = joined.ptr<cv::Vec2f>(y);
        for (int x = 0; x < later.cols; ++x) {
            if (isStill(last[x])) {
                out[x] = same[x];
                continue;
            }
            const Between right = between(static_cast<float>(x) + last[x][0], earlier.cols);
            const Between down = between(static_cast<float>(y) + last[x][1], earlier.rows);
            out[x] = last[x] + sampled<cv::Vec2f>(earlier, right, down);
        }
    }
    return joined;
}

void carry(const cv::Mat& before, const cv::Mat& motion, cv::Mat& moved) {
    CV_Assert(moved.data != before.data || before.empty());
    moved.create(before.size(), CV_32FC1);
    const float perX = static_cast<float>(motion.cols) / static_cast<float>(before.cols);
    const float perY = static_cast<float>(motion.rows) / static_cast<float>(before.rows);
    const std::vector<Between> columns = places(before.cols, motion.cols);
    cv::parallel_for_(cv::Range(0, before.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const Between down = between((static_cast<float>(y) + 0.5F) * perY - 0.5F, motion.rows);
            const auto* same = before.ptr<float>(y);
            auto* out = moved.ptr<float>(y);
            for (int x = 0; x < before.cols; ++x) {
                const auto vector =
                    sampled<cv::Vec2f>(motion, columns[static_cast<std::size_t>(x)], down);
                if (isStill(vector)) {
                    out[x] = same[x];
                    continue;
                }
                out[x] = sampled<float>(
                    before, between(static_cast<float>(x) + vector[0] / perX, before.cols),
                    between(static_cast<float>(y) + vector[1] / perY, before.rows));
            }
        }
    });
}

cv::Mat stretched(const cv::Mat& values, int rows, int cols) {
    cv::Mat result(rows, cols, CV_32FC1);
    const float perY = static_cast<float>(values.rows) / static_cast<float>(rows);
    const std::vector<Between> columns = places(cols, values.cols);
    for (int y = 0; y < rows; ++y) {
        const Between down = between((static_cast<float>(y) + 0.5F) * perY - 0.5F, values.rows);
        auto* out = result.ptr<float>(y);
        for (int x = 0; x < cols; ++x) {
            out[x] = sampled<float>(values, columns[static_cast<std::size_t>(x)], down);
        }
    }
    return result;
}

} // namespace altiro3D
