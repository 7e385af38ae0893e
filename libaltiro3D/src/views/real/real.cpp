// Method Real: every pixel of the photo is projected by its distance (Fehn's DIBR) and spread over
// the pixels that it falls between; the nearest wins. Cracks get a median, other holes are
// inpainted.
//
//     photo   . . . N N N . . .        N near, . far; the camera moves to the right
//     view    N N N x x x . . .        x disocclusion: painted from the far side
//
// Places are whole numbers of 1/256 px, so sums do not depend on their order. The cameras are side
// by side, so each row is on its own.

#include "views/view_methods.hpp"

#include "views/real/real_cells.hpp"
#include "views/real/real_holes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

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

// Projects one row of the photo and writes one row of view, holes and nearness. The scattered sums
// limit the speed.
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
        : photo_(photo), focus_(focus), options_(options) {
        depth_.create(depth.size(), CV_32FC1);
        for (int y = 0; y < depth.rows; ++y) {
            const float* from = depth.ptr<float>(y);
            float* to = depth_.ptr<float>(y);
            for (int x = 0; x < depth.cols; ++x) // NaN compares false: 0
                to[x] = from[x] > 0 ? (from[x] < 1 ? from[x] : 1) : 0;
        }
    }

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

    // For views that no pixel falls into: each row takes the colour of the pixel nearest to the
    // frame.
    void repeatBorders(double shiftPixels, cv::Mat& view) const {
        for (int y = 0; y < photo_.rows; ++y) {
            const float* depth = depth_.ptr<float>(y);
            int best = 0;
            double least = std::numeric_limits<double>::infinity();
            for (int x = 0; x < photo_.cols; ++x) {
                const double place = x - shiftPixels * (static_cast<double>(depth[x]) - focus_);
                const double out = place < 0 ? -place : place - (photo_.cols - 1);
                // for distances too large to differ, the last pixel to leave is on the right
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
