#include "depth/map/photo_paths.hpp"

#include <algorithm>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

constexpr int kNoise = 3; // difference of two neighbours of one surface, of 255
constexpr int kRounds = 2;

float stepCost(const cv::Vec3b& a, const cv::Vec3b& b) {
    int difference = 0;
    for (int channel = 0; channel < 3; ++channel)
        difference = std::max(difference, std::abs(a[channel] - b[channel]));
    return static_cast<float>(std::max(0, difference - kNoise));
}

// Visits all px in one direction, by rows; each takes the paths of the four neighbours before it.
// Photo and costs have a border of one px that no path leaves.
void sweep(const cv::Mat& photo, float perPixel, bool forward, cv::Mat& costs) {
    constexpr float kDiagonal = 1.41421356F;
    const int step = forward ? 1 : -1;
    const int first = forward ? 1 : photo.rows - 2;
    const int left = forward ? 1 : photo.cols - 2;
    for (int y = first; y > 0 && y < photo.rows - 1; y += step) {
        const auto* const colours = photo.ptr<cv::Vec3b>(y);
        const auto* const coloursBefore = photo.ptr<cv::Vec3b>(y - step);
        auto* const here = costs.ptr<float>(y);
        const auto* const before = costs.ptr<float>(y - step);
        for (int x = left; x > 0 && x < photo.cols - 1; x += step) {
            const cv::Vec3b& colour = colours[x];
            float cost =
                std::min(here[x], before[x] + perPixel + stepCost(colour, coloursBefore[x]));
            for (const int side : {-1, 1}) {
                cost = std::min(cost, before[x + side] + kDiagonal * perPixel +
                                          stepCost(colour, coloursBefore[x + side]));
            }
            here[x] =
                std::min(cost, here[x - step] + perPixel + stepCost(colour, colours[x - step]));
        }
    }
}

} // namespace

cv::Mat withoutGrain(const cv::Mat& photo) {
    cv::Mat smooth;
    cv::GaussianBlur(photo, smooth, {3, 3}, 0, 0, cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
    return smooth;
}

void pathCosts(const cv::Mat& photo, float perPixel, cv::Mat& costs) {
    cv::Mat framedPhoto;
    cv::Mat framedCosts;
    cv::copyMakeBorder(photo, framedPhoto, 1, 1, 1, 1, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
    cv::copyMakeBorder(costs, framedCosts, 1, 1, 1, 1, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED,
                       cv::Scalar(kFarAway));
    for (int round = 0; round < kRounds; ++round) {
        sweep(framedPhoto, perPixel, true, framedCosts);
        sweep(framedPhoto, perPixel, false, framedCosts);
    }
    framedCosts(cv::Rect({1, 1}, costs.size())).copyTo(costs);
}

} // namespace altiro3D
