#include "native/view_table.hpp"

#include "base/pixel_rows.hpp"
#include "display/lens_phase.hpp"
#include "native/panel_table.hpp"

#include <atomic>
#include <opencv2/core.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "native/view_table.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// As renderRowPlain(), but computes the row starts instead of looking them up. The result is the
// same on every instruction set.
//
// Reads, per pixel, 3 views and 4 bytes of column table in order, and 3 bytes of quilt, each from
// the row of its own tile; writes 3 bytes. The loads, 2 per sub-pixel, limit the speed. Those of
// the quilt often come from the second-level cache: a row of all tiles exceeds the first.
void renderRowOn(const NativeRow<std::uint8_t>& row, [[maybe_unused]] const TileOffsets& tiles,
                 RowFetcher& fetcher) {
    std::size_t begin = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::CappedTag<std::uint32_t, 16> d; // so a portion consists of whole vectors
    const hn::RebindToSigned<decltype(d)> asSigned;
    const hn::Rebind<std::uint8_t, decltype(d)> narrow;
    const std::size_t lanes = hn::Lanes(d);
    // (v reciprocal) >> 16 is v / columns for v and columns up to 256.
    const auto reciprocal = hn::Set(d, 65536U / tiles.columns + 1);
    const auto perColumn = hn::Set(d, tiles.perColumn);
    const auto perRow = hn::Set(d, 0U - tiles.perRow - tiles.columns * tiles.perColumn);
    const std::uint8_t* const base = row.tileRows[0];
    alignas(64) std::int32_t places[3][kPortionPixels];
    const auto findPlaces = [&](const std::uint8_t* HWY_RESTRICT views, std::uint32_t colour,
                                std::int32_t* HWY_RESTRICT to) HWY_ATTR {
        for (std::size_t i = 0; i < kPortionPixels; i += lanes) {
            const auto view = hn::PromoteTo(d, hn::LoadU(narrow, views + i));
            const auto up = hn::ShiftRight<16>(hn::Mul(view, reciprocal));
            const auto column = hn::LoadU(d, row.columnBytes + begin + i);
            const auto inside = hn::Add(column, hn::Set(d, colour));
            const auto tile = hn::Add(hn::Mul(view, perColumn), hn::Mul(up, perRow));
            hn::Store(hn::BitCast(asSigned, hn::Add(tile, inside)), asSigned, to + i);
        }
    };
    for (; begin + kPortionPixels <= row.count; begin += kPortionPixels) {
        fetcher.fetch();
        for (std::uint32_t k = 0; k < 3; ++k) {
            hwy::Prefetch(row.views[k] + begin + row.toNextViews);
            findPlaces(row.views[k] + begin, k, places[k]);
        }
        std::uint8_t* HWY_RESTRICT out = row.out + 3 * begin;
        for (std::size_t i = 0; i < kPortionPixels; ++i) {
            out[3 * i] = base[places[0][i]];
            out[3 * i + 1] = base[places[1][i]];
            out[3 * i + 2] = base[places[2][i]];
        }
    }
#endif
    NativeRow<std::uint8_t> rest = row;
    for (const std::uint8_t*& views : rest.views)
        views += begin;
    rest.columnBytes += begin;
    rest.count -= begin;
    rest.out += 3 * begin;
    renderRowPlain(rest, fetcher);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(renderRowOn);

namespace {

constexpr int kMaxTiles = 65536;

int tileCount(const QuiltLayout& quilt) {
    return quilt.columns * quilt.rows;
}

ViewTable emptyTable(cv::Size panelSize, const QuiltLayout& quilt) {
    ViewTable t;
    t.panelSize = panelSize;
    t.quilt = quilt;
    const int type = tileCount(quilt) <= 256 ? CV_8U : CV_16U;
    t.views = panelTable(panelSize, type);
    t.columns.resize(static_cast<std::size_t>(panelSize.width));
    t.rows.resize(static_cast<std::size_t>(panelSize.height));
    return t;
}

// Offsets of the tiles, if they fit into 32 bits.
std::optional<TileOffsets> tileOffsets(const QuiltLayout& quilt, std::size_t step) {
    if (tileCount(quilt) > 256 || step * static_cast<std::size_t>(quilt.size().height) >= 1U << 31)
        return std::nullopt;
    TileOffsets tiles;
    tiles.columns = static_cast<std::uint32_t>(quilt.columns);
    tiles.perColumn = static_cast<std::uint32_t>(3 * quilt.tileSize.width);
    tiles.perRow =
        static_cast<std::uint32_t>(step) * static_cast<std::uint32_t>(quilt.tileSize.height);
    return tiles;
}

template <class T>
void renderRows(const ViewTable& t, const std::vector<std::uint32_t>& columnBytes,
                const cv::Mat& source, cv::Mat& native, ChannelOrder order,
                const cv::Range& range) {
    const QuiltLayout& quilt = t.quilt;
    const int portions = (native.cols - 1) / static_cast<int>(kPortionPixels) + 1;
    [[maybe_unused]] const std::optional<TileOffsets> tiles = tileOffsets(quilt, source.step);
    std::vector<const std::uint8_t*> tileRows;
    RowFetcher fetcher;
    int current = -1;
    for (int y = range.start; y < range.end; ++y) {
        const auto rowAt = [&](int panelRow) {
            return static_cast<int>(t.rows[static_cast<std::size_t>(panelRow)]);
        };
        if (rowAt(y) != current) {
            current = rowAt(y);
            tileRows.clear();
            for (int view = 0; view < tileCount(quilt); ++view) {
                const cv::Point origin = quilt.tile(view).tl();
                tileRows.push_back(source.ptr(origin.y + current) + std::ptrdiff_t{3} * origin.x);
            }
            int next = y + 1; // the first panel row that shows another row of the tiles
            while (next < range.end && rowAt(next) == current)
                ++next;
            const int down = next < range.end ? rowAt(next) - current : 0;
            fetcher.start(tileRows, down * static_cast<std::ptrdiff_t>(source.step),
                          static_cast<std::size_t>(3 * quilt.tileSize.width),
                          static_cast<std::size_t>((next - y) * portions));
        }
        const auto viewsOf = [&](int channel) {
            return t.views.ptr<T>(3 * y + 2 - colourAt(channel, order));
        };
        const NativeRow<T> row{{viewsOf(0), viewsOf(1), viewsOf(2)},
                               y + 1 < t.panelSize.height ? 3 * std::ptrdiff_t{t.views.cols} : 0,
                               columnBytes.data(),
                               tileRows.data(),
                               columnBytes.size(),
                               native.ptr(y)};
        if constexpr (sizeof(T) == 1) {
            if (tiles) {
                HWY_DYNAMIC_DISPATCH(renderRowOn)(row, *tiles, fetcher);
                continue;
            }
        }
        renderRowPlain(row, fetcher);
    }
}

// For each px of a side of a quilt the number of the tile that begins there, else -1.
std::vector<int> tileStarts(int length, int tile) {
    std::vector<int> starts(static_cast<std::size_t>(length), -1);
    for (int i = 0; i < length / tile; ++i)
        starts[static_cast<std::size_t>(i * tile)] = i;
    return starts;
}

// Views of a row of sub-pixels. false if one is at another place inside its tile.
template <class T>
bool readViews(const NativeLut& lut, int row, const std::vector<int>& columns,
               const std::vector<int>& rows, const ViewTable& t, T* views) {
    const auto* pairs = lut.channel(2 - row % 3).ptr<std::uint16_t>(row / 3);
    const std::uint32_t yInTile = t.rows[static_cast<std::size_t>(row / 3)];
    const int last = (t.quilt.rows - 1) * t.quilt.columns; // view of the top-left tile
    for (const std::uint32_t inTile : t.columns) {
        const std::uint32_t x = *pairs++ - inTile; // before the quilt: a large number
        const std::uint32_t y = *pairs++ - yInTile;
        if (x >= columns.size() || y >= rows.size() || columns[x] < 0 || rows[y] < 0) return false;
        *views++ = static_cast<T>(last + columns[x] - rows[y] * t.quilt.columns);
    }
    return true;
}

} // namespace

void ViewTable::render(const cv::Mat& source, cv::Mat& native, ChannelOrder order) const {
    std::vector<std::uint32_t> columnBytes(columns.size());
    for (std::size_t x = 0; x < columns.size(); ++x)
        columnBytes[x] = 3 * columns[x];
    cv::parallel_for_(cv::Range(0, native.rows), [&](const cv::Range& range) {
        if (views.depth() == CV_8U) {
            renderRows<std::uint8_t>(*this, columnBytes, source, native, order, range);
        } else {
            renderRows<std::uint16_t>(*this, columnBytes, source, native, order, range);
        }
    });
}

std::optional<ViewTable> viewTable(const LensGeometry& g, const QuiltLayout& quilt) {
    if (tileCount(quilt) > kMaxTiles) return std::nullopt;
    ViewTable t = emptyTable({g.panelWidth, g.panelHeight}, quilt);
    const std::vector<int> columns = samplesUnder(g.panelWidth, quilt.tileSize.width, g.mirrorX);
    t.columns.assign(columns.begin(), columns.end());
    const std::vector<int> rows = samplesUnder(g.panelHeight, quilt.tileSize.height, g.mirrorY);
    t.rows.assign(rows.begin(), rows.end());
    const LensPhases phases(g);
    overRows(3 * g.panelHeight, [&](int row) {
        const int channel = 2 - row % 3;
        if (t.views.depth() == CV_8U) {
            phases.viewsOfRow(row / 3, channel, quilt.viewCount, t.views.ptr(row));
        } else {
            phases.viewsOfRow(row / 3, channel, quilt.viewCount, t.views.ptr<std::uint16_t>(row));
        }
    });
    return t;
}

std::optional<ViewTable> viewTable(const NativeLut& lut) {
    const QuiltLayout& quilt = lut.quilt();
    const cv::Size tile = quilt.tileSize;
    if (tileCount(quilt) > kMaxTiles || tile.width < 2 || tile.height < 2) return std::nullopt;
    ViewTable t = emptyTable(lut.panelSize(), quilt);
    const cv::Mat& red = lut.channel(0);
    for (int x = 0; x < red.cols; ++x) {
        t.columns[static_cast<std::size_t>(x)] =
            static_cast<std::uint32_t>(red.ptr<std::uint16_t>(0)[2 * x] % tile.width);
    }
    for (int y = 0; y < red.rows; ++y) {
        t.rows[static_cast<std::size_t>(y)] =
            static_cast<std::uint32_t>(red.ptr<std::uint16_t>(y)[1] % tile.height);
    }
    const std::vector<int> columns = tileStarts(quilt.size().width, tile.width);
    const std::vector<int> rows = tileStarts(quilt.size().height, tile.height);
    std::atomic<bool> good{true};
    cv::parallel_for_(cv::Range(0, t.views.rows), [&](const cv::Range& range) {
        for (int row = range.start; row < range.end && good; ++row) {
            const bool fits =
                t.views.depth() == CV_8U
                    ? readViews(lut, row, columns, rows, t, t.views.ptr(row))
                    : readViews(lut, row, columns, rows, t, t.views.ptr<std::uint16_t>(row));
            if (!fits) good = false;
        }
    });
    if (!good) return std::nullopt;
    return t;
}

} // namespace altiro3D
#endif
