#include "altiro3D/depth_map.hpp"

#include "altiro3D/error.hpp"
#include "pixel_values.hpp"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <mutex>
#include <numeric>
#include <opencv2/core.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace altiro3D {

namespace {

void check(bool condition, const char* subject, const std::string& problem) {
    if (!condition) throw Error(ErrorCode::InvalidArgument, subject, problem);
}

std::string shape(const cv::Mat& picture) {
    if (picture.empty()) return "is empty";
    return "is " + std::to_string(picture.cols) + " x " + std::to_string(picture.rows) + " px of " +
           cv::typeToString(picture.type());
}

void checkType(const cv::Mat& picture, std::initializer_list<int> types, const char* subject,
               const char* expected) {
    const bool fits = !picture.empty() && picture.dims == 2 &&
                      std::find(types.begin(), types.end(), picture.type()) != types.end();
    check(fits, subject, shape(picture) + ", expected " + expected);
}

// ------------------------------------------------------------------------------ normalizeDepth

// What a sample is worth: whether it is known, its place in the order, its inverse depth.
template <typename T>
bool isKnown(T value, DepthKind kind) {
    if (kind == DepthKind::Metric) return value > 0; // +inf is known: infinitely far
    if constexpr (std::is_floating_point_v<T>) return std::isfinite(value);
    return true;
}

// Larger = nearer.
double nearness(double value, DepthKind kind) {
    switch (kind) {
    case DepthKind::NearWhite:
        return value;
    case DepthKind::FarWhite:
        return -value;
    case DepthKind::Metric:
        return std::min(1.0 / value, DBL_MAX);
    }
    return value;
}

// Keys: unsigned numbers in the same order as the samples.
std::uint16_t keyOf(std::uint8_t value) {
    return value;
}
std::uint16_t keyOf(std::uint16_t value) {
    return value;
}
std::uint32_t keyOf(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}
std::uint64_t keyOf(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
    return (bits & kSign) != 0 ? ~bits : bits | kSign;
}

void valueOf(std::uint16_t key, std::uint8_t& value) {
    value = static_cast<std::uint8_t>(key);
}
void valueOf(std::uint16_t key, std::uint16_t& value) {
    value = key;
}
void valueOf(std::uint32_t key, float& value) {
    const std::uint32_t bits = (key & 0x80000000u) != 0 ? key & 0x7fffffffu : ~key;
    std::memcpy(&value, &bits, sizeof bits);
}
void valueOf(std::uint64_t key, double& value) {
    constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
    const std::uint64_t bits = (key & kSign) != 0 ? key & ~kSign : ~key;
    std::memcpy(&value, &bits, sizeof bits);
}

constexpr int kDigitBits = 16;
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;

using Histogram = std::vector<std::uint32_t>; // pictures have fewer than 2^32 px

// Counts the known samples by one digit of their keys; only those whose higher digits are `prefix`.
// Sums of whole numbers do not depend on how the rows are shared out among threads.
template <typename T>
Histogram countDigits(const cv::Mat& raw, DepthKind kind, int shift, std::uint64_t prefix) {
    constexpr int kKeyBits = static_cast<int>(sizeof(keyOf(T{})) * 8);
    const bool isFirst = shift + kDigitBits == kKeyBits;
    Histogram total(kDigits);
    std::mutex adding;
    const auto count = [&](const cv::Range& rows) {
        Histogram histogram(kDigits);
        for (int y = rows.start; y < rows.end; ++y) {
            const T* row = raw.ptr<T>(y);
            for (int x = 0; x < raw.cols; ++x) {
                if (!isKnown(row[x], kind)) continue;
                const std::uint64_t key = keyOf(row[x]);
                if (!isFirst && key >> (shift + kDigitBits) != prefix) continue;
                ++histogram[key >> shift & (kDigits - 1)];
            }
        }
        const std::lock_guard<std::mutex> lock(adding);
        std::transform(total.begin(), total.end(), histogram.begin(), total.begin(), std::plus<>());
    };
    // A histogram costs as much as some 60 thousand samples.
    const double stripes = std::clamp(static_cast<double>(raw.total()) / 500000, 1.0,
                                      static_cast<double>(std::max(1, cv::getNumThreads())));
    cv::parallel_for_(cv::Range(0, raw.rows), count, std::floor(stripes));
    return total;
}

// Moves the rank into the digit that holds it and returns that digit.
std::uint64_t findDigit(const Histogram& histogram, std::uint64_t& rank) {
    for (std::size_t digit = 0; digit < kDigits; ++digit) {
        if (rank < histogram[digit]) return digit;
        rank -= histogram[digit];
    }
    return kDigits - 1;
}

struct Range {
    bool isFlat = true;
    double low = 0;  // half the nearness that becomes 0
    double span = 0; // half the nearness from 0 to 1
};

// The sample of a rank among the known ones: exact, by one histogram per 16 bits of the key.
template <typename T>
T sampleOfRank(const cv::Mat& raw, DepthKind kind, std::uint64_t rank, const Histogram& first) {
    using Key = decltype(keyOf(T{}));
    constexpr int kKeyBits = static_cast<int>(sizeof(Key) * 8);
    std::uint64_t prefix = findDigit(first, rank);
    for (int shift = kKeyBits - 2 * kDigitBits; shift >= 0; shift -= kDigitBits) {
        const Histogram digits = countDigits<T>(raw, kind, shift, prefix);
        prefix = prefix << kDigitBits | findDigit(digits, rank);
    }
    T value;
    valueOf(static_cast<Key>(prefix), value);
    return value;
}

template <typename T>
Range findRange(const cv::Mat& raw, const DepthNormalization& options) {
    constexpr int kFirstShift = static_cast<int>(sizeof(keyOf(T{})) * 8) - kDigitBits;
    const Histogram first = countDigits<T>(raw, options.kind, kFirstShift, 0);
    const std::uint64_t known = std::accumulate(first.begin(), first.end(), std::uint64_t{0});
    Range range;
    if (known == 0) return range;
    // Ranks are rounded outwards, so that small pictures keep all of their range. They count from
    // far to near; where large numbers are far, the samples' own order is the reverse.
    const double last = static_cast<double>(known - 1);
    auto lowRank = static_cast<std::uint64_t>(std::floor(options.lowPercentile / 100 * last));
    auto highRank = static_cast<std::uint64_t>(std::ceil(options.highPercentile / 100 * last));
    highRank = std::min(highRank, known - 1);
    if (options.kind != DepthKind::NearWhite) {
        lowRank = known - 1 - lowRank;
        highRank = known - 1 - highRank;
    }
    // Halves, as the distance of two large numbers may be beyond the largest.
    const auto half = [&](std::uint64_t rank) {
        const T sample = sampleOfRank<T>(raw, options.kind, rank, first);
        return 0.5 * nearness(static_cast<double>(sample), options.kind);
    };
    range.low = half(lowRank);
    const double high = half(highRank);
    range.span = high - range.low;
    // float carries 24 bits, so that a computed constant wavers by some 1e-7 of itself; denormal
    // ranges depend on how the processor is set.
    constexpr double kNoise = 1e-6;
    const bool isFloat = std::is_same_v<T, float> && options.kind != DepthKind::Metric;
    const double smallest = isFloat ? static_cast<double>(FLT_MIN) : DBL_MIN;
    const double largest = std::max(std::abs(range.low), std::abs(high));
    range.isFlat = !(range.span > kNoise * largest && range.span >= smallest);
    return range;
}

// One row to 0..1 and its unknown samples from their neighbours; false if none is known.
template <typename T>
bool normalizeRow(const T* raw, float* depth, int columns, DepthKind kind, const Range& range) {
    int lastKnown = -1;
    for (int x = 0; x < columns; ++x) {
        const T value = raw[x];
        if (!isKnown(value, kind)) continue;
        const double place =
            (0.5 * nearness(static_cast<double>(value), kind) - range.low) / range.span;
        const float result = static_cast<float>(std::min(std::max(place, 0.0), 1.0));
        if (lastKnown + 1 < x) {
            // The farther neighbour: what the sensor cannot see is behind what it sees.
            const float fill = lastKnown < 0 ? result : std::min(depth[lastKnown], result);
            std::fill(depth + lastKnown + 1, depth + x, fill);
        }
        depth[x] = result;
        lastKnown = x;
    }
    if (lastKnown < 0) return false;
    std::fill(depth + lastKnown + 1, depth + columns, depth[lastKnown]);
    return true;
}

// Rows without any known sample become copies of the nearest row with some (of two, the upper).
void fillRows(cv::Mat& depth, const std::vector<char>& known) {
    const int rows = depth.rows;
    std::vector<int> below(static_cast<std::size_t>(rows), -1);
    for (int y = rows - 1, next = -1; y >= 0; --y) {
        if (known[static_cast<std::size_t>(y)] != 0) next = y;
        below[static_cast<std::size_t>(y)] = next;
    }
    for (int y = 0, above = -1; y < rows; ++y) {
        if (known[static_cast<std::size_t>(y)] != 0) {
            above = y;
            continue;
        }
        const int next = below[static_cast<std::size_t>(y)];
        const bool takeAbove = next < 0 || (above >= 0 && y - above <= next - y);
        depth.row(takeAbove ? above : next).copyTo(depth.row(y));
    }
}

template <typename T>
void normalize(const cv::Mat& raw, cv::Mat& depth, const DepthNormalization& options) {
    const Range range = findRange<T>(raw, options);
    depth.create(raw.size(), CV_32FC1);
    if (range.isFlat) {
        depth.setTo(options.flatDepth);
        return;
    }
    std::vector<char> known(static_cast<std::size_t>(raw.rows), 0);
    cv::parallel_for_(cv::Range(0, raw.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            known[static_cast<std::size_t>(y)] = static_cast<char>(
                normalizeRow(raw.ptr<T>(y), depth.ptr<float>(y), raw.cols, options.kind, range));
        }
    });
    fillRows(depth, known);
}

// ------------------------------------------------------------------------------------ fitDepth

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

// ---------------------------------------------------------------------------------------- RGB-D

bool isBeside(DepthSide side) {
    return side == DepthSide::Right || side == DepthSide::Left;
}

// Where the halves lie, for a half's size and the whole's.
struct Halves {
    cv::Rect photo;
    cv::Rect depth;
};
Halves halvesOf(DepthSide side, cv::Size half, cv::Size whole) {
    const cv::Rect first(cv::Point(0, 0), half);
    const cv::Rect last(cv::Point(whole.width - half.width, whole.height - half.height), half);
    const bool isDepthLast = side == DepthSide::Right || side == DepthSide::Bottom;
    return isDepthLast ? Halves{first, last} : Halves{last, first};
}

template <typename T>
void greyOf(const cv::Mat& bgr, cv::Mat& grey) {
    for (int y = 0; y < bgr.rows; ++y)
        greyRow(bgr.ptr<T>(y), grey.ptr<float>(y), bgr.cols);
}

} // namespace

void normalizeDepth(const cv::Mat& raw, cv::Mat& depth, const DepthNormalization& options) {
    checkType(raw, {CV_8UC1, CV_16UC1, CV_32FC1, CV_64FC1}, "depth",
              "one channel of 8-bit, 16-bit, float or double numbers");
    const auto isWithin = [](double value, double low, double high) {
        return value >= low && value <= high;
    };
    check(isWithin(options.lowPercentile, 0, 50), "lowPercentile",
          "is " + std::to_string(options.lowPercentile) + ", expected 0..50 %");
    check(isWithin(options.highPercentile, 50, 100), "highPercentile",
          "is " + std::to_string(options.highPercentile) + ", expected 50..100 %");
    check(isWithin(options.flatDepth, 0, 1), "flatDepth",
          "is " + std::to_string(options.flatDepth) + ", expected 0..1");
    // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): keeps raw alive if it is depth
    const cv::Mat source = raw;
    switch (source.depth()) {
    case CV_8U:
        normalize<std::uint8_t>(source, depth, options);
        break;
    case CV_16U:
        normalize<std::uint16_t>(source, depth, options);
        break;
    case CV_32F:
        normalize<float>(source, depth, options);
        break;
    default:
        normalize<double>(source, depth, options);
        break;
    }
}

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

void splitRgbd(const cv::Mat& picture, DepthSide side, cv::Mat& photo, cv::Mat& rawDepth) {
    checkType(picture, {CV_8UC3, CV_16UC3}, "RGB-D picture", "three channels of 8 or 16 bits");
    const cv::Mat source = picture;
    const cv::Size half(isBeside(side) ? source.cols / 2 : source.cols,
                        isBeside(side) ? source.rows : source.rows / 2);
    check(!half.empty(), "RGB-D picture",
          shape(source) + ", too small to split, expected at least 2 px " +
              (isBeside(side) ? "across" : "down"));
    const Halves halves = halvesOf(side, half, source.size());
    const cv::Mat photoHalf = source(halves.photo);
    const cv::Mat depthHalf = source(halves.depth);
    rawDepth.create(half, CV_32FC1);
    photo.create(half, CV_8UC3);
    if (source.depth() == CV_8U) {
        greyOf<std::uint8_t>(depthHalf, rawDepth);
        photoHalf.copyTo(photo);
    } else {
        greyOf<std::uint16_t>(depthHalf, rawDepth);
        for (int y = 0; y < half.height; ++y) {
            const std::uint16_t* from = photoHalf.ptr<std::uint16_t>(y);
            std::transform(from, from + 3 * half.width, photo.ptr<std::uint8_t>(y),
                           [](std::uint16_t value) { return toEightBits(value); });
        }
    }
}

void joinRgbd(const cv::Mat& photo, const cv::Mat& depth, DepthSide side, cv::Mat& picture) {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3");
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    check(photo.size() == depth.size(), "depth",
          shape(depth) + ", expected the photo's " + std::to_string(photo.cols) + " x " +
              std::to_string(photo.rows) + " px");
    const cv::Size half = photo.size();
    const cv::Size whole(isBeside(side) ? 2 * half.width : half.width,
                         isBeside(side) ? half.height : 2 * half.height);
    const Halves halves = halvesOf(side, half, whole);
    const cv::Mat first = photo; // keeps the samples if photo and picture are one object
    picture.create(whole, CV_8UC3);
    first.copyTo(picture(halves.photo));
    for (int y = 0; y < half.height; ++y) {
        const float* from = depth.ptr<float>(y);
        std::uint8_t* to = picture.ptr<std::uint8_t>(halves.depth.y + y) + 3 * halves.depth.x;
        for (int x = 0; x < half.width; ++x, to += 3) {
            std::fill_n(to, 3, toWhole<std::uint8_t>(from[x], 255.0f));
        }
    }
}

cv::Mat depthTo16Bit(const cv::Mat& depth) {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    cv::Mat result(depth.size(), CV_16UC1);
    for (int y = 0; y < depth.rows; ++y) {
        const float* from = depth.ptr<float>(y);
        std::transform(from, from + depth.cols, result.ptr<std::uint16_t>(y),
                       [](float value) { return toWhole<std::uint16_t>(value, 65535.0f); });
    }
    return result;
}

} // namespace altiro3D
