#pragma once

#include <cstddef>
#include <cstdint>

namespace altiro3D {

// One row of the photo as method Layered searches it: what does a pixel of a view show?
//
// Content of column c appears in the view shifted by s at g(c) = c - s * offset(c). Cameras that
// move to the right (s > 0) push near things to the left, over others; of all content that meets at
// a pixel x the nearest is therefore the one that comes from farthest right: the largest column c
// with g(c) <= x. If c and c + 1 belong to one surface, x lies between them, linearly. Otherwise x
// lies at or behind the end of a surface (views_layered_ends.hpp).
//
// For s < 0 there are tables of the mirrored row. Both stand in one array, side by side.

constexpr int kOffsetBits = 14;                              ///< Offsets are whole numbers,
constexpr int kLargestOffset = (1 << (kOffsetBits - 1)) - 1; ///< -8191..8191 of these.
constexpr int kEndReach = 2;      ///< The border of a surface reaches less than this beyond it, px.
constexpr int kLeftColumns = 16;  ///< Columns that LayeredTables::left looks at.
constexpr int kTablePadding = 8;  ///< Columns left and right of each table.
constexpr int kSubColumnBits = 8; ///< Places between columns are counted in 1/256.

// A place: 256 * column + 1/256 px. The columns are those of a plane: the row, from `stride` on the
// mirrored row, and from 2 * stride on what is painted beside surfaces (LayeredSurfaces::strips).
constexpr std::int32_t kSeeEnds = INT32_MIN; ///< Place of a pixel that needs LayeredSearch.

/// An offset, and whether the column is the first one of a surface that has a border there, or the
/// last one of its surface.
constexpr int kLastFlag = 1;
constexpr int kFirstFlag = 2;
constexpr std::int16_t columnWord(int offset, bool first, bool last) {
    return static_cast<std::int16_t>(offset * 4 + (first ? kFirstFlag : 0) +
                                     (last ? kLastFlag : 0));
}
constexpr int wordOffset(std::int16_t word) {
    return word >> 2;
}

/// Tables of one row. Each holds the row, kTablePadding more on both sides, and then, `stride`
/// further, the same of the mirrored row; pointers are to column 0.
struct LayeredTables {
    const std::int16_t* words = nullptr; ///< columnWord() of each column.
    /// Bound of the search: the largest offset among the columns that can be seen at this one, as a
    /// columnWord() without flags.
    const std::int16_t* bounds = nullptr;
    /// As `bounds`, of the kLeftColumns columns that end here.
    const std::int16_t* left = nullptr;
    const std::int16_t* surfaces = nullptr; ///< Index of the surface that began last.
    /// columnLimits() of each column.
    const std::int32_t* limits = nullptr;
    int stride = 0;       ///< Columns from a table to its mirrored twin.
    int width = 0;        ///< Columns of the photo.
    float scale = 0;      ///< Depth - focus of one unit of the offsets.
    float clearScale = 0; ///< columnLimits() units of one px.
};

/// What is known of a column before any search: where its surface begins, and up to which
/// shift nothing of a surface further right comes to it.
/// @param begin column, >= 0 @param clear in 1/65535 of the largest shift, 0..65535
constexpr std::int32_t columnLimits(int begin, int clear) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(begin) << 16 |
                                     static_cast<std::uint32_t>(clear));
}

/// The surfaces of a row as the search reads them: one entry each and padding (kRowPadding), first
/// those of the row, then those of the mirrored row.
struct LayeredSurfaces {
    const float* first = nullptr;         ///< First column.
    const float* last = nullptr;          ///< Last column.
    const float* hidden = nullptr;        ///< Painted columns to the left.
    const float* beyond = nullptr;        ///< Painted columns to the right.
    const float* leftBorder = nullptr;    ///< How far it covers pixels left of `first`, px.
    const float* rightBorder = nullptr;   ///< The same, right of what is painted beyond `last`.
    const std::int32_t* strips = nullptr; ///< Column in the planes of `first`; behind it `last`.
    int begin[3] = {0, 0, 0};             ///< Where either direction begins, and the end.
};

/// Where the search may begin: the columnWord() of a column and the slope of the offsets
/// around it, for layeredPlaces() to begin with.
/// @param word columnWord() of the column @param rise offset two columns on minus offset two before
constexpr std::int32_t columnGuess(std::int16_t word, int rise) {
    const int bounded = rise < -32768 ? -32768 : rise > 32767 ? 32767 : rise;
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(word) << 16 |
                                     static_cast<std::uint16_t>(bounded));
}

/// Pixels that are asked for. Arrays of `count` and padding (kRowPadding).
struct LayeredPixels {
    /// Column in the row, in order (ascending or descending) but for the padding; W - 1 - column in
    /// the mirrored row.
    const float* columns = nullptr;
    const std::int32_t* guesses = nullptr; ///< columnGuess() of it, in the row.
    /// LayeredTables::limits of it, in the row and in the mirrored row.
    const std::int32_t* limits[2] = {nullptr, nullptr};
    int reach = 0; ///< How far from its column the place of a pixel may lie, columns.
    std::size_t count = 0;
};

/// Room for layeredPlaces(): `count` and padding each.
struct LayeredRoom {
    std::int32_t* places = nullptr; ///< Result: for layeredSamples(), or kSeeEnds.
    std::int32_t* hard = nullptr;   ///< Result: numbers of the pixels that got kSeeEnds.
    /// Result: for each of `hard` the column (in its direction) from which on, to the left, the
    /// search must go on.
    std::int32_t* hardColumns = nullptr;
    std::int32_t* mixed = nullptr;  ///< Result: numbers of the pixels that a border covers in part.
    std::int32_t* covers = nullptr; ///< Result: for each of `mixed` the place of what covers it,
    std::int32_t* parts = nullptr;  ///< and how much of it, 1..255 of 256.
    std::int32_t* open = nullptr;   ///< For its own use,
    std::int32_t* openColumns = nullptr; ///< as well.
};

/// What layeredPlaces() found besides places.
struct LayeredCounts {
    std::size_t hard = 0;  ///< Pixels that need LayeredSearch.
    std::size_t mixed = 0; ///< Pixels that a border covers in part.
};

/// Finds what pixels show.
///
/// @param tables, surfaces the row
/// @param pixels columns, with what the tables say about them
/// @param shifts shift of the view that each pixel belongs to, px
/// @param bounded whether no |shift| is larger than the one that the bounds were made for
/// @param room results
LayeredCounts layeredPlaces(const LayeredTables& tables, const LayeredSurfaces& surfaces,
                            const LayeredPixels& pixels, const float* shifts, bool bounded,
                            const LayeredRoom& room);

/// Reads one channel between columns, linearly.
///
/// @param tables, pixels as for layeredPlaces()
/// @param plane the channel: row and mirrored row, laid out as the tables, padded
/// @param places from layeredPlaces(), `count` and padding; kSeeEnds gives any value
/// @param values result
void layeredSamples(const LayeredTables& tables, const LayeredPixels& pixels,
                    const std::uint8_t* plane, const std::int32_t* places, std::uint8_t* values);

} // namespace altiro3D
