#include "base/pixel_rows.hpp"
#include "depth/refine/depth_steps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

// A network knows that there is a step, but only roughly where:
//
//      depth   near ______                  The px of the band belong to one of both sides. The
//                         \                 colours of all px around that are surely near, and of
//                          \  band          those that are surely far, decide, and then the px
//                     far   \_______        beside it that have its colour.

namespace altiro3D {

namespace {

// Lengths are px of a picture whose longer side is kSide; docs/lab/edges.md has the measurements.
constexpr double kSide = 512;
constexpr double kRadius = 10;    // window in which a step is seen
constexpr double kFlat = 3;       // window in which a surface is flat
constexpr double kReach = 36;     // reach of the colours that decide
constexpr double kStride = 4;     // stride between them
constexpr double kRamp = 16;      // width of the widest step: more is a slope
constexpr double kSmooth = 7;     // window over which evidence is averaged
constexpr float kHeight = 0.06F;  // lowest step, in units of depth
constexpr float kSure = 0.15F;    // distance from the level of a side, in heights of the step
constexpr float kSureFlat = 0.3F; // range of depth on a side, in heights of the step
constexpr float kBand = 0.42F;    // px farther from the middle are not in doubt
constexpr float kDepthWeight = 1.2F;
constexpr float kColorWeight = 0.6F;
constexpr float kColorFloor = 0.02F; // limits how much the photo may contradict
constexpr float kOwnWeight = 0.15F;  // weight of a px against each px beside it that has its colour
constexpr double kColorSigma = 12;   // standard deviation of the colours of such px, levels
constexpr float kLeak = 0.02F;       // weight of px of another colour
constexpr int kPasses = 30;
constexpr float kSharpness = 4; // sharpness of the result
// Evidence: logarithm of the slope, and how clearly the colours decide.
constexpr float kSlopeUnit = 0.8F;
constexpr float kClarityUnit = 0.12F;
constexpr float kEvidence = -0.8F;
constexpr float kEvidenceRange = 0.6F;

int scaled(double length, double unit) {
    return std::max(1, static_cast<int>(std::lround(length * unit)));
}

std::vector<StepNeighbour> neighboursOf(double unit) {
    const int stride = scaled(kStride, unit);
    const int reach = scaled(kReach, unit) / stride * stride;
    const double sigma = kReach * unit / 2;
    std::vector<StepNeighbour> neighbours;
    for (int y = -reach; y <= reach; y += stride) {
        for (int x = -reach; x <= reach; x += stride) {
            const double square = x * x + y * y;
            if (square > reach * reach) continue;
            neighbours.push_back(
                {x, y, static_cast<float>(std::exp(-square / (2 * sigma * sigma)))});
        }
    }
    return neighbours;
}

class Contours {
  public:
    Contours(const cv::Mat& photo, const cv::Mat& depth)
        : photo_(photo), depth_(depth), unit_(std::max(photo.cols, photo.rows) / kSide) {}

    // @param result [as depth]; it is the depth itself
    void decide(cv::Mat& result) {
        around_.find(depth_, scaled(kRadius, unit_));
        if (!findSteps()) return;
        findSides();
        followColors();
        includeMixedPixels();
        apply(result);
    }

  private:
    float height(int y, int x) const {
        return around_.most.ptr<float>(y)[x] - around_.least.ptr<float>(y)[x];
    }

    // Place between the extremes around a px: 0 far, 1 near.
    float place(int y, int x) const {
        return (depth_.ptr<float>(y)[x] - around_.least.ptr<float>(y)[x]) / height(y, x);
    }

    // Marks the px of steps, and those that surely belong to a side. @return whether there are any
    bool findSteps() {
        cv::Mat least;
        cv::Mat most;
        findExtremes(depth_, scaled(kFlat, unit_), least, most);
        isStep_ = cv::Mat::zeros(depth_.size(), CV_8UC1);
        sure_ = cv::Mat::ones(depth_.size(), CV_32FC1);
        const float ramp = static_cast<float>(kRamp * unit_);
        overRows(depth_.rows, [&](int y) {
            for (int x = 0; x < depth_.cols; ++x) {
                const float h = height(y, x);
                if (h <= kHeight || h * h >= ramp * ramp * around_.steepest.ptr<float>(y)[x])
                    continue;
                isStep_.ptr(y)[x] = 1;
                const float p = place(y, x);
                const bool isFlat = most.ptr<float>(y)[x] - least.ptr<float>(y)[x] < kSureFlat * h;
                const bool isAtLevel = p < kSure || p > 1 - kSure;
                if (!isFlat && !isAtLevel) sure_.ptr<float>(y)[x] = 0;
            }
        });
        return cv::countNonZero(isStep_) > 0;
    }

    // Which side each px of a band belongs to, by itself, and the depth of both sides there.
    void findSides() {
        StepSides sides(photo_, neighboursOf(unit_));
        sides.setDepth(depth_, sure_);
        // px outside bands are on one side
        share_ = cv::Mat::zeros(depth_.size(), CV_32FC1);
        isInBand_ = cv::Mat::zeros(depth_.size(), CV_8UC1);
        near_.create(depth_.size(), CV_32FC1);
        far_.create(depth_.size(), CV_32FC1);
        cv::parallel_for_(cv::Range(0, depth_.rows), [&](const cv::Range& range) {
            StepBuffers buffers(static_cast<std::size_t>(depth_.cols));
            for (int y = range.start; y < range.end; ++y) {
                if (!findBand(y, buffers)) continue;
                sides.sum(y, buffers);
                for (int x = 0; x < depth_.cols; ++x) {
                    if (buffers.wanted[static_cast<std::size_t>(x)] != 0)
                        decidePixel(y, x, buffers);
                }
            }
        });
    }

    // @return whether the row has px in doubt
    bool findBand(int y, StepBuffers& buffers) {
        bool any = false;
        for (int x = 0; x < depth_.cols; ++x) {
            const auto at = static_cast<std::size_t>(x);
            buffers.wanted[at] = 0;
            if (isStep_.ptr(y)[x] == 0) continue;
            const float p = place(y, x);
            share_.ptr<float>(y)[x] = p > 0.5F ? 1.0F : 0.0F;
            if (std::abs(p - 0.5F) >= kBand) continue;
            buffers.wanted[at] = 1;
            buffers.middle[at] =
                (around_.most.ptr<float>(y)[x] + around_.least.ptr<float>(y)[x]) / 2;
            buffers.scale[at] = 2 / height(y, x);
            any = true;
        }
        return any;
    }

    void decidePixel(int y, int x, const StepBuffers& buffers) {
        const auto at = static_cast<std::size_t>(x);
        if (!buffers.nearSide.has(at) || !buffers.farSide.has(at)) return;
        const StepSide nearSide = buffers.nearSide.mean(at);
        const StepSide farSide = buffers.farSide.mean(at);
        const float color = static_cast<float>(std::log(
            static_cast<double>((nearSide.color + kColorFloor) / (farSide.color + kColorFloor))));
        const float side = kDepthWeight * (2 * place(y, x) - 1) + kColorWeight * color;
        share_.ptr<float>(y)[x] = (std::clamp(side, -1.0F, 1.0F) + 1) / 2;
        near_.ptr<float>(y)[x] = nearSide.depth;
        far_.ptr<float>(y)[x] = farSide.depth;
        isInBand_.ptr(y)[x] = 1;
    }

    // A px of a band with the weights of the px to its left, to its right, above and below.
    struct BandPixel {
        int x;
        float own; // share by itself
        std::array<float, 4> weights;
    };

    // Similarity of two neighbouring px; 0 where the other one is not part of a step.
    float link(const cv::Vec3b& color, int y, int x) const {
        if (y < 0 || y >= depth_.rows || x < 0 || x >= depth_.cols || isStep_.ptr(y)[x] == 0)
            return 0;
        const auto& other = photo_.ptr<cv::Vec3b>(y)[x];
        double square = 0;
        for (int c = 0; c < 3; ++c)
            square += (color[c] - other[c]) * (color[c] - other[c]);
        return static_cast<float>(std::exp(-square / (2 * kColorSigma * kColorSigma))) + kLeak;
    }

    // A random walk from the px that are not in doubt (Grady 2006): each px of a band takes the
    // weighted mean of the px beside it and of its own share.
    void followColors() {
        std::vector<std::vector<BandPixel>> band(static_cast<std::size_t>(depth_.rows));
        overRows(depth_.rows, [&](int y) {
            for (int x = 0; x < depth_.cols; ++x) {
                if (isInBand_.ptr(y)[x] == 0) continue;
                const auto& color = photo_.ptr<cv::Vec3b>(y)[x];
                band[static_cast<std::size_t>(y)].push_back(
                    {x,
                     share_.ptr<float>(y)[x],
                     {link(color, y, x - 1), link(color, y, x + 1), link(color, y - 1, x),
                      link(color, y + 1, x)}});
            }
        });
        cv::Mat next = share_.clone();
        for (int pass = 0; pass < kPasses; ++pass) {
            overRows(depth_.rows, [&](int y) {
                const float* const row = share_.ptr<float>(y);
                const float* const above = share_.ptr<float>(std::max(y - 1, 0));
                const float* const below = share_.ptr<float>(std::min(y + 1, depth_.rows - 1));
                float* const to = next.ptr<float>(y);
                for (const BandPixel& px : band[static_cast<std::size_t>(y)]) {
                    const auto& [left, right, up, down] = px.weights;
                    float sum = kOwnWeight * px.own;
                    if (left > 0) sum += left * row[px.x - 1];
                    if (right > 0) sum += right * row[px.x + 1];
                    sum += up * above[px.x] + down * below[px.x];
                    to[px.x] = sum / (kOwnWeight + left + right + up + down);
                }
            });
            std::swap(share_, next);
        }
    }

    // The px of an edge of the photo show both sides, and belong to the near one.
    void includeMixedPixels() {
        cv::Mat wide;
        cv::dilate(share_, wide, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
        wide.copyTo(share_, isInBand_);
    }

    // Means of evidence over the band: 1 where a step is to be hard, 0 where it stays soft.
    cv::Mat evidence() const {
        cv::Mat count;
        isInBand_.convertTo(count, CV_32F);
        cv::Mat sum = cv::Mat::zeros(depth_.size(), CV_32FC1);
        overRows(depth_.rows, [&](int y) {
            for (int x = 0; x < depth_.cols; ++x) {
                if (isInBand_.ptr(y)[x] == 0) continue;
                const double slope2 = around_.steepest.ptr<float>(y)[x] * unit_ * unit_;
                const float steepness =
                    static_cast<float>(std::log(std::max(slope2, 1e-8)) / 2) / kSlopeUnit;
                const float clarity = std::abs(share_.ptr<float>(y)[x] - 0.5F) / kClarityUnit;
                sum.ptr<float>(y)[x] = steepness + clarity;
            }
        });
        const int side = 2 * scaled(kSmooth, unit_) + 1;
        for (cv::Mat* plane : {&count, &sum})
            cv::boxFilter(*plane, *plane, -1, {side, side}, {-1, -1}, false);
        overRows(depth_.rows, [&](int y) {
            float* const values = sum.ptr<float>(y);
            for (int x = 0; x < depth_.cols; ++x) {
                if (isInBand_.ptr(y)[x] == 0) continue;
                const float mean = values[x] / count.ptr<float>(y)[x];
                values[x] = std::clamp((mean - kEvidence) / kEvidenceRange + 0.5F, 0.0F, 1.0F);
            }
        });
        return sum;
    }

    void apply(cv::Mat& result) const {
        const cv::Mat hardness = evidence();
        overRows(depth_.rows, [&](int y) {
            for (int x = 0; x < depth_.cols; ++x) {
                if (isInBand_.ptr(y)[x] == 0) continue;
                const float share =
                    std::clamp((share_.ptr<float>(y)[x] - 0.5F) * kSharpness + 0.5F, 0.0F, 1.0F);
                const float nearDepth = near_.ptr<float>(y)[x];
                const float farDepth = far_.ptr<float>(y)[x];
                const float hard = farDepth + (nearDepth - farDepth) * share;
                float& to = result.ptr<float>(y)[x];
                to += hardness.ptr<float>(y)[x] * (hard - to);
            }
        });
    }

    const cv::Mat& photo_;
    const cv::Mat& depth_;
    double unit_; // px per px of a picture of kSide
    Surroundings around_;
    cv::Mat isStep_;   // CV_8UC1
    cv::Mat isInBand_; // CV_8UC1
    cv::Mat sure_;     // CV_32FC1, 0 or 1
    cv::Mat share_;    // CV_32FC1, share of the near side
    cv::Mat near_;     // CV_32FC1, depth of the sides of a band
    cv::Mat far_;      // CV_32FC1
};

} // namespace

void decideContours(const cv::Mat& photo, cv::Mat& depth) {
    const cv::Mat given = depth.clone();
    Contours(photo, given).decide(depth);
}

} // namespace altiro3D
