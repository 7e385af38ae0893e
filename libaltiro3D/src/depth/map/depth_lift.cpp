#include "altiro3D/depth_map.hpp"
#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "depth/map/photo_paths.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

// The border lies this far from the outline, at most, of the photo's longer side. People draw
// around things rather than into them.
constexpr double kInside = 0.05;
constexpr double kOutside = 0.015;
constexpr float kPerPixel = 0.25F; // without edges the border is the outline
constexpr float kSharpness = 8;    // of the border

// The px inside a polygon: 255, else 0. Where it crosses itself, every second area is inside.
cv::Mat filled(const std::vector<cv::Point2d>& outline, cv::Size size) {
    constexpr int kShift = 8; // bits of fractions
    std::vector<cv::Point> points;
    for (const cv::Point2d& point : outline) {
        const double x = std::clamp(point.x, 0.0, size.width - 1.0);
        const double y = std::clamp(point.y, 0.0, size.height - 1.0);
        points.emplace_back(static_cast<int>(std::lround(x * (1 << kShift))),
                            static_cast<int>(std::lround(y * (1 << kShift))));
    }
    cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
    cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(255), cv::LINE_8,
                 kShift);
    return mask;
}

// The cost of paths from the px that are surely on one side of the outline: those more than `band`
// away from it, and the middle of parts that are thinner. Without edges, paths of `widest` px cost
// the same from both sides.
cv::Mat costsFrom(const cv::Mat& side, float band, float widest, const cv::Mat& photo) {
    cv::Mat distance; // to the other side
    cv::distanceTransform(side, distance, cv::DIST_L2, cv::DIST_MASK_5);
    cv::Mat nearby;
    cv::dilate(distance, nearby, cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
    cv::Mat costs(side.size(), CV_32FC1, cv::Scalar(kFarAway));
    for (int y = 0; y < side.rows; ++y) {
        for (int x = 0; x < side.cols; ++x) {
            const float here = distance.at<float>(y, x);
            const bool isMiddle = here >= 2 && here >= nearby.at<float>(y, x);
            if (here >= band || isMiddle)
                costs.at<float>(y, x) = std::max(0.0F, widest - here) * kPerPixel;
        }
    }
    pathCosts(photo, kPerPixel, costs);
    return costs;
}

} // namespace

cv::Rect liftDepth(const cv::Mat& photo, const cv::Mat& depth,
                   const std::vector<cv::Point2d>& outline, double amount, cv::Mat& lifted) {
    checkPhotoAndDepth(photo, depth, "depth", "CV_32FC1");
    checkNumber(amount >= -1 && amount <= 1, "amount", amount, "-1..1");
    for (const cv::Point2d& point : outline) {
        check(std::isfinite(point.x) && std::isfinite(point.y), "outline",
              "has a point that is not finite, expected px of the photo");
    }
    const cv::Mat before = withinRange(depth);
    lifted = before.clone();
    if (outline.size() < 3) return {};
    const int side = std::max(photo.cols, photo.rows);
    const auto inside = static_cast<float>(std::max(2.0, kInside * side));
    const auto outside = static_cast<float>(std::max(2.0, kOutside * side));
    const cv::Mat mask = filled(outline, photo.size());
    cv::Rect part = cv::boundingRect(mask);
    if (part.empty()) return {};
    const int margin = static_cast<int>(2 * outside) + 2;
    part -= cv::Point(margin, margin);
    part += cv::Size(2 * margin, 2 * margin);
    part &= cv::Rect({0, 0}, photo.size());
    const cv::Mat grainless = withoutGrain(photo(part));
    const cv::Mat inner = mask(part);
    cv::Mat outer;
    cv::bitwise_not(inner, outer);
    const cv::Mat fromInner = costsFrom(inner, inside, inside, grainless);
    const cv::Mat fromOuter = costsFrom(outer, outside, inside, grainless);
    for (int y = 0; y < part.height; ++y) {
        const float* const from = before.ptr<float>(part.y + y) + part.x;
        float* const to = lifted.ptr<float>(part.y + y) + part.x;
        for (int x = 0; x < part.width; ++x) {
            const float in = fromInner.at<float>(y, x);
            const float out = fromOuter.at<float>(y, x);
            const float share = out / std::max(in + out, 1e-6F); // 1 inside
            const float covered = std::clamp((share - 0.5F) * kSharpness + 0.5F, 0.0F, 1.0F);
            to[x] = withinRange(from[x] + covered * static_cast<float>(amount));
        }
    }
    return part;
}

} // namespace altiro3D
