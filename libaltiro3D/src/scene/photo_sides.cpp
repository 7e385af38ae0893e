// The sides of a photo: the border of a scan, and how far views look beyond what the panel shows.

#include "scene/photo_sides.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

using Line = std::vector<std::uint8_t>; // brightness of a row or column

// Px that differ from a level by more than noise does.
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
    int level = 0; // of the last line of the border
    std::size_t count = 0;
    for (; count < most; ++count) {
        Line sorted = lines[count];
        const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
        std::nth_element(sorted.begin(), middle, sorted.end());
        if (shareBeside(lines[count], *middle) > kFew) break;
        level = *middle;
    }
    // The next line may hold some of both. What has no end here is a part of the photo, as the sky.
    if (count == 0 || count == most || shareBeside(lines[count + 1], level) < kMany) return 0;
    return static_cast<int>(count) + 1;
}

} // namespace

cv::Rect withoutScanBorder(const cv::Mat& photo) {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    // @param at index of a line from the rim, and of a px along it -> place
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
    const cv::Rect shown = fitPhoto(size, panelAspect, {1, 1}, FitMode::Cover, framing).source;
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
