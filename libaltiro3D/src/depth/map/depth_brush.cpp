#include "altiro3D/depth_map.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace altiro3D {

namespace {

constexpr double kMaxRadius = 4096;
// Costs of paths, in levels of 255: up to the first the same surface, from the second on another.
constexpr float kSameSurface = 12;
constexpr float kOtherSurface = 40;
constexpr double kSpacing = 0.25; // distance between the places of a stroke, in radii
constexpr double kBlur = 0.25;    // standard deviation of Smooth, in radii

bool isFinite(cv::Point2d place) {
    return std::isfinite(place.x) && std::isfinite(place.y);
}

// Falls from 1 at `from` to 0 at `to`, without corners.
float fallBetween(float from, float to, float value) {
    const float t = std::clamp((to - value) / (to - from), 0.0F, 1.0F);
    return t * t * (3 - 2 * t);
}

cv::Rect inside(const cv::Rect& part, cv::Size size) {
    return part & cv::Rect({0, 0}, size);
}

// The px whose centres are at most `radius` away, of an area that may lie outside the picture.
cv::Rect squareAround(cv::Point2d place, double radius, cv::Size size) {
    const cv::Point low(static_cast<int>(std::ceil(place.x - radius)),
                        static_cast<int>(std::ceil(place.y - radius)));
    const cv::Point high(static_cast<int>(std::floor(place.x + radius)) + 1,
                         static_cast<int>(std::floor(place.y + radius)) + 1);
    return inside({low, high}, size);
}

// Largest distance of the border from the outline, as share of the photo's longer side. People draw
// around things rather than into them.
constexpr double kInside = 0.05;
constexpr double kOutside = 0.015;
constexpr float kPerPixel = 0.25F; // without edges the border is the outline
constexpr float kSharpness = 8;    // sharpness of the border

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

// The cost of paths from the px that are certainly on one side of the outline: those more than
// `band` away from it, and the middle of parts that are thinner. Without edges, paths of `widest`
// px cost the same from both sides.
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

constexpr int kNoise = 3; // difference of two neighbours of one surface, in levels of 255
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

struct DepthStroke::Impl {
    DepthBrushOptions options;
    cv::Mat photo;    // without grain
    cv::Mat before;   // the depth without the stroke
    cv::Mat depth;    // with it
    cv::Mat coverage; // 0..1, the largest so far
    std::optional<cv::Point2d> last;

    // How much one place of the stroke covers of the px around it.
    cv::Mat coverageOf(cv::Point2d place, const cv::Rect& part) const {
        cv::Mat covered(part.size(), CV_32FC1, cv::Scalar(1));
        if (options.keepsEdges) {
            cv::Mat costs(part.size(), CV_32FC1, cv::Scalar(kFarAway));
            const cv::Point middle(
                std::clamp(static_cast<int>(std::lround(place.x)), part.x, part.br().x - 1),
                std::clamp(static_cast<int>(std::lround(place.y)), part.y, part.br().y - 1));
            costs.at<float>(middle - part.tl()) = 0;
            pathCosts(photo(part), 0, costs);
            for (float& cost : cv::Mat_<float>(costs))
                cost = fallBetween(kSameSurface, kOtherSurface, cost);
            covered = costs;
        }
        const auto radius = static_cast<float>(options.radius);
        for (int y = 0; y < part.height; ++y) {
            float* const row = covered.ptr<float>(y);
            for (int x = 0; x < part.width; ++x) {
                const double distance = std::hypot(part.x + x - place.x, part.y + y - place.y);
                row[x] *= fallBetween(radius / 2, radius, static_cast<float>(distance));
            }
        }
        return covered;
    }

    // The average of the depth that a place covers, for Smooth.
    cv::Mat smoothed(const cv::Rect& part, const cv::Mat& covered) const {
        const double sigma = kBlur * options.radius;
        const int border = cv::BORDER_CONSTANT | cv::BORDER_ISOLATED; // outside: no weight
        cv::Mat sum = before(part).mul(covered);
        cv::Mat weight;
        cv::GaussianBlur(sum, sum, {}, sigma, sigma, border);
        cv::GaussianBlur(covered, weight, {}, sigma, sigma, border);
        return sum / cv::max(weight, 1e-6F);
    }

    // @return the part of the depth map that a place may change
    cv::Rect cover(cv::Point2d place) {
        const cv::Rect part = squareAround(place, options.radius, before.size());
        if (part.empty()) return {};
        const cv::Mat covered = coverageOf(place, part);
        cv::Mat average;
        if (options.brush == DepthBrush::Smooth) average = smoothed(part, covered);
        const auto amount = static_cast<float>(options.amount);
        for (int y = 0; y < part.height; ++y) {
            const float* const now = covered.ptr<float>(y);
            const float* const old = before.ptr<float>(part.y + y) + part.x;
            float* const most = coverage.ptr<float>(part.y + y) + part.x;
            float* const to = depth.ptr<float>(part.y + y) + part.x;
            for (int x = 0; x < part.width; ++x) {
                if (now[x] <= most[x]) continue;
                most[x] = now[x];
                float change = amount;
                if (options.brush == DepthBrush::Farther) change = -amount;
                if (options.brush == DepthBrush::Level)
                    change = amount * (static_cast<float>(options.level) - old[x]);
                if (options.brush == DepthBrush::Smooth)
                    change = amount * (average.at<float>(y, x) - old[x]);
                to[x] = withinRange(old[x] + now[x] * change);
            }
        }
        return part;
    }
};

DepthStroke::DepthStroke(const cv::Mat& photo, const cv::Mat& depth,
                         const DepthBrushOptions& options) try
    : impl_(std::make_unique<Impl>()) {
    checkPhotoAndDepth(photo, depth, "depth", "CV_32FC1");
    checkRange("radius", options.radius, 0.5, kMaxRadius);
    checkRange("amount", options.amount, 0, 1);
    checkRange("level", options.level, 0, 1);
    impl_->options = options;
    if (options.keepsEdges) impl_->photo = withoutGrain(photo);
    impl_->before = withinRange(depth);
    impl_->depth = impl_->before.clone();
    impl_->coverage = cv::Mat::zeros(depth.size(), CV_32FC1);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

DepthStroke::~DepthStroke() = default;
DepthStroke::DepthStroke(DepthStroke&& other) noexcept = default;
DepthStroke& DepthStroke::operator=(DepthStroke&& other) noexcept = default;

cv::Rect DepthStroke::moveTo(cv::Point2d place) try {
    check(isFinite(place), "place", "is not finite, expected px of the photo");
    // No place farther out has an effect.
    const double margin = impl_->options.radius + 1;
    place.x = std::clamp(place.x, -margin, impl_->before.cols + margin);
    place.y = std::clamp(place.y, -margin, impl_->before.rows + margin);
    if (!impl_->last) {
        impl_->last = place;
        return impl_->cover(place);
    }
    const double spacing = std::max(0.5, kSpacing * impl_->options.radius);
    const cv::Point2d way = place - *impl_->last;
    const double length = std::hypot(way.x, way.y);
    const int count = static_cast<int>(length / spacing);
    cv::Rect changed;
    for (int i = 1; i <= count; ++i)
        changed |= impl_->cover(*impl_->last + way * (i * spacing / length));
    if (count > 0) *impl_->last += way * (count * spacing / length);
    return changed;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

const cv::Mat& DepthStroke::depth() const {
    return impl_->depth;
}

cv::Rect liftDepth(const cv::Mat& photo, const cv::Mat& depth,
                   const std::vector<cv::Point2d>& outline, double amount, cv::Mat& lifted) try {
    checkPhotoAndDepth(photo, depth, "depth", "CV_32FC1");
    checkRange("amount", amount, -1, 1);
    check(std::all_of(outline.begin(), outline.end(), isFinite), "outline",
          "has a point that is not finite, expected px of the photo");
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
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

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
