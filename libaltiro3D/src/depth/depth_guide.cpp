#include "depth/depth_guide.hpp"

#include "depth/depth_cues_row.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/utility.hpp>
#include <vector>

namespace altiro3D {

namespace {

// Rows of N sums, with room for the margins of windows.
template <class T, std::size_t N>
class SumRows {
  public:
    explicit SumRows(std::size_t columns) {
        for (std::vector<T>& row : rows_)
            row = paddedRow<T>(columns + 2 * kGuideMargin);
    }
    std::array<T*, N> from(std::size_t column) {
        std::array<T*, N> result{};
        for (std::size_t i = 0; i < N; ++i)
            result[i] = rows_[i].data() + column;
        return result;
    }

  private:
    std::array<std::vector<T>, N> rows_;
};

// Number of px from a place - kGuideRadius to it + kGuideRadius that exist.
std::size_t windowLength(std::size_t place, std::size_t count) {
    return std::min(place + kGuideRadius + 1, count) - (place - std::min(place, kGuideRadius));
}

// Calls `add(y, false)` for the rows of the first window, then `use(y)` for each row of a range,
// and between them `add()` for the rows that enter, or leave (true) the window.
template <class Add, class Use>
void slideWindows(const cv::Range& range, std::size_t rows, Add add, Use use) {
    const auto begin = static_cast<std::size_t>(range.start);
    const std::size_t top = begin - std::min(begin, kGuideRadius);
    for (std::size_t y = top; y < std::min(begin + kGuideRadius, rows); ++y)
        add(y, false);
    for (std::size_t y = begin; y < static_cast<std::size_t>(range.end); ++y) {
        if (y + kGuideRadius < rows) add(y + kGuideRadius, false);
        use(y);
        if (y >= kGuideRadius) add(y - kGuideRadius, true);
    }
}

} // namespace

// All sums are exact, so bands of any height give the same result.
void followEdges(const Guide& guide, PaddedPlane<float>& depth) {
    const std::size_t columns = depth.columns();
    const std::size_t rows = depth.rows();
    const auto guideRow = [&](std::size_t y) {
        return RowOf3<std::uint8_t>{guide[0].row(y), guide[1].row(y), guide[2].row(y)};
    };
    std::vector<double> widths = paddedRow<double>(columns);
    std::fill(widths.begin(), widths.end(), 1.0);
    for (std::size_t x = 0; x < columns; ++x)
        widths[x] = static_cast<double>(windowLength(x, columns));
    const auto windowRow = [&](std::size_t y) {
        return WindowRow{columns, widths.data(), static_cast<double>(windowLength(y, rows))};
    };
    const PaddedPlane<float> empty(columns, rows);
    std::array<PaddedPlane<float>, 4> lines{empty, empty, empty, empty};
    const cv::Range all(0, static_cast<int>(rows));
    const double bands = static_cast<double>(rows) / (4 * (2 * kGuideRadius + 1));
    cv::parallel_for_(
        all,
        [&](const cv::Range& range) {
            SumRows<double, 4> depths(columns);
            SumRows<std::int32_t, 9> products(columns);
            SumRows<double, 4> depthWindows(columns);
            SumRows<std::int32_t, 9> productWindows(columns);
            const GuideSums inside{depths.from(kGuideMargin), products.from(kGuideMargin)};
            const GuideSums sums{depths.from(0), products.from(0)};
            const GuideSums windows{depthWindows.from(0), productWindows.from(0)};
            slideWindows(
                range, rows,
                [&](std::size_t y, bool leaves) {
                    addGuideRow(guideRow(y), depth.row(y), columns, leaves, inside);
                },
                [&](std::size_t y) {
                    fitGuideRow(
                        windowRow(y), sums, windows,
                        {lines[0].row(y), lines[1].row(y), lines[2].row(y), lines[3].row(y)});
                });
        },
        bands);
    cv::parallel_for_(
        all,
        [&](const cv::Range& range) {
            SumRows<double, 4> sums(columns);
            SumRows<double, 4> windows(columns);
            slideWindows(
                range, rows,
                [&](std::size_t y, bool leaves) {
                    addLinesRow(
                        {lines[0].row(y), lines[1].row(y), lines[2].row(y), lines[3].row(y)},
                        columns, leaves, sums.from(kGuideMargin));
                },
                [&](std::size_t y) {
                    guidedRow(windowRow(y), guideRow(y), sums.from(0), windows.from(0),
                              depth.row(y));
                });
        },
        bands);
}

} // namespace altiro3D
