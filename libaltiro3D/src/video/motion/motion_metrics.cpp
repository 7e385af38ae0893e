#include "video/motion/motion_metrics.hpp"

#include "video/motion/motion_field.hpp"
#include "video/motion/motion_search.hpp"
#include "video/motion/small_image.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

cv::Mat misfit(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion) {
    CV_Assert(before.size() == now.size());
    cv::Mat moved(now.size(), CV_8UC1);
    for (int y = 0; y < now.rows; ++y) {
        const uchar* same = before.ptr(y);
        const auto* vector = motion.ptr<cv::Vec2f>(y);
        uchar* out = moved.ptr(y);
        for (int x = 0; x < now.cols; ++x) {
            if (isStill(vector[x])) {
                out[x] = same[x];
                continue;
            }
            const Between right = between(static_cast<float>(x) + vector[x][0], before.cols);
            const Between down = between(static_cast<float>(y) + vector[x][1], before.rows);
            const uchar* above = before.ptr(down.low);
            const uchar* below = before.ptr(down.high);
            const auto mix = [](uchar a, uchar b, float share) {
                return mixed(static_cast<float>(a), static_cast<float>(b), share);
            };
            out[x] = static_cast<uchar>(mixed(mix(above[right.low], above[right.high], right.share),
                                              mix(below[right.low], below[right.high], right.share),
                                              down.share) +
                                        0.5F);
        }
    }
    cv::Mat difference;
    cv::absdiff(matchedBrightness(moved, now), now, difference);
    cv::Mat result;
    cv::boxFilter(difference, result, CV_32F, cv::Size(3, 3), cv::Point(-1, -1), false,
                  cv::BORDER_REPLICATE);
    for (int y = 0; y < result.rows; ++y) {
        auto* row = result.ptr<float>(y);
        for (int x = 0; x < result.cols; ++x)
            row[x] /= 9;
    }
    return result;
}

double dissimilarity(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion,
                     const cv::Mat& misfits) {
    constexpr double kNoise = 4;      // grey levels; uniform pictures differ only by noise
    constexpr float kWild = 3;        // px from one cell to the next
    constexpr double kWildShare = .5; // weight of wild motion relative to the misfit
    double sum = 0;
    int pairs = 0;
    int wild = 0;
    for (int y = 0; y < now.rows; ++y) {
        const auto* row = misfits.ptr<float>(y);
        for (int x = 0; x < now.cols; ++x)
            sum += static_cast<double>(row[x]);
        if (y % kMotionCell != 0 || y + kMotionCell >= now.rows) continue;
        const auto* vectors = motion.ptr<cv::Vec2f>(y);
        const auto* below = motion.ptr<cv::Vec2f>(y + kMotionCell);
        const auto differ = [](const cv::Vec2f& a, const cv::Vec2f& b) {
            const cv::Vec2f d = a - b;
            return d[0] * d[0] + d[1] * d[1] > kWild * kWild;
        };
        for (int x = 0; x + kMotionCell < now.cols; x += kMotionCell, pairs += 2) {
            wild += static_cast<int>(differ(vectors[x], vectors[x + kMotionCell]));
            wild += static_cast<int>(differ(vectors[x], below[x]));
        }
    }
    const double contrast = std::min(contrastOf(before), contrastOf(now));
    const double wildness = pairs == 0 ? 0.0 : static_cast<double>(wild) / pairs;
    return sum / static_cast<double>(now.total()) / (kNoise + contrast) + kWildShare * wildness;
}

} // namespace altiro3D
