#include "altiro3D/video_depth.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/state_bytes.hpp"
#include "base/text.hpp"
#include "video/motion/motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <utility>
#include <vector>

// docs/mathematics.md, section 5, has the formulas; docs/lab/video.md what was measured.

namespace altiro3D {

namespace {

// Misfit in grey levels: depth is fully trusted up to the first and not trusted from the second on.
constexpr float kTrustedMisfit = 4;
constexpr float kNewMisfit = 14;

// Share of the difference between the range of the depth and 0..1 that remains after a picture.
constexpr double kRangeMemory = 0.95;

// The share of `steadiness` that remains where content moves by kFast px or more per picture.
constexpr float kMovingShare = 0.5F;
constexpr float kFast = 2;

// Distance around moving content within which depth is updated, px of the small picture.
constexpr int kHaloPixels = 5;

// 1 where the previous picture explains this one, 0 where it does not.
float trustOf(float misfitThere) {
    return std::clamp((kNewMisfit - misfitThere) / (kNewMisfit - kTrustedMisfit), 0.0F, 1.0F);
}

// Replaces each value by the mean of those within `radius` px. Sums are formed in a fixed order.
void blur(cv::Mat& values, int radius) {
    cv::Mat along(values.size(), CV_32FC1);
    for (int y = 0; y < values.rows; ++y) {
        const auto* row = values.ptr<float>(y);
        auto* out = along.ptr<float>(y);
        for (int x = 0; x < values.cols; ++x) {
            out[x] = row[x];
            for (int d = 1; d <= radius; ++d)
                out[x] = out[x] + row[std::max(x - d, 0)] + row[std::min(x + d, values.cols - 1)];
        }
    }
    for (int y = 0; y < values.rows; ++y) {
        auto* out = values.ptr<float>(y);
        std::copy_n(along.ptr<float>(y), values.cols, out);
        for (int d = 1; d <= radius; ++d) {
            const auto* above = along.ptr<float>(std::max(y - d, 0));
            const auto* below = along.ptr<float>(std::min(y + d, values.rows - 1));
            for (int x = 0; x < values.cols; ++x)
                out[x] = out[x] + above[x] + below[x];
        }
    }
    const auto count = static_cast<float>(2 * radius + 1);
    values = values * (1 / (count * count));
}

// value -> gain value + offset
struct Affine {
    double gain = 1;
    double offset = 0;
};

// Fits the range of `fresh` to that of `carried`, weighted; px that differ strongly count less.
// Both have noise, but the carried depth, a mean of many, has less. The gain is therefore the
// geometric mean of two gains: the one that is right if only the fresh depth has noise, and the one
// that is right if both have the same.
Affine fitRange(const cv::Mat& fresh, const cv::Mat& carried, const cv::Mat& weights) {
    Affine fit;
    constexpr double kOutlier = 0.05;
    constexpr double kFlat = 1e-3; // added to variances; smaller ones count as flat
    for (int pass = 0; pass < 3; ++pass) {
        double sum = 0;
        double sumF = 0;
        double sumC = 0;
        double sumCC = 0;
        double sumFC = 0;
        double sumFF = 0;
        for (int y = 0; y < fresh.rows; ++y) {
            const auto* f = fresh.ptr<float>(y);
            const auto* c = carried.ptr<float>(y);
            const auto* w = weights.ptr<float>(y);
            for (int x = 0; x < fresh.cols; ++x) {
                const double a = static_cast<double>(f[x]);
                const double b = static_cast<double>(c[x]);
                const double error = pass == 0 ? 0 : (fit.gain * a + fit.offset - b) / kOutlier;
                const double weight = static_cast<double>(w[x]) / (1 + error * error);
                sum += weight;
                sumF += weight * a;
                sumC += weight * b;
                sumFC += weight * a * b;
                sumFF += weight * a * a;
                sumCC += weight * b * b;
            }
        }
        if (sum < 0.02 * static_cast<double>(fresh.total())) return fit;
        const double meanF = sumF / sum;
        const double meanC = sumC / sum;
        const double varianceC = std::max(0.0, sumCC / sum - meanC * meanC) + kFlat;
        const double varianceF = std::max(0.0, sumFF / sum - meanF * meanF) + kFlat;
        const double covariance = std::max(0.0, sumFC / sum - meanF * meanC) + kFlat;
        const double gain = std::sqrt(varianceC / covariance * std::sqrt(varianceC / varianceF));
        fit.gain = std::clamp(gain, 0.5, 2.0);
        fit.offset = meanC - fit.gain * meanF;
    }
    return fit;
}

// The two percentiles of a picture of depth, from some thousands of its px.
std::pair<float, float> percentilesOf(const cv::Mat& depth) {
    constexpr double kEnough = 20000;
    const int step =
        std::max(1, static_cast<int>(std::sqrt(static_cast<double>(depth.total()) / kEnough)));
    std::vector<float> values;
    for (int y = std::min(step / 2, depth.rows - 1); y < depth.rows; y += step)
        for (int x = std::min(step / 2, depth.cols - 1); x < depth.cols; x += step)
            values.push_back(depth.at<float>(y, x));
    const DepthNormalization percentiles;
    const auto at = [&](double percentile) {
        const double rank = percentile / 100 * static_cast<double>(values.size() - 1);
        const auto place = values.begin() + static_cast<std::ptrdiff_t>(std::lround(rank));
        std::nth_element(values.begin(), place, values.end());
        return *place;
    };
    const float low = at(percentiles.lowPercentile);
    return {low, at(percentiles.highPercentile)};
}

constexpr std::uint64_t kMagic = 0x3144564434334c41; // "AL34DVD1" on little-endian machines

} // namespace

void validate(const VideoDepthOptions& options) {
    const auto checkWhole = [](const char* name, int value, int least) {
        check(value >= least && value <= 1000, name,
              "is " + std::to_string(value) + ", expected a whole number " + std::to_string(least) +
                  "..1000");
    };
    const auto checkNumber = [](const char* name, double value, double most) {
        check(value >= 0 && value <= most, name,
              "is " + numberText(value) + ", expected 0.." + numberText(most));
    };
    checkWhole("every", options.every, 0);
    checkWhole("longestGap", options.longestGap, 1);
    checkNumber("maxChangedShare", options.maxChangedShare, 1);
    checkNumber("steadiness", options.steadiness, 0.99);
}

struct VideoDepth::Impl {
    Estimator estimator;
    DepthKind kind = DepthKind::NearWhite;
    VideoDepthOptions options;

    // The data of state(). Pictures are replaced and never modified, so copies do not change.
    struct Memory {
        PictureTracker tracker;
        cv::Mat keyGrey;       // small copy of the last inference's picture [CV_8UC1]
        cv::Mat keyDepth;      // steady depth there, may leave 0..1 [CV_32FC1]
        cv::Mat sinceKey;      // motion since [small size, CV_32FC2]
        std::uint64_t gap = 0; // pictures since
        cv::Mat depth;         // depth of the last picture [CV_32FC1]
    };
    Memory memory;

    bool isDue(const Memory& at, const cv::Mat& misfits) const;
    cv::Mat keptShares(const Memory& at, const cv::Mat& misfits) const;
    cv::Mat steadied(const Memory& at, const cv::Mat& misfits, const cv::Mat& fresh) const;
};

bool VideoDepth::Impl::isDue(const Memory& at, const cv::Mat& misfits) const {
    if (options.every > 0) return at.gap >= static_cast<std::uint64_t>(options.every);
    if (at.gap >= static_cast<std::uint64_t>(options.longestGap)) return true;
    double unexplained = 0;
    for (int y = 0; y < misfits.rows; ++y) {
        const auto* row = misfits.ptr<float>(y);
        for (int x = 0; x < misfits.cols; ++x)
            unexplained += 1 - static_cast<double>(trustOf(row[x]));
    }
    return unexplained > options.maxChangedShare * static_cast<double>(misfits.total());
}

// Share of the carried depth that stays [small size, CV_32FC1].
cv::Mat VideoDepth::Impl::keptShares(const Memory& at, const cv::Mat& misfits) const {
    const auto still = static_cast<float>(
        std::pow(options.steadiness, static_cast<double>(std::max<std::uint64_t>(at.gap, 1))));
    const float perPicture = 1 / (kFast * static_cast<float>(std::max<std::uint64_t>(at.gap, 1)));
    cv::Mat shares(misfits.size(), CV_32FC1);
    for (int y = 0; y < shares.rows; ++y) {
        const auto* row = misfits.ptr<float>(y);
        const auto* motion = at.sinceKey.ptr<cv::Vec2f>(y);
        auto* out = shares.ptr<float>(y);
        for (int x = 0; x < shares.cols; ++x) {
            const float speed =
                std::min(1.0F, (std::abs(motion[x][0]) + std::abs(motion[x][1])) * perPicture);
            out[x] = still * trustOf(row[x]) * (1 - (1 - kMovingShare) * speed);
        }
    }
    constexpr int kSide = 2 * kHaloPixels + 1;
    cv::erode(shares, shares, cv::getStructuringElement(cv::MORPH_RECT, {kSide, kSide}));
    blur(shares, kHaloPixels - 1);
    return shares;
}

cv::Mat VideoDepth::Impl::steadied(const Memory& at, const cv::Mat& misfits,
                                   const cv::Mat& fresh) const {
    const bool comparable = !at.keyDepth.empty() && at.keyDepth.size() == fresh.size();
    if (!comparable || options.steadiness == 0) return fresh;
    cv::Mat carried;
    carry(at.keyDepth, at.sinceKey, carried);
    const cv::Mat shares = stretched(keptShares(at, misfits), fresh.rows, fresh.cols);
    const Affine fit = fitRange(fresh, carried, shares);
    const auto gain = static_cast<float>(fit.gain);
    const auto offset = static_cast<float>(fit.offset);
    cv::Mat result(fresh.size(), CV_32FC1);
    for (int y = 0; y < fresh.rows; ++y) {
        const auto* f = fresh.ptr<float>(y);
        const auto* c = carried.ptr<float>(y);
        const auto* share = shares.ptr<float>(y);
        auto* out = result.ptr<float>(y);
        for (int x = 0; x < fresh.cols; ++x) {
            const float now = gain * f[x] + offset;
            out[x] = now + share[x] * (c[x] - now);
        }
    }
    // The range follows the percentiles slowly; depth without a range keeps the previous one.
    constexpr float kFlatSpan = 1e-3F;
    const auto [low, high] = percentilesOf(result);
    const bool isFlat = high - low < kFlatSpan;
    const double followed = 1 - std::pow(kRangeMemory, static_cast<double>(at.gap));
    const auto follow = isFlat ? 0.0F : static_cast<float>(followed);
    const float newLow = follow * low;
    const float newSpan = 1 + follow * (high - low - 1);
    constexpr float kFarOut = 1; // limit beyond the range, so that values stay bounded
    for (int y = 0; y < result.rows; ++y) {
        auto* row = result.ptr<float>(y);
        for (int x = 0; x < result.cols; ++x)
            row[x] = std::clamp((row[x] - newLow) / newSpan, -kFarOut, 1 + kFarOut);
    }
    return result;
}

VideoDepth::VideoDepth(Estimator estimator, DepthKind kind, const VideoDepthOptions& options)
    : impl_(std::make_unique<Impl>()) {
    validate(options);
    check(static_cast<bool>(estimator), "estimator", "is empty, expected a function");
    impl_->estimator = std::move(estimator);
    impl_->kind = kind;
    impl_->options = options;
}

VideoDepth::~VideoDepth() = default;
VideoDepth::VideoDepth(VideoDepth&&) noexcept = default;
VideoDepth& VideoDepth::operator=(VideoDepth&&) noexcept = default;

VideoDepthStep VideoDepth::next(const cv::Mat& picture, cv::Mat& depth) try {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3");
    VideoDepthStep step;
    Impl::Memory now = impl_->memory;
    const PictureTracker::Step tracked = now.tracker.next(picture);
    step.cut = tracked.cut;
    step.repeated = tracked.repeated;
    if (tracked.repeated || tracked.blank) {
        // For black or a flash, a network would estimate a depth unrelated to the scene.
        depth = now.depth.clone();
        impl_->memory = std::move(now);
        return step;
    }
    const cv::Mat& grey = now.tracker.grey();
    cv::Mat misfits;
    if (step.cut) {
        now.keyDepth = cv::Mat();
    } else {
        now.sinceKey = joinMotion(now.sinceKey, tracked.motion);
        if (now.gap > 0) refineMotion(now.keyGrey, grey, now.sinceKey);
        misfits = misfit(now.keyGrey, grey, now.sinceKey);
        ++now.gap;
    }
    step.inferred = step.cut || impl_->isDue(now, misfits);
    if (step.inferred) {
        cv::Mat raw;
        impl_->estimator(picture, raw);
        DepthNormalization normalization;
        normalization.kind = impl_->kind;
        cv::Mat fresh;
        normalizeDepth(raw, fresh, normalization);
        now.keyDepth = impl_->steadied(now, misfits, fresh);
        now.keyGrey = grey;
        now.sinceKey = cv::Mat(grey.size(), CV_32FC2, cv::Scalar(0, 0));
        now.gap = 0;
        now.depth = cv::min(cv::max(now.keyDepth, 0), 1);
    } else {
        cv::Mat moved;
        carry(now.keyDepth, now.sinceKey, moved);
        now.depth = cv::min(cv::max(moved, 0), 1);
    }
    depth = now.depth.clone();
    impl_->memory = std::move(now);
    return step;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

SavedState VideoDepth::state() const try {
    const Impl::Memory& memory = impl_->memory;
    std::string bytes;
    append(bytes, kMagic);
    memory.tracker.save(bytes);
    append(bytes, memory.keyGrey);
    append(bytes, memory.keyDepth);
    append(bytes, memory.sinceKey);
    append(bytes, memory.gap);
    append(bytes, memory.depth);
    append(bytes, checksum(bytes));
    return {std::move(bytes)};
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void VideoDepth::setState(const SavedState& state) try {
    const auto fail = [] {
        throw Error(ErrorCode::BadFormat, "state",
                    "is damaged or foreign, expected a result of VideoDepth::state()");
    };
    std::string_view rest = state.bytes;
    constexpr std::size_t kSum = sizeof(std::uint64_t);
    if (rest.size() < 2 * kSum) fail();
    std::string_view end = rest.substr(rest.size() - kSum);
    rest.remove_suffix(kSum);
    std::uint64_t sum = 0;
    std::uint64_t magic = 0;
    if (!take(end, sum) || checksum(rest) != sum || !take(rest, magic) || magic != kMagic) fail();
    Impl::Memory memory;
    if (!memory.tracker.load(rest) || !take(rest, CV_8UC1, memory.keyGrey) ||
        !take(rest, CV_32FC1, memory.keyDepth) || !take(rest, CV_32FC2, memory.sinceKey) ||
        !take(rest, memory.gap) || !take(rest, CV_32FC1, memory.depth) || !rest.empty()) {
        fail();
    }
    const cv::Size size = memory.tracker.grey().size();
    if (memory.keyGrey.size() != size || memory.sinceKey.size() != size ||
        memory.keyDepth.size() != memory.depth.size() || size.empty() != memory.depth.empty()) {
        fail();
    }
    impl_->memory = std::move(memory);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
