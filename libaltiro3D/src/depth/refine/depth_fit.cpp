#include "depth/refine/depth_fit.hpp"

#include "altiro3D/depth_map.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/refine/depth_fit.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Wholes = hn::RebindToSigned<Floats>;
using F = hn::Vec<Floats>;
using I = hn::Vec<Wholes>;

// Reads the taps of neighbouring px. If the guide has more columns than samples, the taps are so
// close together that one load is enough.
class Taps {
  public:
    HWY_INLINE explicit Taps(const std::int32_t* taps)
        : first_(*taps), taps_(hn::LoadU(Wholes(), taps)),
          inside_(hn::Sub(taps_, hn::Set(Wholes(), first_))) {}

    HWY_INLINE bool near() const {
        const auto lanes = static_cast<std::int32_t>(hn::Lanes(Wholes()));
        return hn::AllTrue(Wholes(), hn::Lt(inside_, hn::Set(Wholes(), lanes)));
    }

    // @tparam kNear near()
    template <bool kNear, typename T, class D = hn::ScalableTag<T>>
    HWY_INLINE hn::Vec<D> read(const T* row) const {
        const D d;
        if (kNear) return lanesAt(d, hn::LoadU(d, row + first_), inside_);
        return hn::BitCast(d, gatherBytes4(Wholes(), row, hn::ShiftLeft<2>(taps_)));
    }

  private:
    std::int32_t first_;
    I taps_;
    I inside_; // relative to the first tap
};

// One vector of px. The 16 table look-ups per px limit the speed.
template <bool kNear>
HWY_INLINE F fitVector(const Taps& taps, const FitSamples& samples, const F* columnWeight,
                       const F* rowWeight, const float* colorWeight, I blueGreen, I red) {
    const Floats d;
    const Wholes whole;
    const I lastStep = hn::Set(whole, kColorSteps);
    F sum[kFitTaps] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    F weights[kFitTaps] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    std::ptrdiff_t row = 0;
    for (std::size_t i = 0; i < kFitTaps; ++i, row += samples.stride) {
        for (std::size_t j = 0; j < kFitTaps; ++j) {
            const std::ptrdiff_t at = row + static_cast<std::ptrdiff_t>(j);
            const I square =
                hn::Add(squaresOfPair(whole, taps.read<kNear>(samples.blueGreen + at), blueGreen),
                        squaresOfPair(whole, taps.read<kNear>(samples.red + at), red));
            const I step = hn::Min(hn::ShiftRight<kColorShift>(square), lastStep);
            const F weight =
                hn::Mul(gatherFloats(d, colorWeight, step), hn::Mul(rowWeight[i], columnWeight[j]));
            const F depth = taps.read<kNear>(samples.depth + at);
            sum[j] = hn::Add(sum[j], hn::Mul(weight, depth));
            weights[j] = hn::Add(weights[j], weight);
        }
    }
    const F mean =
        hn::Div(hn::Add(hn::Add(sum[0], sum[1]), hn::Add(sum[2], sum[3])),
                hn::Add(hn::Add(weights[0], weights[1]), hn::Add(weights[2], weights[3])));
    // Rounding must not leave the range of the samples: constant depth stays constant.
    const F least = taps.read<kNear>(samples.least);
    const F most = taps.read<kNear>(samples.most);
    return hn::Min(hn::Max(mean, least), most);
}

// The mean depth of the 4 x 4 samples around each px of a row, weighted by distance and by
// similarity of colour. The four columns of samples are summed separately, then in pairs, so the
// result has the same bits on all instruction sets.
// @param rowWeight weights of the four rows of samples
// @param colorWeight kColorSteps + 1 weights, by squared colour distance >> kColorShift
// @param fitted result, exactly `count`
void fitDepthRowOn(const FitSamples& samples, const FitColumns& columns,
                   const float* HWY_RESTRICT rowWeight, const float* HWY_RESTRICT colorWeight,
                   const FitGuide& guide, std::size_t count, float* HWY_RESTRICT fitted) {
    const Floats d;
    const Wholes whole;
    const hn::Rebind<std::uint8_t, Floats> bytes;
    const std::size_t lanes = hn::Lanes(d);
    const F rows[kFitTaps] = {hn::Set(d, rowWeight[0]), hn::Set(d, rowWeight[1]),
                              hn::Set(d, rowWeight[2]), hn::Set(d, rowWeight[3])};
    for (std::size_t x = 0; x < count; x += lanes) {
        const I blue = hn::PromoteTo(whole, hn::LoadU(bytes, guide.blue + x));
        const I green = hn::PromoteTo(whole, hn::LoadU(bytes, guide.green + x));
        const I red = hn::PromoteTo(whole, hn::LoadU(bytes, guide.red + x));
        const I blueGreen = hn::Or(blue, hn::ShiftLeft<16>(green));
        const F weights[kFitTaps] = {
            hn::LoadU(d, columns.weight[0] + x), hn::LoadU(d, columns.weight[1] + x),
            hn::LoadU(d, columns.weight[2] + x), hn::LoadU(d, columns.weight[3] + x)};
        const Taps taps(columns.tap + x);
        const F result =
            taps.near()
                ? fitVector<true>(taps, samples, weights, rows, colorWeight, blueGreen, red)
                : fitVector<false>(taps, samples, weights, rows, colorWeight, blueGreen, red);
        if (x + lanes <= count) {
            hn::StoreU(result, d, fitted + x);
        } else {
            HWY_ALIGN float last[HWY_LANES(float)];
            hn::Store(result, d, last);
            std::copy_n(last, count - x, fitted + x);
        }
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(fitDepthRowOn);

namespace {

// A colour distance of this many levels (0..255, over the three channels together) reduces a
// sample's weight to 0.6. Larger values let depth leak over edges, smaller ones copy the photo's
// noise; 10 to 30 give the same error within 3 % on five Middlebury scenes reduced 2 to 6 times.
constexpr double kColorSigma = 16.0;

constexpr float kMinColorWeight = 1e-4f;

std::array<float, kColorSteps + 1> makeColorWeights() {
    std::array<float, kColorSteps + 1> weights{};
    for (int i = 0; i <= kColorSteps; ++i) {
        const double square = (i + 0.5) * (1 << kColorShift);
        weights[static_cast<std::size_t>(i)] =
            static_cast<float>(std::exp(-square / (2 * kColorSigma * kColorSigma))) +
            kMinColorWeight;
    }
    weights[kColorSteps] = kMinColorWeight;
    return weights;
}

// One axis of the grid of depth samples under the guide.
struct Axis {
    int first = 0;        // first sample under the guide
    int samples = 0;      // number of samples
    std::vector<int> tap; // per guide px, padded: index of the first tap, from `first` - 2
    std::array<std::vector<float>, kFitTaps> weight; // weights of the taps, per guide px, padded
    std::vector<cv::Range> cell;                     // per sample: the guide px that it covers
};

// Samples and guide px along one axis (start and length in samples; centre of a sample at + 0.5):
//
//     samples    |    0    |    1    |    2    |    3    |
//     guide px        | 0 | 1 | 2 | 3 | 4 | 5 | 6 |
//                     ^ start                     ^ start + length
Axis layOut(double start, double length, int pixels, int available) {
    Axis axis;
    const double step = length / pixels;
    axis.first = std::clamp(static_cast<int>(std::floor(start)), 0, available - 1);
    const int last =
        std::clamp(static_cast<int>(std::ceil(start + length)) - 1, axis.first, available - 1);
    axis.samples = last - axis.first + 1;
    axis.tap = paddedRow<int>(static_cast<std::size_t>(pixels));
    axis.weight.fill(paddedRow<float>(static_cast<std::size_t>(pixels)));
    for (int x = 0; x < pixels; ++x) {
        const double at = start + (x + 0.5) * step - 0.5;
        // Clamped at the borders: one more tap would lie outside the two repeated samples.
        const double base = std::clamp(std::floor(at), axis.first - 1.0, static_cast<double>(last));
        const double t = std::clamp(at - base, 0.0, 1.0);
        const double s = 1 - t;
        const auto pixel = static_cast<std::size_t>(x);
        axis.tap[pixel] = static_cast<int>(base) - 1 - (axis.first - 2);
        // Cubic B-spline: smooth, reproduces ramps, ends at 0 where its support ends.
        axis.weight[0][pixel] = static_cast<float>(s * s * s / 6);
        axis.weight[1][pixel] = static_cast<float>((4 - 6 * t * t + 3 * t * t * t) / 6);
        axis.weight[2][pixel] = static_cast<float>((4 - 6 * s * s + 3 * s * s * s) / 6);
        axis.weight[3][pixel] = static_cast<float>(t * t * t / 6);
    }
    std::fill(axis.tap.begin() + pixels, axis.tap.end(),
              axis.tap[static_cast<std::size_t>(pixels) - 1]);
    axis.cell.resize(static_cast<std::size_t>(axis.samples));
    for (int i = 0; i < axis.samples; ++i) {
        // The px with centres in the sample's cell, at least the one nearest to its centre.
        const double low = (axis.first + i - start) / step - 0.5;
        const double high = (axis.first + i + 1 - start) / step - 0.5;
        const auto whole = [](double value, int most) {
            return static_cast<int>(std::clamp<double>(value, 0, most));
        };
        int from = whole(std::ceil(low), pixels);
        int to = whole(std::ceil(high), pixels);
        if (from >= to) {
            from = whole(std::floor((low + high) / 2 + 0.5), pixels - 1);
            to = from + 1;
        }
        axis.cell[static_cast<std::size_t>(i)] = cv::Range(from, to);
    }
    return axis;
}

// The depth samples and the picture's mean colours there, as the planes of FitSamples. The outer
// samples are repeated twice, so taps need no bounds checks.
struct Samples {
    std::size_t columns; // including repeated ones
    std::size_t rows;
    std::vector<float> depth;
    std::vector<std::int32_t> blueGreen;
    std::vector<std::int32_t> red;
    std::vector<float> least;
    std::vector<float> most;

    Samples(const Axis& alongColumns, const Axis& alongRows)
        : columns(static_cast<std::size_t>(alongColumns.samples) + 4),
          rows(static_cast<std::size_t>(alongRows.samples) + 4),
          depth(paddedRow<float>(columns * rows)),
          blueGreen(paddedRow<std::int32_t>(columns * rows)), red(blueGreen), least(depth),
          most(depth) {}

    FitSamples from(int row) const {
        const std::size_t at = static_cast<std::size_t>(row) * columns;
        return {static_cast<std::ptrdiff_t>(columns),
                depth.data() + at,
                blueGreen.data() + at,
                red.data() + at,
                least.data() + at,
                most.data() + at};
    }
};

// One row of samples: depth unchanged, colours averaged over the guide px in each sample's cell.
// @param row index including repeated rows
void collectRow(const float* depth, const cv::Mat& guide, const Axis& columns, cv::Range guideRows,
                std::size_t row, Samples& samples) {
    const auto count = static_cast<std::size_t>(columns.samples);
    const std::size_t begin = row * samples.columns + 2;
    for (std::size_t j = 0; j < count; ++j) {
        const cv::Range cell = columns.cell[j];
        std::array<std::uint64_t, 3> sum{};
        for (int y = guideRows.start; y < guideRows.end; ++y) {
            const std::uint8_t* pixel = guide.ptr<std::uint8_t>(y) + 3 * cell.start;
            for (int x = cell.start; x < cell.end; ++x, pixel += 3) {
                for (std::size_t c = 0; c < 3; ++c)
                    sum[c] += pixel[c];
            }
        }
        const auto pixels =
            static_cast<std::uint64_t>(guideRows.size()) * static_cast<std::uint64_t>(cell.size());
        const auto mean = [&](std::size_t c) { // rounded
            return static_cast<std::int32_t>((sum[c] + pixels / 2) / pixels);
        };
        samples.depth[begin + j] = depth[j];
        samples.blueGreen[begin + j] = mean(0) + (mean(1) << 16);
        samples.red[begin + j] = mean(2);
    }
    const auto repeatEnds = [&](auto& plane) {
        const auto first = plane.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto end = first + static_cast<std::ptrdiff_t>(count);
        std::fill(first - 2, first, *first);
        std::fill(end, end + 2, *(end - 1));
    };
    repeatEnds(samples.depth);
    repeatEnds(samples.blueGreen);
    repeatEnds(samples.red);
}

// FitSamples::least and most of a row.
void findRange(std::size_t row, Samples& samples) {
    const std::size_t count = samples.columns;
    const float* const depth = samples.depth.data() + row * count;
    std::vector<float> low(depth, depth + count);
    std::vector<float> high = low;
    for (std::size_t i = 1; i < kFitTaps; ++i) {
        for (std::size_t x = 0; x < count; ++x) {
            low[x] = std::min(low[x], depth[i * count + x]);
            high[x] = std::max(high[x], depth[i * count + x]);
        }
    }
    float* const least = samples.least.data() + row * count;
    float* const most = samples.most.data() + row * count;
    for (std::size_t x = 0; x + kFitTaps <= count; ++x) {
        least[x] = std::min(std::min(low[x], low[x + 1]), std::min(low[x + 2], low[x + 3]));
        most[x] = std::max(std::max(high[x], high[x + 1]), std::max(high[x + 2], high[x + 3]));
    }
}

Samples collectSamples(const cv::Mat& depth, const cv::Mat& guide, const Axis& columns,
                       const Axis& rows) {
    Samples samples(columns, rows);
    overRows(rows.samples, [&](int i) {
        const auto row = static_cast<std::size_t>(i);
        collectRow(depth.ptr<float>(rows.first + i) + columns.first, guide, columns, rows.cell[row],
                   row + 2, samples);
    });
    const auto repeatEnds = [&](auto& plane) {
        const auto copyRow = [&](std::size_t from, std::size_t to) {
            std::copy_n(plane.data() + from * samples.columns, samples.columns,
                        plane.data() + to * samples.columns);
        };
        copyRow(2, 0);
        copyRow(2, 1);
        copyRow(samples.rows - 3, samples.rows - 2);
        copyRow(samples.rows - 3, samples.rows - 1);
    };
    repeatEnds(samples.depth);
    repeatEnds(samples.blueGreen);
    repeatEnds(samples.red);
    for (std::size_t row = 0; row + kFitTaps <= samples.rows; ++row)
        findRange(row, samples);
    return samples;
}

// The 2 x 2 samples around each place between samples. Enlarged depth stays within their range, and
// takes one end of it where they hold a whole step.
struct Steps {
    std::vector<float> from; // per place, as the planes of FitSamples: the least sample
    std::vector<float> to;   // the largest one; exchanged at a step

    explicit Steps(const Samples& samples) : from(samples.depth.size()), to(from) {
        constexpr float kHeight = 0.03F; // lowest step, in units of depth
        constexpr float kPart = 0.6F;    // share of the range around; a slope has a third of it
        const std::size_t columns = samples.columns;
        for (std::size_t i = 0; i + kFitTaps <= samples.rows; ++i) {
            for (std::size_t at = i * columns; at + kFitTaps <= (i + 1) * columns; ++at) {
                const float* const above = &samples.depth[at + columns + 1];
                const float* const below = above + columns;
                std::tie(from[at], to[at]) = std::minmax({above[0], above[1], below[0], below[1]});
                const float range = samples.most[at] - samples.least[at];
                if (to[at] - from[at] >= std::max(kHeight, kPart * range))
                    std::swap(from[at], to[at]);
            }
        }
    }

    // @param first place of the row @param tap of each px
    void harden(std::size_t first, const std::vector<int>& tap, int count, float* fitted) const {
        for (int x = 0; x < count; ++x) {
            const std::size_t at =
                first + static_cast<std::size_t>(tap[static_cast<std::size_t>(x)]);
            const float a = from[at];
            const float b = to[at];
            fitted[x] = a <= b ? std::clamp(fitted[x], a, b) : fitted[x] > (a + b) / 2 ? a : b;
        }
    }
};

// @param keepsSteps steps between two samples stay hard
void enlarge(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide, bool keepsSteps,
             cv::Mat& fitted) {
    static const std::array<float, kColorSteps + 1> colorWeights = makeColorWeights();
    const Axis columns = layOut(part.x, part.width, guide.cols, depth.cols);
    const Axis rows = layOut(part.y, part.height, guide.rows, depth.rows);
    const Samples samples = collectSamples(depth, guide, columns, rows);
    std::optional<Steps> steps;
    if (keepsSteps) steps.emplace(samples);
    FitColumns fitColumns;
    fitColumns.tap = columns.tap.data();
    for (std::size_t j = 0; j < kFitTaps; ++j)
        fitColumns.weight[j] = columns.weight[j].data();
    const auto width = static_cast<std::size_t>(guide.cols);
    fitted.create(guide.size(), CV_32FC1);
    cv::parallel_for_(cv::Range(0, guide.rows), [&](const cv::Range& range) {
        std::array<std::vector<std::uint8_t>, 3> channels;
        channels.fill(paddedRow<std::uint8_t>(width));
        const FitGuide fitGuide = {channels[0].data(), channels[1].data(), channels[2].data()};
        for (int y = range.start; y < range.end; ++y) {
            const auto row = static_cast<std::size_t>(y);
            const float rowWeight[kFitTaps] = {rows.weight[0][row], rows.weight[1][row],
                                               rows.weight[2][row], rows.weight[3][row]};
            splitRow(guide.ptr<std::uint8_t>(y), width, channels[0].data(), channels[1].data(),
                     channels[2].data());
            HWY_DYNAMIC_DISPATCH(fitDepthRowOn)
            (samples.from(rows.tap[row]), fitColumns, rowWeight, colorWeights.data(), fitGuide,
             width, fitted.ptr<float>(y));
            if (steps)
                steps->harden(static_cast<std::size_t>(rows.tap[row]) * samples.columns,
                              columns.tap, guide.cols, fitted.ptr<float>(y));
        }
    });
}

// The index of the sample under each px centre.
std::vector<int> nearestSamples(double start, double length, int pixels, int available) {
    std::vector<int> indices(static_cast<std::size_t>(pixels));
    for (int x = 0; x < pixels; ++x) {
        const double at = start + (x + 0.5) * (length / pixels);
        indices[static_cast<std::size_t>(x)] =
            std::clamp(static_cast<int>(std::floor(at)), 0, available - 1);
    }
    return indices;
}

void pickNearest(const cv::Mat& depth, const cv::Rect2d& part, cv::Size size, cv::Mat& fitted) {
    const std::vector<int> columns = nearestSamples(part.x, part.width, size.width, depth.cols);
    const std::vector<int> rows = nearestSamples(part.y, part.height, size.height, depth.rows);
    cv::Mat result;
    if (fitted.datastart != depth.datastart) result = fitted; // else in place: newly allocated
    result.create(size, CV_32FC1);
    overRows(size.height, [&](int y) {
        const float* const from = depth.ptr<float>(rows[static_cast<std::size_t>(y)]);
        float* const to = result.ptr<float>(y);
        for (std::size_t x = 0; x < columns.size(); ++x)
            to[x] = from[columns[x]];
    });
    fitted = result;
}

// Places between samples, for linear interpolation: sample `first` and the share of the next one.
struct Between {
    int first;
    int second; // the same at the ends
    float share;
};

std::vector<Between> between(double start, double length, int pixels, int available) {
    std::vector<Between> places(static_cast<std::size_t>(pixels));
    for (int x = 0; x < pixels; ++x) {
        const double last = available - 1;
        const double at = std::clamp(start + (x + 0.5) * (length / pixels) - 0.5, 0.0, last);
        const int first = static_cast<int>(at);
        places[static_cast<std::size_t>(x)] = {first, std::min(first + 1, available - 1),
                                               static_cast<float>(at - first)};
    }
    return places;
}

void mix(const cv::Mat& depth, const cv::Rect2d& part, cv::Mat& result) {
    const std::vector<Between> columns = between(part.x, part.width, result.cols, depth.cols);
    const std::vector<Between> rows = between(part.y, part.height, result.rows, depth.rows);
    cv::parallel_for_(cv::Range(0, result.rows), [&](const cv::Range& range) {
        std::vector<float> row(static_cast<std::size_t>(depth.cols));
        for (int y = range.start; y < range.end; ++y) {
            const Between& at = rows[static_cast<std::size_t>(y)];
            const float* const above = depth.ptr<float>(at.first);
            const float* const below = depth.ptr<float>(at.second);
            for (std::size_t x = 0; x < row.size(); ++x)
                row[x] = above[x] + at.share * (below[x] - above[x]);
            float* const to = result.ptr<float>(y);
            for (std::size_t x = 0; x < columns.size(); ++x) {
                const float left = row[static_cast<std::size_t>(columns[x].first)];
                const float right = row[static_cast<std::size_t>(columns[x].second)];
                to[x] = left + columns[x].share * (right - left);
            }
        }
    });
}

void checkPart(const cv::Mat& depth, const cv::Rect2d& part) {
    // Callers that compute `size - start` and add it again are off by rounding.
    constexpr double kSlackPixels = 1e-6;
    const bool isInside = part.x >= -kSlackPixels && part.y >= -kSlackPixels && part.width > 0 &&
                          part.height > 0 && part.x + part.width <= depth.cols + kSlackPixels &&
                          part.y + part.height <= depth.rows + kSlackPixels;
    check(isInside, "part",
          "is " + numberText(part.width) + " x " + numberText(part.height) + " px at (" +
              numberText(part.x) + ", " + numberText(part.y) +
              "), expected a part of the depth map of " + sizeText(depth.size()));
}

bool isShrunk(const cv::Rect2d& part, cv::Size size) {
    return part.width >= size.width && part.height >= size.height;
}

void fit(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide, bool keepsSteps,
         cv::Mat& fitted) {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    checkType(guide, {CV_8UC3}, "guide", "CV_8UC3");
    checkPart(depth, part);
    if (isShrunk(part, guide.size())) {
        pickNearest(depth, part, guide.size(), fitted);
    } else {
        enlarge(depth, part, guide, keepsSteps, fitted);
    }
}

} // namespace

void fitDepth(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide,
              cv::Mat& fitted) try {
    fit(depth, part, guide, false, fitted);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void fitRefinedDepth(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide,
                     cv::Mat& fitted) {
    fit(depth, part, guide, true, fitted);
}

void interpolateDepth(const cv::Mat& depth, const cv::Rect2d& part, cv::Size size,
                      cv::Mat& fitted) {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    checkPart(depth, part);
    if (isShrunk(part, size)) return pickNearest(depth, part, size, fitted);
    cv::Mat result(size, CV_32FC1); // not `fitted`: it may be the depth itself
    mix(depth, part, result);
    fitted = result;
}

} // namespace altiro3D
#endif
