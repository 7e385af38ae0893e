#include "native/native_lut_kernels.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "native/native_lut_kernels.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// Reads 8 bytes per sub-pixel from the cache and writes 4. Writing limits the speed if the memory
// is new, else the four multiplications.
void quiltPixelsOn(const std::uint32_t* HWY_RESTRICT views,
                   const std::uint32_t* HWY_RESTRICT inTile, std::size_t count,
                   const TilePlaces& places, std::uint32_t first, std::uint16_t* HWY_RESTRICT out) {
    std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::ScalableTag<std::uint32_t> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    const hn::RepartitionToNarrow<decltype(d)> narrow;
    const auto perView = hn::Set(d, places.perView);
    const auto perRow = hn::Set(d, places.perRow);
    const auto reciprocal = hn::Set(d, places.reciprocal);
    const auto vFirst = hn::Set(d, first);
    const std::size_t lanes = hn::Lanes(d);
    for (; i + lanes <= count; i += lanes) {
        const auto view = hn::LoadU(d, views + i);
        const auto even = hn::MulEven(view, reciprocal);
        const auto odd =
            hn::MulEven(hn::BitCast(d, hn::ShiftRight<32>(hn::BitCast(wide, view))), reciprocal);
        const auto row = hn::OddEven(hn::BitCast(d, odd), hn::BitCast(d, hn::ShiftRight<32>(even)));
        const auto inside = hn::Add(hn::LoadU(d, inTile + i), vFirst);
        const auto tile = hn::Add(hn::Mul(view, perView), hn::Mul(row, perRow));
        hn::StoreU(hn::BitCast(narrow, hn::Add(tile, inside)), narrow, out + 2 * i);
    }
#endif
    for (; i < count; ++i) {
        const std::uint64_t scaled = static_cast<std::uint64_t>(views[i]) * places.reciprocal;
        const auto row = static_cast<std::uint32_t>(scaled >> 32U);
        const std::uint32_t pair =
            first + views[i] * places.perView + row * places.perRow + inTile[i];
        out[2 * i] = static_cast<std::uint16_t>(pair);
        out[2 * i + 1] = static_cast<std::uint16_t>(pair >> 16);
    }
}

// Reads 4 bytes per pair; memory limits the speed.
LargestPair largestPairOn(const std::uint16_t* HWY_RESTRICT pairs, std::size_t count) {
    LargestPair largest;
    std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::ScalableTag<std::uint16_t> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    const std::size_t lanes = hn::Lanes(d);
    auto most = hn::Zero(d);
    for (; i + lanes <= 2 * count; i += lanes)
        most = hn::Max(most, hn::LoadU(d, pairs + i));
    const auto both = hn::BitCast(wide, most);
    largest.x = static_cast<std::uint16_t>(
        hn::GetLane(hn::MaxOfLanes(wide, hn::And(both, hn::Set(wide, 0xffff)))));
    largest.y =
        static_cast<std::uint16_t>(hn::GetLane(hn::MaxOfLanes(wide, hn::ShiftRight<16>(both))));
#endif
    for (; i < 2 * count; i += 2) {
        largest.x = std::max(largest.x, pairs[i]);
        largest.y = std::max(largest.y, pairs[i + 1]);
    }
    return largest;
}

// Reads 4 bytes per pair and 4 of the column table, writes 1 or 2; memory limits the speed.
template <class T>
HWY_INLINE bool viewsOfQuiltPixelsOn(const std::uint16_t* HWY_RESTRICT pairs,
                                     const std::uint32_t* HWY_RESTRICT inTile, std::size_t count,
                                     const TileGrid& grid, std::uint32_t yInTile,
                                     T* HWY_RESTRICT views) {
    const std::uint32_t last = (grid.rows - 1) * grid.columns; // view of the top-left tile
    bool good = true;
    std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::ScalableTag<std::uint32_t> d;
    const hn::RebindToSigned<decltype(d)> asSigned;
    const hn::RepartitionToNarrow<decltype(d)> narrow;
    const hn::Rebind<T, decltype(d)> result;
    const auto pair = [&](std::uint32_t x, std::uint32_t y) {
        return hn::BitCast(narrow, hn::Set(d, x | y << 16));
    };
    // For each multiple k * size below 65536: (k size reciprocal) >> 16 is k.
    const auto reciprocal = pair(65536U / grid.tileWidth + 1, 65536U / grid.tileHeight + 1);
    const auto size = pair(grid.tileWidth, grid.tileHeight);
    const auto largest = pair(grid.columns - 1, grid.rows - 1);
    const auto row = hn::Set(d, yInTile << 16);
    const auto columns = hn::Set(d, grid.columns);
    const auto lowHalf = hn::Set(d, 0xffffU);
    const auto vLast = hn::Set(d, last);
    auto wrong = hn::Zero(narrow);
    const std::size_t lanes = hn::Lanes(d);
    for (; i + lanes <= count; i += lanes) {
        const auto inside = hn::BitCast(narrow, hn::Or(hn::LoadU(d, inTile + i), row));
        const auto origin = hn::Sub(hn::LoadU(narrow, pairs + 2 * i), inside);
        const auto index = hn::MulHigh(origin, reciprocal);
        const auto off = hn::Xor(hn::Mul(index, size), origin);
        const auto outside = hn::Xor(hn::Min(index, largest), index);
        wrong = hn::Or(wrong, hn::Or(off, outside));
        const auto both = hn::BitCast(d, index);
        const auto up = hn::Mul(hn::ShiftRight<16>(both), columns);
        const auto view = hn::Sub(hn::Add(hn::And(both, lowHalf), vLast), up);
        hn::StoreU(hn::DemoteTo(result, hn::BitCast(asSigned, view)), result, views + i);
    }
    good = hn::AllTrue(narrow, hn::Eq(wrong, hn::Zero(narrow)));
#endif
    for (; i < count; ++i) {
        const std::uint32_t x = pairs[2 * i];
        const std::uint32_t y = pairs[2 * i + 1];
        const std::uint32_t column = x / grid.tileWidth;
        const std::uint32_t up = y / grid.tileHeight;
        good = good && x % grid.tileWidth == inTile[i] && y % grid.tileHeight == yInTile &&
               column < grid.columns && up < grid.rows;
        views[i] = static_cast<T>(last + column - up * grid.columns);
    }
    return good;
}

bool viewsOfQuiltPixels8(const std::uint16_t* pairs, const std::uint32_t* inTile, std::size_t count,
                         const TileGrid& grid, std::uint32_t yInTile, std::uint8_t* views) {
    return viewsOfQuiltPixelsOn(pairs, inTile, count, grid, yInTile, views);
}
bool viewsOfQuiltPixels16(const std::uint16_t* pairs, const std::uint32_t* inTile,
                          std::size_t count, const TileGrid& grid, std::uint32_t yInTile,
                          std::uint16_t* views) {
    return viewsOfQuiltPixelsOn(pairs, inTile, count, grid, yInTile, views);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(quiltPixelsOn);
HWY_EXPORT(largestPairOn);
HWY_EXPORT(viewsOfQuiltPixels8);
HWY_EXPORT(viewsOfQuiltPixels16);

TilePlaces tilePlaces(int columns, int rows, int tileWidth, int tileHeight) {
    const auto c = static_cast<std::uint32_t>(columns);
    const auto width = static_cast<std::uint32_t>(tileWidth);
    const std::uint32_t height = static_cast<std::uint32_t>(tileHeight) << 16;
    TilePlaces p;
    p.first = (static_cast<std::uint32_t>(rows) - 1) * height;
    if (columns == 1) { // a row is a view; the reciprocal 2^32 does not fit
        p.perView = 0U - height;
        return p;
    }
    p.perView = width;
    p.perRow = 0U - c * width - height;
    p.reciprocal = static_cast<std::uint32_t>((std::uint64_t{1} << 32) / c) + 1;
    return p;
}

void quiltPixels(const std::uint32_t* views, const std::uint32_t* inTile, std::size_t count,
                 const TilePlaces& places, int yInTile, std::uint16_t* out) {
    const std::uint32_t first = places.first + (static_cast<std::uint32_t>(yInTile) << 16);
    HWY_DYNAMIC_DISPATCH(quiltPixelsOn)(views, inTile, count, places, first, out);
}

LargestPair largestPair(const std::uint16_t* pairs, std::size_t count) {
    return HWY_DYNAMIC_DISPATCH(largestPairOn)(pairs, count);
}

bool viewsOfQuiltPixels(const std::uint16_t* pairs, const std::uint32_t* inTile, std::size_t count,
                        const TileGrid& grid, std::uint32_t yInTile, std::uint8_t* views) {
    return HWY_DYNAMIC_DISPATCH(viewsOfQuiltPixels8)(pairs, inTile, count, grid, yInTile, views);
}

bool viewsOfQuiltPixels(const std::uint16_t* pairs, const std::uint32_t* inTile, std::size_t count,
                        const TileGrid& grid, std::uint32_t yInTile, std::uint16_t* views) {
    return HWY_DYNAMIC_DISPATCH(viewsOfQuiltPixels16)(pairs, inTile, count, grid, yInTile, views);
}

} // namespace altiro3D
#endif
