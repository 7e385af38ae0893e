#pragma once

#include "base/pixel_rows.hpp"

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
// Otherwise x is at or behind the end of a surface (layered_ends.hpp).
//
// For s < 0, tables of the mirrored row are used. Both are in one array, side by side.
//
// Most pixels need no search, because the depth around them follows a line (LayeredLines).

constexpr int kOffsetBits = 14;                          ///< Bits of an offset, a whole number.
constexpr int kMaxOffset = (1 << (kOffsetBits - 1)) - 1; ///< Offsets are -8191..8191.
constexpr int kEndReach = 2;      ///< Limit of the extent of a surface's border, px.
constexpr int kTablePadding = 8;  ///< Columns left and right of each table.
constexpr int kSubColumnBits = 8; ///< Positions between columns are multiples of 1/256.

// A place: 256 * column + 1/256 px. Columns are those of a plane, which holds the row, from
// `stride` on the mirrored row, and from 2 * stride on the strips painted beside surfaces
// (LayeredRow::strips).
constexpr std::int32_t kSeeEnds = INT32_MIN; ///< Place of a pixel that needs a search.
constexpr std::size_t kBlockPixels = 32;     ///< Pixels that are searched if one of them needs it.

/// Packs an offset with a flag: the column is the last of its surface.
constexpr int kLastFlag = 1;
constexpr std::int16_t columnWord(int offset, bool last) {
    return static_cast<std::int16_t>(offset * 4 + (last ? kLastFlag : 0));
}
constexpr int wordOffset(std::int16_t word) {
    return word >> 2;
}

// Sources: layered_scene.cpp (tables), layered_lines.cpp (columns, lines), layered_guesses.cpp.

/// Tables of one row. Each holds the row with kTablePadding entries on both sides and then,
/// `stride` entries further, the same for the mirrored row. Pointers are to column 0.
struct LayeredTables {
    const std::int16_t* words = nullptr; ///< columnWord() of each column.
    /// Index of the last surface that begins here or to the left.
    const std::int16_t* surfaces = nullptr;
    /// The shift up to which no surface further right reaches the column, in 1/65535 of the largest
    /// shift; known before any search.
    const std::uint16_t* freeUpTo = nullptr;
    /// LayeredScene::shares of the row, not mirrored; null if all borders are hard.
    const std::uint8_t* shares = nullptr;
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
    /// Left: column of the surface's first column in the planes, beside what is painted there.
    /// Right: the column before that of its last one.
    float strip = 0;
};

constexpr float kNeverPasses = 1e30F; ///< LayeredEndOffsets::passing without such a surface.

/// Offsets of the first and the last column of a surface, in 2^-18 units of the tables.
struct LayeredEndOffsets {
    float first = 0;
    float last = 0;
    /// Movement, px per such unit, from which on the end of a surface further left lies right of
    /// this surface's end: a thin thing has passed what it hid.
    float passing = kNeverPasses;
};

/// The surfaces of a row for the search: first those of the row, then those of the mirrored row.
struct LayeredSurfaces {
    const LayeredEnd* left = nullptr;
    const LayeredEnd* right = nullptr;
    const LayeredEndOffsets* offsets = nullptr;
    int begin[3] = {0, 0, 0}; ///< Start of each direction, and the end.
};

/// The requested pixels, in blocks of kBlockPixels. Arrays of `count` or one per block, and
/// padding (kRowPadding).
struct LayeredPixels {
    /// Column in the row, in order (ascending or descending) except for the padding; W - 1 - column
    /// in the mirrored row.
    const float* columns = nullptr;
    const float* offsets = nullptr;       ///< LayeredColumns::offsets of each.
    const float* slopes = nullptr;        ///< LayeredColumns::slopes of each.
    const float* from = nullptr;          ///< LayeredColumns::from of each.
    const float* to = nullptr;            ///< LayeredColumns::to of each.
    const float* first = nullptr;         ///< LayeredColumns::first of each.
    const float* mirroredFirst = nullptr; ///< LayeredColumns::mirroredFirst of each.
    std::size_t count = 0;
};

/// Pixels that must be searched: the first `size` entries.
struct LayeredList {
    explicit LayeredList(std::size_t entries)
        : pixels(entries), columns(entries), shifts(entries) {}

    std::vector<std::int32_t> pixels; ///< Index in LayeredRoom::places.
    std::vector<float> columns;       ///< LayeredPixels::columns of it.
    std::vector<float> shifts;        ///< Shift of its view, px.
    std::size_t size = 0;
};

/// Results for some pixels.
struct LayeredRoom {
    /// @param count pixels
    explicit LayeredRoom(std::size_t count)
        : places(paddedRow<std::int32_t>(count)), openBlocks(count / kBlockPixels + 1),
          shifts(places.size()), open{LayeredList(places.size()), LayeredList(places.size())},
          hard(places.size()), hardColumns(places), mixed(places), covers(places), parts(places) {}

    std::vector<std::int32_t> places;     ///< Places, or kSeeEnds.
    std::vector<std::uint8_t> openBlocks; ///< For each block, 1 if it must be searched.
    std::vector<float> shifts;            ///< Shift of each pixel's view in open blocks, px.
    LayeredList open[2];                  ///< Pixels without a place, per direction.
    LayeredList hard;                     ///< Those that need LayeredSearch.
    /// For each of `hard`, the column (in its direction) from which the search goes on to the left.
    std::vector<std::int32_t> hardColumns;
    std::vector<std::int32_t> mixed;  ///< Indices of the pixels that a border covers in part,
    std::vector<std::int32_t> covers; ///< for each of them, the place of its cover,
    std::vector<std::int32_t> parts;  ///< and its share, 1..255 of 256.
    std::size_t mixedCount = 0;
};

// Most pixels need no search: no other surface comes near them, and the offsets around their column
// follow a line, offset(c) = o + m (c - x). They show c = x + s o / (1 - s m), which is computed in
// 16-bit whole numbers.

constexpr int kMaxLineMovement = 32; ///< px; content that moves farther is searched for.

/// What lines need, for each column or for each pixel.
template <class T>
struct LayeredLines {
    std::vector<T> offsets; ///< Movement at the largest shift without the slope, 1/512 px.
    std::vector<T> slopes;  ///< Its change from column to column, 1/32768 px.
    /// Both count outwards, unlike LayeredColumns::from, which is negative: within shifts of
    /// -from..to, in 1/32768 of the largest one, the line holds and no other
    /// surface reaches the column; both are -1 if the column follows no line.
    std::vector<T> from;
    std::vector<T> to;

    std::array<std::vector<T>*, 4> all() { return {&offsets, &slopes, &from, &to}; }
};

/// Facts about columns, known before any search: one value per column, and kRowPadding more.
struct LayeredColumns {
    std::vector<float> offsets; ///< Movement in px per px of shift.
    std::vector<float> slopes;  ///< Change of the offset from column to column.
    /// Within these shifts (px, from <= 0 <= to), no other surface reaches the column.
    std::vector<float> from;
    std::vector<float> to;
    std::vector<float> first;         ///< First column of its surface.
    std::vector<float> mirroredFirst; ///< The same in the mirrored row.
    LayeredLines<std::int32_t> lines;

    std::array<std::vector<float>*, 6> all() {
        return {&offsets, &slopes, &from, &to, &first, &mirroredFirst};
    }
};

/// Describes the columns of a row.
/// @param scratch resized and overwritten
/// @param columns result, resized and overwritten
void layeredColumns(const LayeredTables& tables, std::vector<float>& scratch,
                    LayeredColumns& columns);

constexpr double kWholeReach = 16384; ///< The largest shift in whole steps.

/// Pixels of a row for layeredLines(). All arrays are padded (kRowPadding).
struct LayeredLinePixels {
    const std::int16_t* offsets = nullptr; ///< LayeredLines of each pixel, as the next three.
    const std::int16_t* slopes = nullptr;
    const std::int16_t* from = nullptr;    ///< Not negative, in the padding as well.
    const std::int16_t* to = nullptr;      ///< The same.
    const std::int32_t* columns = nullptr; ///< Places of their columns.
    const std::int16_t* shifts = nullptr;  ///< In steps of kWholeReach, within the largest shift.
    float reachPixels = 0;                 ///< Largest shift, px.
    std::size_t count = 0;
};

/// Finds the pixels whose place a line gives.
/// @param room result: places, open blocks and the shifts of their pixels
/// @return whether any block is open
bool layeredLines(const LayeredLinePixels& pixels, LayeredRoom& room);

/// Finds places of the pixels of open blocks and lists the pixels whose places it does not find.
/// @param tables data of the row
/// @param pixels columns with their table entries
void layeredGuesses(const LayeredTables& tables, const LayeredPixels& pixels, LayeredRoom& room);

/// Finds the places of listed pixels, surface by surface. Only for rows whose surfaces keep the
/// order of their columns in all views, and for shifts within the reach. Fast with few surfaces.
/// @param tables, surfaces data of the row
/// @param reach LayeredScene::reachColumns
/// @param direction index in LayeredRoom::open
void layeredAmongSurfaces(const LayeredTables& tables, const LayeredSurfaces& surfaces, int reach,
                          int direction, LayeredRoom& room);

/// Reads one channel between columns, linearly.
/// @param plane the channel: row and mirrored row, laid out as the tables, padded
/// @param places of `count` pixels, and padding; kSeeEnds gives undefined values
/// @param values result
void layeredSamples(const std::uint8_t* plane, const std::int32_t* places, std::size_t count,
                    std::uint8_t* values);

/// Reads one channel at a place in the same way as layeredSamples().
inline int sampleAt(const std::uint8_t* plane, std::int32_t place) {
    const std::uint8_t* first = plane + (place >> kSubColumnBits);
    const int part = place & ((1 << kSubColumnBits) - 1);
    const int sum = (first[0] << kSubColumnBits) + (first[1] - first[0]) * part;
    return (sum + (1 << (kSubColumnBits - 1))) >> kSubColumnBits;
}

} // namespace altiro3D
