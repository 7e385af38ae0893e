// Brings depth to the size of a picture: fitDepth() of depth_map.hpp.

#include "altiro3D/depth_map.hpp"
#include "checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kTaps = 4; // along each axis: the cubic B-spline's support

// A colour distance of this many of 255 levels (over the three channels together) lowers a sample's
// weight to 0.6. Larger values let depth leak over edges, smaller ones copy the photo's noise; 10
// to 30 give the same error within 3 % on five Middlebury scenes reduced 2 to 6 times.
constexpr double kColorSigma = 16.0;

// Weights by squared colour distance, in steps of 8; beyond the table (5.6 sigma) the weight is the
// floor that lets plain interpolation win where no sample resembles the pixel.
constexpr int kColorShift = 3;
constexpr int kColorSteps = 1024;
constexpr float kLeastColorWeight = 1e-4f;

std::array<float, kColorSteps + 1> colorWeights() {
    std::array<float, kColorSteps + 1> weights{};
    for (int i = 0; i <= kColorSteps; ++i) {
        const double square = (i + 0.5) * (1 << kColorShift);
        weights[static_cast<std::size_t>(i)] =
            static_cast<float>(std::exp(-square / (2 * kColorSigma * kColorSigma))) +
            kLeastColorWeight;
    }
    weights[kColorSteps] = kLeastColorWeight;
    return weights;
}

// One axis of the grid of depth samples under the guide.
struct Axis {
    int first = 0;        // index of the first sample under the guide
    int samples = 0;      // how many
    std::vector<int> tap; // per guide px: the first tap, counted from first - 2
    std::vector<std::array<float, kTaps>> weight; // per guide px: the taps' weights
    std::vector<cv::Range> cell;                  // per sample: the guide's px that it covers
};

// Samples and guide px along one axis (start, length in samples; a sample's centre is at + 0.5):
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
    axis.tap.resize(static_cast<std::size_t>(pixels));
    axis.weight.resize(static_cast<std::size_t>(pixels));
    for (int x = 0; x < pixels; ++x) {
        const double at = start + (x + 0.5) * step - 0.5;
        // At the borders a whole tap more would lie outside the two repeated samples.
        const double base = std::clamp(std::floor(at), axis.first - 1.0, static_cast<double>(last));
        const double t = std::clamp(at - base, 0.0, 1.0);
        const double s = 1 - t;
        axis.tap[static_cast<std::size_t>(x)] = static_cast<int>(base) - 1 - (axis.first - 2);
        // Cubic B-spline: smooth, reproduces ramps, ends at 0 where its support ends.
        axis.weight[static_cast<std::size_t>(x)] = {
            static_cast<float>(s * s * s / 6),
            static_cast<float>((4 - 6 * t * t + 3 * t * t * t) / 6),
            static_cast<float>((4 - 6 * s * s + 3 * s * s * s) / 6),
            static_cast<float>(t * t * t / 6)};
    }
    axis.cell.resize(static_cast<std::size_t>(axis.samples));
    for (int i = 0; i < axis.samples; ++i) {
        // The px whose centres lie in the sample's cell, at least the one nearest to its centre.
        const double low = (axis.first + i - start) / step - 0.5;
        const double high = (axis.first + i + 1 - start) / step - 0.5;
        int from = std::max(0, static_cast<int>(std::ceil(low)));
        int to = std::min(pixels, static_cast<int>(std::ceil(high)));
        if (from >= to) {
            from = std::clamp(static_cast<int>(std::floor((low + high) / 2 + 0.5)), 0, pixels - 1);
            to = from + 1;
        }
        axis.cell[static_cast<std::size_t>(i)] = cv::Range(from, to);
    }
    return axis;
}

// The depth samples and the picture's mean colours there, as four planes; the outer samples are
// repeated twice so that no tap needs a check. Whole numbers in float are exact and fast.
struct Samples {
    enum Plane { Depth, Blue, Green, Red, Planes };
    int stride = 0;
    std::array<std::vector<float>, Planes> planes;

    float* row(int plane, int y) {
        return planes[static_cast<std::size_t>(plane)].data() +
               static_cast<std::ptrdiff_t>(y + 2) * stride + 2;
    }
};

// One row of samples: depth as it is, colours averaged over the guide's px in each sample's cell.
void collectRow(const float* depth, const cv::Mat& guide, const Axis& columns, cv::Range guideRows,
                const std::array<float*, Samples::Planes>& to) {
    const int count = columns.samples;
    for (int j = 0; j < count; ++j) {
        const cv::Range cell = columns.cell[static_cast<std::size_t>(j)];
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
        to[Samples::Depth][j] = depth[j];
        for (std::size_t c = 0; c < 3; ++c) {
            const std::uint64_t mean = (sum[c] + pixels / 2) / pixels; // rounded
            to[Samples::Blue + c][j] = static_cast<float>(mean);
        }
    }
    for (float* const row : to) {
        row[-2] = row[-1] = row[0];
        row[count] = row[count + 1] = row[count - 1];
    }
}

Samples collectSamples(const cv::Mat& depth, const cv::Mat& guide, const Axis& columns,
                       const Axis& rows) {
    Samples samples;
    samples.stride = columns.samples + 4;
    for (std::vector<float>& plane : samples.planes) {
        plane.resize(static_cast<std::size_t>(samples.stride) *
                     static_cast<std::size_t>(rows.samples + 4));
    }
    cv::parallel_for_(cv::Range(0, rows.samples), [&](const cv::Range& part) {
        for (int i = part.start; i < part.end; ++i) {
            collectRow(depth.ptr<float>(rows.first + i) + columns.first, guide, columns,
                       rows.cell[static_cast<std::size_t>(i)],
                       {samples.row(Samples::Depth, i), samples.row(Samples::Blue, i),
                        samples.row(Samples::Green, i), samples.row(Samples::Red, i)});
        }
    });
    for (int plane = 0; plane < Samples::Planes; ++plane) {
        const auto copyRow = [&](int from, int to) {
            std::copy_n(samples.row(plane, from) - 2, samples.stride, samples.row(plane, to) - 2);
        };
        for (int i = 1; i <= 2; ++i) {
            copyRow(0, -i);
            copyRow(rows.samples - 1, rows.samples - 1 + i);
        }
    }
    return samples;
}

// Reads 4 x 4 samples around each px of a guide row; writes their mean, weighed by nearness and
// likeness of colour. Bound by the 16 table look-ups per px.
void fitRow(const std::array<const float*, Samples::Planes>& samples, int stride,
            const Axis& columns, const std::array<float, kTaps>& rowWeight,
            const float* colorWeight, const std::uint8_t* guide, float* fitted) {
    constexpr float kToStep = 1.0f / (1 << kColorShift);
    constexpr auto kLastStep = static_cast<float>(kColorSteps);
    const std::size_t pixels = columns.tap.size();
    for (std::size_t x = 0; x < pixels; ++x) {
        const float blue = guide[3 * x];
        const float green = guide[3 * x + 1];
        const float red = guide[3 * x + 2];
        const std::array<float, kTaps>& columnWeight = columns.weight[x];
        std::ptrdiff_t at = columns.tap[x];
        // Four lanes, one per column of taps, in the order in which SIMD adds them.
        std::array<float, kTaps> sum{};
        std::array<float, kTaps> weights{};
        std::array<float, kTaps> least;
        std::copy_n(samples[Samples::Depth] + at, kTaps, least.begin());
        std::array<float, kTaps> most = least;
        for (std::size_t i = 0; i < kTaps; ++i, at += stride) {
            const float* const depths = samples[Samples::Depth] + at;
            const float* const blues = samples[Samples::Blue] + at;
            const float* const greens = samples[Samples::Green] + at;
            const float* const reds = samples[Samples::Red] + at;
            std::array<int, kTaps> step;
            for (std::size_t j = 0; j < kTaps; ++j) {
                const float b = blues[j] - blue;
                const float g = greens[j] - green;
                const float r = reds[j] - red;
                const float square = (b * b + g * g + r * r) * kToStep;
                step[j] = static_cast<int>(square < kLastStep ? square : kLastStep);
            }
            std::array<float, kTaps> weight;
            for (std::size_t j = 0; j < kTaps; ++j)
                weight[j] = colorWeight[step[j]];
            for (std::size_t j = 0; j < kTaps; ++j) {
                const float depth = depths[j];
                weight[j] = weight[j] * (rowWeight[i] * columnWeight[j]);
                sum[j] += weight[j] * depth;
                weights[j] += weight[j];
                least[j] = depth < least[j] ? depth : least[j];
                most[j] = depth > most[j] ? depth : most[j];
            }
        }
        const float mean = ((sum[0] + sum[1]) + (sum[2] + sum[3])) /
                           ((weights[0] + weights[1]) + (weights[2] + weights[3]));
        const float low = std::min(std::min(least[0], least[1]), std::min(least[2], least[3]));
        const float high = std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
        // Rounding must not lead out of the samples' range: constant depth stays constant.
        fitted[x] = std::min(std::max(mean, low), high);
    }
}

void enlarge(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide, cv::Mat& fitted) {
    const Axis columns = layOut(part.x, part.width, guide.cols, depth.cols);
    const Axis rows = layOut(part.y, part.height, guide.rows, depth.rows);
    const Samples samples = collectSamples(depth, guide, columns, rows);
    const std::array<float, kColorSteps + 1> colorWeight = colorWeights();
    fitted.create(guide.size(), CV_32FC1);
    cv::parallel_for_(cv::Range(0, guide.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const auto row = static_cast<std::size_t>(y);
            const std::ptrdiff_t first =
                static_cast<std::ptrdiff_t>(rows.tap[row]) * samples.stride;
            std::array<const float*, Samples::Planes> planes;
            for (std::size_t i = 0; i < planes.size(); ++i) {
                planes[i] = samples.planes[i].data() + first;
            }
            fitRow(planes, samples.stride, columns, rows.weight[row], colorWeight.data(),
                   guide.ptr<std::uint8_t>(y), fitted.ptr<float>(y));
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
    if (fitted.datastart != depth.datastart) result = fitted; // else in place: a fresh picture
    result.create(size, CV_32FC1);
    cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const float* const from = depth.ptr<float>(rows[static_cast<std::size_t>(y)]);
            float* const to = result.ptr<float>(y);
            for (std::size_t x = 0; x < columns.size(); ++x)
                to[x] = from[columns[x]];
        }
    });
    fitted = result;
}

} // namespace

void fitDepth(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide, cv::Mat& fitted) {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    checkType(guide, {CV_8UC3}, "guide", "CV_8UC3");
    // What is computed as `size - start` and added again may be off by rounding.
    constexpr double kSlackPixels = 1e-6;
    const bool isInside = part.x >= -kSlackPixels && part.y >= -kSlackPixels && part.width > 0 &&
                          part.height > 0 && part.x + part.width <= depth.cols + kSlackPixels &&
                          part.y + part.height <= depth.rows + kSlackPixels;
    check(isInside, "part",
          "is " + std::to_string(part.width) + " x " + std::to_string(part.height) + " px at (" +
              std::to_string(part.x) + ", " + std::to_string(part.y) +
              "), expected a part of the depth map of " + std::to_string(depth.cols) + " x " +
              std::to_string(depth.rows) + " px");
    const cv::Mat source = depth;
    if (part.width >= guide.cols && part.height >= guide.rows) {
        pickNearest(source, part, guide.size(), fitted);
    } else {
        enlarge(source, part, guide, fitted);
    }
}

} // namespace altiro3D
