#include "altiro3D/depth_source.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "depth/depth_cues_row.hpp"
#include "depth/depth_guide.hpp"
#include "depth/depth_regions.hpp"
#include "depth/padded_plane.hpp"
#include "image/downscale.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

// docs/lab/depth.md describes the cues, docs/depth.md their accuracy. They are computed on a small
// copy of the photo. All sums over pixels are exact, because their terms are integers or multiples
// of kGrid. So they depend neither on the number of threads nor on the direction, and a mirrored
// photo has the mirrored depth.

namespace altiro3D {

namespace {

// Size of the small copy, px: objects are still whole, most texture is gone.
constexpr int kLongSide = 320;

// Weights of the cues, in units of the height cue (0 at the top of the photo, 1 at its bottom).
// They were tuned on the scenes of docs/lab/depth.md; halving or doubling any one of them changes
// the mean by 0.01 or less.
constexpr float kHeightWeight = 1.0f;
constexpr float kContactWeight = 3.0f;
constexpr float kColourHeightWeight = 0.9f;
constexpr float kSideWeight = 0.2f;

// Regions are computed at three coarsenesses and their cues averaged. A single coarseness would
// turn its region borders into hard steps. Two find fewer edges, four are not more accurate.
constexpr std::array<float, 3> kCoarseness{0.3f, 0.85f, 2.4f};

using Plane = PaddedPlane<float>;

// Rounds to a multiple of kGrid; |value| < 2^25.
float onGrid(double value) {
    return static_cast<float>((value + kToGrid) - kToGrid);
}

Guide planesOf(const cv::Mat& picture) {
    const PaddedPlane<std::uint8_t> empty(static_cast<std::size_t>(picture.cols),
                                          static_cast<std::size_t>(picture.rows));
    Guide planes{empty, empty, empty};
    for (std::size_t y = 0; y < empty.rows(); ++y)
        splitRow(picture.ptr<std::uint8_t>(static_cast<int>(y)), empty.columns(), planes[0].row(y),
                 planes[1].row(y), planes[2].row(y));
    return planes;
}

// The mean colours of 3 x 3 px, of those that exist.
Colours meanColours(const Guide& planes) {
    const std::size_t columns = planes[0].columns();
    const std::size_t rows = planes[0].rows();
    const Plane empty(columns, rows);
    Colours colours{empty, empty, empty};
    std::vector<std::uint16_t> sums(columns + 2); // over columns, and 0 beside them
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t y = 0; y < rows; ++y) {
            std::copy_n(planes[c].row(y), columns, sums.begin() + 1);
            float height = 1;
            for (const std::size_t other : {y - 1, y + 1}) {
                if (other >= rows) continue; // also the one before 0
                const std::uint8_t* row = planes[c].row(other);
                for (std::size_t x = 0; x < columns; ++x)
                    sums[x + 1] = static_cast<std::uint16_t>(sums[x + 1] + row[x]);
                ++height;
            }
            float* mean = colours[c].row(y);
            for (std::size_t x = 0; x < columns; ++x)
                mean[x] = static_cast<float>(sums[x] + sums[x + 1] + sums[x + 2]) / (3 * height);
            const float least = columns > 1 ? 2 : 1; // columns at the border
            for (const std::size_t x : {std::size_t{0}, columns - 1})
                mean[x] =
                    static_cast<float>(sums[x] + sums[x + 1] + sums[x + 2]) / (least * height);
        }
    }
    return colours;
}

// Neighbouring px of a row that belong to the same piece.
struct Run {
    std::uint32_t piece;
    std::uint32_t length;
};

// What the cues need to know of a region, or of a piece of one.
struct Shape {
    std::size_t size = 0;      // px
    std::uint64_t heights = 0; // in units of 1 / (2 rows)
    std::size_t left = SIZE_MAX;
    std::size_t right = 0;
    bool touchesTop = false;
    double cue = 0; // sum of the cue of colours, exact

    void add(const Shape& other) {
        size += other.size;
        heights += other.heights;
        left = std::min(left, other.left);
        right = std::max(right, other.right);
        touchesTop = touchesTop || other.touchesTop;
        cue += other.cue;
    }
};

// The two cues that need regions.
struct RegionCues {
    float contact = 0;
    float colourHeight = 0;
};

class CuesOfRegions {
  public:
    // @param cue of colours, multiples of kGrid
    CuesOfRegions(const PictureRegions& regions, const Plane& cue)
        : regions_(regions), columns_(cue.columns()), rows_(cue.rows()), shapes_(regions.pieces),
          rowEnds_(rows_) {
        const std::uint32_t* pieceOf = regions.pieceOf.data();
        for (std::size_t y = 0; y < rows_; ++y, pieceOf += columns_) {
            const float* cueRow = cue.row(y);
            for (std::size_t x = 0; x < columns_;) {
                const std::size_t begin = x;
                const std::uint32_t piece = pieceOf[x];
                double sum = 0;
                for (; x < columns_ && pieceOf[x] == piece; ++x)
                    sum += static_cast<double>(cueRow[x]);
                const std::size_t length = x - begin;
                shapes_[piece].add({length, (2 * y + 1) * length, begin, x - 1, y == 0, sum});
                runs_.push_back({piece, static_cast<std::uint32_t>(length)});
            }
            rowEnds_[y] = runs_.size();
        }
    }

    // The mean of both scans, and of all coarsenesses, for each piece.
    std::vector<RegionCues> means() const {
        const float share = 1.0f / static_cast<float>(regions_.divisions.size());
        std::array<std::vector<RegionCues>, 2> scans;
        for (std::size_t scan = 0; scan < scans.size(); ++scan) {
            scans[scan].resize(shapes_.size());
            for (const auto& divisions : regions_.divisions) {
                const auto& division = divisions[scan];
                const std::vector<RegionCues> cues = cuesOf(division);
                for (std::size_t i = 0; i < shapes_.size(); ++i) {
                    const RegionCues& found = cues[division.regionOf[i]];
                    scans[scan][i].contact += share * found.contact;
                    scans[scan][i].colourHeight += share * found.colourHeight;
                }
            }
        }
        std::vector<RegionCues> means(shapes_.size());
        for (std::size_t i = 0; i < means.size(); ++i) {
            means[i].contact = 0.5f * (scans[0][i].contact + scans[1][i].contact);
            means[i].colourHeight = 0.5f * (scans[0][i].colourHeight + scans[1][i].colourHeight);
        }
        return means;
    }

  private:
    // Contact is the height at which a region stands on the ground:
    //
    //   a thing that stands:      a backdrop:
    //     | |                     =============   as wide as the photo, or up to its top edge:
    //     | |                      mean height    it has no foot to be seen
    //   --+-+--  <- its foot      =============
    std::vector<RegionCues> cuesOf(const PictureRegions::Division& division) const {
        std::vector<Shape> shapes(division.regions);
        for (std::size_t i = 0; i < shapes_.size(); ++i)
            shapes[division.regionOf[i]].add(shapes_[i]);
        const std::vector<double> feet = feetOf(division, shapes);
        std::vector<RegionCues> cues(shapes.size());
        for (std::size_t i = 0; i < shapes.size(); ++i) {
            const Shape& shape = shapes[i];
            const auto size = static_cast<double>(shape.size);
            const double mean =
                static_cast<double>(shape.heights) / (2 * static_cast<double>(rows_) * size);
            const double width =
                static_cast<double>(shape.right - shape.left + 1) / static_cast<double>(columns_);
            const double stands = (1 - width) * (shape.touchesTop ? 0.25 : 1.0);
            cues[i].contact = static_cast<float>(mean + stands * (feet[i] - mean));
            cues[i].colourHeight = static_cast<float>(shape.cue / size);
        }
        return cues;
    }

    // The foot is the upper end of the lowest twentieth, so a few pixels that leak downwards do not
    // matter.
    std::vector<double> feetOf(const PictureRegions::Division& division,
                               const std::vector<Shape>& shapes) const {
        std::vector<double> feet(shapes.size());
        std::vector<std::size_t> missing(shapes.size()); // px up to the foot
        for (std::size_t i = 0; i < shapes.size(); ++i)
            missing[i] = shapes[i].size / 20 + 1;
        std::size_t unknown = shapes.size();
        for (std::size_t y = rows_; y-- > 0 && unknown > 0;) {
            for (std::size_t i = y > 0 ? rowEnds_[y - 1] : 0; i < rowEnds_[y]; ++i) {
                const std::uint32_t region = division.regionOf[runs_[i].piece];
                if (missing[region] == 0) continue;
                if (missing[region] > runs_[i].length) {
                    missing[region] -= runs_[i].length;
                    continue;
                }
                missing[region] = 0;
                feet[region] = (static_cast<double>(y) + 0.5) / static_cast<double>(rows_);
                --unknown;
            }
        }
        return feet;
    }

    const PictureRegions& regions_;
    std::size_t columns_;
    std::size_t rows_;
    std::vector<Shape> shapes_; // of pieces
    std::vector<Run> runs_;
    std::vector<std::size_t> rowEnds_; // of the runs
};

// The mean height of all pixels of similar colour: the colour of the photo's ground is near, that
// of its sky or wall is far. A table of 12^3 colours, smoothed and interpolated. The cue is a
// multiple of kGrid.
Plane colourHeightCue(const Guide& planes) {
    constexpr std::size_t kSide = 12;
    constexpr std::size_t kCells = kSide * kSide * kSide;
    constexpr std::array<std::size_t, 3> kStride{1, kSide, kSide * kSide};
    constexpr double kCellsPerLevel = (kSide - 1) / 255.0;
    const std::size_t columns = planes[0].columns();
    const std::size_t rows = planes[0].rows();
    struct Place {
        std::size_t nearest = 0;
        std::size_t cell = 0; // of two, the lower one
        double upper = 0;     // weight of the upper one
    };
    std::array<Place, 256> places;
    for (std::size_t level = 0; level < places.size(); ++level) {
        const double position = static_cast<double>(level) * kCellsPerLevel;
        Place& place = places[level];
        place.nearest = static_cast<std::size_t>(position + 0.5);
        place.cell = std::min(kSide - 2, static_cast<std::size_t>(position));
        place.upper = position - static_cast<double>(place.cell);
    }
    using Pair = std::array<double, 2>; // sum of heights, in units of 1 / (2 rows), and count
    std::vector<Pair> table(kCells, Pair{});
    for (std::size_t y = 0; y < rows; ++y) {
        for (std::size_t x = 0; x < columns; ++x) {
            std::size_t cell = 0;
            for (std::size_t c = 0; c < 3; ++c)
                cell += kStride[c] * places[planes[c].row(y)[x]].nearest;
            table[cell][0] += static_cast<double>(2 * y + 1);
            table[cell][1] += 1;
        }
    }
    for (const std::size_t stride : kStride) {
        const std::vector<Pair> before = table;
        for (std::size_t cell = 0; cell < kCells; ++cell) {
            const std::size_t place = cell / stride % kSide;
            for (std::size_t i = 0; i < 2; ++i)
                table[cell][i] = 0.5 * before[cell][i] +
                                 0.25 * (place > 0 ? before[cell - stride][i] : 0.0) +
                                 0.25 * (place + 1 < kSide ? before[cell + stride][i] : 0.0);
        }
    }
    // A rare colour is not informative; it is drawn to the middle.
    const double doubt = 0.002 * static_cast<double>(columns * rows);
    const double twiceRows = 2 * static_cast<double>(rows);
    Plane cue(columns, rows);
    for (std::size_t y = 0; y < rows; ++y) {
        float* out = cue.row(y);
        for (std::size_t x = 0; x < columns; ++x) {
            const Place& b = places[planes[0].row(y)[x]];
            const Place& g = places[planes[1].row(y)[x]];
            const Place& r = places[planes[2].row(y)[x]];
            const Pair* base = &table[b.cell + kStride[1] * g.cell + kStride[2] * r.cell];
            Pair total{static_cast<double>(rows) * doubt, doubt};
            for (const std::size_t upperR : {0U, 1U}) {
                for (const std::size_t upperG : {0U, 1U}) {
                    for (const std::size_t upperB : {0U, 1U}) {
                        const double weight = (upperB != 0 ? b.upper : 1 - b.upper) *
                                              (upperG != 0 ? g.upper : 1 - g.upper) *
                                              (upperR != 0 ? r.upper : 1 - r.upper);
                        const Pair& corner =
                            base[upperB + kStride[1] * upperG + kStride[2] * upperR];
                        total[0] += weight * corner[0];
                        total[1] += weight * corner[1];
                    }
                }
            }
            out[x] = onGrid(total[0] / (twiceRows * total[1]));
        }
    }
    return cue;
}

// The weighted sum of all cues, smoothed; any range.
Plane combineCues(const cv::Mat& small) {
    // The median removes fine texture and keeps edges; on 8 bits it is exact.
    cv::Mat calm;
    cv::medianBlur(small, calm, 5);
    const Guide planes = planesOf(calm);
    const Plane colourHeight = colourHeightCue(planes);
    // A slight blur gives uniform surfaces differences below one grey level, so 8-bit steps in
    // shading do not divide them. Where differences are equal, merging regions prefers the
    // direction of the scan. The mean of both directions has no preferred one and half the noise at
    // region borders.
    const PictureRegions regions =
        findRegions(meanColours(planes), {kCoarseness.begin(), kCoarseness.end()});
    const std::vector<RegionCues> cues = CuesOfRegions(regions, colourHeight).means();
    Plane sum(colourHeight.columns(), colourHeight.rows());
    const auto columns = static_cast<int>(sum.columns());
    const std::uint32_t* piece = regions.pieceOf.data();
    for (std::size_t y = 0; y < sum.rows(); ++y) {
        const float height = (static_cast<float>(y) + 0.5f) / static_cast<float>(sum.rows());
        float* row = sum.row(y);
        for (int x = 0; x < columns; ++x, ++piece) {
            const float aside =
                static_cast<float>(2 * x + 1 - columns) / static_cast<float>(columns);
            row[x] = onGrid(kHeightWeight * height + kContactWeight * cues[*piece].contact +
                            kColourHeightWeight * cues[*piece].colourHeight +
                            kSideWeight * aside * aside * (1 - height));
        }
    }
    followEdges(planes, sum);
    return sum;
}

} // namespace

void estimateDepthFromCues(const cv::Mat& photo, cv::Mat& depth) {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    const cv::Mat small = downscale(photo, kLongSide);
    const Plane sum = combineCues(small);

    // Clips half a percent at either end.
    std::vector<float> values;
    values.reserve(small.total());
    for (std::size_t y = 0; y < sum.rows(); ++y)
        values.insert(values.end(), sum.row(y), sum.row(y) + sum.columns());
    const auto cut = static_cast<std::ptrdiff_t>(values.size() / 200);
    std::nth_element(values.begin(), values.begin() + cut, values.end());
    const float farthest = values[static_cast<std::size_t>(cut)];
    std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
    const float range = *(values.end() - 1 - cut) - farthest;
    depth.create(small.size(), CV_32FC1);
    for (std::size_t y = 0; y < sum.rows(); ++y) {
        const float* row = sum.row(y);
        auto* out = depth.ptr<float>(static_cast<int>(y));
        for (std::size_t x = 0; x < sum.columns(); ++x)
            out[x] = range > 1e-4f ? std::clamp((row[x] - farthest) / range, 0.0f, 1.0f) : 0.5f;
    }
}

} // namespace altiro3D
