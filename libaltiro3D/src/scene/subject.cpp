#include "scene/subject.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "image/downscale.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kMaxSide = 320;
constexpr int kNeighbours = 3; // px to each side in which sharpness is measured

// Sums of rectangles of whole numbers.
class Sums {
  public:
    // @param valueAt (y, x) -> whole number
    template <typename ValueAt>
    Sums(cv::Size size, ValueAt valueAt)
        : width_(size.width + 1),
          sums_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(size.height + 1)) {
        for (int y = 0; y < size.height; ++y) {
            std::int64_t row = 0;
            for (int x = 0; x < size.width; ++x) {
                row += valueAt(y, x);
                sums_[index(y + 1, x + 1)] = sums_[index(y, x + 1)] + row;
            }
        }
    }
    std::int64_t of(const cv::Rect& part) const {
        const cv::Point end = part.br();
        return sums_[index(end.y, end.x)] - sums_[index(part.y, end.x)] -
               sums_[index(end.y, part.x)] + sums_[index(part.y, part.x)];
    }

  private:
    std::size_t index(int y, int x) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }
    int width_;
    std::vector<std::int64_t> sums_;
};

// Differences of brightness to the right and below, 0..510.
cv::Mat steps(const cv::Mat& photo) {
    const auto brightness = [&](int y, int x) {
        return int{
            brightnessOf(photo.ptr(std::min(y, photo.rows - 1), std::min(x, photo.cols - 1)))};
    };
    cv::Mat result(photo.size(), CV_32SC1);
    for (int y = 0; y < photo.rows; ++y) {
        for (int x = 0; x < photo.cols; ++x) {
            const int here = brightness(y, x);
            result.at<int>(y, x) =
                std::abs(brightness(y, x + 1) - here) + std::abs(brightness(y + 1, x) - here);
        }
    }
    return result;
}

// The value that a quarter of the row does not exceed.
float lowerQuarter(const cv::Mat& depth, int y, std::vector<float>& row) {
    row.assign(depth.ptr<float>(y), depth.ptr<float>(y) + depth.cols);
    const auto quarter = row.begin() + static_cast<std::ptrdiff_t>((row.size() - 1) / 4);
    std::nth_element(row.begin(), quarter, row.end());
    return *quarter;
}

void checkWeights(const cv::Mat& weights) {
    checkType(weights, {CV_32SC1}, "weights", "CV_32SC1, from subjectWeights()");
}

cv::Rect middleHalf(const cv::Rect& part) {
    return {part.x + part.width / 4, part.y + part.height / 4, part.width - part.width / 4 * 2,
            part.height - part.height / 4 * 2};
}

} // namespace

void subjectWeights(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& weights) {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    const cv::Mat small = downscale(photo, kMaxSide);
    const cv::Mat near = sampledDepth(depth, small.size());
    const cv::Mat step = steps(small);
    const Sums stepSums(small.size(), [&](int y, int x) { return step.at<int>(y, x); });
    const cv::Rect whole({}, small.size());
    weights.create(small.size(), CV_32SC1);
    std::vector<float> row;
    for (int y = 0; y < small.rows; ++y) {
        const double usual = lowerQuarter(near, y, row);
        for (int x = 0; x < small.cols; ++x) {
            constexpr int kSide = 2 * kNeighbours + 1;
            const cv::Rect around =
                cv::Rect(x - kNeighbours, y - kNeighbours, kSide, kSide) & whole;
            const double sharpness =
                std::min(1.0, static_cast<double>(stepSums.of(around)) / (32.0 * around.area()));
            const double d = near.at<float>(y, x);
            const double nearness = 0.02 + 0.18 * d + 0.8 * std::max(0.0, d - usual);
            const double right = (2.0 * x + 1) / small.cols - 1;
            const double down = (2.0 * y + 1) / small.rows - 1;
            const double middle = 1 - 0.45 * (right * right + down * down);
            const double weight = (0.2 + 0.8 * sharpness) * nearness * middle;
            weights.at<int>(y, x) = 1 + static_cast<int>(65534 * weight);
        }
    }
}

Framing frameSubject(const cv::Mat& weights, cv::Size picture, double panelAspect, double zoom) {
    checkWeights(weights);
    const cv::Rect shown =
        fitPhoto(picture, panelAspect, {1, 1}, FitMode::Cover, {{0.5, 0.5}, zoom}).source;
    const auto scaled = [](int part, int from, int to) {
        const double exact = static_cast<double>(part) * to / from;
        return std::clamp(static_cast<int>(std::lround(exact)), 1, to);
    };
    const cv::Size window(scaled(shown.width, picture.width, weights.cols),
                          scaled(shown.height, picture.height, weights.rows));
    const Sums sums(weights.size(), [&](int y, int x) { return weights.at<int>(y, x); });
    const cv::Size room = weights.size() - window;
    // the largest sum, then the place nearest to the middle
    using Score = std::tuple<std::int64_t, int>;
    Score best(-1, 0);
    cv::Point place;
    for (int y = 0; y <= room.height; ++y) {
        for (int x = 0; x <= room.width; ++x) {
            const cv::Rect part({x, y}, window);
            const int away = std::abs(2 * x - room.width) + std::abs(2 * y - room.height);
            const Score score(sums.of(part) + sums.of(middleHalf(part)), -away);
            if (!(score > best)) continue;
            best = score;
            place = part.tl();
        }
    }
    const auto centre = [](int start, int length, int roomThere, int all) {
        return roomThere == 0 ? 0.5 : (start + length / 2.0) / all;
    };
    return {{centre(place.x, window.width, room.width, weights.cols),
             centre(place.y, window.height, room.height, weights.rows)},
            zoom};
}

double subjectDepth(const cv::Mat& weights, const cv::Mat& depth, const cv::Rect2d& part) {
    checkWeights(weights);
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    constexpr double kRounding = 1e-9;
    check(part.x >= 0 && part.y >= 0 && part.width > 0 && part.height > 0 &&
              part.x + part.width <= 1 + kRounding && part.y + part.height <= 1 + kRounding,
          "part", "is not inside the scene, expected 0..1 on each axis");
    const auto range = [](double start, double length, int all) {
        const int first = std::min(static_cast<int>(std::floor(start * all)), all - 1);
        const int end = static_cast<int>(std::ceil((start + length) * all));
        return cv::Range(first, std::clamp(end, first + 1, all));
    };
    const cv::Range rows = range(part.y, part.height, weights.rows);
    const cv::Range columns = range(part.x, part.width, weights.cols);
    const cv::Mat near = sampledDepth(depth, weights.size());
    std::vector<std::pair<float, std::int64_t>> places;
    std::int64_t all = 0;
    for (int y = rows.start; y < rows.end; ++y) {
        for (int x = columns.start; x < columns.end; ++x) {
            const std::int64_t weight = weights.at<int>(y, x);
            places.emplace_back(near.at<float>(y, x), weight * weight);
            all += weight * weight;
        }
    }
    std::sort(places.begin(), places.end());
    std::int64_t sum = 0;
    for (const auto& [d, weight] : places) {
        sum += weight;
        if (2 * sum >= all) return static_cast<double>(d);
    }
    return 0.5; // not reached: weights are positive
}

} // namespace altiro3D
