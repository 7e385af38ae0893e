#pragma once

#include <cstdint>
#include <vector>

namespace altiro3D {

// One row of the scene as method Layered sees it: surfaces made of nodes.
//
//   photo row       0 1 2 3 | 4 5 6 7 | 8 9 ...        | = tear: a step of the depth
//   depth           . . . . | ####### | . . .          (4..7 stand in front)
//   surfaces        0 1 2 3 |   4 5 6 7 |   h h h h 8 9 ...
//                                           ^^^^^^^ hidden nodes, behind 4..7
//
// Nodes of a surface lie one px apart in the photo. A surface is followed leftwards behind what
// hides it, because a camera that moves to the right (shift > 0) looks behind the right borders of
// near things; for the other direction there are tables of the mirrored picture.

constexpr int kSubNodeBits = 8; ///< Places between two nodes are counted in 1/256.
constexpr std::int32_t kNothing = INT32_MIN;

/// A stretch of consecutive nodes of one surface, drawn from left to right.
struct LayeredSpan {
    std::int32_t first = 0; ///< Index of its first node.
    std::int32_t count = 0; ///< Nodes, >= 1.
    std::int32_t x = 0;     ///< Column of the first node in the photo (may lie outside of it).
    bool leftEnd = false;   ///< The surface ends here: its border covers part of a pixel.
    bool rightEnd = false;  ///< As leftEnd.
    float leftExtra = 0;    ///< How far it reaches beyond its first node's pixel, px, 0..1.
    float rightExtra = 0;   ///< As leftExtra, beyond its last node's pixel.
};

/// Tables of one row; the arrays belong to the renderer.
struct LayeredRow {
    const float* offset = nullptr;        ///< Per node: depth - focus.
    const std::uint8_t* colour = nullptr; ///< Per node: B G R and one unused byte.
    const LayeredSpan* spans = nullptr;   ///< In painter's order: what hides comes later.
    int spanCount = 0;
};

/// A pixel at the border of a surface: `top` covers `coverage` / 256 of it, `under` the rest. Both
/// are codes as in LayeredTrace::code.
struct LayeredBorder {
    std::int32_t top = 0;
    std::int32_t under = 0;
    std::int32_t coverage = 0;
};

/// What each pixel of a row of a view shows. Reused from row to row, so that nothing is allocated.
struct LayeredTrace {
    std::vector<std::int32_t> code; ///< Per column: >= 0: place between nodes, in 1/256;
                                    ///< < 0: border number -1 - code.
    std::vector<LayeredBorder> borders;
};

// Reads the offsets of all nodes of a row, writes a code for each of `width` columns: what the view
// shifted by shiftPixels >= 0 shows there. Bound by one division per node.
void traceRow(const LayeredRow& row, double shiftPixels, int width, LayeredTrace& trace);

// Reads four neighbouring nodes (eight at a border), writes B G R of one pixel of a traced row.
// Bound by the twelve multiplications of the cubic.
void samplePixel(const LayeredRow& row, const LayeredTrace& trace, int x, std::uint8_t* bgr);

// samplePixel() for all columns.
void sampleRow(const LayeredRow& row, const LayeredTrace& trace, int width, std::uint8_t* bgr);

} // namespace altiro3D
