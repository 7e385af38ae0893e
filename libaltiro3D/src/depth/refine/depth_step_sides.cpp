#include "depth/refine/depth_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/refine/depth_step_sides.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"
#include "base/pixel_rows.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Wholes = hn::RebindToSigned<Floats>;

// One vector of px. Arithmetic limits the speed, some 25 operations per tap and a table look-up.
// @tparam kInside all taps are columns of the row
// @tparam kSure row.sure is given
template <bool kInside, bool kSure>
HWY_INLINE void sumVector(const StepRow& row, const float* HWY_RESTRICT colorWeight, std::size_t x,
                          const StepSums& nearSide, const StepSums& farSide) {
    const Floats d;
    const Wholes whole;
    const auto middle = hn::LoadU(d, row.middle + x);
    const auto scale = hn::LoadU(d, row.scale + x);
    const auto blueGreen = hn::LoadU(whole, row.blueGreen + x);
    const auto red = hn::LoadU(whole, row.red + x);
    const auto lastStep = hn::Set(whole, kStepColors);
    [[maybe_unused]] const auto columns = hn::Iota(whole, static_cast<std::int32_t>(x));
    [[maybe_unused]] const auto end = hn::Set(whole, static_cast<std::int32_t>(row.count));
    auto nearDepth = hn::Zero(d);
    auto nearWeight = hn::Zero(d);
    auto nearColor = hn::Zero(d);
    auto farDepth = hn::Zero(d);
    auto farWeight = hn::Zero(d);
    auto farColor = hn::Zero(d);
    for (std::size_t i = 0; i < row.tapCount; ++i) {
        const StepTap& tap = row.taps[i];
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(x) + tap.offset;
        const auto depth = hn::LoadU(d, row.depth + at);
        const auto side = hn::Mul(hn::Sub(depth, middle), scale);
        auto weight = hn::Mul(hn::Mul(side, side), hn::Set(d, tap.weight));
        if (kSure) {
            const auto isClose = hn::Lt(hn::Abs(side), hn::Set(d, 2.0F));
            weight = hn::IfThenElseZero(isClose, hn::Mul(weight, hn::LoadU(d, row.sure + at)));
        }
        if (!kInside) {
            const auto column = hn::Add(columns, hn::Set(whole, tap.column));
            const auto inside = hn::AndNot(hn::Lt(column, hn::Zero(whole)), hn::Lt(column, end));
            weight = hn::IfThenElseZero(hn::RebindMask(d, inside), weight);
        }
        const auto square =
            hn::Add(squaresOfPair(whole, hn::LoadU(whole, row.blueGreen + at), blueGreen),
                    squaresOfPair(whole, hn::LoadU(whole, row.red + at), red));
        const auto step = hn::Min(hn::ShiftRight<kStepColorShift>(square), lastStep);
        const auto similarity = gatherFloats(d, colorWeight, step);
        const auto isNear = hn::Gt(side, hn::Zero(d));
        const auto ofNear = hn::IfThenElseZero(isNear, weight);
        const auto ofFar = hn::IfThenZeroElse(isNear, weight);
        nearDepth = hn::Add(nearDepth, hn::Mul(ofNear, depth));
        nearWeight = hn::Add(nearWeight, ofNear);
        nearColor = hn::Add(nearColor, hn::Mul(ofNear, similarity));
        farDepth = hn::Add(farDepth, hn::Mul(ofFar, depth));
        farWeight = hn::Add(farWeight, ofFar);
        farColor = hn::Add(farColor, hn::Mul(ofFar, similarity));
    }
    hn::StoreU(nearDepth, d, nearSide.depth + x);
    hn::StoreU(nearWeight, d, nearSide.weight + x);
    hn::StoreU(nearColor, d, nearSide.color + x);
    hn::StoreU(farDepth, d, farSide.depth + x);
    hn::StoreU(farWeight, d, farSide.weight + x);
    hn::StoreU(farColor, d, farSide.color + x);
}

template <bool kSure>
HWY_INLINE void sumRow(const StepRow& row, const float* HWY_RESTRICT colorWeight,
                       const StepSums& nearSide, const StepSums& farSide) {
    const std::size_t lanes = hn::Lanes(Floats());
    const auto reach = static_cast<std::size_t>(row.reach);
    for (std::size_t x = 0; x < row.count; x += lanes) {
        unsigned wanted = 0;
        for (std::size_t i = x; i < x + lanes; ++i)
            wanted |= row.wanted[i];
        if (wanted == 0) continue;
        if (x >= reach && x + lanes + reach <= row.count) {
            sumVector<true, kSure>(row, colorWeight, x, nearSide, farSide);
        } else {
            sumVector<false, kSure>(row, colorWeight, x, nearSide, farSide);
        }
    }
}

// The sums of both sides of each wanted px, (4.8) of docs/mathematics.md. They are added in the
// order of the taps, so they have the same bits on all instruction sets.
// @param colorWeight kStepColors + 1 similarities
// @param nearSide @param farSide results; undefined where a px is not wanted
void sumStepSidesOn(const StepRow& row, const float* HWY_RESTRICT colorWeight,
                    const StepSums& nearSide, const StepSums& farSide) {
    if (row.sure != nullptr) {
        sumRow<true>(row, colorWeight, nearSide, farSide);
    } else {
        sumRow<false>(row, colorWeight, nearSide, farSide);
    }
}

// Reads the rows of the filter, writes one row. Loads limit the speed, two per weight.
void filterRowOn(const float* HWY_RESTRICT middle, const float* const* before,
                 const float* const* after, const float* HWY_RESTRICT weights, std::size_t reach,
                 std::size_t count, float* HWY_RESTRICT to) {
    const auto filter = [&](auto d, std::size_t x) HWY_ATTR {
        auto sum = hn::Mul(hn::Set(d, weights[0]), hn::LoadU(d, middle + x));
        for (std::size_t k = 1; k <= reach; ++k) {
            const auto both = hn::Add(hn::LoadU(d, before[k] + x), hn::LoadU(d, after[k] + x));
            sum = hn::Add(sum, hn::Mul(hn::Set(d, weights[k]), both));
        }
        hn::StoreU(sum, d, to + x);
    };
    const Floats d;
    std::size_t x = 0;
    for (; x + hn::Lanes(d) <= count; x += hn::Lanes(d))
        filter(d, x);
    for (; x < count; ++x)
        filter(hn::CappedTag<float, 1>(), x);
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(sumStepSidesOn);
HWY_EXPORT(filterRowOn);

void filterRow(const float* middle, const float* const* before, const float* const* after,
               const float* weights, std::size_t reach, std::size_t count, float* to) {
    HWY_DYNAMIC_DISPATCH(filterRowOn)(middle, before, after, weights, reach, count, to);
}

namespace {

constexpr double kColorSigma = 14; // levels; 8 to 20 give the same within 0.05 dB

// Similarity of colours by their squared distance >> kStepColorShift.
std::vector<float> makeColorWeights() {
    std::vector<float> weights;
    for (int i = 0; i < kStepColors; ++i) {
        const double square = (i + 0.5) * (1 << kStepColorShift);
        weights.push_back(static_cast<float>(std::exp(-square / (2 * kColorSigma * kColorSigma))));
    }
    weights.push_back(0);
    return weights;
}

// Squared slope.
void findSlopes(const cv::Mat& depth, cv::Mat& result) {
    result.create(depth.size(), CV_32FC1);
    overRows(depth.rows, [&](int y) {
        const auto* const above = depth.ptr<float>(std::max(y - 1, 0));
        const auto* const row = depth.ptr<float>(y);
        const auto* const below = depth.ptr<float>(std::min(y + 1, depth.rows - 1));
        auto* const to = result.ptr<float>(y);
        for (int x = 0; x < depth.cols; ++x) {
            const float across = row[std::min(x + 1, depth.cols - 1)] - row[std::max(x - 1, 0)];
            const float down = below[x] - above[x];
            to[x] = (across * across + down * down) / 4;
        }
    });
}

// A filter that reads the rows around each part of the picture. OpenCV's filters use one thread.
template <class Filter>
void inParts(const cv::Mat& from, cv::Mat& to, const Filter& filter) {
    to.create(from.size(), from.type());
    // if `from` is a region, filters would also read the columns beside it
    const cv::Mat alone(from.size(), from.type(), const_cast<uchar*>(from.data), from.step);
    cv::parallel_for_(
        cv::Range(0, from.rows),
        [&](const cv::Range& rows) {
            cv::Mat part = to.rowRange(rows);
            filter(alone.rowRange(rows), part);
        },
        cv::getNumThreads());
}

cv::Mat windowOf(int radius) {
    return cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8UC1);
}

void findMost(const cv::Mat& from, int radius, cv::Mat& to) {
    inParts(from, to, [window = windowOf(radius)](const cv::Mat& part, cv::Mat& result) {
        cv::dilate(part, result, window, {-1, -1}, 1, cv::BORDER_REPLICATE);
    });
}

} // namespace

void findExtremes(const cv::Mat& depth, int radius, cv::Mat& least, cv::Mat& most) {
    inParts(depth, least, [window = windowOf(radius)](const cv::Mat& part, cv::Mat& result) {
        cv::erode(part, result, window, {-1, -1}, 1, cv::BORDER_REPLICATE);
    });
    findMost(depth, radius, most);
}

void Surroundings::find(const cv::Mat& depth, int radius) {
    findExtremes(depth, radius, least, most);
    findSlopes(depth, slopes);
    findMost(slopes, radius, steepest);
}

StepSides::StepSides(const cv::Mat& photo, std::vector<StepNeighbour> neighbours)
    : size_(photo.size()), neighbours_(std::move(neighbours)), margin_(0) {
    for (const StepNeighbour& neighbour : neighbours_)
        margin_ = std::max(margin_, std::abs(neighbour.x));
    blueGreen_ = padded(CV_32SC1);
    red_ = padded(CV_32SC1);
    overRows(photo.rows, [&](int y) {
        const auto* bgr = photo.ptr<std::uint8_t>(y);
        auto* const blueGreen = blueGreen_.ptr<std::int32_t>(y) + margin_;
        auto* const red = red_.ptr<std::int32_t>(y) + margin_;
        for (int x = 0; x < photo.cols; ++x, bgr += 3) {
            blueGreen[x] = bgr[0] | (bgr[1] << 16);
            red[x] = bgr[2];
        }
    });
}

cv::Mat StepSides::padded(int type) const {
    const int columns = size_.width + 2 * margin_ + static_cast<int>(kRowPadding);
    return cv::Mat::zeros(size_.height, columns, type);
}

cv::Mat StepSides::inside(const cv::Mat& plane) const {
    return plane(cv::Rect({margin_, 0}, size_));
}

void StepSides::setDepth(const cv::Mat& depth, const cv::Mat& sure) {
    if (depthPlane_.empty()) {
        depthPlane_ = padded(CV_32FC1);
        depth_ = inside(depthPlane_);
    }
    depth.copyTo(depth_);
    surePlane_.release();
    if (sure.empty()) return;
    surePlane_ = padded(CV_32FC1);
    cv::Mat to = inside(surePlane_);
    sure.copyTo(to);
}

void StepSides::sum(int y, StepBuffers& buffers) const {
    static const std::vector<float> colorWeights = makeColorWeights();
    const auto stride = static_cast<std::ptrdiff_t>(depthPlane_.step1());
    buffers.taps.clear();
    for (const StepNeighbour& neighbour : neighbours_) {
        if (y + neighbour.y >= 0 && y + neighbour.y < size_.height)
            buffers.taps.push_back(
                {neighbour.x, neighbour.y * stride + neighbour.x, neighbour.weight});
    }
    StepRow row;
    row.count = static_cast<std::size_t>(size_.width);
    row.depth = depthPlane_.ptr<float>(y) + margin_;
    if (!surePlane_.empty()) row.sure = surePlane_.ptr<float>(y) + margin_;
    row.blueGreen = blueGreen_.ptr<std::int32_t>(y) + margin_;
    row.red = red_.ptr<std::int32_t>(y) + margin_;
    row.wanted = buffers.wanted.data();
    row.middle = buffers.middle.data();
    row.scale = buffers.scale.data();
    row.taps = buffers.taps.data();
    row.tapCount = buffers.taps.size();
    row.reach = margin_;
    HWY_DYNAMIC_DISPATCH(sumStepSidesOn)
    (row, colorWeights.data(), buffers.nearSide.sums(), buffers.farSide.sums());
}

} // namespace altiro3D
#endif
