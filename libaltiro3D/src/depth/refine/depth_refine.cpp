#include "altiro3D/depth_map.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "depth/map/depth_values.hpp"
#include "depth/refine/depth_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kBorder = cv::BORDER_REPLICATE | cv::BORDER_ISOLATED;

void validate(const DepthFlaws& flaws) {
    checkRange("softness", flaws.softnessPixels, 0, 64, " px");
    checkRange("growth", flaws.growthPixels, -7, 7, " px");
    checkRange("shift", flaws.shiftPixels.x, -7, 7, " px");
    checkRange("shift", flaws.shiftPixels.y, -7, 7, " px");
    checkRange("mixed px", flaws.mixedPixels, 0, 7, " px");
}

// Moves the map back; px at the border are repeated.
cv::Mat unshifted(const cv::Mat& depth, cv::Point shift) {
    const int margin = std::max(std::abs(shift.x), std::abs(shift.y));
    cv::Mat wide;
    cv::copyMakeBorder(depth, wide, margin, margin, margin, margin, kBorder);
    return wide(cv::Rect({margin + shift.x, margin + shift.y}, depth.size())).clone();
}

// Makes near things smaller on each side, larger if negative.
void shrinkNear(cv::Mat& depth, int pixels) {
    const int side = 2 * std::abs(pixels) + 1;
    const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
    cv::Mat result;
    if (pixels > 0) cv::erode(depth, result, disc, {-1, -1}, 1, kBorder);
    if (pixels < 0) cv::dilate(depth, result, disc, {-1, -1}, 1, kBorder);
    depth = result;
}

// The weights of a Gaussian from its middle to one side.
std::vector<float> gaussian(double sigma) {
    const int radius = std::max(1, static_cast<int>(std::ceil(2.5 * sigma)));
    std::vector<float> half;
    double sum = 0;
    for (int k = 0; k <= radius; ++k) {
        const double weight = std::exp(-k * k / (2 * sigma * sigma));
        half.push_back(static_cast<float>(weight));
        sum += k == 0 ? weight : 2 * weight;
    }
    for (float& weight : half)
        weight = static_cast<float>(static_cast<double>(weight) / sum);
    return half;
}

// Columns of depth, blurred; px at the border are repeated.
void blurDown(const cv::Mat& depth, const std::vector<float>& half, cv::Mat& blurred) {
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        std::vector<const float*> above(half.size());
        std::vector<const float*> below(half.size());
        for (int y = range.start; y < range.end; ++y) {
            for (std::size_t k = 1; k < half.size(); ++k) {
                const int distance = static_cast<int>(k);
                above[k] = depth.ptr<float>(std::max(y - distance, 0));
                below[k] = depth.ptr<float>(std::min(y + distance, depth.rows - 1));
            }
            filterRow(depth.ptr<float>(y), above.data(), below.data(), half.data(), half.size() - 1,
                      static_cast<std::size_t>(depth.cols), blurred.ptr<float>(y));
        }
    });
}

// Undoes most of a Gaussian blur (van Cittert 1931): thin things get their height back.
// @param depth equal to `given` @param buffer of the same size
void deblur(const cv::Mat& given, double sigma, cv::Mat& depth, cv::Mat& buffer) {
    const std::vector<float> half = gaussian(sigma);
    const std::size_t reach = half.size() - 1;
    const auto count = static_cast<std::size_t>(depth.cols);
    constexpr int kPasses = 3;
    for (int pass = 0; pass < kPasses; ++pass) {
        blurDown(depth, half, buffer);
        cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
            std::vector<float> row(count + 2 * reach); // the border repeated on both sides
            std::vector<float> soft(count);
            std::vector<const float*> before(half.size());
            std::vector<const float*> after(half.size());
            float* const middle = row.data() + reach;
            for (std::size_t k = 1; k <= reach; ++k) {
                before[k] = row.data() + (reach - k);
                after[k] = middle + k;
            }
            for (int y = range.start; y < range.end; ++y) {
                const auto* const columns = buffer.ptr<float>(y);
                std::fill_n(row.data(), reach, columns[0]);
                std::copy_n(columns, count, middle);
                std::fill_n(middle + count, reach, columns[count - 1]);
                filterRow(middle, before.data(), after.data(), half.data(), reach, count,
                          soft.data());
                const auto* const from = given.ptr<float>(y);
                auto* const to = depth.ptr<float>(y);
                for (std::size_t x = 0; x < count; ++x)
                    to[x] = std::clamp(to[x] + (from[x] - soft[x]), 0.0F, 1.0F);
            }
        });
    }
}

// Takes deblurred depth back where the given depth is steeper than a blur leaves it: there a hard
// step would get a rim on both sides. Formula (4.7a) of docs/mathematics.md.
void keepHardSteps(const cv::Mat& given, double sigma, Surroundings& around, cv::Mat& depth) {
    constexpr float kSoft = 1.8F; // a blurred step has 1, a blurred line 1.5
    constexpr float kHard = 2.4F;
    around.find(given, static_cast<int>(std::lround(2 * sigma)));
    const auto stepWidth = static_cast<float>(std::sqrt(2 * CV_PI) * sigma);
    overRows(depth.rows, [&](int y) {
        const auto* const least = around.least.ptr<float>(y);
        const auto* const most = around.most.ptr<float>(y);
        const auto* const steepest = around.steepest.ptr<float>(y);
        const auto* const from = given.ptr<float>(y);
        auto* const to = depth.ptr<float>(y);
        for (int x = 0; x < depth.cols; ++x) {
            const float height = most[x] - least[x];
            const float slope2 = steepest[x] * stepWidth * stepWidth;
            if (slope2 <= kSoft * kSoft * height * height) continue; // most px
            const float hardness = std::sqrt(slope2) / height;
            const float keep = std::clamp((hardness - kSoft) / (kHard - kSoft), 0.0F, 1.0F);
            to[x] += keep * (from[x] - to[x]);
        }
    });
}

// How the px of a step are decided.
struct StepRule {
    double width;    // width of the steps, px
    int radius;      // radius of the window that decides on a px
    float part;      // px within this part of a step's height from its middle are decided
    float minHeight; // lowest step, in units of depth
};

// The neighbourhood of a px that decides to which side it belongs.
std::vector<StepNeighbour> windowOf(const StepRule& rule) {
    std::vector<StepNeighbour> taps;
    const int radius = rule.radius;
    constexpr int kSamples = 6; // at most, on each side of the px
    const int stride = (radius + kSamples - 1) / kSamples;
    const int reach = radius / stride * stride;
    for (int y = -reach; y <= reach; y += stride) {
        for (int x = -reach; x <= reach; x += stride) {
            const double square = x * x + y * y;
            taps.push_back({x, y, static_cast<float>(std::exp(-square / (2.0 * radius * radius)))});
        }
    }
    return taps;
}

// Measured on the scenes of docs/lab/views.md.
constexpr float kWholeStep = 1;  // px farther from the middle belong to something else
constexpr float kMiddle = 0.3F;  // px that are left between the sides after the first pass
constexpr double kLeftWidth = 2; // width of what is left
constexpr float kSimilar = 0.8F; // a px that is so similar to both sides is no edge

// In a wide window, lower steps are slopes of a surface.
constexpr double kMinHeight = 0.03; // lowest step, in units of depth
constexpr double kMinHeightOfWide = 0.08;
constexpr double kMinHeightPerPixel = 0.006;

// The rule for equally soft steps of a width: the depth has them at accurate places.
StepRule evenRule(double width) {
    const int radius = std::max(2, static_cast<int>(std::lround(0.9 * width)));
    const double least = std::clamp(kMinHeightPerPixel * width, kMinHeight, kMinHeightOfWide);
    return {width, radius, kWholeStep, static_cast<float>(least)};
}

// The depth of a px in a step: 0 far, 1 near, from its own place between the sides and its colour.
float sideOf(float place, const StepSide& nearSide, const StepSide& farSide) {
    constexpr float kFloor = 0.02F;   // limits how much the photo may contradict
    constexpr float kDepthWeight = 6; // weight of the place; the colour counts once
    const double color =
        std::log(static_cast<double>((nearSide.color + kFloor) / (farSide.color + kFloor)));
    const double side = static_cast<double>(kDepthWeight * (2 * place - 1)) + color;
    return static_cast<float>((std::clamp(side, -1.0, 1.0) + 1) / 2);
}

class Sharpener {
  public:
    // @param given the depth that stays where the photo has no edge
    // @param sides the depth of which steps are made, and the photo
    // @param around surroundings of each px within rule.radius
    Sharpener(const cv::Mat& given, const StepRule& rule, const StepSides& sides,
              const Surroundings& around)
        : given_(given), depth_(sides.depth()), rule_(rule), sides_(sides), around_(around) {}

    // @param to row y of the result, which holds the depth
    void row(int y, StepBuffers& buffers, float* to) const {
        if (!findSteps(y, buffers)) return;
        sides_.sum(y, buffers);
        for (int x = 0; x < depth_.cols; ++x) {
            if (buffers.wanted[static_cast<std::size_t>(x)] != 0) to[x] = pixel(x, y, buffers);
        }
    }

  private:
    // Marks the px of a row that may have to be decided. @return whether there are any
    bool findSteps(int y, StepBuffers& buffers) const {
        const auto* const least = around_.least.ptr<float>(y);
        const auto* const most = around_.most.ptr<float>(y);
        const auto* const steepest = around_.steepest.ptr<float>(y);
        const auto* const depth = depth_.ptr<float>(y);
        const float ramp = 1.5F * (static_cast<float>(rule_.width) + 1);
        // The means of the sides lie in their halves of least..most, so px that are farther from
        // the middle than this are not within rule_.part.
        constexpr float kRounding = 0.01F;
        const float reach = rule_.part + 0.5F + kRounding;
        bool any = false;
        for (int x = 0; x < depth_.cols; ++x) {
            const auto at = static_cast<std::size_t>(x);
            const float height = most[x] - least[x];
            buffers.wanted[at] = 0;
            // A slope is not a step: it is higher than a step of this width and slope.
            if (height < rule_.minHeight || height * height > ramp * ramp * steepest[x]) continue;
            const float middle = (most[x] + least[x]) / 2;
            const float scale = 2 / height;
            if (std::abs(depth[x] - middle) * scale > reach) continue;
            buffers.wanted[at] = 1;
            buffers.middle[at] = middle;
            buffers.scale[at] = scale;
            any = true;
        }
        return any;
    }

    float pixel(int x, int y, const StepBuffers& buffers) const {
        const auto at = static_cast<std::size_t>(x);
        const float here = depth_.ptr<float>(y)[x];
        if (!buffers.nearSide.has(at) || !buffers.farSide.has(at)) return here;
        const StepSide nearSide = buffers.nearSide.mean(at);
        const StepSide farSide = buffers.farSide.mean(at);
        if (!(nearSide.depth > farSide.depth)) return here; // equal but for rounding
        const float place = (here - farSide.depth) / (nearSide.depth - farSide.depth);
        if (std::abs(place - 0.5F) > rule_.part) return here;
        if (nearSide.color > kSimilar && farSide.color > kSimilar) return given_.ptr<float>(y)[x];
        return farSide.depth + (nearSide.depth - farSide.depth) * sideOf(place, nearSide, farSide);
    }

    cv::Mat given_;
    cv::Mat depth_;
    StepRule rule_;
    const StepSides& sides_;
    const Surroundings& around_;
};

// Smooths the contours of steps that were moved: each px that has moved becomes the median of the
// 3 x 3 px around it; px at the border are repeated.
// @param given the depth map before
void smoothContours(const cv::Mat& given, cv::Mat& depth) {
    constexpr float kMoved = 0.005F;
    cv::Mat buffer;
    cv::medianBlur(depth, buffer, 3);
    overRows(depth.rows, [&](int y) {
        const auto* const before = given.ptr<float>(y);
        const auto* const medians = buffer.ptr<float>(y);
        auto* const row = depth.ptr<float>(y);
        for (int x = 0; x < depth.cols; ++x)
            row[x] = std::abs(row[x] - before[x]) > kMoved ? medians[x] : row[x];
    });
}

} // namespace

DepthFlaws refineDepth(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& refined,
                       const DepthRefineOptions& options) try {
    checkPhotoAndDepth(photo, depth, "depth", "CV_32FC1");
    if (options.keepsDepth()) {
        depth.copyTo(refined);
        return {};
    }
    cv::Mat result = withinRange(depth);
    const DepthFlaws flaws = options.flaws ? *options.flaws : measureDepthFlaws(photo, result);
    validate(flaws);
    if (flaws.shiftPixels != cv::Point()) result = unshifted(result, flaws.shiftPixels);
    int growth = static_cast<int>(std::lround(flaws.growthPixels));
    if (flaws.softnessPixels > 0) {
        if (growth != 0) shrinkNear(result, growth);
        if (flaws.isUneven) {
            decideContours(photo, result);
        } else {
            sharpenSteps(photo, flaws, result);
        }
        growth = 0;
    }
    // at once, because thin things do not survive being shrunk first; below 0 near things grow
    growth -= flaws.mixedPixels;
    if (growth != 0) shrinkNear(result, growth);
    result.copyTo(refined);
    return flaws;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void sharpenSteps(const cv::Mat& photo, const DepthFlaws& flaws, cv::Mat& depth) {
    const double softness = flaws.softnessPixels;
    const StepRule rule = evenRule(flaws.isBlurred ? softness / 2 : softness);
    StepRule left = evenRule(kLeftWidth);
    left.part = kMiddle;
    const cv::Mat given = depth.clone();
    Surroundings around;
    if (flaws.isBlurred) { // enlarged depth would be harmed
        const double sigma = (softness + 1) / 2.5;
        cv::Mat buffer(depth.size(), CV_32FC1);
        deblur(given, sigma, depth, buffer);
        keepHardSteps(given, sigma, around, depth);
    }
    const auto sharpen = [&](const cv::Mat& flat, const StepRule& how) {
        around.find(depth, how.radius);
        StepSides sides(photo, windowOf(how));
        sides.setDepth(depth);
        const Sharpener sharpener(flat, how, sides, around);
        cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
            StepBuffers buffers(static_cast<std::size_t>(depth.cols));
            for (int y = range.start; y < range.end; ++y)
                sharpener.row(y, buffers, depth.ptr<float>(y));
        });
    };
    sharpen(given, rule);
    sharpen(depth.clone(), left);
    smoothContours(given, depth);
}

} // namespace altiro3D
