#include "video/motion/small_image.hpp"

#include "image/downscale.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

// Grey levels added to both pictures for gains, so dark, noisy cells have little weight.
constexpr float kBlack = 8;

// Brightness of `now` relative to `before`: the median over cells of 4 x 4 px.
float gainBetween(const cv::Mat& before, const cv::Mat& now) {
    const cv::Mat a = halved(halved(before));
    const cv::Mat b = halved(halved(now));
    std::vector<float> ratios;
    ratios.reserve(a.total());
    for (int y = 0; y < a.rows; ++y) {
        const uchar* rowA = a.ptr(y);
        const uchar* rowB = b.ptr(y);
        for (int x = 0; x < a.cols; ++x)
            ratios.push_back((static_cast<float>(rowB[x]) + kBlack) /
                             (static_cast<float>(rowA[x]) + kBlack));
    }
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return std::clamp(*middle, 0.5F, 2.0F);
}

cv::Mat brightened(const cv::Mat& grey, float gain) {
    std::array<uchar, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        const float value = gain * (static_cast<float>(i) + kBlack) - kBlack;
        table[i] = static_cast<uchar>(std::clamp(std::lround(value), 0L, 255L));
    }
    cv::Mat result(grey.size(), CV_8UC1);
    for (int y = 0; y < grey.rows; ++y) {
        const uchar* from = grey.ptr(y);
        std::transform(from, from + grey.cols, result.ptr(y),
                       [&](uchar value) { return table[value]; });
    }
    return result;
}

} // namespace

cv::Mat smallImage(const cv::Mat& picture) {
    return downscale(picture, kSmallSide);
}

cv::Mat halved(const cv::Mat& grey) {
    cv::Mat half((grey.rows + 1) / 2, (grey.cols + 1) / 2, CV_8UC1);
    for (int y = 0; y < half.rows; ++y) {
        const uchar* above = grey.ptr(2 * y);
        const uchar* below = grey.ptr(std::min(2 * y + 1, grey.rows - 1));
        uchar* out = half.ptr(y);
        for (int x = 0; x < half.cols; ++x) {
            const int left = 2 * x;
            const int right = std::min(left + 1, grey.cols - 1);
            out[x] = static_cast<uchar>(
                (above[left] + above[right] + below[left] + below[right] + 2) / 4);
        }
    }
    return half;
}

cv::Mat matchedBrightness(const cv::Mat& grey, const cv::Mat& now) {
    return brightened(grey, gainBetween(grey, now));
}

double contrastOf(const cv::Mat& grey) {
    std::int64_t sum = 0;
    std::int64_t squares = 0;
    for (int y = 0; y < grey.rows; ++y) {
        const uchar* row = grey.ptr(y);
        for (int x = 0; x < grey.cols; ++x) {
            sum += row[x];
            squares += row[x] * row[x];
        }
    }
    const auto count = static_cast<double>(grey.total());
    const double mean = static_cast<double>(sum) / count;
    return std::sqrt(std::max(0.0, static_cast<double>(squares) / count - mean * mean));
}

} // namespace altiro3D
