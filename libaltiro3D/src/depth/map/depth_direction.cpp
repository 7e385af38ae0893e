#include "altiro3D/depth_map.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kSide = 64;                  // places per row and column
constexpr int kBorder = kSide / 8;         // width of the border
constexpr int kMiddle = kSide / 4;         // the middle begins here
constexpr double kMaxContradiction = -0.3; // correlation of a contradiction
constexpr double kMinSpread = 0.02;        // standard deviation of depth that has a direction

using Samples = std::vector<double>; // [kSide * kSide], by rows

Samples samplesOf(const cv::Mat& depth) {
    const cv::Mat sampled = sampledDepth(depth, {kSide, kSide});
    return {sampled.begin<float>(), sampled.end<float>()};
}

double meanOf(const Samples& samples) {
    double sum = 0;
    for (const double sample : samples)
        sum += sample;
    return sum / static_cast<double>(samples.size());
}

// The mean product of the deviations from the means.
double covariance(const Samples& a, const Samples& b) {
    const double meanA = meanOf(a);
    const double meanB = meanOf(b);
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - meanA) * (b[i] - meanB);
    return sum / static_cast<double>(a.size());
}

// -1..1; 0 if one of them is constant
double correlation(const Samples& a, const Samples& b) {
    const double spread = std::sqrt(covariance(a, a) * covariance(b, b));
    return spread > 0 ? covariance(a, b) / spread : 0;
}

Samples rowNumbers() {
    Samples rows;
    for (int row = 0; row < kSide; ++row)
        rows.insert(rows.end(), kSide, row);
    return rows;
}

bool isBorderNearer(const Samples& depth) {
    Samples border;
    Samples middle;
    const auto isInside = [](int i, int margin) { return i >= margin && i < kSide - margin; };
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            const double sample = depth[static_cast<std::size_t>(y * kSide + x)];
            if (isInside(y, kMiddle) && isInside(x, kMiddle)) middle.push_back(sample);
            const bool isBorder = !isInside(y, kBorder) || !isInside(x, kBorder);
            if (isBorder && y < kSide / 2) border.push_back(sample);
        }
    }
    return meanOf(border) > meanOf(middle);
}

} // namespace

bool looksInverted(const cv::Mat& depth, const std::function<cv::Mat()>& estimate) {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    const Samples samples = samplesOf(depth);
    if (std::sqrt(covariance(samples, samples)) < kMinSpread) return false;
    if (correlation(samples, rowNumbers()) > kMaxContradiction || !isBorderNearer(samples))
        return false;
    const cv::Mat estimated = estimate();
    return !estimated.empty() && correlation(samples, samplesOf(estimated)) <= kMaxContradiction;
}

} // namespace altiro3D
