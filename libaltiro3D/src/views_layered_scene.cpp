#include "views_layered_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

constexpr int kLongestRun = 4096;    // px of hidden background at one tear
constexpr int kMostHiddenWidths = 4; // hidden px in a row, in widths
constexpr int kSpareNodes = 3;       // for mixed px, and for what shows under soft borders

// Depth as offset from the focus, clamped, NaN as 0.
float offsetOf(float depth, double focus) {
    const float d = depth > 0 ? (depth < 1 ? depth : 1.0F) : 0.0F;
    if (d == static_cast<float>(focus)) return 0; // also where the focus is not a float
    return static_cast<float>(static_cast<double>(d) - focus);
}

// Nodes outside of the frame that views within the reach can show.
int outsideCount(double pixels) {
    return static_cast<int>(std::ceil(std::clamp(pixels, 0.0, 1.0 * kLongestRun))) + 1;
}

// How many px of the surface that begins at `first` can come to light behind what lies left of it.
int hiddenCount(const std::vector<float>& offsets, int first, double reach, double tear) {
    const double own = static_cast<double>(offsets[static_cast<std::size_t>(first)]);
    if (first == 0) return outsideCount(-own * reach);
    double nearest = own;
    int count = 0;
    while (count < kLongestRun) {
        const int x = std::max(first - 1 - count, 0);
        const double front = static_cast<double>(offsets[static_cast<std::size_t>(x)]);
        if (front <= own + tear) break;
        nearest = std::max(nearest, front);
        if (count > reach * (nearest - own) + kSpareNodes) break;
        ++count;
    }
    return count;
}

struct Run {
    int start = 0; // first hidden column
    std::size_t surface = 0;
    float offset = 0;
};

// Painter's order for a camera that moves to the right: of two things that meet in a view the one
// that was farther right is nearer. Hidden nodes come before the front nodes of their columns.
void orderSpans(LayeredRowData& row) {
    std::vector<std::vector<Run>> clusters; // hidden runs that share columns
    int clusterEnd = 0;
    for (std::size_t i = row.surfaces.size(); i-- > 0;) { // from right to left
        const LayeredSurface& surface = row.surfaces[i];
        if (surface.hidden == 0) continue;
        const Run run{surface.first - surface.hidden, i,
                      row.offset[static_cast<std::size_t>(surface.node)]};
        if (clusters.empty() || surface.first <= clusterEnd) {
            clusters.emplace_back();
            clusterEnd = run.start;
        }
        clusterEnd = std::min(clusterEnd, run.start);
        clusters.back().push_back(run);
    }
    std::size_t next = 0; // front surface that is drawn next, from column `from` of it on
    int from = INT32_MIN;
    const auto drawFront = [&](int until) { // columns < until
        while (next < row.surfaces.size()) {
            const LayeredSurface& surface = row.surfaces[next];
            const int end = surface.last + surface.beyond; // its last column
            if (std::max(surface.first, from) >= until) return;
            LayeredSpan span;
            span.x = std::max(surface.first, from);
            span.first = surface.node + span.x - surface.first;
            const bool whole = end < until;
            span.count = (whole ? end : until) - span.x + 1;
            span.leftEnd = span.x == surface.first && surface.hidden == 0;
            span.rightEnd = whole;
            span.leftExtra = span.leftEnd ? surface.leftExtra : 0.0F;
            span.rightExtra = whole ? surface.rightExtra : 0.0F;
            row.spans.push_back(span);
            if (!whole) {
                from = until;
                return;
            }
            from = INT32_MIN;
            ++next;
        }
    };
    for (auto cluster = clusters.rbegin(); cluster != clusters.rend(); ++cluster) {
        int start = cluster->front().start;
        for (const Run& run : *cluster)
            start = std::min(start, run.start);
        drawFront(start);
        std::stable_sort(cluster->begin(), cluster->end(),
                         [](const Run& a, const Run& b) { return a.offset < b.offset; });
        for (const Run& run : *cluster) {
            const LayeredSurface& surface = row.surfaces[run.surface];
            LayeredSpan span;
            span.x = run.start;
            span.first = surface.node - surface.hidden;
            span.count = surface.hidden + 1;
            span.leftEnd = true;
            row.spans.push_back(span);
        }
    }
    drawFront(INT32_MAX);
}

void addSurfaces(const std::uint8_t* bgr, std::vector<float>& offsets,
                 const LayeredSettings& options, LayeredRowData& row) {
    const double tear = options.tearPixels / options.reachPixels;
    const auto offsetAt = [&](int x) {
        return static_cast<double>(offsets[static_cast<std::size_t>(x)]);
    };
    cutSurfaces(bgr, offsets, options, row.surfaces);
    std::int64_t hidden = 0;
    for (LayeredSurface& surface : row.surfaces) {
        surface.hidden = hiddenCount(offsets, surface.first, options.reachPixels, tear);
        hidden += surface.hidden;
    }
    const auto width = static_cast<std::int64_t>(offsets.size());
    if (hidden > kMostHiddenWidths * width + kLongestRun) { // a depth of noise: bound the memory
        const std::int64_t longest =
            kMostHiddenWidths * width / static_cast<std::int64_t>(row.surfaces.size());
        for (LayeredSurface& surface : row.surfaces)
            surface.hidden = std::min(surface.hidden, static_cast<int>(longest));
    }
    int nodes = 0;
    for (std::size_t i = 0; i < row.surfaces.size(); ++i) {
        LayeredSurface& surface = row.surfaces[i];
        if (i + 1 == row.surfaces.size()) {
            surface.beyond = outsideCount(offsetAt(surface.last) * options.reachPixels);
        } else if (offsetAt(row.surfaces[i + 1].first) > offsetAt(surface.last)) {
            surface.beyond = row.surfaces[i + 1].first - surface.last; // the mixed px, and one more
        }
        surface.node = nodes + 1 + surface.hidden;
        nodes = surface.end() + 3;
    }
    row.offset.resize(static_cast<std::size_t>(nodes));
    row.colour.resize(4 * static_cast<std::size_t>(nodes));
    for (const LayeredSurface& surface : row.surfaces) {
        for (int node = surface.begin() - 1; node <= surface.end() + 2; ++node) {
            const int x =
                std::clamp(surface.first + node - surface.node, surface.first, surface.last);
            row.offset[static_cast<std::size_t>(node)] = offsets[static_cast<std::size_t>(x)];
            std::memcpy(&row.colour[4 * static_cast<std::size_t>(node)],
                        bgr + 3 * static_cast<std::ptrdiff_t>(x), 3);
        }
    }
}

} // namespace

std::vector<LayeredRowData> layeredScene(const cv::Mat& photo, const cv::Mat& depth, double focus,
                                         const LayeredSettings& options) {
    std::vector<LayeredRowData> rows(static_cast<std::size_t>(photo.rows));
    const auto still = [&](int y) {
        const auto* row = depth.ptr<float>(y);
        return std::all_of(row, row + depth.cols,
                           [&](float value) { return offsetOf(value, focus) == 0; });
    };
    int stillRows = 0; // at the top
    while (stillRows < photo.rows && still(stillRows))
        ++stillRows;
    if (stillRows == photo.rows) {
        for (LayeredRowData& row : rows)
            row.still = true; // its tables stay empty
        return rows;
    }
    cv::parallel_for_(cv::Range(0, photo.rows), [&](const cv::Range& range) {
        std::vector<float> offsets;
        for (int y = range.start; y < range.end; ++y) {
            LayeredRowData& row = rows[static_cast<std::size_t>(y)];
            const auto* depthRow = depth.ptr<float>(y);
            offsets.resize(static_cast<std::size_t>(photo.cols));
            std::transform(depthRow, depthRow + photo.cols, offsets.begin(),
                           [&](float value) { return offsetOf(value, focus); });
            row.still = std::all_of(offsets.begin(), offsets.end(), [](float d) { return d == 0; });
            addSurfaces(photo.ptr<std::uint8_t>(y), offsets, options, row);
            orderSpans(row);
        }
    });
    if (options.fill == LayeredFill::BackgroundLayer) paintBackground(photo, options, rows);
    return rows;
}

} // namespace altiro3D
