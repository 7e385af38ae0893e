#include "altiro3D/depth_map.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "depth/map/photo_paths.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace altiro3D {

namespace {

constexpr double kMaxRadius = 4096;
// Costs of paths, of 255: up to the first a px belongs to the same surface, from the second on it
// does not.
constexpr float kSameSurface = 12;
constexpr float kOtherSurface = 40;
constexpr double kSpacing = 0.25; // of the places of a stroke, in radii
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
                         const DepthBrushOptions& options)
    : impl_(std::make_unique<Impl>()) {
    checkPhotoAndDepth(photo, depth, "depth", "CV_32FC1");
    checkNumber(options.radius >= 0.5 && options.radius <= kMaxRadius, "radius", options.radius,
                "0.5..4096");
    checkNumber(options.amount >= 0 && options.amount <= 1, "amount", options.amount, "0..1");
    checkNumber(options.level >= 0 && options.level <= 1, "level", options.level, "0..1");
    impl_->options = options;
    if (options.keepsEdges) impl_->photo = withoutGrain(photo);
    impl_->before = withinRange(depth);
    impl_->depth = impl_->before.clone();
    impl_->coverage = cv::Mat::zeros(depth.size(), CV_32FC1);
}

DepthStroke::~DepthStroke() = default;
DepthStroke::DepthStroke(DepthStroke&& other) noexcept = default;
DepthStroke& DepthStroke::operator=(DepthStroke&& other) noexcept = default;

cv::Rect DepthStroke::moveTo(cv::Point2d place) {
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
}

const cv::Mat& DepthStroke::depth() const {
    return impl_->depth;
}

} // namespace altiro3D
