#include "native/view_table_kernels.hpp"

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "native/view_table_kernels.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// Reads, per pixel, 3 views and 4 bytes of column table in order, and 3 bytes of quilt, each from
// the row of its own tile; writes 3 bytes. The loads, 2 per sub-pixel, limit the speed. Those of
// the quilt often come from the second-level cache, because a row of all tiles is larger than the
// first.
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
            __builtin_prefetch(row.views[k] + begin + row.toNextViews);
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

void renderRow(const NativeRow<std::uint8_t>& row, const TileOffsets& tiles, RowFetcher& fetcher) {
    HWY_DYNAMIC_DISPATCH(renderRowOn)(row, tiles, fetcher);
}

} // namespace altiro3D
#endif
