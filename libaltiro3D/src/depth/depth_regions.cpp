#include "depth/depth_regions.hpp"

#include "depth/depth_cues_row.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <utility>

// All regions are found from one list of pieces, for these reasons. A region's limit is the largest
// difference inside it plus coarseness / size.
//
// - A difference that exceeds the limit of a region exceeds it for ever, because differences
//   ascend: the region is closed. Equal differences merge all regions that are open and connected
//   by them, in any order. So the merges by limit are the same for both scans.
// - What the least coarseness merges, the others merge as well, because their limits are larger. At
//   the first difference that does not merge, both sides become pieces. They are left alone from
//   then on, and so is each region at its first neighbour that is a piece. Differences between
//   pieces, in their order, are all that the coarsenesses treat differently.

namespace altiro3D {

namespace {

// Neighbours: px / 2 and the px to its right (even) or below it (odd).
using Place = std::uint32_t;

struct Edge {
    Place place;
    std::uint32_t step; // colour difference
};

// An edge between pieces, or between px while they are found.
struct Border {
    std::uint32_t a;
    std::uint32_t b;
    Edge edge;
};

// A region or a part of one. Data other than `parent` is valid at roots.
struct Node {
    std::uint32_t parent;
    std::uint32_t size; // px
    float largest;      // difference inside, in units of the range of a channel
    float limit;        // of merging with others
};

constexpr float kUnitsPerStep = 1 / (kColourStepsPerLevel * 255);
constexpr float kClosed = -1; // a limit that no difference keeps

class Forest {
  public:
    explicit Forest(std::size_t count) : nodes_(count) {
        for (std::size_t i = 0; i < count; ++i)
            nodes_[i].parent = static_cast<std::uint32_t>(i);
    }
    std::size_t size() const { return nodes_.size(); }
    Node& operator[](std::uint32_t i) { return nodes_[i]; }
    bool areSurelyJoined(std::uint32_t a, std::uint32_t b) const {
        return nodes_[a].parent == nodes_[b].parent;
    }
    std::uint32_t root(std::uint32_t i) {
        while (nodes_[i].parent != i) {
            nodes_[i].parent = nodes_[nodes_[i].parent].parent;
            i = nodes_[i].parent;
        }
        return i;
    }
    // @param a @param b different roots
    Node& join(std::uint32_t a, std::uint32_t b) {
        if (nodes_[a].size < nodes_[b].size) std::swap(a, b);
        nodes_[b].parent = a;
        nodes_[a].size += nodes_[b].size;
        return nodes_[a];
    }
    // Joins if the difference keeps the limits of both sides.
    // @param a @param b different roots
    bool joinWithin(std::uint32_t a, std::uint32_t b, float difference, float coarseness) {
        if (difference > nodes_[a].limit || difference > nodes_[b].limit) return false;
        Node& joined = join(a, b);
        joined.largest = difference;
        joined.limit = limitOf(joined, coarseness);
        return true;
    }
    static float limitOf(const Node& node, float coarseness) {
        return node.largest + coarseness / static_cast<float>(node.size);
    }
    // Numbers the roots in the order of their first node.
    // @return number of each node's root
    std::vector<std::uint32_t> numbers(std::size_t& count) {
        constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
        std::vector<std::uint32_t> ofRoot(nodes_.size(), kNone);
        std::vector<std::uint32_t> result(nodes_.size());
        count = 0;
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            std::uint32_t& number = ofRoot[root(static_cast<std::uint32_t>(i))];
            if (number == kNone) number = static_cast<std::uint32_t>(count++);
            result[i] = number;
        }
        return result;
    }

  private:
    std::vector<Node> nodes_;
};

// All edges, in the order of their differences, equal ones in the order of their places.
std::vector<Edge> sortedEdges(const Colours& colours) {
    const std::size_t columns = colours[0].columns();
    const std::size_t rows = colours[0].rows();
    const PaddedPlane<std::uint16_t> empty(columns, rows);
    std::array<PaddedPlane<std::uint16_t>, 2> steps{empty, empty}; // to the right, downwards
    std::vector<std::uint32_t> begin(kColourSteps + 1, 0);
    const auto from = [&](std::size_t x, std::size_t y) {
        return RowOf3<float>{colours[0].row(y) + x, colours[1].row(y) + x, colours[2].row(y) + x};
    };
    const auto measure = [&](std::size_t y, const RowOf3<float>& neighbours, std::size_t count,
                             std::uint16_t* result) {
        colourSteps(from(0, y), neighbours, count, result);
        for (std::size_t x = 0; x < count; ++x)
            ++begin[result[x] + std::size_t{1}];
    };
    for (std::size_t y = 0; y < rows; ++y) {
        measure(y, from(1, y), columns - 1, steps[0].row(y));
        if (y + 1 < rows) measure(y, from(0, y + 1), columns, steps[1].row(y));
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Edge> sorted(begin.back());
    Place place = 0;
    for (std::size_t y = 0; y < rows; ++y) {
        const std::uint16_t* right = steps[0].row(y);
        const std::uint16_t* down = steps[1].row(y);
        for (std::size_t x = 0; x < columns; ++x, place += 2) {
            if (x + 1 < columns) sorted[begin[right[x]]++] = {place, right[x]};
            if (y + 1 < rows) sorted[begin[down[x]]++] = {place + 1, down[x]};
        }
    }
    return sorted;
}

float differenceOf(const Edge& edge) {
    return static_cast<float>(edge.step) * kUnitsPerStep;
}

// What all coarsenesses have in common.
struct Pieces {
    Forest forest{0};            // not joined
    std::vector<Border> borders; // in order
};

// Merges px into pieces.
Pieces findPieces(const std::vector<Edge>& sorted, std::size_t columns, std::size_t pixels,
                  float coarseness, PictureRegions& regions) {
    Forest forest(pixels);
    for (std::uint32_t i = 0; i < pixels; ++i) {
        forest[i].size = 1;
        forest[i].largest = 0;
        forest[i].limit = coarseness;
    }
    Pieces pieces;
    for (const Edge& edge : sorted) {
        std::uint32_t a = edge.place / 2;
        std::uint32_t b = a + static_cast<std::uint32_t>((edge.place & 1U) == 0 ? 1 : columns);
        if (forest.areSurelyJoined(a, b)) continue;
        a = forest.root(a);
        b = forest.root(b);
        if (a == b || forest.joinWithin(a, b, differenceOf(edge), coarseness)) continue;
        forest[a].limit = forest[b].limit = kClosed;
        pieces.borders.push_back({a, b, edge});
    }
    regions.pieceOf = forest.numbers(regions.pieces);
    pieces.forest = Forest(regions.pieces);
    for (std::uint32_t i = 0; i < pixels; ++i)
        if (forest[i].parent == i) {
            Node& piece = pieces.forest[regions.pieceOf[i]];
            piece.size = forest[i].size;
            piece.largest = forest[i].largest;
        }
    for (Border& border : pieces.borders) {
        border.a = regions.pieceOf[border.a];
        border.b = regions.pieceOf[border.b];
    }
    return pieces;
}

// The place in the order of the scan from the right.
Place fromRight(Place place, std::size_t columns) {
    const auto perRow = static_cast<Place>(2 * columns);
    const Place inRow = place % perRow;
    const Place isDown = inRow & 1U;
    // the edge to the left of a px comes just before the one below it
    const Place column = inRow / 2 + 1 - isDown;
    return place - inRow + 2 * (static_cast<Place>(columns) - 1 - column) + isDown;
}

// Joins small regions with others.
// @param borders between regions of which one is small, in order
PictureRegions::Division joinSmall(Forest forest, const std::vector<Border>& borders,
                                   std::size_t smallest) {
    for (const Border& border : borders) {
        const std::uint32_t a = forest.root(border.a);
        const std::uint32_t b = forest.root(border.b);
        if (a != b && (forest[a].size < smallest || forest[b].size < smallest)) forest.join(a, b);
    }
    PictureRegions::Division division;
    division.regionOf = forest.numbers(division.regions);
    return division;
}

// Joins pieces to the regions of one coarseness.
std::array<PictureRegions::Division, 2> divide(const Pieces& pieces, float coarseness,
                                               std::size_t columns, std::size_t pixels) {
    Forest forest = pieces.forest;
    for (std::uint32_t i = 0; i < forest.size(); ++i)
        forest[i].limit = Forest::limitOf(forest[i], coarseness);
    std::vector<Border> borders;
    for (const Border& border : pieces.borders) {
        if (forest.areSurelyJoined(border.a, border.b)) continue;
        const std::uint32_t a = forest.root(border.a);
        const std::uint32_t b = forest.root(border.b);
        if (a != b && !forest.joinWithin(a, b, differenceOf(border.edge), coarseness))
            borders.push_back(border);
    }
    // Smaller regions are remains of texture.
    const std::size_t smallest = pixels / 300;
    const auto areFinal = [&](const Border& border) {
        const std::uint32_t a = forest.root(border.a);
        const std::uint32_t b = forest.root(border.b);
        return a == b || (forest[a].size >= smallest && forest[b].size >= smallest);
    };
    borders.erase(std::remove_if(borders.begin(), borders.end(), areFinal), borders.end());
    std::array<PictureRegions::Division, 2> divisions;
    divisions[static_cast<std::size_t>(Scan::FromLeft)] = joinSmall(forest, borders, smallest);
    std::sort(borders.begin(), borders.end(), [&](const Border& a, const Border& b) {
        if (a.edge.step != b.edge.step) return a.edge.step < b.edge.step;
        return fromRight(a.edge.place, columns) < fromRight(b.edge.place, columns);
    });
    divisions[static_cast<std::size_t>(Scan::FromRight)] = joinSmall(forest, borders, smallest);
    return divisions;
}

} // namespace

PictureRegions findRegions(const Colours& colours, const std::vector<float>& coarseness) {
    PictureRegions regions;
    const std::size_t columns = colours[0].columns();
    const std::size_t pixels = columns * colours[0].rows();
    const Pieces pieces =
        findPieces(sortedEdges(colours), columns, pixels, coarseness.front(), regions);
    regions.divisions.resize(coarseness.size());
    cv::parallel_for_(
        cv::Range(0, static_cast<int>(coarseness.size())), [&](const cv::Range& range) {
            for (int i = range.start; i < range.end; ++i) {
                const auto at = static_cast<std::size_t>(i);
                regions.divisions[at] = divide(pieces, coarseness[at], columns, pixels);
            }
        });
    return regions;
}

} // namespace altiro3D
