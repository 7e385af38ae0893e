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

// Cells over columns, rows and depth; the cells of one place lie together.
struct Grid {
    int side; // px per cell
    int columns;
    int rows;
    int levels;
    std::vector<Cell> cells;

    Grid(cv::Size picture, int cellSide, int depthLevels)
        : side(cellSide), columns((picture.width - 1) / cellSide + 1),
          rows((picture.height - 1) / cellSide + 1), levels(depthLevels),
          cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) *
                static_cast<std::size_t>(levels)) {}
    Cell* at(int column, int row) {
        return cells.data() + (static_cast<std::ptrdiff_t>(row) * columns + column) * levels;
    }
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
                    Cell& cell = grid.at(x / grid.side, row)[grid.levelOf(from[x])];
                    cell.sum += from[x];
                    cell.weight += 1;
                }
            }
        }
    });
}

// One line of cells, blurred by a binomial kernel: standard deviation 1.41 cells. Beyond the ends
// there is nothing.
void blurLine(Cell* cells, std::ptrdiff_t stride, int count, std::vector<Cell>& buffer) {
    constexpr int kRadius = 4;
    constexpr std::array<float, 2 * kRadius + 1> kKernel = {1 / 256.F,  8 / 256.F,  28 / 256.F,
                                                            56 / 256.F, 70 / 256.F, 56 / 256.F,
                                                            28 / 256.F, 8 / 256.F,  1 / 256.F};
    buffer.assign(static_cast<std::size_t>(count + 2 * kRadius), {});
    for (int i = 0; i < count; ++i)
        buffer[static_cast<std::size_t>(i + kRadius)] = cells[i * stride];
    for (int i = 0; i < count; ++i) {
        Cell blurred;
        const Cell* const from = buffer.data() + i;
        for (std::size_t k = 0; k < kKernel.size(); ++k) {
            blurred.sum += kKernel[k] * from[k].sum;
            blurred.weight += kKernel[k] * from[k].weight;
        }
        cells[i * stride] = blurred;
    }
}

void blur(Grid& grid) {
    const std::ptrdiff_t rowStride = static_cast<std::ptrdiff_t>(grid.columns) * grid.levels;
    cv::parallel_for_(cv::Range(0, grid.rows), [&](const cv::Range& range) {
        std::vector<Cell> buffer;
        for (int row = range.start; row < range.end; ++row) {
            for (int column = 0; column < grid.columns; ++column)
                blurLine(grid.at(column, row), 1, grid.levels, buffer);
            for (int level = 0; level < grid.levels; ++level)
                blurLine(grid.at(0, row) + level, grid.levels, grid.columns, buffer);
        }
    });
    cv::parallel_for_(cv::Range(0, grid.columns), [&](const cv::Range& range) {
        std::vector<Cell> buffer;
        for (int column = range.start; column < range.end; ++column) {
            for (int level = 0; level < grid.levels; ++level)
                blurLine(grid.at(column, 0) + level, rowStride, grid.rows, buffer);
        }
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

// The cells at a place between two rows of cells.
void mixRows(const Cell* first, const Cell* second, float weight, std::vector<Cell>& mixed) {
    for (std::size_t i = 0; i < mixed.size(); ++i)
        mixed[i] = mix(first[i], second[i], weight);
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
            mixRows(grid.at(0, rows.first), grid.at(0, rows.second), rows.weight, cells);
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
