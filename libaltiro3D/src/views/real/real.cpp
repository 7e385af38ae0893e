// Method Real: every photo pixel is projected by its distance (Fehn's DIBR) and spread over the
// pixels it falls between; the nearest wins. Cracks get a median, other holes are inpainted.
//
//     photo   . . . N N N . . .        N near, . far; the camera moves to the right
//     view    N N N x x x . . .        x disocclusion: painted from the far side
//
// Places are whole numbers of 1/256 px, so sums do not depend on their order. Rows are independent.

#include "views/view_methods.hpp"

#include "depth/map/depth_values.hpp"
#include "views/real/real_holes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kOne = 256; // one pixel; also the weight of a whole pixel
constexpr int kCovered =
    kOne / 2; // minimum weight of a covered pixel; less is the fringe of an edge
constexpr int kOutside = std::numeric_limits<int>::min(); // place of a point outside the view
constexpr std::uint32_t kFull = 1U << 23U; // weight at which a sum stops: 255 kFull < 2^31
constexpr double kNearest = 1e30;          // limit of nearness, representable as float
constexpr float kNothing = -1e30F;

// Surfaces closer than this (px of parallax) are blended. 0.5 to 2 px differ by at most 0.05 dB.
constexpr float kSameSurface = 1;

// A weighted sum of colours.
struct Sum {
    std::uint32_t weight = 0;
    std::uint32_t colour[3] = {0, 0, 0};

    void add(const uchar* pixel, int by) {
        if (weight >= kFull) return;
        const auto w = static_cast<std::uint32_t>(by);
        weight += w;
        for (int k = 0; k < 3; ++k)
            colour[k] += w * pixel[k];
    }
};

// Contents of a view pixel. `surface` is the nearest content that falls onto the pixel. `fringe` is
// nearer content that only reaches into the pixel from beside it: an edge, blended by its weight.
struct Cell {
    float nearest = kNothing;
    Sum surface;
    Sum fringe;
    float fringeNearest = kNothing;
};

// The two pixels around a place, and the weight of the second one.
struct Split {
    int first;
    int secondWeight;

    explicit Split(int place)
        : first((place + kOne) / kOne - 1), // floor: places are > -kOne
          secondWeight(place - first * kOne) {}
};

// The place of a coordinate; kOutside if it touches no pixel of 0..size-1.
int placeOf(double coordinate, int size) {
    if (!(coordinate > -1 && coordinate < size)) return kOutside; // also NaN
    const int place = static_cast<int>(std::floor(coordinate * kOne + 0.5));
    return place > -kOne && place < size * kOne ? place : kOutside;
}

void offer(Cell& cell, float nearness) {
    cell.nearest = std::max(cell.nearest, nearness);
}

void collect(Cell& cell, float nearness, const uchar* pixel, int weight) {
    if (nearness < cell.nearest - kSameSurface) return;
    if (nearness <= cell.nearest + kSameSurface) {
        cell.surface.add(pixel, weight);
    } else {
        cell.fringe.add(pixel, weight);
        cell.fringeNearest = std::max(cell.fringeNearest, nearness);
    }
}

// The mean colour of a sum, in 1/16 levels.
std::uint32_t mean16(const Sum& sum, int k) {
    return static_cast<std::uint32_t>((std::uint64_t{16} * sum.colour[k] + sum.weight / 2) /
                                      sum.weight);
}

// Writes the pixel of a cell; false if it is a hole.
bool resolve(const Cell& cell, uchar* pixel, float* nearness) {
    const bool seen = cell.surface.weight > 0;
    const bool fringed = cell.fringe.weight > 0;
    if (!seen && cell.fringe.weight < kCovered) {
        std::fill_n(pixel, 3, uchar{0});
        *nearness = kNothing;
        return false;
    }
    *nearness = seen ? cell.nearest : cell.fringeNearest;
    const std::uint32_t share =
        !seen
            ? kOne
            : std::min<std::uint32_t>(cell.fringe.weight, kOne); // weight of the fringe, in 1/kOne
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t below = seen ? mean16(cell.surface, k) * (kOne - share) : 0;
        const std::uint32_t above = fringed ? mean16(cell.fringe, k) * share : 0;
        pixel[k] = static_cast<uchar>((below + above + 8 * kOne) / (16 * kOne));
    }
    return true;
}

// Buffers for one row.
struct RowScratch {
    std::vector<Cell> cells;
    std::vector<int> places;
    std::vector<double> moves; // px to the left, for the camera on the right
    std::vector<float> nearness;

    explicit RowScratch(int width)
        : cells(static_cast<std::size_t>(width)), places(cells.size()), moves(cells.size()),
          nearness(cells.size()) {}
};

// Work shared by the cameras at +-shiftPixels: movement and nearness of each pixel of a row.
void projectRow(const float* depth, int width, double shiftPixels, double focus,
                RowScratch& scratch) {
    for (int x = 0; x < width; ++x) {
        const auto d = static_cast<double>(depth[x]);
        const auto i = static_cast<std::size_t>(x);
        scratch.moves[i] = shiftPixels * (d - focus);
        scratch.nearness[i] = static_cast<float>(std::min(std::abs(shiftPixels) * d, kNearest));
    }
}

// Projects a row of the photo to rows of view, holes and nearness. Scattered sums limit the speed.
// @param side 1, or -1 for the camera on the other side
void warpRow(const uchar* photo, int width, int side, RowScratch& scratch, uchar* view,
             uchar* holes, float* nearness) {
    Cell* cells = scratch.cells.data();
    int* places = scratch.places.data();
    const double* moves = scratch.moves.data();
    const float* near = scratch.nearness.data();
    std::fill_n(cells, width, Cell());
    for (int x = 0; x < width; ++x) {
        places[x] = placeOf(x - side * moves[x], width);
        if (places[x] == kOutside) continue;
        const Split split(places[x]);
        if (split.first >= 0 && split.secondWeight <= kCovered) offer(cells[split.first], near[x]);
        if (split.first + 1 < width && split.secondWeight >= kCovered) {
            offer(cells[split.first + 1], near[x]);
        }
    }
    for (int x = 0; x < width; ++x) {
        if (places[x] == kOutside) continue;
        const Split split(places[x]);
        if (split.first >= 0) {
            collect(cells[split.first], near[x], photo + 3 * x, kOne - split.secondWeight);
        }
        if (split.secondWeight > 0 && split.first + 1 < width) {
            collect(cells[split.first + 1], near[x], photo + 3 * x, split.secondWeight);
        }
    }
    for (int x = 0; x < width; ++x)
        holes[x] = resolve(cells[x], view + 3 * x, nearness + x) ? uchar{0} : uchar{255};
}

class RealRenderer : public ViewRenderer {
  public:
    RealRenderer(const cv::Mat& photo, const cv::Mat& depth, double focus,
                 const RealOptions& options)
        : photo_(photo), depth_(withinRange(depth)), focus_(focus), options_(options) {}

    void render(double shiftPixels, cv::Mat& view) const override {
        if (shiftPixels == 0) {
            photo_.copyTo(view);
            return;
        }
        Warped warped = room();
        cv::parallel_for_(cv::Range(0, photo_.rows), [&](const cv::Range& rows) {
            RowScratch scratch(photo_.cols);
            for (int y = rows.start; y < rows.end; ++y) {
                projectRow(depth_.ptr<float>(y), photo_.cols, shiftPixels, focus_, scratch);
                warp(y, 1, scratch, warped, view);
            }
        });
        finish(shiftPixels, warped, view);
    }

    void renderPair(double shiftPixels, cv::Mat& view, cv::Mat& opposite) const override {
        Warped warped = room();
        Warped warpedOpposite = room();
        RowScratch scratch(photo_.cols);
        for (int y = 0; y < photo_.rows; ++y) {
            projectRow(depth_.ptr<float>(y), photo_.cols, shiftPixels, focus_, scratch);
            warp(y, 1, scratch, warped, view);
            warp(y, -1, scratch, warpedOpposite, opposite);
        }
        finish(shiftPixels, warped, view);
        finish(-shiftPixels, warpedOpposite, opposite);
    }

  private:
    Warped room() const {
        return {cv::Mat(photo_.size(), CV_8UC1), cv::Mat(photo_.size(), CV_32FC1)};
    }

    void warp(int y, int side, RowScratch& scratch, Warped& warped, cv::Mat& view) const {
        warpRow(photo_.ptr(y), photo_.cols, side, scratch, view.ptr(y), warped.holes.ptr(y),
                warped.nearness.ptr<float>(y));
    }

    void finish(double shiftPixels, Warped& warped, cv::Mat& view) const {
        if (cv::countNonZero(warped.holes) == photo_.rows * photo_.cols) {
            repeatBorders(shiftPixels, view);
        } else {
            fillHoles(view, warped, options_);
        }
    }

    // For views that no pixel falls into: each row takes the colour nearest to the frame.
    void repeatBorders(double shiftPixels, cv::Mat& view) const {
        for (int y = 0; y < photo_.rows; ++y) {
            const float* depth = depth_.ptr<float>(y);
            int best = 0;
            double least = std::numeric_limits<double>::infinity();
            for (int x = 0; x < photo_.cols; ++x) {
                const double place = x - shiftPixels * (static_cast<double>(depth[x]) - focus_);
                const double out = place < 0 ? -place : place - (photo_.cols - 1);
                // distances may be too large to differ: at the left, the rightmost px then counts
                if (out < least || (out == least && place < 0)) {
                    least = out;
                    best = x;
                }
            }
            const uchar* colour = photo_.ptr(y) + 3 * best;
            for (int x = 0; x < photo_.cols; ++x)
                std::copy_n(colour, 3, view.ptr(y) + 3 * x);
        }
    }

    cv::Mat photo_;
    cv::Mat depth_; // 0..1
    double focus_;
    RealOptions options_;
};

} // namespace

std::unique_ptr<ViewRenderer> makeRealRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               double focus, const RealOptions& options) {
    return std::make_unique<RealRenderer>(photo, depth, focus, options);
}

} // namespace altiro3D
