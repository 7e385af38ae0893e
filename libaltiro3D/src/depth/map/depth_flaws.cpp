// Measures how a depth map differs from its photo. Everything is counted in whole numbers, so the
// order of the threads does not matter.

#include "altiro3D/depth_map.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <numeric>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kReach = 7;               // edges of the photo are searched this far away, px
constexpr int kMaxRamp = 40;            // px on each side of the steepest place
constexpr float kMinHeight = 0.04F;     // lowest step, in units of depth
constexpr float kMinSlope = 0.004F;     // slope at its steepest place, per px
constexpr int kMinContrast = 30;        // contrast of the photo at a step, sum over px and channels
constexpr int kWeakContrast = 60;       // steps with less count less
constexpr std::int64_t kMinSteps = 100; // fewer may look alike by chance
constexpr int kEdgeReach = 4;           // px from a step to colours of its sides
constexpr int kEdgeContrast = 90;       // contrast of the sides, for the width of a photo's edge

// Counts of values in bins of equal width.
template <std::size_t kBins>
class Histogram {
  public:
    constexpr Histogram(double low, double binWidth) : low_(low), binWidth_(binWidth) {}
    void add(double value, std::int64_t weight) {
        const double bin = (value - low_) / binWidth_;
        count_[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))] += weight;
    }
    void add(const Histogram& other) {
        for (std::size_t i = 0; i < kBins; ++i)
            count_[i] += other.count_[i];
    }
    // The middle of the bin below which a part of all values lies; 0 without values.
    double quantile(double part) const {
        double total = 0;
        for (const std::int64_t count : count_)
            total += static_cast<double>(count);
        double sum = 0;
        for (std::size_t i = 0; i < kBins; ++i) {
            sum += static_cast<double>(count_[i]);
            if (sum > part * total) return low_ + (static_cast<double>(i) + 0.5) * binWidth_;
        }
        return 0;
    }

  private:
    double low_;
    double binWidth_;
    std::array<std::int64_t, kBins> count_{};
};

// Contrast of the photo across depth steps that face one way, by distance from the step.
struct Profile {
    std::array<std::int64_t, 2 * kReach + 1> contrast{};
    std::int64_t weight = 0;
};

// The side on which a step has its near surface.
enum Side : std::size_t { Right, Left, Below, Above };

struct Steps {
    std::int64_t count = 0;
    Histogram<660> width{0, 0.1};
    Histogram<500> tails{0, 0.001};
    std::int64_t edgeCount = 0;
    Histogram<100> edges{0, 0.1}; // widths of the photo's edges at the steps, px
    std::array<Profile, 4> profiles;

    void add(const Steps& other) {
        count += other.count;
        width.add(other.width);
        tails.add(other.tails);
        edgeCount += other.edgeCount;
        edges.add(other.edges);
        for (std::size_t side = 0; side < profiles.size(); ++side) {
            for (std::size_t t = 0; t < profiles[side].contrast.size(); ++t)
                profiles[side].contrast[t] += other.profiles[side].contrast[t];
            profiles[side].weight += other.profiles[side].weight;
        }
    }
};

// A row or a column of photo and depth.
struct Line {
    const float* depth;
    std::ptrdiff_t depthStride;
    const std::uint8_t* photo;
    std::ptrdiff_t photoStride;
    int length;

    float at(int x) const { return depth[x * depthStride]; }
    float slope(int x) const { return at(x + 1) - at(x); }
    // Linear between px.
    float between(float x) const {
        const float inside = std::clamp(x, 0.0F, static_cast<float>(length - 1));
        const int left = std::min(static_cast<int>(inside), length - 2);
        return at(left) + slope(left) * (inside - static_cast<float>(left));
    }
    // Difference of two px of the photo, summed over the channels.
    int contrast(int x, int other) const {
        const std::uint8_t* const here = photo + x * photoStride;
        const std::uint8_t* const there = photo + other * photoStride;
        return std::abs(here[0] - there[0]) + std::abs(here[1] - there[1]) +
               std::abs(here[2] - there[2]);
    }
};

//                    __________ at(high)        A step is the run of equal slope signs around a
//                   /                           steepest place x that are at least a tenth as
//        __________/                            steep. Its width is its height / largest slope.
//          at(low)
void measureStep(const Line& line, int x, float least, Side rising, Steps& steps) {
    const float slope = line.slope(x);
    const float steepest = std::abs(slope);
    const float sign = slope > 0 ? 1.0F : -1.0F;
    if (line.slope(x - 1) * sign > steepest || line.slope(x + 1) * sign >= steepest) return;
    int low = x;
    int high = x + 1;
    const auto isRamp = [&](int i) { return line.slope(i) * sign > 0.1F * steepest; };
    while (low > 0 && x - low < kMaxRamp && isRamp(low - 1))
        --low;
    while (high + 1 < line.length && high - x < kMaxRamp && isRamp(high))
        ++high;
    const float height = std::abs(line.at(high) - line.at(low));
    if (height < least) return;
    if (x - low == kMaxRamp || high - x == kMaxRamp) return; // a slope
    const float middle = (line.at(low) + line.at(high)) / 2;
    int border = low; // between this px and the next
    while (border + 1 < high && (middle - line.at(border + 1)) * sign > 0)
        ++border;
    if (border < kReach || border + 1 + kReach >= line.length) return;
    std::array<int, 2 * kReach + 1> contrast{};
    int sum = 0;
    for (int t = -kReach; t <= kReach; ++t) {
        const int value = line.contrast(border + t, border + t + 1);
        contrast[static_cast<std::size_t>(t + kReach)] = value;
        sum += value;
    }
    if (sum < kMinContrast) return; // the photo shows no edge
    const float width = height / steepest;
    // Slopes are many, but wide; ripples of cubic enlargement are narrow, but low.
    const auto weight = static_cast<std::int64_t>(std::min(height, 0.3F) / width * 1e4F);
    const auto shapeWeight = static_cast<std::int64_t>(static_cast<float>(weight) * height * 1e2F);
    ++steps.count;
    steps.width.add(static_cast<double>(width), shapeWeight);
    const float half = width / 2;
    const float centre = static_cast<float>(border) +
                         std::clamp((middle - line.at(border)) / line.slope(border), 0.0F, 1.0F);
    const float core = (line.between(centre + half) - line.between(centre - half)) * sign;
    steps.tails.add(static_cast<double>(1 - core / height), shapeWeight);
    Profile& profile = steps.profiles[slope > 0 ? rising : rising + 1U];
    for (std::size_t t = 0; t < contrast.size(); ++t)
        profile.contrast[t] += weight * 1024 * contrast[t] / (sum + kWeakContrast);
    profile.weight += weight * 1024;
    const int across = line.contrast(border - kEdgeReach, border + 1 + kEdgeReach);
    if (across < kEdgeContrast) return;
    const auto middleOfProfile = contrast.begin() + kReach;
    const int steepestEdge =
        *std::max_element(middleOfProfile - kEdgeReach, middleOfProfile + kEdgeReach + 1);
    ++steps.edgeCount;
    steps.edges.add(static_cast<double>(across) / steepestEdge, weight);
}

void measureLine(const Line& line, float least, Side rising, Steps& steps) {
    for (int x = 1; x + 2 < line.length; ++x) {
        if (std::abs(line.slope(x)) >= kMinSlope) measureStep(line, x, least, rising, steps);
    }
}

// Runs over all lines; each part of them has its own counts.
template <class Work>
Steps overLines(int lines, const Work& work) {
    Steps all;
    std::mutex mutex;
    cv::parallel_for_(cv::Range(0, lines), [&](const cv::Range& range) {
        Steps part;
        for (int i = range.start; i < range.end; ++i)
            work(i, part);
        const std::lock_guard<std::mutex> lock(mutex);
        all.add(part);
    });
    return all;
}

Steps findSteps(const cv::Mat& photo, const cv::Mat& depth, float least) {
    const auto depthStep = static_cast<std::ptrdiff_t>(depth.step1());
    const auto photoStep = static_cast<std::ptrdiff_t>(photo.step1());
    Steps steps = overLines(depth.rows, [&](int y, Steps& part) {
        measureLine({depth.ptr<float>(y), 1, photo.ptr<std::uint8_t>(y), 3, depth.cols}, least,
                    Right, part);
    });
    steps.add(overLines(depth.cols, [&](int x, Steps& part) {
        measureLine({depth.ptr<float>(0) + x, depthStep,
                     photo.ptr<std::uint8_t>(0) + 3 * static_cast<std::ptrdiff_t>(x), photoStep,
                     depth.rows},
                    least, Below, part);
    }));
    return steps;
}

// Contrast of the photo where the steps would be after correction of growth and shift, relative to
// the whole contrast around them.
class Alignment {
  public:
    explicit Alignment(const std::array<Profile, 4>& profiles) {
        double mean = 0;
        for (const Profile& profile : profiles)
            mean += static_cast<double>(profile.weight) / 4;
        for (std::size_t side = 0; side < 4; ++side) {
            // sides with few steps count less
            const double all = static_cast<double>(profiles[side].weight) + 0.2 * mean + 1e-9;
            for (std::size_t t = 0; t < share_[side].size(); ++t)
                share_[side][t] = static_cast<double>(profiles[side].contrast[t]) / all;
        }
    }
    double at(int growth, cv::Point shift) const {
        return share(Right, growth - shift.x) + share(Left, -growth - shift.x) +
               share(Below, growth - shift.y) + share(Above, -growth - shift.y);
    }

  private:
    double share(Side side, int distance) const {
        return share_[side]
                     [static_cast<std::size_t>(std::clamp(distance, -kReach, kReach) + kReach)];
    }
    std::array<std::array<double, 2 * kReach + 1>, 4> share_{};
};

// @param longerSide of the map, px
void measureSoftness(const Steps& steps, int longerSide, DepthFlaws& flaws) {
    constexpr double kHardWidth = 1.05; // middle of the bin
    constexpr double kMinSoftness = 0.35;
    constexpr double kUneven = 2.2;   // blurred and enlarged depth has less, networks' mostly more
    constexpr double kUnevenHard = 4; // beside hard steps
    constexpr double kMaxUneven = 0.04; // softness of uneven steps, of the longer side
    const auto softness = [&](double part) { return steps.width.quantile(part) - kHardWidth; };
    if (softness(0.5) < kMinSoftness) return;
    const double narrow = steps.width.quantile(0.1);
    const bool someAreHard = narrow - kHardWidth < kMinSoftness;
    flaws.isUneven = steps.width.quantile(0.5) > kUneven * narrow ||
                     (someAreHard && steps.width.quantile(0.75) > kUnevenHard * narrow);
    if (flaws.isUneven) {
        flaws.softnessPixels = std::min(softness(0.8), kMaxUneven * longerSide);
    } else {
        flaws.softnessPixels = std::max(softness(0.3), kMinSoftness);
        // Enlargement leaves shorter tails. Those of hardly soft steps always look longer.
        const double tailsOfBlur = std::max(0.175, 0.25 - 0.03 * flaws.softnessPixels);
        flaws.isBlurred = steps.tails.quantile(0.25) >= tailsOfBlur;
    }
    flaws.softnessPixels = std::min(flaws.softnessPixels, 64.0);
}

// Edges of sharp photos are 1 to 2 px wide; a Gaussian blur of sigma s leaves about 2.4 s px.
void measureMixedPixels(const Steps& steps, DepthFlaws& flaws) {
    constexpr double kSoftEdge = 2.8;     // sigma 1.2 px; sharper photos would lose
    constexpr double kVerySoftEdge = 5.2; // sigma 2.4 px
    if (steps.edgeCount < kMinSteps) return;
    const double width = steps.edges.quantile(0.25);
    flaws.mixedPixels = width >= kVerySoftEdge ? 2 : (width >= kSoftEdge ? 1 : 0);
}

struct Displacement {
    int growth = 0;
    cv::Point shift;
};

// @param mostGrowth 0 to find shifts alone
Displacement bestDisplacement(const Alignment& alignment, int mostGrowth) {
    constexpr double kMinGain = 1.1; // gain of the alignment that justifies a correction
    double best = kMinGain * alignment.at(0, {});
    Displacement found;
    for (int g = -mostGrowth; g <= mostGrowth; ++g) {
        for (int y = -3; y <= 3; ++y) {
            for (int x = -3; x <= 3; ++x) {
                // the simplest explanation wins if several are about as good
                const double doubt = 0.01 * std::abs(g) + 0.03 * (std::abs(x) + std::abs(y));
                const double value = alignment.at(g, {x, y}) * (1 - doubt);
                if (value <= best) continue;
                best = value;
                found = {g, {x, y}};
            }
        }
    }
    return found;
}

// The growth with its fraction, from a parabola through three values. It is measured along rows and
// columns, where oblique edges move farther than across themselves, on average by 15 %.
double exactGrowth(const Alignment& alignment, const Displacement& found) {
    if (found.growth == 0) return 0;
    const double before = alignment.at(found.growth - 1, found.shift);
    const double here = alignment.at(found.growth, found.shift);
    const double after = alignment.at(found.growth + 1, found.shift);
    const double bend = before - 2 * here + after;
    const double fraction = bend < 0 ? std::clamp((before - after) / (2 * bend), -0.5, 0.5) : 0;
    return (found.growth + fraction) / 1.15;
}

void findDisplacement(const Steps& steps, DepthFlaws& flaws) {
    constexpr double kMinGrowth = 0.7; // less is also found in exact depth
    const Alignment alignment(steps.profiles);
    Displacement found = bestDisplacement(alignment, 4);
    flaws.growthPixels = exactGrowth(alignment, found);
    if (std::abs(flaws.growthPixels) < kMinGrowth) {
        flaws.growthPixels = 0;
        found = bestDisplacement(alignment, 0);
    }
    flaws.shiftPixels = found.shift;
}

constexpr int kSide = 64;                  // places per row and column
constexpr int kBorder = kSide / 8;         // width of the border
constexpr int kMiddle = kSide / 4;         // the middle begins here
constexpr double kMaxContradiction = -0.3; // correlation of a contradiction
constexpr double kMinSpread = 0.02;        // standard deviation of depth that has a direction

using Samples = std::vector<double>; // [kSide * kSide], by rows

Samples samplesOf(const cv::Mat& depth) {
    const cv::Mat sampled = sampledDepth(depth, {kSide, kSide});
    return {sampled.begin<float>(), sampled.end<float>()};
}

double meanOf(const Samples& samples) {
    return std::accumulate(samples.begin(), samples.end(), 0.0) /
           static_cast<double>(samples.size());
}

// The mean product of the deviations from the means.
double covariance(const Samples& a, const Samples& b) {
    const double meanA = meanOf(a);
    const double meanB = meanOf(b);
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - meanA) * (b[i] - meanB);
    return sum / static_cast<double>(a.size());
}

// -1..1; 0 if one of them is constant
double correlation(const Samples& a, const Samples& b) {
    const double spread = std::sqrt(covariance(a, a) * covariance(b, b));
    return spread > 0 ? covariance(a, b) / spread : 0;
}

Samples rowNumbers() {
    Samples rows;
    for (int row = 0; row < kSide; ++row)
        rows.insert(rows.end(), kSide, row);
    return rows;
}

bool isBorderNearer(const Samples& depth) {
    Samples border;
    Samples middle;
    const auto isInside = [](int i, int margin) { return i >= margin && i < kSide - margin; };
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            const double sample = depth[static_cast<std::size_t>(y * kSide + x)];
            if (isInside(y, kMiddle) && isInside(x, kMiddle)) middle.push_back(sample);
            const bool isBorder = !isInside(y, kBorder) || !isInside(x, kBorder);
            if (isBorder && y < kSide / 2) border.push_back(sample);
        }
    }
    return meanOf(border) > meanOf(middle);
}

} // namespace

DepthFlaws measureDepthFlaws(const cv::Mat& photo, const cv::Mat& depth) try {
    checkPhotoAndDepth(photo, depth, "depth", "CV_32FC1");
    DepthFlaws flaws;
    const Steps steps = findSteps(photo, withinRange(depth), kMinHeight);
    if (steps.count < kMinSteps) return flaws;
    measureSoftness(steps, std::max(depth.cols, depth.rows), flaws);
    findDisplacement(steps, flaws);
    measureMixedPixels(steps, flaws);
    return flaws;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

bool looksInverted(const cv::Mat& depth, const std::function<cv::Mat()>& estimate) try {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    checkFunction(estimate, "estimate");
    const Samples samples = samplesOf(depth);
    if (std::sqrt(covariance(samples, samples)) < kMinSpread) return false;
    if (correlation(samples, rowNumbers()) > kMaxContradiction || !isBorderNearer(samples))
        return false;
    const cv::Mat estimated = estimate();
    if (!estimated.empty()) checkType(estimated, {CV_32FC1}, "estimate", "CV_32FC1");
    return !estimated.empty() && correlation(samples, samplesOf(estimated)) <= kMaxContradiction;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
