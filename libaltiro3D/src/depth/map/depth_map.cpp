#include "altiro3D/depth_map.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "depth/map/depth_values.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <opencv2/core.hpp>
#include <type_traits>
#include <vector>

namespace altiro3D {

namespace {

// Properties of a sample: whether it is known, its sort key, its inverse depth.
template <typename T>
bool isKnown(T value, DepthKind kind) {
    if (kind == DepthKind::Metric) return value > 0; // +inf is valid: infinitely far
    if constexpr (std::is_floating_point_v<T>) return std::isfinite(value);
    return true;
}

// Larger = nearer.
double nearness(double value, DepthKind kind) {
    return kind == DepthKind::Metric     ? std::min(1.0 / value, DBL_MAX)
           : kind == DepthKind::FarWhite ? -value
                                         : value;
}

// Keys: unsigned numbers in the same order as the samples.
template <typename T>
using Key = std::conditional_t<sizeof(T) == 8, std::uint64_t,
                               std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint16_t>>;
template <typename T>
constexpr Key<T> kSign = static_cast<Key<T>>(Key<T>{1} << (8 * sizeof(Key<T>) - 1));

template <typename T>
Key<T> keyOf(T value) {
    if constexpr (std::is_integral_v<T>) {
        return value;
    } else {
        Key<T> bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        return (bits & kSign<T>) != 0 ? ~bits : bits | kSign<T>;
    }
}

template <typename T>
T valueOf(Key<T> key) {
    if constexpr (std::is_integral_v<T>) {
        return static_cast<T>(key);
    } else {
        const Key<T> bits = (key & kSign<T>) != 0 ? key & ~kSign<T> : ~key;
        T value = 0;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }
}

constexpr int kDigitBits = 16;
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;

using Histogram = std::vector<std::uint32_t>; // pictures have fewer than 2^32 px

// Counts the known samples by one digit of their keys, only those whose higher digits are `prefix`.
// Sums of whole numbers do not depend on the distribution of rows to threads.
template <typename T>
Histogram countDigits(const cv::Mat& raw, DepthKind kind, int shift, std::uint64_t prefix) {
    constexpr int kKeyBits = static_cast<int>(sizeof(Key<T>) * 8);
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
    // A histogram costs as much as about 60 thousand samples.
    const double stripes = std::clamp(static_cast<double>(raw.total()) / 500000, 1.0,
                                      static_cast<double>(std::max(1, cv::getNumThreads())));
    cv::parallel_for_(cv::Range(0, raw.rows), count, std::floor(stripes));
    return total;
}

// Finds the digit that contains the rank, makes the rank relative to it and returns the digit.
std::uint64_t findDigit(const Histogram& histogram, std::uint64_t& rank) {
    for (std::size_t digit = 0; digit < kDigits; ++digit) {
        if (rank < histogram[digit]) return digit;
        rank -= histogram[digit];
    }
    return kDigits - 1;
}

struct Range {
    bool isFlat = true;
    double low = 0;  // half of the nearness that maps to 0
    double span = 0; // half of the nearness range that maps to 0..1
};

// The known sample of a rank. Exact; uses one histogram per 16 bits of the key.
template <typename T>
T sampleOfRank(const cv::Mat& raw, DepthKind kind, std::uint64_t rank, const Histogram& first) {
    constexpr int kKeyBits = static_cast<int>(sizeof(Key<T>) * 8);
    std::uint64_t prefix = findDigit(first, rank);
    for (int shift = kKeyBits - 2 * kDigitBits; shift >= 0; shift -= kDigitBits) {
        const Histogram digits = countDigits<T>(raw, kind, shift, prefix);
        prefix = prefix << kDigitBits | findDigit(digits, rank);
    }
    return valueOf<T>(static_cast<Key<T>>(prefix));
}

template <typename T>
Range findRange(const cv::Mat& raw, const DepthNormalization& options) {
    constexpr int kFirstShift = static_cast<int>(sizeof(Key<T>) * 8) - kDigitBits;
    const Histogram first = countDigits<T>(raw, options.kind, kFirstShift, 0);
    const std::uint64_t known = std::accumulate(first.begin(), first.end(), std::uint64_t{0});
    Range range;
    if (known == 0) return range;
    // Ranks are rounded outwards, so small pictures keep their full range. Ranks count from far to
    // near; if large numbers are far, the order of the samples is reversed.
    const double last = static_cast<double>(known - 1);
    auto lowRank = static_cast<std::uint64_t>(std::floor(options.lowPercentile / 100 * last));
    auto highRank = static_cast<std::uint64_t>(std::ceil(options.highPercentile / 100 * last));
    highRank = std::min(highRank, known - 1);
    if (options.kind != DepthKind::NearWhite) {
        lowRank = known - 1 - lowRank;
        highRank = known - 1 - highRank;
    }
    // Halves, because the difference of two large numbers may overflow.
    const auto half = [&](std::uint64_t rank) {
        const T sample = sampleOfRank<T>(raw, options.kind, rank, first);
        return 0.5 * nearness(static_cast<double>(sample), options.kind);
    };
    range.low = half(lowRank);
    const double high = half(highRank);
    range.span = high - range.low;
    // A float has 24 bits, so a computed constant varies by about 1e-7 of itself. Denormal ranges
    // depend on the processor's settings.
    constexpr double kNoise = 1e-6;
    const bool isFloat = std::is_same_v<T, float> && options.kind != DepthKind::Metric;
    const double smallest = isFloat ? static_cast<double>(FLT_MIN) : DBL_MIN;
    const double largest = std::max(std::abs(range.low), std::abs(high));
    range.isFlat = !(range.span > kNoise * largest && range.span >= smallest);
    return range;
}

// Position of a known sample in the range, 0..1.
template <typename T>
float placeOf(T value, DepthKind kind, const Range& range) {
    const double place =
        (0.5 * nearness(static_cast<double>(value), kind) - range.low) / range.span;
    return static_cast<float>(std::min(std::max(place, 0.0), 1.0));
}

// The positions of all values of an 8-bit or 16-bit sample.
template <typename T>
std::vector<float> placesOf(DepthKind kind, const Range& range) {
    std::vector<float> places(std::size_t{std::numeric_limits<T>::max()} + 1);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const T value = static_cast<T>(i);
        if (isKnown(value, kind)) places[i] = placeOf(value, kind, range);
    }
    return places;
}

// Maps one row to 0..1 and fills unknown samples from their neighbours; false if none is known.
template <typename T, typename Place>
bool normalizeRow(const T* raw, float* depth, int columns, DepthKind kind, const Place& place) {
    int lastKnown = -1;
    for (int x = 0; x < columns; ++x) {
        const T value = raw[x];
        if (!isKnown(value, kind)) continue;
        const float result = place(value);
        if (lastKnown + 1 < x) {
            // The farther neighbour: what the sensor does not see is behind what it sees.
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

template <typename T, typename Place>
void normalizeRows(const cv::Mat& raw, cv::Mat& depth, DepthKind kind, const Place& place) {
    std::vector<char> known(static_cast<std::size_t>(raw.rows), 0);
    overRows(raw.rows, [&](int y) {
        known[static_cast<std::size_t>(y)] = static_cast<char>(
            normalizeRow(raw.ptr<T>(y), depth.ptr<float>(y), raw.cols, kind, place));
    });
    fillUnknownRows(depth, known);
}

template <typename T>
void normalize(const cv::Mat& raw, cv::Mat& depth, const DepthNormalization& options) {
    const Range range = findRange<T>(raw, options);
    depth.create(raw.size(), CV_32FC1);
    if (range.isFlat) {
        depth.setTo(options.flatDepth);
        return;
    }
    if constexpr (std::is_integral_v<T>) {
        if (raw.total() >> (8 * sizeof(T)) > 0) { // more samples than values: a table is faster
            const std::vector<float> places = placesOf<T>(options.kind, range);
            normalizeRows<T>(raw, depth, options.kind, [&](T value) { return places[value]; });
            return;
        }
    }
    normalizeRows<T>(raw, depth, options.kind,
                     [&](T value) { return placeOf(value, options.kind, range); });
}

} // namespace

void checkDepthRange(const cv::Mat& depth) {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    constexpr float kBeyond = 0.1F;
    const int step = depth.rows / 64 + 1;
    std::int64_t known = 0;
    std::int64_t outside = 0;
    float least = std::numeric_limits<float>::max();
    float most = -least;
    for (int y = step / 2; y < depth.rows; y += step) {
        const float* const row = depth.ptr<float>(y);
        for (int x = 0; x < depth.cols; ++x) {
            const float value = row[x];
            if (!std::isfinite(value)) continue;
            ++known;
            if (value < -kBeyond || value > 1 + kBeyond) ++outside;
            least = std::min(least, value);
            most = std::max(most, value);
        }
    }
    check(outside * 2 <= known, "depth",
          "has values of " + numberText(static_cast<double>(least)) + ".." +
              numberText(static_cast<double>(most)) +
              ", expected 0..1, 1 = nearest; normalizeDepth() (in Python: normalize_depth()) makes "
              "such depth of other numbers");
}

int unknownFarthest(const cv::Mat& raw) {
    if (raw.type() != CV_16UC1) return 0;
    cv::Mat found;
    cv::inRange(raw, 64880, 65534, found); // within 1 %
    if (cv::countNonZero(found) > 0) return 0;
    cv::inRange(raw, 65535, 65535, found);
    return cv::countNonZero(found);
}

void normalizeDepth(const cv::Mat& raw, cv::Mat& depth, const DepthNormalization& options) try {
    checkType(raw, {CV_8UC1, CV_16UC1, CV_32FC1, CV_64FC1}, "depth",
              "one channel of 8-bit, 16-bit, float or double numbers");
    checkRange("lowPercentile", options.lowPercentile, 0, 50, " %");
    checkRange("highPercentile", options.highPercentile, 50, 100, " %");
    checkRange("flatDepth", options.flatDepth, 0, 1);
    cv::Mat source = raw;
    if (options.kind == DepthKind::Metric && unknownFarthest(raw) > 0) {
        source = raw.clone();
        source.setTo(0, raw == 65535);
    }
    if (source.depth() == CV_8U) return normalize<std::uint8_t>(source, depth, options);
    if (source.depth() == CV_16U) return normalize<std::uint16_t>(source, depth, options);
    if (source.depth() == CV_32F) return normalize<float>(source, depth, options);
    normalize<double>(source, depth, options);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Mat depthTo16Bit(const cv::Mat& depth) try {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    return mapped<float, std::uint16_t>(
        depth, [](float value) { return toWhole<std::uint16_t>(value, 65535.0f); });
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Mat bendDepth(const cv::Mat& depth, double exponent) try {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    checkRange("exponent", exponent, 0.5, 2);
    if (exponent == 1) return depth;
    // Rounded, because the last digits of pow() differ from processor to processor.
    constexpr int kSteps = 16384;
    constexpr double kUnit = 1 << 23;
    std::vector<float> curve(kSteps + 2, 1.0F);
    for (int i = 0; i < kSteps; ++i) {
        const double value = std::pow(static_cast<double>(i) / kSteps, exponent);
        curve[static_cast<std::size_t>(i)] = static_cast<float>(std::round(value * kUnit) / kUnit);
    }
    return mapped<float, float>(depth, [&curve](float value) {
        if (std::isnan(value)) return value;
        const float place = withinRange(value) * kSteps;
        const auto i = static_cast<std::size_t>(place);
        return curve[i] + (place - static_cast<float>(i)) * (curve[i + 1] - curve[i]);
    });
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
