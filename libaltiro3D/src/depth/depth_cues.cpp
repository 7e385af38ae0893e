#include "altiro3D/depth_source.hpp"

#include "altiro3D/error.hpp"
#include "image/downscale.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

// docs/depth.md describes the cues and their accuracy. They are computed serially on a small copy
// of the photo. Only two parts run in parallel: shrinking the photo, which uses integers, and the
// computations for the photo and its mirror image. No sum depends on the number of threads.

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

// Regions are computed at four coarsenesses and their cues averaged. A single coarseness would turn
// its region borders into hard steps.
constexpr std::array<float, 4> kCoarseness{0.3f, 0.6f, 1.2f, 2.4f};

// One number per pixel of the small photo, row by row.
struct Plane {
    int columns = 0;
    int rows = 0;
    std::vector<float> values;

    Plane(int columnCount, int rowCount, float value = 0)
        : columns(columnCount), rows(rowCount),
          values(static_cast<std::size_t>(columnCount) * static_cast<std::size_t>(rowCount),
                 value) {}
    std::size_t size() const { return values.size(); }
    float* row(int y) { return values.data() + static_cast<std::ptrdiff_t>(y) * columns; }
    const float* row(int y) const {
        return values.data() + static_cast<std::ptrdiff_t>(y) * columns;
    }
    float& operator[](std::size_t i) { return values[i]; }
    float operator[](std::size_t i) const { return values[i]; }
};

using Colour = std::array<Plane, 3>; // B, G, R, 0..1

Colour planesOf(const cv::Mat& picture) {
    const Plane empty(picture.cols, picture.rows);
    Colour colour{empty, empty, empty};
    for (int y = 0; y < picture.rows; ++y) {
        const uchar* pixel = picture.ptr<uchar>(y);
        for (int x = 0; x < picture.cols; ++x, pixel += 3)
            for (std::size_t c = 0; c < 3; ++c)
                colour[c].row(y)[x] = static_cast<float>(pixel[c]) / 255.0f;
    }
    return colour;
}

// Mean over the window of (2 * radius + 1)^2 px, clipped to the plane. Running sums in double lose
// far less over a row than a float's last bit.
Plane boxMean(const Plane& in, int radius) {
    const int columns = in.columns;
    const int rows = in.rows;
    Plane out(columns, rows);
    std::vector<double> sums(static_cast<std::size_t>(columns), 0.0);
    std::vector<double> prefix(static_cast<std::size_t>(columns) + 1, 0.0);
    const auto addRow = [&](int y, double sign) {
        const float* row = in.row(y);
        for (std::size_t x = 0; x < sums.size(); ++x)
            sums[x] += sign * static_cast<double>(row[x]);
    };
    for (int y = 0; y < std::min(radius, rows); ++y)
        addRow(y, 1);
    for (int y = 0; y < rows; ++y) {
        if (y + radius < rows) addRow(y + radius, 1);
        if (y - radius - 1 >= 0) addRow(y - radius - 1, -1);
        const int height = std::min(rows - 1, y + radius) - std::max(0, y - radius) + 1;
        for (std::size_t x = 0; x < sums.size(); ++x)
            prefix[x + 1] = prefix[x] + sums[x];
        float* row = out.row(y);
        for (int x = 0; x < columns; ++x) {
            const int left = std::max(0, x - radius);
            const int right = std::min(columns - 1, x + radius) + 1;
            row[x] = static_cast<float>(
                (prefix[static_cast<std::size_t>(right)] - prefix[static_cast<std::size_t>(left)]) /
                (static_cast<double>(right - left) * height));
        }
    }
    return out;
}

Plane product(const Plane& a, const Plane& b) {
    Plane out = a;
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] *= b[i];
    return out;
}

float colourDistance(const Colour& colour, std::size_t a, std::size_t b) {
    float sum = 0;
    for (const Plane& plane : colour) {
        const float difference = plane[a] - plane[b];
        sum += difference * difference;
    }
    return std::sqrt(sum);
}

// The photo divided into regions of similar colour.
struct Regions {
    int count = 0;
    std::vector<int> index; // per px, 0..count-1
};

// Finds regions by merging neighbours in order of their colour difference, as long as the
// difference is not larger than the largest difference inside each side plus coarseness / size (the
// criterion of Felzenszwalb and Huttenlocher 2004).
class RegionFinder {
  public:
    explicit RegionFinder(const Colour& colour) {
        // Counting sort of the differences, quantized to 65536 steps.
        constexpr std::size_t kSteps = 65536;
        const int rows = colour[0].rows;
        const int columns = colour[0].columns;
        std::vector<Edge> edges;
        edges.reserve(colour[0].size() * 2);
        std::vector<std::size_t> begin(kSteps + 1, 0);
        const float stepsPerUnit = static_cast<float>(kSteps - 1) / std::sqrt(3.0f);
        const auto add = [&](std::size_t a, std::size_t b) {
            const auto step = static_cast<std::uint32_t>(
                std::min(colourDistance(colour, a, b) * stepsPerUnit + 0.5f,
                         static_cast<float>(kSteps - 1)));
            edges.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), step});
            ++begin[step + 1];
        };
        for (int y = 0; y < rows; ++y) {
            for (int x = 0; x < columns; ++x) {
                const std::size_t i =
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                    static_cast<std::size_t>(x);
                if (x + 1 < columns) add(i, i + 1);
                if (y + 1 < rows) add(i, i + static_cast<std::size_t>(columns));
            }
        }
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        sorted_.resize(edges.size());
        for (const Edge& edge : edges)
            sorted_[begin[edge.step]++] = edge;
        pixelCount_ = colour[0].size();
        unitsPerStep_ = 1.0f / stepsPerUnit;
    }

    Regions find(float coarseness) const {
        std::vector<std::uint32_t> parent(pixelCount_);
        std::iota(parent.begin(), parent.end(), 0U);
        std::vector<std::uint32_t> size(pixelCount_, 1U);
        std::vector<float> limit(pixelCount_, coarseness);
        const auto root = [&](std::uint32_t i) {
            while (parent[i] != i) {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            return i;
        };
        const auto merge = [&](std::uint32_t a, std::uint32_t b) {
            if (size[a] < size[b]) std::swap(a, b);
            parent[b] = a;
            size[a] += size[b];
            return a;
        };
        for (const Edge& edge : sorted_) {
            const std::uint32_t a = root(edge.a);
            const std::uint32_t b = root(edge.b);
            const float difference = static_cast<float>(edge.step) * unitsPerStep_;
            if (a == b || difference > limit[a] || difference > limit[b]) continue;
            const std::uint32_t merged = merge(a, b);
            limit[merged] = difference + coarseness / static_cast<float>(size[merged]);
        }
        // Smaller regions are remains of texture.
        const std::size_t smallest = pixelCount_ / 300;
        for (const Edge& edge : sorted_) {
            const std::uint32_t a = root(edge.a);
            const std::uint32_t b = root(edge.b);
            if (a != b && (size[a] < smallest || size[b] < smallest)) merge(a, b);
        }
        Regions regions;
        regions.index.resize(pixelCount_);
        std::vector<int> number(pixelCount_, -1);
        for (std::size_t i = 0; i < pixelCount_; ++i) {
            int& region = number[root(static_cast<std::uint32_t>(i))];
            if (region < 0) region = regions.count++;
            regions.index[i] = region;
        }
        return regions;
    }

  private:
    struct Edge {
        std::uint32_t a;
        std::uint32_t b;
        std::uint32_t step;
    };
    std::size_t pixelCount_ = 0;
    float unitsPerStep_ = 0;
    std::vector<Edge> sorted_;
};

// Adds the mean of the cue over a region to each of its pixels.
void addRegionMean(const Regions& regions, const Plane& cue, float weight, Plane& sum) {
    std::vector<double> total(static_cast<std::size_t>(regions.count), 0.0);
    std::vector<double> count(total.size(), 0.0);
    for (std::size_t i = 0; i < cue.size(); ++i) {
        const auto region = static_cast<std::size_t>(regions.index[i]);
        total[region] += static_cast<double>(cue[i]);
        count[region] += 1;
    }
    for (std::size_t r = 0; r < total.size(); ++r)
        total[r] /= count[r];
    for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] += weight * static_cast<float>(total[static_cast<std::size_t>(regions.index[i])]);
}

// Adds the height at which a region stands on the ground to each of its pixels.
//
//   a thing that stands:      a backdrop:
//     | |                     =============   as wide as the photo, or up to its top edge:
//     | |                      mean height    it has no foot to be seen
//   --+-+--  <- its foot      =============
void addContact(const Regions& regions, float weight, Plane& sum) {
    struct Shape {
        int size = 0;
        double heights = 0;
        int left = 0;
        int right = 0;
        bool touchesTop = false;
        int counted = 0;
        double foot = 0;
    };
    std::vector<Shape> shapes(static_cast<std::size_t>(regions.count));
    const auto height = [&](int y) { return (y + 0.5) / sum.rows; };
    const auto shapeAt = [&](int y, int x) -> Shape& {
        const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(sum.columns) +
                              static_cast<std::size_t>(x);
        return shapes[static_cast<std::size_t>(regions.index[i])];
    };
    for (int y = 0; y < sum.rows; ++y) {
        for (int x = 0; x < sum.columns; ++x) {
            Shape& shape = shapeAt(y, x);
            if (shape.size == 0) shape.left = shape.right = x;
            shape.left = std::min(shape.left, x);
            shape.right = std::max(shape.right, x);
            shape.touchesTop = shape.touchesTop || y == 0;
            shape.heights += height(y);
            ++shape.size;
        }
    }
    // The foot is the upper end of the lowest twentieth, so a few pixels that leak downwards do not
    // matter.
    for (int y = sum.rows - 1; y >= 0; --y) {
        for (int x = 0; x < sum.columns; ++x) {
            Shape& shape = shapeAt(y, x);
            if (++shape.counted == shape.size / 20 + 1) shape.foot = height(y);
        }
    }
    std::vector<float> value(shapes.size());
    for (std::size_t r = 0; r < shapes.size(); ++r) {
        const Shape& shape = shapes[r];
        const double mean = shape.heights / shape.size;
        const double width = static_cast<double>(shape.right - shape.left + 1) / sum.columns;
        const double stands = (1 - width) * (shape.touchesTop ? 0.25 : 1.0);
        value[r] = static_cast<float>(mean + stands * (shape.foot - mean));
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] += weight * value[static_cast<std::size_t>(regions.index[i])];
}

// The mean height of all pixels of similar colour: the colour of the photo's ground is near, that
// of its sky or wall is far. A table of 12^3 colours, smoothed and interpolated.
Plane colourHeightCue(const Colour& colour) {
    constexpr std::size_t kSide = 12;
    constexpr std::size_t kCells = kSide * kSide * kSide;
    constexpr std::array<std::size_t, 3> kStride{1, kSide, kSide * kSide};
    const int rows = colour[0].rows;
    const int columns = colour[0].columns;
    const std::size_t pixelCount = colour[0].size();
    std::vector<double> heights(kCells, 0.0);
    std::vector<double> counts(kCells, 0.0);
    for (std::size_t i = 0; i < pixelCount; ++i) {
        std::size_t cell = 0;
        for (std::size_t c = 0; c < 3; ++c)
            cell += kStride[c] *
                    static_cast<std::size_t>(colour[c][i] * static_cast<float>(kSide - 1) + 0.5f);
        const auto y = static_cast<int>(i / static_cast<std::size_t>(columns));
        heights[cell] += (y + 0.5) / rows;
        counts[cell] += 1;
    }
    for (std::vector<double>* table : {&heights, &counts}) {
        for (const std::size_t stride : kStride) {
            const std::vector<double> before = *table;
            for (std::size_t cell = 0; cell < kCells; ++cell) {
                const std::size_t place = cell / stride % kSide;
                (*table)[cell] = 0.5 * before[cell] +
                                 0.25 * (place > 0 ? before[cell - stride] : 0.0) +
                                 0.25 * (place + 1 < kSide ? before[cell + stride] : 0.0);
            }
        }
    }
    // A rare colour is not informative; it is drawn to the middle.
    const double doubt = 0.002 * static_cast<double>(pixelCount);
    Plane cue(columns, rows);
    for (std::size_t i = 0; i < pixelCount; ++i) {
        std::size_t base = 0;
        std::array<double, 3> fraction{};
        for (std::size_t c = 0; c < 3; ++c) {
            const double position = static_cast<double>(colour[c][i]) * (kSide - 1);
            const std::size_t cell = std::min(kSide - 2, static_cast<std::size_t>(position));
            fraction[c] = position - static_cast<double>(cell);
            base += kStride[c] * cell;
        }
        double height = 0.5 * doubt;
        double count = doubt;
        for (std::size_t corner = 0; corner < 8; ++corner) {
            double weight = 1;
            std::size_t cell = base;
            for (std::size_t c = 0; c < 3; ++c) {
                const bool upper = (corner >> c & 1U) != 0;
                weight *= upper ? fraction[c] : 1 - fraction[c];
                if (upper) cell += kStride[c];
            }
            height += weight * heights[cell];
            count += weight * counts[cell];
        }
        cue[i] = static_cast<float>(height / count);
    }
    return cue;
}

// Guided filter (He, Sun, Tang 2010) with the colours as guide: in each window the depth is a
// linear function of the colour, so its steps move to the photo's edges and flat parts stay flat.
Plane followEdges(const Plane& depth, const Colour& guide) {
    constexpr int kRadius = 8;
    constexpr float kFlatVariance = 0.003f; // windows with less variance are smoothed
    const Plane meanDepth = boxMean(depth, kRadius);
    const Plane empty(depth.columns, depth.rows);
    Colour mean{empty, empty, empty};
    Colour slope{empty, empty, empty}; // initially the covariance with the depth
    for (std::size_t c = 0; c < 3; ++c) {
        mean[c] = boxMean(guide[c], kRadius);
        slope[c] = boxMean(product(guide[c], depth), kRadius);
        for (std::size_t i = 0; i < depth.size(); ++i)
            slope[c][i] -= mean[c][i] * meanDepth[i];
    }
    constexpr std::array<std::pair<std::size_t, std::size_t>, 6> kPairs{
        {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
    std::array<Plane, 6> covariance{empty, empty, empty, empty, empty, empty};
    for (std::size_t p = 0; p < 6; ++p) {
        const auto [a, b] = kPairs[p];
        covariance[p] = boxMean(product(guide[a], guide[b]), kRadius);
        for (std::size_t i = 0; i < depth.size(); ++i)
            covariance[p][i] -= mean[a][i] * mean[b][i];
    }
    Plane offset = meanDepth;
    for (std::size_t i = 0; i < depth.size(); ++i) {
        // Cramer's rule in double; the matrix is positive definite thanks to kFlatVariance.
        const double bb = static_cast<double>(covariance[0][i] + kFlatVariance);
        const double gg = static_cast<double>(covariance[1][i] + kFlatVariance);
        const double rr = static_cast<double>(covariance[2][i] + kFlatVariance);
        const double bg = static_cast<double>(covariance[3][i]);
        const double br = static_cast<double>(covariance[4][i]);
        const double gr = static_cast<double>(covariance[5][i]);
        const double b = static_cast<double>(slope[0][i]);
        const double g = static_cast<double>(slope[1][i]);
        const double r = static_cast<double>(slope[2][i]);
        const double minorBB = gg * rr - gr * gr;
        const double minorBG = br * gr - bg * rr;
        const double minorBR = bg * gr - br * gg;
        const double minorGG = bb * rr - br * br;
        const double minorGR = bg * br - bb * gr;
        const double minorRR = bb * gg - bg * bg;
        const double determinant = bb * minorBB + bg * minorBG + br * minorBR;
        slope[0][i] = static_cast<float>((minorBB * b + minorBG * g + minorBR * r) / determinant);
        slope[1][i] = static_cast<float>((minorBG * b + minorGG * g + minorGR * r) / determinant);
        slope[2][i] = static_cast<float>((minorBR * b + minorGR * g + minorRR * r) / determinant);
        for (std::size_t c = 0; c < 3; ++c)
            offset[i] -= slope[c][i] * mean[c][i];
    }
    Plane out = boxMean(offset, kRadius);
    for (std::size_t c = 0; c < 3; ++c) {
        const Plane meanSlope = boxMean(slope[c], kRadius);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] += meanSlope[i] * guide[c][i];
    }
    return out;
}

// The weighted sum of all cues, smoothed; any range.
Plane combineCues(const cv::Mat& small) {
    // The median removes fine texture and keeps edges; on 8 bits it is exact.
    cv::Mat calmPicture;
    cv::medianBlur(small, calmPicture, 5);
    const Colour calm = planesOf(calmPicture);

    const Plane empty(small.cols, small.rows);
    Plane contact = empty;
    Plane colourHeight = empty;
    {
        const Plane colourHeightOfPixel = colourHeightCue(calm);
        // A slight blur gives uniform surfaces differences below one grey level, so 8-bit steps in
        // shading do not divide them.
        const RegionFinder finder(
            Colour{boxMean(calm[0], 1), boxMean(calm[1], 1), boxMean(calm[2], 1)});
        constexpr float kShare = 1.0f / static_cast<float>(kCoarseness.size());
        for (const float coarseness : kCoarseness) {
            const Regions regions = finder.find(coarseness);
            addContact(regions, kShare, contact);
            addRegionMean(regions, colourHeightOfPixel, kShare, colourHeight);
        }
    }
    Plane sum = empty;
    for (int y = 0; y < sum.rows; ++y) {
        const float height = (static_cast<float>(y) + 0.5f) / static_cast<float>(sum.rows);
        for (int x = 0; x < sum.columns; ++x) {
            const std::size_t i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(sum.columns) +
                static_cast<std::size_t>(x);
            const float aside =
                (2 * static_cast<float>(x) + 1) / static_cast<float>(sum.columns) - 1;
            sum[i] = kHeightWeight * height + kContactWeight * contact[i] +
                     kColourHeightWeight * colourHeight[i] +
                     kSideWeight * aside * aside * (1 - height);
        }
    }
    return followEdges(sum, calm);
}

} // namespace

void estimateDepthFromCues(const cv::Mat& photo, cv::Mat& depth) {
    if (photo.empty())
        throw Error(ErrorCode::InvalidArgument, "photo", "is empty, expected a picture");
    if (photo.type() != CV_8UC3)
        throw Error(ErrorCode::InvalidArgument, "photo",
                    "is " + cv::typeToString(photo.type()) + ", expected CV_8UC3 (BGR)");

    const cv::Mat small = downscale(photo, kLongSide);
    cv::Mat mirrored;
    cv::flip(small, mirrored, 1);
    // Where differences are equal, merging regions prefers one direction. The mean of the depths of
    // the photo and its mirror image has no preferred direction and half the noise at region
    // borders.
    std::array<Plane, 2> sides{Plane(0, 0), Plane(0, 0)};
    cv::parallel_for_(cv::Range(0, 2), [&](const cv::Range& range) {
        for (int side = range.start; side < range.end; ++side)
            sides[static_cast<std::size_t>(side)] = combineCues(side == 0 ? small : mirrored);
    });
    Plane& sum = sides[0];
    for (int y = 0; y < sum.rows; ++y)
        for (int x = 0; x < sum.columns; ++x)
            sum.row(y)[x] += sides[1].row(y)[sum.columns - 1 - x];

    // Clips half a percent at either end.
    std::vector<float> values = sum.values;
    const auto cut = static_cast<std::ptrdiff_t>(values.size() / 200);
    std::nth_element(values.begin(), values.begin() + cut, values.end());
    const float farthest = values[static_cast<std::size_t>(cut)];
    std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
    const float range = *(values.end() - 1 - cut) - farthest;
    depth.create(small.size(), CV_32FC1);
    for (int y = 0; y < sum.rows; ++y) {
        float* out = depth.ptr<float>(y);
        for (int x = 0; x < sum.columns; ++x)
            out[x] =
                range > 1e-4f ? std::clamp((sum.row(y)[x] - farthest) / range, 0.0f, 1.0f) : 0.5f;
    }
}

} // namespace altiro3D
