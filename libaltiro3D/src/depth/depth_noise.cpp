#include "depth/depth_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

// Sum of the depths in a cell, and their number; later weighted.
struct Cell {
    float sum = 0;
    float weight = 0;
};

// Levels begin..end - 1.
struct Span {
    int begin = 0;
    int end = 0;

    bool empty() const { return begin == end; }
    void include(const Span& other) {
        if (other.empty()) return;
        begin = empty() ? other.begin : std::min(begin, other.begin);
        end = std::max(end, other.end);
    }
};

// Cells over columns, rows and depth; the cells of one place lie together. Most of them are empty:
// the depths around a place are few.
struct Grid {
    int side; // px per cell
    int columns;
    int rows;
    int levels;
    std::vector<Cell> cells;
    std::vector<Span> spans; // of each place; all other cells are 0

    Grid(cv::Size picture, int cellSide, int depthLevels)
        : side(cellSide), columns((picture.width - 1) / cellSide + 1),
          rows((picture.height - 1) / cellSide + 1), levels(depthLevels),
          cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) *
                static_cast<std::size_t>(levels)),
          spans(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}
    std::ptrdiff_t place(int column, int row) const {
        return static_cast<std::ptrdiff_t>(row) * columns + column;
    }
    Cell* at(std::ptrdiff_t place) { return cells.data() + place * levels; }
    Span& span(std::ptrdiff_t place) { return spans[static_cast<std::size_t>(place)]; }
    int levelOf(float depth) const {
        return std::min(static_cast<int>(depth * static_cast<float>(levels)), levels - 1);
    }
};

void collect(const cv::Mat& depth, Grid& grid) {
    cv::parallel_for_(cv::Range(0, grid.rows), [&](const cv::Range& range) {
        for (int row = range.start; row < range.end; ++row) {
            const int end = std::min((row + 1) * grid.side, depth.rows);
            for (int y = row * grid.side; y < end; ++y) {
                const float* const from = depth.ptr<float>(y);
                for (int x = 0; x < depth.cols; ++x) {
                    const std::ptrdiff_t place = grid.place(x / grid.side, row);
                    const int level = grid.levelOf(from[x]);
                    Cell& cell = grid.at(place)[level];
                    cell.sum += from[x];
                    cell.weight += 1;
                    grid.span(place).include({level, level + 1});
                }
            }
        }
    });
}

// A binomial kernel: standard deviation 1.41 cells. Beyond the ends there is nothing.
constexpr int kRadius = 4;
constexpr std::array<float, 2 * kRadius + 1> kKernel = {1 / 256.F,  8 / 256.F,  28 / 256.F,
                                                        56 / 256.F, 70 / 256.F, 56 / 256.F,
                                                        28 / 256.F, 8 / 256.F,  1 / 256.F};

void addTo(Cell* to, const Cell* from, int count, float share) {
    for (int i = 0; i < count; ++i) {
        to[i].sum += share * from[i].sum;
        to[i].weight += share * from[i].weight;
    }
}

// Blurs the levels of a place.
void blurPlace(Cell* cells, int levels, Span& span, std::vector<Cell>& buffer) {
    const Span from = span;
    span = {std::max(0, from.begin - kRadius), std::min(levels, from.end + kRadius)};
    buffer.assign(cells + from.begin, cells + from.end);
    std::fill(cells + from.begin, cells + from.end, Cell());
    for (int level = from.begin; level < from.end; ++level)
        for (int k = -kRadius; k <= kRadius; ++k)
            if (level + k >= 0 && level + k < levels)
                addTo(cells + level + k, &buffer[static_cast<std::size_t>(level - from.begin)], 1,
                      kKernel[static_cast<std::size_t>(k + kRadius)]);
}

// Blurs a line of places.
// @param stride places from one to the next
void blurLine(Grid& grid, std::ptrdiff_t first, std::ptrdiff_t stride, int count,
              std::vector<Cell>& buffer, std::vector<Span>& spans) {
    buffer.resize(static_cast<std::size_t>(count) * static_cast<std::size_t>(grid.levels));
    spans.resize(static_cast<std::size_t>(count));
    const auto copyOf = [&](int i) {
        return buffer.data() + static_cast<std::ptrdiff_t>(i) * grid.levels;
    };
    for (int i = 0; i < count; ++i) {
        const Span& span = spans[static_cast<std::size_t>(i)] = grid.span(first + i * stride);
        Cell* const cells = grid.at(first + i * stride);
        std::copy(cells + span.begin, cells + span.end, copyOf(i) + span.begin);
        std::fill(cells + span.begin, cells + span.end, Cell());
    }
    for (int i = 0; i < count; ++i) {
        Cell* const cells = grid.at(first + i * stride);
        Span& all = grid.span(first + i * stride);
        for (int k = std::max(-kRadius, -i); k <= std::min(kRadius, count - 1 - i); ++k) {
            const Span& span = spans[static_cast<std::size_t>(i + k)];
            addTo(cells + span.begin, copyOf(i + k) + span.begin, span.end - span.begin,
                  kKernel[static_cast<std::size_t>(k + kRadius)]);
            all.include(span);
        }
    }
}

void blur(Grid& grid) {
    cv::parallel_for_(cv::Range(0, grid.rows), [&](const cv::Range& range) {
        std::vector<Cell> buffer;
        std::vector<Span> spans;
        for (int row = range.start; row < range.end; ++row) {
            const std::ptrdiff_t first = grid.place(0, row);
            for (std::ptrdiff_t place = first; place < first + grid.columns; ++place)
                blurPlace(grid.at(place), grid.levels, grid.span(place), buffer);
            blurLine(grid, first, 1, grid.columns, buffer, spans);
        }
    });
    cv::parallel_for_(cv::Range(0, grid.columns), [&](const cv::Range& range) {
        std::vector<Cell> buffer;
        std::vector<Span> spans;
        for (int column = range.start; column < range.end; ++column)
            blurLine(grid, grid.place(column, 0), grid.columns, grid.rows, buffer, spans);
    });
}

// The two cells around a place, and the weight of the second.
struct Between {
    int first;
    int second;
    float weight;

    Between(float place, int count) { // centre of cell i at i + 0.5
        const float at = std::clamp(place - 0.5F, 0.0F, static_cast<float>(count - 1));
        first = static_cast<int>(at);
        second = std::min(first + 1, count - 1);
        weight = at - static_cast<float>(first);
    }
};

Cell mix(const Cell& a, const Cell& b, float weight) {
    return {a.sum + weight * (b.sum - a.sum), a.weight + weight * (b.weight - a.weight)};
}

// The cells between two rows of places. What is in neither span is not read.
void mixRows(Grid& grid, const Between& rows, std::vector<Cell>& mixed) {
    for (int column = 0; column < grid.columns; ++column) {
        const std::ptrdiff_t above = grid.place(column, rows.first);
        const std::ptrdiff_t below = grid.place(column, rows.second);
        Span span = grid.span(above);
        span.include(grid.span(below));
        const Cell* const first = grid.at(above);
        const Cell* const second = grid.at(below);
        Cell* const to = mixed.data() + static_cast<std::ptrdiff_t>(column) * grid.levels;
        for (int level = span.begin; level < span.end; ++level)
            to[level] = mix(first[level], second[level], rows.weight);
    }
}

void readBack(Grid& grid, cv::Mat& depth) {
    std::vector<Between> columns;
    columns.reserve(static_cast<std::size_t>(depth.cols));
    const auto place = [&](int pixel) {
        return (static_cast<float>(pixel) + 0.5F) / static_cast<float>(grid.side);
    };
    for (int x = 0; x < depth.cols; ++x)
        columns.emplace_back(place(x), grid.columns);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        std::vector<Cell> cells(static_cast<std::size_t>(grid.columns) *
                                static_cast<std::size_t>(grid.levels));
        for (int y = range.start; y < range.end; ++y) {
            const Between rows(place(y), grid.rows);
            mixRows(grid, rows, cells);
            auto* const row = depth.ptr<float>(y);
            for (int x = 0; x < depth.cols; ++x) {
                const Between& column = columns[static_cast<std::size_t>(x)];
                const Between level(row[x] * static_cast<float>(grid.levels), grid.levels);
                const auto along = [&](int c) {
                    const Cell* const here =
                        cells.data() + static_cast<std::ptrdiff_t>(c) * grid.levels;
                    return mix(here[level.first], here[level.second], level.weight);
                };
                const Cell cell = mix(along(column.first), along(column.second), column.weight);
                if (cell.weight > 0) row[x] = std::clamp(cell.sum / cell.weight, 0.0F, 1.0F);
            }
        }
    });
}

} // namespace

void smoothSurfaces(double noise, cv::Mat& depth) {
    const int side = std::max(8, std::max(depth.cols, depth.rows) / 64);
    const int levels = static_cast<int>(std::clamp(1 / (1.5 * noise), 1.0, 192.0));
    Grid grid(depth.size(), side, levels);
    collect(depth, grid);
    blur(grid);
    readBack(grid, depth);
}

} // namespace altiro3D
