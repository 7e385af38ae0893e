#include "video/motion_field.hpp"

#include <opencv2/core.hpp>

namespace altiro3D {

cv::Mat joinMotion(const cv::Mat& earlier, const cv::Mat& later) {
    cv::Mat joined(later.size(), CV_32FC2);
    for (int y = 0; y < later.rows; ++y) {
        const auto* last = later.ptr<cv::Vec2f>(y);
        auto* out = joined.ptr<cv::Vec2f>(y);
        for (int x = 0; x < later.cols; ++x) {
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
    cv::parallel_for_(cv::Range(0, before.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const Between down = between((static_cast<float>(y) + 0.5F) * perY - 0.5F, motion.rows);
            const auto* same = before.ptr<float>(y);
            auto* out = moved.ptr<float>(y);
            for (int x = 0; x < before.cols; ++x) {
                const Between right =
                    between((static_cast<float>(x) + 0.5F) * perX - 0.5F, motion.cols);
                const auto vector = sampled<cv::Vec2f>(motion, right, down);
                if (vector[0] == 0 && vector[1] == 0) {
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
    const float perX = static_cast<float>(values.cols) / static_cast<float>(cols);
    const float perY = static_cast<float>(values.rows) / static_cast<float>(rows);
    for (int y = 0; y < rows; ++y) {
        const Between down = between((static_cast<float>(y) + 0.5F) * perY - 0.5F, values.rows);
        auto* out = result.ptr<float>(y);
        for (int x = 0; x < cols; ++x) {
            out[x] = sampled<float>(
                values, between((static_cast<float>(x) + 0.5F) * perX - 0.5F, values.cols), down);
        }
    }
    return result;
}

} // namespace altiro3D
