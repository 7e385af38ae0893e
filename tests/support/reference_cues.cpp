// The built-in estimator of depth, step by step: each division into regions for itself, px by px.

#include "support/reference.hpp"

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

namespace altiro3D::test {

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

// 2^-26: sums of its multiples are exact in double up to 2^27.
constexpr double kGrid = 1.0 / (1 << 26);

// Rounds to a multiple of kGrid; |value| < 2^25.
float onGrid(double value) {
    constexpr double kShift = 1.5 * (1LL << 52) * kGrid; // the value of its last bit is kGrid
    return static_cast<float>((value + kShift) - kShift);
}

cv::Mat matOf(Plane& plane) {
    return {plane.rows, plane.columns, CV_32FC1, plane.values.data()};
}

// Windows of (2 * radius + 1)^2 px, clipped to the picture.
class Windows {
  public:
    Windows(cv::Size size, int radius)
        : side_(2 * radius + 1, 2 * radius + 1), width_(static_cast<std::size_t>(size.width)),
          height_(static_cast<std::size_t>(size.height)) {
        const auto fill = [radius](std::vector<double>& lengths) {
            const int count = static_cast<int>(lengths.size());
            for (int i = 0; i < count; ++i)
                lengths[static_cast<std::size_t>(i)] =
                    std::min(i + radius, count - 1) - std::max(i - radius, 0) + 1;
        };
        fill(width_);
        fill(height_);
    }
    // Pixels in the window at a place.
    double count(std::size_t x, std::size_t y) const { return width_[x] * height_[y]; }
    // Sums over the windows, exact.
    // @param values 8U or 16U; or CV_32FC1, multiples of kGrid
    // @return CV_32S, or CV_64F of CV_32F
    cv::Mat sums(const cv::Mat& values) const {
        cv::Mat result;
        cv::boxFilter(values, result, values.depth() == CV_32F ? CV_64F : CV_32S, side_, {-1, -1},
                      false, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
        return result;
    }

  private:
    cv::Size side_;
    std::vector<double> width_;
    std::vector<double> height_;
};

using Colour = std::array<Plane, 3>; // B, G, R, 0..255

// The mean colours of the windows.
Colour meanColours(const cv::Mat& picture, int radius) {
    const Windows windows(picture.size(), radius);
    const cv::Mat sums = windows.sums(picture);
    const Plane empty(picture.cols, picture.rows);
    Colour colour{empty, empty, empty};
    for (int y = 0; y < picture.rows; ++y) {
        const auto* sum = sums.ptr<int>(y);
        for (int x = 0; x < picture.cols; ++x, sum += 3) {
            const double count =
                windows.count(static_cast<std::size_t>(x), static_cast<std::size_t>(y));
            for (std::size_t c = 0; c < 3; ++c)
                colour[c].row(y)[x] = static_cast<float>(sum[c] / count);
        }
    }
    return colour;
}

// The photo divided into regions of similar colour.
struct Regions {
    int count = 0;
    std::vector<int> index; // per px, 0..count-1
};

enum class Scan { FromLeft, FromRight };

// Finds regions by merging neighbours in order of their colour difference, as long as the
// difference is not larger than the largest difference inside each side plus coarseness / size (the
// criterion of Felzenszwalb and Huttenlocher 2004). Equal differences are taken in the order in
// which the rows are scanned.
class RegionFinder {
  public:
    RegionFinder(const Colour& colour, Scan scan) : pixelCount_(colour[0].size()) {
        constexpr std::size_t kSteps = 65536;
        constexpr double kLargest = 255 * 1.7320508075688772; // black to white
        const int rows = colour[0].rows;
        const int columns = colour[0].columns;
        const auto stepsPerLevel = static_cast<float>((kSteps - 1) / kLargest);
        const auto add = [&](std::size_t a, std::size_t b) {
            float sum = 0;
            for (const Plane& plane : colour) {
                const float difference = plane[a] - plane[b];
                sum += difference * difference;
            }
            const auto step = static_cast<std::uint32_t>(
                std::min(std::sqrt(sum) * stepsPerLevel + 0.5f, static_cast<float>(kSteps - 1)));
            sorted_.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), step});
        };
        const int first = scan == Scan::FromLeft ? 0 : columns - 1;
        const int forward = scan == Scan::FromLeft ? 1 : -1;
        for (int y = 0; y < rows; ++y) {
            for (int i = 0; i < columns; ++i) {
                const auto place = static_cast<std::ptrdiff_t>(y) * columns + first + i * forward;
                const auto at = static_cast<std::size_t>(place);
                if (i + 1 < columns) add(at, static_cast<std::size_t>(place + forward));
                if (y + 1 < rows) add(at, static_cast<std::size_t>(place + columns));
            }
        }
        std::stable_sort(sorted_.begin(), sorted_.end(),
                         [](const Edge& a, const Edge& b) { return a.step < b.step; });
        unitsPerStep_ = 1 / (stepsPerLevel * 255);
    }

    // @param coarseness in units of the range of a channel
    Regions find(float coarseness) const {
        struct Region {
            std::uint32_t size = 1;
            float limit = 0;
        };
        std::vector<Region> found(pixelCount_, {1, coarseness}); // valid at roots
        std::vector<std::uint32_t> parent(pixelCount_);
        std::iota(parent.begin(), parent.end(), 0U);
        const auto root = [&](std::uint32_t i) {
            while (parent[i] != i)
                i = parent[i];
            return i;
        };
        const auto merge = [&](std::uint32_t a, std::uint32_t b) {
            if (found[a].size < found[b].size) std::swap(a, b);
            parent[b] = a;
            found[a].size += found[b].size;
            return a;
        };
        std::vector<Edge> borders; // between regions when they were looked at
        for (const Edge& edge : sorted_) {
            const std::uint32_t a = root(edge.a);
            const std::uint32_t b = root(edge.b);
            if (a == b) continue;
            const float difference = static_cast<float>(edge.step) * unitsPerStep_;
            if (difference > found[a].limit || difference > found[b].limit) {
                borders.push_back(edge);
                continue;
            }
            Region& merged = found[merge(a, b)];
            merged.limit = difference + coarseness / static_cast<float>(merged.size);
        }
        // Smaller regions are remains of texture.
        const std::size_t smallest = pixelCount_ / 300;
        for (const Edge& edge : borders) {
            const std::uint32_t a = root(edge.a);
            const std::uint32_t b = root(edge.b);
            if (a != b && (found[a].size < smallest || found[b].size < smallest)) merge(a, b);
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
// @param cue multiples of kGrid
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
        std::int64_t heights = 0; // in units of 1 / (2 rows)
        int left = 0;
        int right = 0;
        bool touchesTop = false;
        int counted = 0;
        double foot = 0;
    };
    std::vector<Shape> shapes(static_cast<std::size_t>(regions.count));
    const double rows = sum.rows;
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
            shape.heights += 2 * y + 1;
            ++shape.size;
        }
    }
    // The foot is the upper end of the lowest twentieth, so a few pixels that leak downwards do not
    // matter.
    for (int y = sum.rows - 1; y >= 0; --y) {
        for (int x = 0; x < sum.columns; ++x) {
            Shape& shape = shapeAt(y, x);
            if (++shape.counted == shape.size / 20 + 1) shape.foot = (y + 0.5) / rows;
        }
    }
    std::vector<float> value(shapes.size());
    for (std::size_t r = 0; r < shapes.size(); ++r) {
        const Shape& shape = shapes[r];
        const double mean = static_cast<double>(shape.heights) / (2 * rows * shape.size);
        const double width = static_cast<double>(shape.right - shape.left + 1) / sum.columns;
        const double stands = (1 - width) * (shape.touchesTop ? 0.25 : 1.0);
        value[r] = static_cast<float>(mean + stands * (shape.foot - mean));
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] += weight * value[static_cast<std::size_t>(regions.index[i])];
}

// The mean height of all pixels of similar colour: the colour of the photo's ground is near, that
// of its sky or wall is far. A table of 12^3 colours, smoothed and interpolated. The cue is a
// multiple of kGrid.
Plane colourHeightCue(const cv::Mat& picture) {
    constexpr std::size_t kSide = 12;
    constexpr std::size_t kCells = kSide * kSide * kSide;
    constexpr std::array<std::size_t, 3> kStride{1, kSide, kSide * kSide};
    constexpr double kCellsPerLevel = (kSide - 1) / 255.0;
    const int rows = picture.rows;
    std::vector<double> heights(kCells, 0.0); // in units of 1 / (2 rows)
    std::vector<double> counts(kCells, 0.0);
    for (int y = 0; y < rows; ++y) {
        const uchar* pixel = picture.ptr<uchar>(y);
        for (int x = 0; x < picture.cols; ++x, pixel += 3) {
            std::size_t cell = 0;
            for (std::size_t c = 0; c < 3; ++c)
                cell += kStride[c] * static_cast<std::size_t>(pixel[c] * kCellsPerLevel + 0.5);
            heights[cell] += 2 * y + 1;
            counts[cell] += 1;
        }
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
    const double doubt = 0.002 * static_cast<double>(picture.total());
    Plane cue(picture.cols, rows);
    for (int y = 0; y < rows; ++y) {
        const uchar* pixel = picture.ptr<uchar>(y);
        for (int x = 0; x < picture.cols; ++x, pixel += 3) {
            std::size_t base = 0;
            std::array<double, 3> fraction{};
            for (std::size_t c = 0; c < 3; ++c) {
                const double position = pixel[c] * kCellsPerLevel;
                const std::size_t cell = std::min(kSide - 2, static_cast<std::size_t>(position));
                fraction[c] = position - static_cast<double>(cell);
                base += kStride[c] * cell;
            }
            double height = rows * doubt;
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
            cue.row(y)[x] = onGrid(height / (2.0 * rows * count));
        }
    }
    return cue;
}

// Guided filter (He, Sun, Tang 2010) with the colours as guide: in each window the depth is a
// linear function of the colour, so its steps move to the photo's edges and flat parts stay flat.
// @param depth multiples of kGrid
// @param guide CV_8UC3
Plane followEdges(Plane depth, const cv::Mat& guide) {
    constexpr int kRadius = 8;
    constexpr double kFlatVariance = 0.003 * 255 * 255; // windows with less variance are smoothed
    const Windows windows(guide.size(), kRadius);
    std::array<cv::Mat, 3> channel;
    cv::split(guide, channel.data());
    std::array<cv::Mat, 3> sum;       // of a channel
    std::array<cv::Mat, 3> withDepth; // of a channel times the depth
    for (std::size_t c = 0; c < 3; ++c) {
        sum[c] = windows.sums(channel[c]);
        cv::Mat product;
        cv::multiply(channel[c], matOf(depth), product, 1, CV_32F);
        withDepth[c] = windows.sums(product);
    }
    constexpr std::array<std::pair<std::size_t, std::size_t>, 6> kPairs{
        {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
    std::array<cv::Mat, 6> squares;
    for (std::size_t p = 0; p < 6; ++p) {
        cv::Mat product;
        cv::multiply(channel[kPairs[p].first], channel[kPairs[p].second], product, 1, CV_16U);
        squares[p] = windows.sums(product);
    }
    const cv::Mat depthSum = windows.sums(matOf(depth));
    const Plane empty(depth.columns, depth.rows);
    Colour slope{empty, empty, empty};
    Plane offset = empty;
    for (int y = 0; y < depth.rows; ++y) {
        for (int x = 0; x < depth.columns; ++x) {
            const double share =
                1 / windows.count(static_cast<std::size_t>(x), static_cast<std::size_t>(y));
            const double mean = share * depthSum.at<double>(y, x);
            std::array<double, 3> colour{};
            std::array<double, 3> covariance{}; // with the depth
            for (std::size_t c = 0; c < 3; ++c) {
                colour[c] = share * sum[c].at<int>(y, x);
                covariance[c] = share * withDepth[c].at<double>(y, x) - colour[c] * mean;
            }
            std::array<double, 6> m{}; // of the colours
            for (std::size_t p = 0; p < 6; ++p) {
                const auto [a, b] = kPairs[p];
                m[p] = share * squares[p].at<int>(y, x) - colour[a] * colour[b] +
                       (p < 3 ? kFlatVariance : 0.0);
            }
            // Cramer's rule; the matrix is positive definite thanks to kFlatVariance.
            const auto [bb, gg, rr, bg, br, gr] = m;
            const double minorBB = gg * rr - gr * gr;
            const double minorBG = br * gr - bg * rr;
            const double minorBR = bg * gr - br * gg;
            const double minorGG = bb * rr - br * br;
            const double minorGR = bg * br - bb * gr;
            const double minorRR = bb * gg - bg * bg;
            const double scale = 1 / (bb * minorBB + bg * minorBG + br * minorBR);
            const auto [b, g, r] = covariance;
            const std::array<double, 3> slopes{(minorBB * b + minorBG * g + minorBR * r) * scale,
                                               (minorBG * b + minorGG * g + minorGR * r) * scale,
                                               (minorBR * b + minorGR * g + minorRR * r) * scale};
            double rest = mean;
            for (std::size_t c = 0; c < 3; ++c) {
                slope[c].row(y)[x] = onGrid(slopes[c]);
                rest -= slopes[c] * colour[c];
            }
            offset.row(y)[x] = onGrid(rest);
        }
    }
    const cv::Mat offsets = windows.sums(matOf(offset));
    for (std::size_t c = 0; c < 3; ++c)
        withDepth[c] = windows.sums(matOf(slope[c]));
    for (int y = 0; y < depth.rows; ++y) {
        const uchar* pixel = guide.ptr<uchar>(y);
        for (int x = 0; x < depth.columns; ++x, pixel += 3) {
            double total = offsets.at<double>(y, x);
            for (std::size_t c = 0; c < 3; ++c)
                total += withDepth[c].at<double>(y, x) * pixel[c];
            depth.row(y)[x] = static_cast<float>(
                total / windows.count(static_cast<std::size_t>(x), static_cast<std::size_t>(y)));
        }
    }
    return depth;
}

// The two cues that need regions, averaged over all coarsenesses.
struct RegionCues {
    Plane contact;
    Plane colourHeight;
};

RegionCues regionCues(const Colour& colour, const Plane& colourHeight, Scan scan) {
    const Plane empty(colourHeight.columns, colourHeight.rows);
    RegionCues cues{empty, empty};
    const RegionFinder finder(colour, scan);
    constexpr float kShare = 1.0f / static_cast<float>(kCoarseness.size());
    for (const float coarseness : kCoarseness) {
        const Regions regions = finder.find(coarseness);
        addContact(regions, kShare, cues.contact);
        addRegionMean(regions, colourHeight, kShare, cues.colourHeight);
    }
    return cues;
}

// The weighted sum of all cues, smoothed; any range.
Plane combineCues(const cv::Mat& small) {
    // The median removes fine texture and keeps edges; on 8 bits it is exact.
    cv::Mat calm;
    cv::medianBlur(small, calm, 5);
    const Plane colourHeight = colourHeightCue(calm);
    // A slight blur gives uniform surfaces differences below one grey level, so 8-bit steps in
    // shading do not divide them.
    const Colour blurred = meanColours(calm, 1);
    // Where differences are equal, merging regions prefers the direction of the scan. The mean of
    // both directions has no preferred one and half the noise at region borders.
    const RegionCues none{Plane(0, 0), Plane(0, 0)};
    std::array<RegionCues, 2> scans{none, none};
    for (std::size_t i = 0; i < 2; ++i)
        scans[i] = regionCues(blurred, colourHeight, i == 0 ? Scan::FromLeft : Scan::FromRight);
    Plane sum(small.cols, small.rows);
    for (int y = 0; y < sum.rows; ++y) {
        const float height = (static_cast<float>(y) + 0.5f) / static_cast<float>(sum.rows);
        for (int x = 0; x < sum.columns; ++x) {
            const std::size_t i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(sum.columns) +
                static_cast<std::size_t>(x);
            const float aside =
                static_cast<float>(2 * x + 1 - sum.columns) / static_cast<float>(sum.columns);
            const float contact = 0.5f * (scans[0].contact[i] + scans[1].contact[i]);
            const float colour = 0.5f * (scans[0].colourHeight[i] + scans[1].colourHeight[i]);
            sum[i] =
                onGrid(kHeightWeight * height + kContactWeight * contact +
                       kColourHeightWeight * colour + kSideWeight * aside * aside * (1 - height));
        }
    }
    return followEdges(std::move(sum), calm);
}

} // namespace

cv::Mat referenceDownscale(const cv::Mat& photo, int longestSide) {
    const int longer = std::max(photo.cols, photo.rows);
    if (longer <= longestSide) return photo.clone();
    const auto scaled = [&](int side) {
        return std::max(1L, std::lround(static_cast<double>(side) * longestSide / longer));
    };
    cv::Mat small(static_cast<int>(scaled(photo.rows)), static_cast<int>(scaled(photo.cols)),
                  CV_8UC3);
    // the px that a px of the small photo touches
    const auto touched = [](std::int64_t i, std::int64_t from, std::int64_t to) {
        return cv::Range(static_cast<int>(i * from / to),
                         static_cast<int>(((i + 1) * from + to - 1) / to));
    };
    for (int y = 0; y < small.rows; ++y) {
        for (int x = 0; x < small.cols; ++x) {
            const cv::Mat block =
                photo(touched(y, photo.rows, small.rows), touched(x, photo.cols, small.cols));
            std::array<std::int64_t, 3> total{};
            for (int j = 0; j < block.rows; ++j)
                for (int i = 0; i < block.cols; ++i)
                    for (int c = 0; c < 3; ++c)
                        total[static_cast<std::size_t>(c)] += block.at<cv::Vec3b>(j, i)[c];
            const auto count = static_cast<std::int64_t>(block.total());
            for (int c = 0; c < 3; ++c)
                small.at<cv::Vec3b>(y, x)[c] =
                    static_cast<uchar>((total[static_cast<std::size_t>(c)] + count / 2) / count);
        }
    }
    return small;
}

cv::Mat referenceDepthFromCues(const cv::Mat& photo) {
    const cv::Mat small = referenceDownscale(photo, kLongSide);
    const Plane sum = combineCues(small);

    // Clips half a percent at either end.
    std::vector<float> values = sum.values;
    const auto cut = static_cast<std::ptrdiff_t>(values.size() / 200);
    std::nth_element(values.begin(), values.begin() + cut, values.end());
    const float farthest = values[static_cast<std::size_t>(cut)];
    std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
    const float range = *(values.end() - 1 - cut) - farthest;
    cv::Mat depth(small.size(), CV_32FC1);
    for (int y = 0; y < sum.rows; ++y) {
        auto* out = depth.ptr<float>(y);
        for (int x = 0; x < sum.columns; ++x)
            out[x] =
                range > 1e-4f ? std::clamp((sum.row(y)[x] - farthest) / range, 0.0f, 1.0f) : 0.5f;
    }
    return depth;
}

} // namespace altiro3D::test
