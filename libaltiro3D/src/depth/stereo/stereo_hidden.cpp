#include "depth/stereo/stereo_hidden.hpp"

#include "altiro3D/depth_source.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

constexpr float kBehind = 1.5F; // px of disparity by which hidden px lie behind visible ones
constexpr float kTear = 1;      // px of disparity between neighbours of one surface

// Moves a row of the right picture to the left one.
// @param disparity, seen of the right and of the left picture, px
// @param bgr of the right picture
void moveRow(const float* disparity, const std::uint8_t* bgr, const float* seen, int width,
             std::uint8_t* hiddenBgr, float* hidden) {
    const auto put = [&](int x, float value, const std::uint8_t* first, float share) {
        if (x < 0 || x >= width || seen[x] - value < kBehind) return;
        if (hidden[x] >= value) return; // of several, the nearest one is visible behind the thing
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

void scaleHiddenDepth(const cv::Mat& disparity, const cv::Mat& depth, HiddenLayer& hidden) {
    if (hidden.photo.empty()) return;
    checkType(disparity, {CV_32FC1}, "disparity", "CV_32FC1");
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    if (disparity.size() != depth.size()) {
        throw Error(ErrorCode::Mismatch, "depth",
                    "has " + sizeText(depth.size()) + " px, expected those of the disparity, " +
                        sizeText(disparity.size()));
    }
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
