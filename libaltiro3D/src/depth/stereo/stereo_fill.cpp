#include "depth/stereo/stereo_fill.hpp"

#include "depth/map/unknown_depth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kReach = 16; // px around a px that count for its median, to each side
constexpr int kStep = 4;   // px between them
constexpr int kPasses = 2;
constexpr int kBins = 256;       // of the range of disparities
constexpr int kColourScale = 24; // sum of the differences of B, G and R with weight 1/2

void fillRows(cv::Mat& disparity) {
    std::vector<char> known(static_cast<std::size_t>(disparity.rows));
    for (int y = 0; y < disparity.rows; ++y) {
        known[static_cast<std::size_t>(y)] =
            static_cast<char>(fillUnknown(disparity.ptr<float>(y), disparity.cols));
    }
    fillUnknownRows(disparity, known);
}

using Weights = std::array<std::int32_t, 3 * 256>; // by difference of colours

Weights weightsOf() {
    Weights weights{};
    for (std::size_t i = 0; i < weights.size(); ++i)
        weights[i] = 1 + static_cast<std::int32_t>(std::lround(
                             65536 * std::exp2(-static_cast<double>(i) / kColourScale)));
    return weights;
}

// The bin in which half of the weight around a px is reached.
std::uint8_t weightedMedian(const cv::Mat& bins, const cv::Mat& photo, int x, int y,
                            const Weights& weights) {
    std::array<std::int64_t, kBins> histogram{};
    std::int64_t all = 0;
    const auto& here = photo.at<cv::Vec3b>(y, x);
    const int left = x - std::min(x, kReach) / kStep * kStep;
    const int top = y - std::min(y, kReach) / kStep * kStep;
    for (int v = top; v <= std::min(y + kReach, bins.rows - 1); v += kStep) {
        const auto* const colours = photo.ptr<cv::Vec3b>(v);
        const auto* const values = bins.ptr(v);
        for (int u = left; u <= std::min(x + kReach, bins.cols - 1); u += kStep) {
            const int difference = std::abs(colours[u][0] - here[0]) +
                                   std::abs(colours[u][1] - here[1]) +
                                   std::abs(colours[u][2] - here[2]);
            const std::int32_t weight = weights[static_cast<std::size_t>(difference)];
            histogram[values[u]] += weight;
            all += weight;
        }
    }
    std::int64_t sum = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
        sum += histogram[bin];
        if (2 * sum >= all) return static_cast<std::uint8_t>(bin);
    }
    return kBins - 1;
}

} // namespace

void fillFromBehind(cv::Mat& disparity, const cv::Mat& photo) {
    cv::Mat known;
    cv::compare(disparity, disparity, known, cv::CMP_EQ); // NaN differs from itself
    if (cv::countNonZero(known) == known.rows * known.cols) return;
    double low = 0;
    double high = 0;
    cv::minMaxLoc(disparity, &low, &high, nullptr, nullptr, known);
    fillRows(disparity);
    if (!(high > low)) return;
    const double perBin = (high - low) / (kBins - 1);
    cv::Mat bins(disparity.size(), CV_8UC1);
    for (int y = 0; y < bins.rows; ++y) {
        const auto* const from = disparity.ptr<float>(y);
        for (int x = 0; x < bins.cols; ++x)
            bins.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(
                std::lround((static_cast<double>(from[x]) - low) / perBin));
    }
    static const Weights weights = weightsOf();
    cv::Mat median = bins.clone();
    for (int pass = 0; pass < kPasses; ++pass) {
        cv::parallel_for_(cv::Range(0, bins.rows), [&](const cv::Range& rows) {
            for (int y = rows.start; y < rows.end; ++y) {
                for (int x = 0; x < bins.cols; ++x) {
                    if (known.at<std::uint8_t>(y, x) == 0)
                        median.at<std::uint8_t>(y, x) = weightedMedian(bins, photo, x, y, weights);
                }
            }
        });
        median.copyTo(bins);
    }
    for (int y = 0; y < bins.rows; ++y) {
        auto* const to = disparity.ptr<float>(y);
        for (int x = 0; x < bins.cols; ++x) {
            if (known.at<std::uint8_t>(y, x) == 0)
                to[x] = static_cast<float>(low + perBin * bins.at<std::uint8_t>(y, x));
        }
    }
}

} // namespace altiro3D
