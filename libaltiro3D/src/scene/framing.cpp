#include "scene/framing.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kMaxSide = 320;
constexpr int kNeighbours = 3; // px to each side in which sharpness is measured

// Sums over rectangles of a picture of whole numbers.
class Sums {
  public:
    explicit Sums(const cv::Mat& numbers) {
        cv::Mat exact;
        numbers.convertTo(exact, CV_64F);
        cv::integral(exact, sums_, CV_64F);
    }
    std::int64_t of(const cv::Rect& part) const {
        const cv::Point end = part.br();
        return static_cast<std::int64_t>(sums_[end.y][end.x] - sums_[part.y][end.x] -
                                         sums_[end.y][part.x] + sums_[part.y][part.x]);
    }

  private:
    cv::Mat_<double> sums_;
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
    return valueOfRank(row, (row.size() - 1) / 4);
}

void checkWeights(const cv::Mat& weights) {
    checkType(weights, {CV_32SC1}, "weights", "CV_32SC1, from subjectWeights()");
}

cv::Rect middleHalf(const cv::Rect& part) {
    return {part.x + part.width / 4, part.y + part.height / 4, part.width - part.width / 4 * 2,
            part.height - part.height / 4 * 2};
}

using Line = std::vector<std::uint8_t>; // brightness of a row or column

// Share of the px that differ from a level by more than noise does.
double shareBeside(const Line& line, int level) {
    constexpr int kNoise = 12;
    const auto beside = std::count_if(line.begin(), line.end(), [&](std::uint8_t value) {
        return std::abs(value - level) > kNoise;
    });
    return static_cast<double>(beside) / static_cast<double>(line.size());
}

// Rows of a scan's border at the top. @param lines lines from the rim on, one more than may be cut
int borderLines(const std::vector<Line>& lines) {
    constexpr double kFew = 0.05;  // dust, and the ends of the lines, which lie in other borders
    constexpr double kMany = 0.33; // the photo begins with a step all along the border
    const std::size_t most = lines.size() - 1;
    int level = 0; // level of the last line of the border
    std::size_t count = 0;
    for (; count < most; ++count) {
        Line sorted = lines[count];
        const std::uint8_t middle = valueOfRank(sorted, sorted.size() / 2);
        if (shareBeside(lines[count], middle) > kFew) break;
        level = middle;
    }
    // The next line may hold parts of both. A border without an end here belongs to the photo.
    if (count == 0 || count == most || shareBeside(lines[count + 1], level) < kMany) return 0;
    return static_cast<int>(count) + 1;
}

} // namespace

void subjectWeights(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& weights) {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    const cv::Mat small = downscale(photo, kMaxSide);
    const cv::Mat near = sampledDepth(depth, small.size());
    const Sums stepSums(steps(small));
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
    const cv::Rect shown = shownPart(picture, panelAspect, FitMode::Cover, {{0.5, 0.5}, zoom});
    const auto scaled = [](int part, int from, int to) {
        const double exact = static_cast<double>(part) * to / from;
        return std::clamp(static_cast<int>(std::lround(exact)), 1, to);
    };
    const cv::Size window(scaled(shown.width, picture.width, weights.cols),
                          scaled(shown.height, picture.height, weights.rows));
    const Sums sums(weights);
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

cv::Rect withoutScanBorder(const cv::Mat& photo) {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    // @param at (number of a line from the rim, number of a px in it) -> place
    const auto border = [&](int across, int along, auto at) {
        const int most = static_cast<int>(across * kMaxScanBorder / 100);
        if (most < 1) return 0;
        std::vector<Line> lines;
        for (int i = 0; i <= most; ++i) {
            Line& line = lines.emplace_back();
            for (int j = 0; j < along; ++j)
                line.push_back(brightnessOf(photo.ptr<std::uint8_t>(at(i, j).y, at(i, j).x)));
        }
        return borderLines(lines);
    };
    const int columns = photo.cols;
    const int rows = photo.rows;
    const int left = border(columns, rows, [](int i, int j) { return cv::Point(i, j); });
    const int right =
        border(columns, rows, [&](int i, int j) { return cv::Point(columns - 1 - i, j); });
    const int top = border(rows, columns, [](int i, int j) { return cv::Point(j, i); });
    const int bottom =
        border(rows, columns, [&](int i, int j) { return cv::Point(j, rows - 1 - i); });
    return {left, top, columns - left - right, rows - top - bottom};
}

Framing insideViews(const Scene& scene, const cv::Rect& inside, double panelAspect,
                    const Framing& framing, const ViewOptions& options) {
    checkType(scene.depth, {CV_32FC1}, "depth", "CV_32FC1");
    const cv::Size size = scene.photo.size();
    check(!inside.empty() && (inside & cv::Rect({}, size)) == inside, "part",
          "is not inside the photo, expected a part of its px");
    const cv::Rect shown = shownPart(size, panelAspect, FitMode::Cover, framing);
    // How far the outermost views look beyond a column, in widths of what is shown.
    const auto reachOf = [&](int column) {
        const auto at = static_cast<int>(std::int64_t{column} * scene.depth.cols / size.width);
        double low = 0;
        double high = 0;
        cv::minMaxLoc(
            sampledDepth(scene.depth.col(at), {1, size.height}).rowRange(shown.y, shown.br().y),
            &low, &high);
        return options.strengthPercent / 200 *
               std::max(std::abs(low - options.focus), std::abs(high - options.focus));
    };
    const double left = reachOf(inside.x);
    const double right = reachOf(inside.br().x - 1);
    const double border = std::max({1.0, static_cast<double>(shown.width) / inside.width,
                                    static_cast<double>(shown.height) / inside.height});
    const double wanted = std::max(border, shown.width * (1 + left + right) / inside.width);
    const double most = inside.width < size.width ? 2 * kMaxSideZoom : kMaxSideZoom;
    const double more = std::min(wanted, border * (1 + most / 100));
    const cv::Size2d window(shown.width / more, shown.height / more);
    if (std::min(window.width, window.height) < kMinFramedPixels) return framing;
    // as near to where it was as the sides allow; in their middle if they are too near
    const auto centre = [](double now, double length, double start, double end) {
        const double first = start + length / 2;
        const double last = end - length / 2;
        return first < last ? std::clamp(now, first, last) : (first + last) / 2;
    };
    const double x = centre(framing.centre.x * size.width, window.width,
                            inside.x + left * window.width, inside.br().x - right * window.width);
    const double y = centre(framing.centre.y * size.height, window.height, inside.y, inside.br().y);
    return {{x / size.width, y / size.height}, framing.zoom * more};
}

} // namespace altiro3D
