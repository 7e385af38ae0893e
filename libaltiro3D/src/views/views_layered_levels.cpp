// Depth with few levels (8 bits) and a long reach turns slopes into staircases. This file smooths
// them.

#include "views/views_layered_scene.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

// Steps that move by less than this (px at the reach) are not changed.
constexpr double kVisibleStep = 0.2;
// Fewer levels are taken for flat layers. More levels than in 8 bits are taken for continuous
// depth.
constexpr std::size_t kMinLevels = 16;
constexpr std::size_t kMaxLevels = 256;
// The largest distance of two levels in a depth of 0..1: 6 bits.
constexpr double kMaxLevel = 1.0 / 63;
// Pixels that differ by at most this many levels are on one slope.
constexpr double kSameSlope = 1.5;
// Distances of the neighbours, and sweeps at each distance.
constexpr int kStrides[] = {32, 16, 8, 4, 2, 1};
constexpr int kSweeps = 2;

float clamped(float depth) {
    return depth > 0 ? std::min(depth, 1.0F) : 0.0F; // NaN compares false: 0
}

// The values that occur, ascending; empty if there are too many.
std::vector<float> levelsOf(const cv::Mat& depth) {
    std::vector<float> levels;
    for (int y = 0; y < depth.rows; ++y) {
        const auto* row = depth.ptr<float>(y);
        for (int x = 0; x < depth.cols; ++x) {
            if (x > 0 && row[x] == row[x - 1]) continue;
            const float value = clamped(row[x]);
            const auto place = std::lower_bound(levels.begin(), levels.end(), value);
            if (place != levels.end() && *place == value) continue;
            if (levels.size() == kMaxLevels) return {};
            levels.insert(place, value);
        }
    }
    return levels;
}

// The distance of two levels; 0 if the depth has no levels that views within the reach would show.
double visibleLevel(const cv::Mat& depth, double reach) {
    if (reach * kMaxLevel < kVisibleStep) return 0;
    const std::vector<float> levels = levelsOf(depth);
    if (levels.size() < kMinLevels) return 0;
    double level = 1;
    for (std::size_t i = 1; i < levels.size(); ++i)
        level =
            std::min(level, static_cast<double>(levels[i]) - static_cast<double>(levels[i - 1]));
    return level <= kMaxLevel && level * reach >= kVisibleStep ? level : 0;
}

// Each pixel becomes the mean of its left and right and its upper and lower neighbours. A pair that
// is not on the pixel's slope is replaced by the pixel itself. Slopes and the sides of steps do not
// change.
class Sweep {
  public:
    Sweep(const cv::Mat& given, double level)
        : given_(given), same_(static_cast<float>(kSameSlope * level)),
          half_(static_cast<float>(level / 2)) {}

    // Memory limits the speed.
    void row(const cv::Mat& from, int y, int stride, float* to) const {
        const bool edge = y < stride || y >= given_.rows - stride;
        const int above = edge ? y : y - stride;
        const int below = edge ? y : y + stride;
        const float* given[] = {given_.ptr<float>(y), given_.ptr<float>(above),
                                given_.ptr<float>(below)};
        const float* now[] = {from.ptr<float>(y), from.ptr<float>(above), from.ptr<float>(below)};
        const auto pair = [&](float own, float ownNow, float a, float b, float aNow, float bNow) {
            const bool same = std::abs(a - own) <= same_ && std::abs(b - own) <= same_;
            return same ? aNow + bNow : ownNow + ownNow;
        };
        const auto pixel = [&](int x, int left, int right) {
            const float own = given[0][x];
            const float ownNow = now[0][x];
            const float along =
                pair(own, ownNow, given[0][left], given[0][right], now[0][left], now[0][right]);
            const float across = pair(own, ownNow, given[1][x], given[2][x], now[1][x], now[2][x]);
            const float mean = 0.25F * (along + across);
            to[x] = std::min(std::max(mean, own - half_), own + half_);
        };
        const int width = given_.cols;
        const int inner = std::min(stride, width);
        const int outer = std::max(width - stride, inner);
        for (int x = 0; x < inner; ++x)
            pixel(x, x, x);
        for (int x = inner; x < outer; ++x)
            pixel(x, x - stride, x + stride);
        for (int x = outer; x < width; ++x)
            pixel(x, x, x);
    }

  private:
    const cv::Mat& given_;
    float same_;
    float half_;
};

} // namespace

cv::Mat withoutLevels(const cv::Mat& depth, double reach) {
    const double level = visibleLevel(depth, reach);
    if (level == 0) return depth;
    cv::Mat given(depth.size(), CV_32FC1);
    for (int y = 0; y < depth.rows; ++y)
        std::transform(depth.ptr<float>(y), depth.ptr<float>(y) + depth.cols, given.ptr<float>(y),
                       clamped);
    const Sweep sweep(given, level);
    cv::Mat now = given.clone();
    cv::Mat next(depth.size(), CV_32FC1);
    for (const int stride : kStrides) {
        for (int i = 0; i < kSweeps; ++i) {
            cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& rows) {
                for (int y = rows.start; y < rows.end; ++y)
                    sweep.row(now, y, stride, next.ptr<float>(y));
            });
            cv::swap(now, next);
        }
    }
    return now;
}

} // namespace altiro3D
