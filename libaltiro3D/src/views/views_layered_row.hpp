#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

// The search of method Layered in one row of the photo: what a pixel of a view shows.
//
// Content of column c appears in the view shifted by s at g(c) = c - s * offset(c). A camera that
// moves to the right (s > 0) shifts near things to the left, over others. Of all contents that meet
// at a pixel x, the nearest therefore comes from farthest right: it is the largest column c with
// g(c) <= x. If c and c + 1 belong to one surface, x is interpolated linearly between them.
// Otherwise x is at or behind the end of a surface (views_layered_ends.hpp).
//
// For s < 0, tables of the mirrored row are used. Both are in one array, side by side.
//
// Most pixels need no search: no other surface comes near them, and the offsets around them follow
// a line, offset(c) = o + m (c - x). They show c = x + s o / (1 - s m).

constexpr int kOffsetBits = 14;                          ///< Bits of an offset, a whole number.
constexpr int kMaxOffset = (1 << (kOffsetBits - 1)) - 1; ///< Offsets are -8191..8191.
constexpr int kEndReach = 2;      ///< Limit of the extent of a surface's border, px.
constexpr int kLeftColumns = 16;  ///< Columns that LayeredTables::left covers.
constexpr int kTablePadding = 8;  ///< Columns left and right of each table.
constexpr int kSubColumnBits = 8; ///< Positions between columns are multiples of 1/256.

// A place: 256 * column + 1/256 px. Columns are those of a plane, which holds the row, from
// `stride` on the mirrored row, and from 2 * stride on the strips painted beside surfaces
// (LayeredSurfaces::strips).
constexpr std::int32_t kSeeEnds = INT32_MIN; ///< Place of a pixel that needs LayeredSearch.

/// Packs an offset with two flags: the column is the first of a surface with a border there, or the
/// last of its surface.
constexpr int kLastFlag = 1;
constexpr int kFirstFlag = 2;
constexpr std::int16_t columnWord(int offset, bool first, bool last) {
    return static_cast<std::int16_t>(offset * 4 + (first ? kFirstFlag : 0) +
                                     (last ? kLastFlag : 0));
}
constexpr int wordOffset(std::int16_t word) {
    return word >> 2;
}

/// Tables of one row. Each holds the row with kTablePadding entries on both sides and then,
/// `stride` entries further, the same for the mirrored row. Pointers are to column 0.
struct LayeredTables {
    const std::int16_t* words = nullptr; ///< columnWord() of each column.
    /// Bound of the search: the largest offset among the columns that can appear at this one, as a
    /// columnWord() without flags.
    const std::int16_t* bounds = nullptr;
    /// As `bounds`, for the kLeftColumns columns that end here.
    const std::int16_t* left = nullptr;
    /// Index of the last surface that begins here or to the left.
    const std::int16_t* surfaces = nullptr;
    /// The shift up to which no surface further right reaches the column, in 1/65535 of the largest
    /// shift; known before any search.
    const std::uint16_t* clear = nullptr;
    int stride = 0;        ///< Columns from a table to its mirrored table.
    int width = 0;         ///< Columns of the photo.
    float scale = 0;       ///< One unit of the offsets in depth - focus.
    float reachPixels = 0; ///< The largest shift, px.
};

/// One end of a surface.
struct LayeredEnd {
    float column = 0;  ///< First or last column.
    float painted = 0; ///< Painted columns beside it.
    float border =
        0; ///< Extent of its border beyond the column (right: beyond the painted ones), px.
    float strip = 0; ///< Column of the surface's first column in the planes; the last one is next.
};

/// The surfaces of a row for the search: first those of the row, then those of the mirrored row.
struct LayeredSurfaces {
    const LayeredEnd* left = nullptr;
    const LayeredEnd* right = nullptr;
    int begin[3] = {0, 0, 0}; ///< Start of each direction, and the end.
};

/// What is known of the columns of a row before any search. Arrays of one value per column, and
/// kRowPadding more.
struct LayeredColumns {
    std::vector<float> offsets; ///< Movement in px per px of shift.
    /// Change of the offset from column to column. If its lowest bit is set, all content that a
    /// shift brings to the column lies on this line, to 1/64 px.
    std::vector<float> slopes;
    /// Within these shifts (px, from <= 0 <= to), no other surface reaches the column.
    std::vector<float> from;
    std::vector<float> to;
    std::vector<float> first;         ///< First column of its surface.
    std::vector<float> mirroredFirst; ///< The same in the mirrored row.

    std::array<std::vector<float>*, 6> all() {
        return {&offsets, &slopes, &from, &to, &first, &mirroredFirst};
    }
};

/// Describes the columns of a row.
/// @param scratch resized and overwritten
/// @param columns result, resized and overwritten
void layeredColumns(const LayeredTables& tables, std::vector<float>& scratch,
                    LayeredColumns& columns);

/// The requested pixels. Arrays of `count` and padding (kRowPadding).
struct LayeredPixels {
    /// Column in the row, in order (ascending or descending) except for the padding; W - 1 - column
    /// in the mirrored row.
    const float* columns = nullptr;
    const std::int32_t* places = nullptr; ///< The place of each column.
    const float* offsets = nullptr;       ///< LayeredColumns::offsets of each.
    const float* slopes = nullptr;        ///< LayeredColumns::slopes of each.
    const float* from = nullptr;          ///< LayeredColumns::from of each.
    const float* to = nullptr;            ///< LayeredColumns::to of each.
    const float* first = nullptr;         ///< LayeredColumns::first of each.
    const float* mirroredFirst = nullptr; ///< LayeredColumns::mirroredFirst of each.
    int reach = 0;                        ///< Largest distance of a place from its column, columns.
    const std::int32_t* windows = nullptr; ///< RowWindows::starts
    int tables = 2;                        ///< RowWindows::tables
    std::size_t count = 0;
};

/// Buffers of layeredPlaces(): `count` and padding each.
struct LayeredRoom {
    std::int32_t* places = nullptr; ///< Result: places for layeredSamples(), or kSeeEnds.
    std::int32_t* hard = nullptr;   ///< Result: indices of the pixels with kSeeEnds.
    /// Result: for each of `hard`, the column (in its direction) from which the search must
    /// continue to the left.
    std::int32_t* hardColumns = nullptr;
    std::int32_t* mixed = nullptr;  ///< Result: indices of the pixels that a border covers in part.
    std::int32_t* covers = nullptr; ///< Result: for each of `mixed`, the place of its cover,
    std::int32_t* parts = nullptr;  ///< and its share, 1..255 of 256.
    std::int32_t* open = nullptr;   ///< Internal.
    std::int32_t* openColumns = nullptr; ///< Internal.
};

/// Counts returned by layeredPlaces().
struct LayeredCounts {
    std::size_t hard = 0;  ///< Pixels that need LayeredSearch.
    std::size_t mixed = 0; ///< Pixels that a border covers in part.
};

/// Finds the places that pixels show.
///
/// @param tables, surfaces data of the row
/// @param pixels columns with their table entries
/// @param shifts shift of each pixel's view, px
/// @param bounded whether every |shift| is within the one that the bounds were made for
/// @param room results
LayeredCounts layeredPlaces(const LayeredTables& tables, const LayeredSurfaces& surfaces,
                            const LayeredPixels& pixels, const float* shifts, bool bounded,
                            const LayeredRoom& room);

/// Reads one channel between columns, linearly.
///
/// @param pixels as for layeredPlaces()
/// @param plane the channel: row and mirrored row, laid out as the tables, padded
/// @param places from layeredPlaces(), `count` and padding; kSeeEnds gives undefined values
/// @param values result
void layeredSamples(const LayeredPixels& pixels, const std::uint8_t* plane,
                    const std::int32_t* places, std::uint8_t* values);

/// Reads one channel at a place in the same way as layeredSamples().
inline int sampleAt(const std::uint8_t* plane, std::int32_t place) {
    const std::uint8_t* first = plane + (place >> kSubColumnBits);
    const int part = place & ((1 << kSubColumnBits) - 1);
    const int sum = (first[0] << kSubColumnBits) + (first[1] - first[0]) * part;
    return (sum + (1 << (kSubColumnBits - 1))) >> kSubColumnBits;
}

} // namespace altiro3D
