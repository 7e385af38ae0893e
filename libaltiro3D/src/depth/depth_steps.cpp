#include "depth/depth_steps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kColorShift = 4;
constexpr std::size_t kColorSteps = 512;

// One pass of a separable filter with a symmetric kernel; px at the border are repeated.
void blur(const cv::Mat& depth, const std::vector<float>& half, cv::Mat& blurred, cv::Mat& buffer) {
    const int radius = static_cast<int>(half.size()) - 1;
    buffer.create(depth.size(), CV_32FC1);
    blurred.create(depth.size(), CV_32FC1);
    const auto count = static_cast<std::size_t>(depth.cols);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            auto* const to = buffer.ptr<float>(y);
            const auto* const here = depth.ptr<float>(y);
            for (std::size_t x = 0; x < count; ++x)
                to[x] = half[0] * here[x];
            for (int k = 1; k <= radius; ++k) {
                const auto* const above = depth.ptr<float>(std::max(y - k, 0));
                const auto* const below = depth.ptr<float>(std::min(y + k, depth.rows - 1));
                const float weight = half[static_cast<std::size_t>(k)];
                for (std::size_t x = 0; x < count; ++x)
                    to[x] += weight * (above[x] + below[x]);
            }
        }
    });
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        const auto reach = static_cast<std::size_t>(radius);
        std::vector<float> row(count + 2 * reach);
        for (int y = range.start; y < range.end; ++y) {
            const auto* const from = buffer.ptr<float>(y);
            std::fill_n(row.begin(), reach, from[0]);
            std::copy_n(from, count, row.begin() + radius);
            std::fill_n(row.begin() + radius + static_cast<std::ptrdiff_t>(count), reach,
                        from[count - 1]);
            auto* const to = blurred.ptr<float>(y);
            const float* const middle = row.data() + reach;
            for (std::size_t x = 0; x < count; ++x)
                to[x] = half[0] * middle[x];
            for (std::size_t k = 1; k <= reach; ++k) {
                const float weight = half[k];
                for (std::size_t x = 0; x < count; ++x)
                    to[x] += weight * (middle[x + k] + *(middle + x - k));
            }
        }
    });
}

// Undoes most of a Gaussian blur (van Cittert 1931): thin things get their height back.
void deblur(double sigma, cv::Mat& depth) {
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
    const cv::Mat given = depth.clone();
    cv::Mat blurred;
    cv::Mat buffer;
    constexpr int kPasses = 3;
    for (int pass = 0; pass < kPasses; ++pass) {
        blur(depth, half, blurred, buffer);
        cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
            for (int y = range.start; y < range.end; ++y) {
                const auto* const from = given.ptr<float>(y);
                const auto* const soft = blurred.ptr<float>(y);
                auto* const to = depth.ptr<float>(y);
                for (int x = 0; x < depth.cols; ++x)
                    to[x] = std::clamp(to[x] + (from[x] - soft[x]), 0.0F, 1.0F);
            }
        });
    }
}

// Squared slope.
void slopes(const cv::Mat& depth, cv::Mat& result) {
    result.create(depth.size(), CV_32FC1);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const auto* const above = depth.ptr<float>(std::max(y - 1, 0));
            const auto* const row = depth.ptr<float>(y);
            const auto* const below = depth.ptr<float>(std::min(y + 1, depth.rows - 1));
            auto* const to = result.ptr<float>(y);
            for (int x = 0; x < depth.cols; ++x) {
                const float across = row[std::min(x + 1, depth.cols - 1)] - row[std::max(x - 1, 0)];
                const float down = below[x] - above[x];
                to[x] = (across * across + down * down) / 4;
            }
        }
    });
}

// What a square window around each px holds.
struct Surroundings {
    cv::Mat least;    // depth
    cv::Mat most;     // depth
    cv::Mat steepest; // largest squared slope
};

// @param result its memory is reused
void findSurroundings(const cv::Mat& depth, int radius, Surroundings& result) {
    const cv::Mat window = cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8UC1);
    slopes(depth, result.steepest);
    const auto prepare = [&](int which) {
        constexpr int kBorder = cv::BORDER_REPLICATE | cv::BORDER_ISOLATED;
        if (which == 0) cv::erode(depth, result.least, window, {-1, -1}, 1, kBorder);
        if (which == 1) cv::dilate(depth, result.most, window, {-1, -1}, 1, kBorder);
        if (which == 2) cv::dilate(result.steepest, result.steepest, window, {-1, -1}, 1, kBorder);
    };
    // OpenCV uses one thread for each
    cv::parallel_for_(cv::Range(0, 3), [&](const cv::Range& range) {
        for (int which = range.start; which < range.end; ++which)
            prepare(which);
    });
}

// Takes deblurred depth back where the given depth is steeper than a blur leaves it: there a hard
// step would get a rim on both sides. Formula (4.7a) of docs/mathematics.md.
void keepHardSteps(const cv::Mat& given, double sigma, Surroundings& around, cv::Mat& depth) {
    constexpr float kSoft = 1.8F; // a blurred step has 1, a blurred line 1.5
    constexpr float kHard = 2.4F;
    findSurroundings(given, static_cast<int>(std::lround(2 * sigma)), around);
    const auto stepWidth = static_cast<float>(std::sqrt(2 * CV_PI) * sigma);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
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
        }
    });
}

// The neighbourhood of a px that decides to which side it belongs.
struct Tap {
    int x;
    int y;
    float weight;
};

std::vector<Tap> windowOf(int radius) {
    std::vector<Tap> taps;
    const int stride = (radius + 5) / 6; // large windows are sampled
    const int reach = radius / stride * stride;
    for (int y = -reach; y <= reach; y += stride) {
        for (int x = -reach; x <= reach; x += stride) {
            const double square = x * x + y * y;
            taps.push_back({x, y, static_cast<float>(std::exp(-square / (2.0 * radius * radius)))});
        }
    }
    return taps;
}

// Similarity of colours by their squared distance >> kColorShift.
std::array<float, kColorSteps + 1> makeColorWeights() {
    constexpr double kSigma = 14; // levels; 8 to 20 give the same within 0.05 dB
    std::array<float, kColorSteps + 1> weights{};
    for (std::size_t i = 0; i < kColorSteps; ++i) {
        const double square = (static_cast<double>(i) + 0.5) * (1 << kColorShift);
        weights[i] = static_cast<float>(std::exp(-square / (2 * kSigma * kSigma)));
    }
    return weights;
}

// One side of a step: its mean depth, and how similar the photo there is to the px in question.
struct StepSide {
    float depth = 0;
    float weight = 0;
    float color = 0;

    void add(float tapDepth, float tapWeight, float similarity) {
        depth += tapWeight * tapDepth;
        weight += tapWeight;
        color += tapWeight * similarity;
    }
    // Sums become means. @return false without samples
    bool finish() {
        if (!(weight > 0)) return false;
        depth /= weight;
        color /= weight;
        return true;
    }
};

// Parameters that were measured on the scenes of docs/lab/views.md.
constexpr float kMinHeight = 0.03F; // of a step, in units of depth
constexpr float kWholeStep = 1;     // px farther from the middle belong to something else
constexpr float kMiddle = 0.3F;     // px that are left between the sides after the first pass
constexpr double kLeftWidth = 2;    // width of what is left
constexpr float kSimilar = 0.8F;    // a px that is so similar to both sides is no edge
constexpr float kHardness = 6;      // weight of the depth of a px against its colour

// The depth of a px in a step: 0 far, 1 near, from its own place between the sides and its colour.
float sideOf(float place, const StepSide& nearSide, const StepSide& farSide) {
    constexpr float kFloor = 0.02F; // the photo may contradict, but not for ever
    const double color =
        std::log(static_cast<double>((nearSide.color + kFloor) / (farSide.color + kFloor)));
    const double side = static_cast<double>(kHardness * (2 * place - 1)) + color;
    return static_cast<float>((std::clamp(side, -1.0, 1.0) + 1) / 2);
}

class Sharpener {
  public:
    // @param given the depth that stays where the photo has no edge
    // @param depth the depth of which steps are made
    // @param part px within this part of a step's height from its middle are decided
    // @param around its memory is used
    Sharpener(const cv::Mat& photo, const cv::Mat& given, const cv::Mat& depth, double width,
              float part, Surroundings& around)
        : photo_(photo), given_(given), depth_(depth), width_(static_cast<float>(width)),
          part_(part), around_(around) {
        const int radius = std::max(2, static_cast<int>(std::lround(0.8 * width)));
        taps_ = windowOf(radius);
        findSurroundings(depth, radius, around);
    }

    // @param to row y of the result, which holds the depth
    void row(int y, float* to) const {
        for (int x = 0; x < depth_.cols; ++x) {
            if (isStep(x, y)) to[x] = pixel(x, y);
        }
    }

  private:
    // A slope is not a step: it is higher than its steepest place makes a step of this width.
    bool isStep(int x, int y) const {
        const float height = around_.most.ptr<float>(y)[x] - around_.least.ptr<float>(y)[x];
        const float ramp = 1.5F * (width_ + 1);
        return height >= kMinHeight &&
               height * height <= ramp * ramp * around_.steepest.ptr<float>(y)[x];
    }

    float pixel(int x, int y) const {
        const float low = around_.least.ptr<float>(y)[x];
        const float high = around_.most.ptr<float>(y)[x];
        const float middle = (high + low) / 2;
        const float scale = 2 / (high - low);
        const float here = depth_.ptr<float>(y)[x];
        // The means of the sides lie in their halves of low..high, so px that are farther from the
        // middle than this are not within part_.
        constexpr float kRounding = 0.01F;
        if (std::abs(here - middle) * scale > part_ + 0.5F + kRounding) return here;
        const std::uint8_t* const color = photo_.ptr<std::uint8_t>(y) + 3 * x;
        StepSide nearSide;
        StepSide farSide;
        for (const Tap& tap : taps_) {
            const int column = x + tap.x;
            const int row = y + tap.y;
            if (column < 0 || row < 0 || column >= depth_.cols || row >= depth_.rows) continue;
            const float depth = depth_.ptr<float>(row)[column];
            const float side = (depth - middle) * scale;
            const float weight = side * side * tap.weight; // px of the ramp itself count little
            const float similarity =
                similarityOf(color, photo_.ptr<std::uint8_t>(row) + 3 * column);
            (side > 0 ? nearSide : farSide).add(depth, weight, similarity);
        }
        if (!nearSide.finish() || !farSide.finish()) return here;
        if (!(nearSide.depth > farSide.depth)) return here; // equal but for rounding
        const float place = (here - farSide.depth) / (nearSide.depth - farSide.depth);
        if (std::abs(place - 0.5F) > part_) return here;
        if (nearSide.color > kSimilar && farSide.color > kSimilar) return given_.ptr<float>(y)[x];
        return farSide.depth + (nearSide.depth - farSide.depth) * sideOf(place, nearSide, farSide);
    }

    static float similarityOf(const std::uint8_t* a, const std::uint8_t* b) {
        static const std::array<float, kColorSteps + 1> weights = makeColorWeights();
        int square = 0;
        for (int c = 0; c < 3; ++c)
            square += (a[c] - b[c]) * (a[c] - b[c]);
        return weights[std::min(static_cast<std::size_t>(square >> kColorShift), kColorSteps)];
    }

    cv::Mat photo_;
    cv::Mat given_;
    cv::Mat depth_;
    float width_;
    float part_;
    std::vector<Tap> taps_;
    const Surroundings& around_;
};

} // namespace

void sharpenSteps(const cv::Mat& photo, double softness, double overshoot, cv::Mat& depth) {
    // More shows that depth was enlarged, not blurred. Among wide steps other things add to it.
    const double overshootOfBlur = softness < 3 ? 0.01 : 0.02;
    const cv::Mat given = depth.clone();
    Surroundings around;
    double width = softness;
    if (overshoot < overshootOfBlur) {
        const double sigma = (softness + 1) / 2.5;
        deblur(sigma, depth);
        keepHardSteps(given, sigma, around, depth);
        width /= 2;
    }
    cv::Mat before;
    const auto sharpen = [&](const cv::Mat& flat, double ramp, float part) {
        const Sharpener sharpener(photo, flat, before, ramp, part, around);
        cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
            for (int y = range.start; y < range.end; ++y)
                sharpener.row(y, depth.ptr<float>(y));
        });
    };
    depth.copyTo(before);
    sharpen(given, width, kWholeStep);
    depth.copyTo(before);
    sharpen(before, kLeftWidth, kMiddle);
}

} // namespace altiro3D
