#include "depth/stereo/stereo_parts.hpp"

#include "altiro3D/depth_source.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "depth/map/depth_values.hpp"

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
constexpr int kBins = 256;       // bins of the range of disparities
constexpr int kColourScale = 24; // sum of the differences of B, G and R with weight 1/2

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

constexpr float kBehind = 1.5F; // px of disparity by which hidden px lie behind visible ones
constexpr float kTear = 1;      // px of disparity between neighbours of one surface

// Moves a row of the right picture to the left one.
// @param disparity, seen rows of disparities of the right and of the left picture, px
// @param bgr row of the right picture
void moveRow(const float* disparity, const std::uint8_t* bgr, const float* seen, int width,
             std::uint8_t* hiddenBgr, float* hidden) {
    const auto put = [&](int x, float value, const std::uint8_t* first, float share) {
        if (x < 0 || x >= width || seen[x] - value < kBehind) return;
        if (hidden[x] >= value) return; // of several hidden px at one place, the nearest counts
        hidden[x] = value;
        for (int c = 0; c < 3; ++c) {
            const float colour = share > 0 ? static_cast<float>(first[c]) * (1 - share) +
                                                 static_cast<float>(first[c + 3]) * share
                                           : static_cast<float>(first[c]);
            hiddenBgr[3 * x + c] = static_cast<std::uint8_t>(colour + 0.5F);
        }
    };
    for (int x = 0; x < width; ++x) {
        const float here = static_cast<float>(x) + disparity[x];
        const bool goesOn = x + 1 < width && std::abs(disparity[x + 1] - disparity[x]) < kTear;
        if (!goesOn) {
            put(static_cast<int>(std::lround(here)), disparity[x], bgr + 3 * x, 0);
            continue;
        }
        const float next = static_cast<float>(x + 1) + disparity[x + 1];
        for (int to = static_cast<int>(std::ceil(here)); static_cast<float>(to) < next; ++to) {
            const float share = (static_cast<float>(to) - here) / (next - here);
            put(to, disparity[x] + share * (disparity[x + 1] - disparity[x]), bgr + 3 * x, share);
        }
    }
}

} // namespace

void fillFromBehind(cv::Mat& disparity, const cv::Mat& photo) {
    cv::Mat known;
    cv::compare(disparity, disparity, known, cv::CMP_EQ); // NaN differs from itself
    if (cv::countNonZero(known) == known.rows * known.cols) return;
    double low = 0;
    double high = 0;
    cv::minMaxLoc(disparity, &low, &high, nullptr, nullptr, known);
    fillUnknown(disparity);
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
        overRows(bins.rows, [&](int y) {
            for (int x = 0; x < bins.cols; ++x) {
                if (known.at<std::uint8_t>(y, x) == 0)
                    median.at<std::uint8_t>(y, x) = weightedMedian(bins, photo, x, y, weights);
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

void scaleHiddenDepth(const cv::Mat& disparity, const cv::Mat& depth, HiddenLayer& hidden) try {
    if (hidden.photo.empty()) return;
    checkType(disparity, {CV_32FC1}, "disparity", "CV_32FC1");
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    checkSize(depth.size(), disparity.size(), "depth", "the disparity's ");
    checkType(hidden.depth, {CV_32FC1}, "hidden depth", "CV_32FC1");
    // The scale is linear; its ends are taken where it is not clamped.
    const cv::Mat inside = (depth > 0) & (depth < 1);
    double low = 0;
    double high = 0;
    cv::Point first;
    cv::Point last;
    cv::minMaxLoc(disparity, &low, &high, &first, &last, inside);
    if (cv::countNonZero(inside) == 0 || low == high) {
        hidden = {};
        return;
    }
    const double lowDepth = static_cast<double>(depth.at<float>(first));
    const double highDepth = static_cast<double>(depth.at<float>(last));
    const double factor = (highDepth - lowDepth) / (high - low);
    hidden.depth = cv::Mat(hidden.depth * factor + (lowDepth - low * factor));
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

HiddenLayer hiddenByRight(const cv::Mat& right, const cv::Mat& leftDisparity,
                          const cv::Mat& rightDisparity) {
    constexpr float kNothing = std::numeric_limits<float>::lowest();
    const int width = right.cols;
    const cv::Mat seen = leftDisparity * width;
    const cv::Mat disparity = rightDisparity * width;
    HiddenLayer layer{cv::Mat(right.size(), CV_8UC3, cv::Scalar::all(0)),
                      cv::Mat(right.size(), CV_32FC1)};
    for (int y = 0; y < right.rows; ++y) {
        auto* const hidden = layer.depth.ptr<float>(y);
        std::fill_n(hidden, width, kNothing);
        moveRow(disparity.ptr<float>(y), right.ptr<std::uint8_t>(y), seen.ptr<float>(y), width,
                layer.photo.ptr<std::uint8_t>(y), hidden);
        std::transform(hidden, hidden + width, hidden, [&](float value) {
            return value == kNothing ? std::numeric_limits<float>::quiet_NaN()
                                     : value / static_cast<float>(width);
        });
    }
    return layer;
}

} // namespace altiro3D
