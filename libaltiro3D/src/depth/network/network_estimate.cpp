#include "depth/network/network_estimate.hpp"

#include "depth/network/depth_lines.hpp"
#include "depth/refine/depth_contours.hpp"
#include "image/downscale.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kPhotoSide = 512; // of the depth of photos, px
constexpr int kFrameSide = 320; // and of frames
constexpr int kReadSide = 1024; // networks read a copy of larger photos
// docs/lab/depth.md has the measurements of other sizes and shares.
constexpr double kDetailSize = 1.625; // of the larger copy, in sizes of the network's own input
constexpr double kLayoutShare = 0.65; // of the run at the network's own size
constexpr int kWindows = 16;          // of the guided filter, across the longer side
constexpr double kFlatVariance = 1e-3;

cv::Mat resized(const cv::Mat& picture, cv::Size size) {
    if (picture.size() == size) return picture;
    cv::Mat result;
    const bool shrinks = size.width < picture.cols;
    cv::resize(picture, result, size, 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
    return result;
}

cv::Mat meanAround(const cv::Mat& values, int radius) {
    cv::Mat mean;
    cv::blur(values, mean, {2 * radius + 1, 2 * radius + 1}, {-1, -1}, cv::BORDER_REFLECT);
    return mean;
}

// Guided filter (He, Sun and Tang 2010): the depth as a linear function of the guide in each
// window, so that it has the steps that both have, where the guide has them.
cv::Mat withEdgesOf(const cv::Mat& guide, const cv::Mat& depth) {
    const int radius = std::max(2, std::max(depth.cols, depth.rows) / kWindows);
    const cv::Mat meanGuide = meanAround(guide, radius);
    const cv::Mat meanDepth = meanAround(depth, radius);
    const cv::Mat covariance = meanAround(guide.mul(depth), radius) - meanGuide.mul(meanDepth);
    const cv::Mat variance = meanAround(guide.mul(guide), radius) - meanGuide.mul(meanGuide);
    const cv::Mat slope = covariance / (variance + kFlatVariance);
    const cv::Mat offset = meanDepth - slope.mul(meanGuide);
    return meanAround(slope, radius).mul(guide) + meanAround(offset, radius);
}

// The longer side of the larger copy; 0 if there is none.
int detailSide(const DepthNetwork& network) {
    const NetworkProfile& profile = network.profile();
    const int own = std::max(profile.inputWidth, profile.inputHeight);
    const int chosen = std::max(network.inputSize().width, network.inputSize().height);
    if (profile.inputShape != InputShape::Photo || chosen < own) return 0;
    if (chosen > own) return chosen;
    const double multiples = own * kDetailSize / profile.multipleOf;
    return std::min(4096 / profile.multipleOf, static_cast<int>(std::lround(multiples))) *
           profile.multipleOf;
}

cv::Mat runTwice(DepthNetwork& network, const cv::Mat& photo, int detail, cv::Size size) {
    cv::Mat layout;
    network.estimate(photo, layout,
                     std::max(network.profile().inputWidth, network.profile().inputHeight));
    cv::Mat mirrored;
    cv::flip(photo, mirrored, 1);
    cv::Mat edges;
    network.estimate(mirrored, edges, detail);
    cv::flip(edges, edges, 1);
    edges = resized(edges, size);
    cv::Mat mean;
    cv::addWeighted(resized(layout, size), kLayoutShare, edges, 1 - kLayoutShare, 0, mean);
    cv::Mat depth = withEdgesOf(edges, mean);
    cv::min(cv::max(depth, 0), 1, depth);
    return depth;
}

} // namespace

cv::Mat estimatePhoto(DepthNetwork& network, const cv::Mat& photo) {
    const cv::Mat read = downscale(photo, kReadSide);
    const cv::Size size = downscaledSize(photo.size(), kPhotoSide);
    const int detail = detailSide(network);
    cv::Mat depth;
    if (detail > 0) {
        depth = runTwice(network, read, detail, size);
    } else {
        network.estimate(read, depth);
        depth = resized(depth, size);
    }
    const cv::Mat seen = resized(read, size);
    const std::vector<cv::Vec4f> lines = findLines(seen);
    straightenLines(lines, depth);
    decideContours(seen, depth);
    straightenLines(lines, depth);
    return depth;
}

cv::Mat estimateFrame(DepthNetwork& network, const cv::Mat& frame) {
    cv::Mat depth;
    network.estimate(frame, depth);
    const cv::Size size = downscaledSize(frame.size(), kFrameSide);
    depth = resized(depth, size);
    decideContours(resized(frame, size), depth);
    return depth;
}

} // namespace altiro3D
