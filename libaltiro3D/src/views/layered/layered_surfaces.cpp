// Surfaces of rows: staircases of depth with few levels are smoothed, rows are cut at depth steps,
// and the cuts are moved to the edges of the photo.

#include "base/pixel_rows.hpp"
#include "depth/map/depth_values.hpp"
#include "views/depth_offsets.hpp"
#include "views/layered/layered_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

// Depth with few levels (8 bits) and a long reach turns slopes into staircases.

namespace {

// Steps that move by less than this (px at the reach) are not changed.
constexpr double kVisibleStep = 0.2;
// Fewer levels count as flat layers, more than in 8 bits as continuous depth.
constexpr std::size_t kMinLevels = 16;
constexpr std::size_t kMaxLevels = 256;
// The largest distance of two levels in a depth of 0..1: 6 bits.
constexpr double kMaxLevel = 1.0 / 63;
// Pixels that differ by at most this many levels are on one slope.
constexpr double kSameSlope = 1.5;
// Distances of the neighbours, and sweeps at each distance.
constexpr int kStrides[] = {32, 16, 8, 4, 2, 1};
constexpr int kSweeps = 2;

// The values that occur, ascending; empty if there are too many.
std::vector<float> levelsOf(const cv::Mat& depth) {
    std::vector<float> levels;
    for (int y = 0; y < depth.rows; ++y) {
        const auto* row = depth.ptr<float>(y);
        for (int x = 0; x < depth.cols; ++x) {
            if (x > 0 && row[x] == row[x - 1]) continue;
            const float value = withinRange(row[x]);
            const auto place = std::lower_bound(levels.begin(), levels.end(), value);
            if (place != levels.end() && *place == value) continue;
            if (levels.size() == kMaxLevels) return {};
            levels.insert(place, value);
        }
    }
    return levels;
}

// The distance of two levels; 0 if the depth has no levels that views within the reach would show.
double visibleLevel(const cv::Mat& depth, double reach) {
    if (reach * kMaxLevel < kVisibleStep) return 0;
    const std::vector<float> levels = levelsOf(depth);
    if (levels.size() < kMinLevels) return 0;
    double level = 1;
    for (std::size_t i = 1; i < levels.size(); ++i)
        level =
            std::min(level, static_cast<double>(levels[i]) - static_cast<double>(levels[i - 1]));
    return level <= kMaxLevel && level * reach >= kVisibleStep ? level : 0;
}

// Each pixel becomes the mean of its left, right, upper and lower neighbours. A pair that is not on
// the pixel's slope is replaced by the pixel itself. Slopes and the sides of steps do not change.
class Sweep {
  public:
    Sweep(const cv::Mat& given, double level)
        : given_(given), same_(static_cast<float>(kSameSlope * level)),
          half_(static_cast<float>(level / 2)) {}

    // Memory limits the speed.
    void row(const cv::Mat& from, int y, int stride, float* to) const {
        const bool edge = y < stride || y >= given_.rows - stride;
        const int above = edge ? y : y - stride;
        const int below = edge ? y : y + stride;
        const float* given[] = {given_.ptr<float>(y), given_.ptr<float>(above),
                                given_.ptr<float>(below)};
        const float* now[] = {from.ptr<float>(y), from.ptr<float>(above), from.ptr<float>(below)};
        const auto pair = [&](float own, float ownNow, float a, float b, float aNow, float bNow) {
            const bool same = std::abs(a - own) <= same_ && std::abs(b - own) <= same_;
            return same ? aNow + bNow : ownNow + ownNow;
        };
        const auto pixel = [&](int x, int left, int right) {
            const float own = given[0][x];
            const float ownNow = now[0][x];
            const float along =
                pair(own, ownNow, given[0][left], given[0][right], now[0][left], now[0][right]);
            const float across = pair(own, ownNow, given[1][x], given[2][x], now[1][x], now[2][x]);
            const float mean = 0.25F * (along + across);
            to[x] = std::min(std::max(mean, own - half_), own + half_);
        };
        const int width = given_.cols;
        const int inner = std::min(stride, width);
        const int outer = std::max(width - stride, inner);
        for (int x = 0; x < inner; ++x)
            pixel(x, x, x);
        for (int x = inner; x < outer; ++x)
            pixel(x, x - stride, x + stride);
        for (int x = outer; x < width; ++x)
            pixel(x, x, x);
    }

  private:
    const cv::Mat& given_;
    float same_;
    float half_;
};

// A step has no visible border if its sides differ by less (distance in BGR).
constexpr double kBorderContrast = 60;

double at(const std::vector<float>& offsets, int x) {
    return static_cast<double>(offsets[static_cast<std::size_t>(x)]);
}

// Extends the near side of a tear by the adjacent pixels.
void dilateNear(std::vector<float>& offsets, double tear, int pixels, std::vector<float>& source,
                std::vector<int>& steps) {
    if (pixels <= 0) return;
    const int width = static_cast<int>(offsets.size());
    findSteps(offsets.data(), offsets.size(), tear, steps);
    if (steps.empty()) return;
    source = offsets;
    const auto raise = [&](int x, float to) {
        if (x < 0 || x >= width) return;
        float& offset = offsets[static_cast<std::size_t>(x)];
        offset = std::max(offset, to);
    };
    for (const int x : steps) {
        const double step = at(source, x + 1) - at(source, x);
        for (int k = 0; k < pixels && step > tear; ++k)
            raise(x - k, source[static_cast<std::size_t>(x + 1)]);
        for (int k = 0; k < pixels && step < -tear; ++k)
            raise(x + 1 + k, source[static_cast<std::size_t>(x)]);
    }
}

// The border of a near surface as the photo shows it, if it is clear and within a px.
//
//   far surface      ...  f2  f1  f0 | n0  n1  n2  ...   near surface
//   share of near         0   0  .3    .95 1   1
//   result           ...  f2  f1 (mixed) n0 ...          n0 reaches .3 px beyond its pixel
struct Border {
    bool isClear = false; // the photo shows it; else it stays where the depth has it
    int gain = 0;         // px by which the near surface grows, -1..1
    int mixed = 0;        // mixed px, 0 or 1
    double extra = 0;     // share of the near surface in the mixed px
};

// @param edge last px of the near surface
// @param out direction to the far surface, 1 or -1
// @param nearRoom distance in px from the edge to a px that is certainly near
// @param farRoom px beyond the edge before one that is certainly far
Border findBorder(const std::uint8_t* bgr, int edge, int out, int nearRoom, int farRoom) {
    constexpr double kAllNear = 0.9;
    constexpr double kAllFar = 0.1;
    constexpr double kUnclear = 0.25;
    if (nearRoom < 1 || farRoom < 1) return {};
    const std::uint8_t* near = bgr + 3 * static_cast<std::ptrdiff_t>(edge - out * nearRoom);
    const std::uint8_t* far = bgr + 3 * static_cast<std::ptrdiff_t>(edge + out * (farRoom + 1));
    double contrast = 0;
    for (int c = 0; c < 3; ++c)
        contrast += (near[c] - far[c]) * (near[c] - far[c]);
    if (contrast < kBorderContrast * kBorderContrast) return {};
    const auto share = [&](int k) { // share of the near surface in the px k beyond the edge
        const std::uint8_t* mix = bgr + 3 * static_cast<std::ptrdiff_t>(edge + out * k);
        double sum = 0;
        for (int c = 0; c < 3; ++c)
            sum += (mix[c] - far[c]) * (near[c] - far[c]);
        return sum / contrast;
    };
    Border border;
    int k = 1 - nearRoom;
    while (k <= farRoom && share(k) >= kAllNear)
        ++k;
    border.gain = k - 1;
    if (border.gain < -1 || border.gain > 1) return {};
    if (k <= farRoom && share(k) > kAllFar) {
        border.mixed = 1;
        border.extra = share(k);
        ++k;
    }
    for (; k <= farRoom; ++k)
        if (share(k) > (border.mixed == 1 && k == border.gain + 2 ? kAllFar : kUnclear)) return {};
    border.isClear = true;
    return border;
}

void placeBorder(const std::uint8_t* bgr, int dilation, int leftLength, int rightLength,
                 LayeredSurface& left, LayeredSurface& right, std::vector<float>& offsets) {
    constexpr int kLookedAt = 2; // px beside the tear, on either side
    const float leftOffset = offsets[static_cast<std::size_t>(left.last)];
    const float rightOffset = offsets[static_cast<std::size_t>(right.first)];
    const bool leftIsNear = leftOffset > rightOffset;
    const int out = leftIsNear ? 1 : -1; // from near to far
    const int edge = leftIsNear ? left.last : right.first;
    // A surface keeps at least one px, even if both ends shrink.
    const int nearRoom =
        std::min(kLookedAt + dilation, ((leftIsNear ? leftLength : rightLength) - 1) / 2);
    const int farRoom = std::min(kLookedAt, ((leftIsNear ? rightLength : leftLength) - 1) / 2);
    const Border border = findBorder(bgr, edge, out, nearRoom, farRoom);
    for (int k = border.gain + 1; k <= 0; ++k)
        offsets[static_cast<std::size_t>(edge + out * k)] = leftIsNear ? rightOffset : leftOffset;
    for (int k = std::min(border.gain, 0) + 1; k <= border.gain + border.mixed; ++k)
        offsets[static_cast<std::size_t>(edge + out * k)] = leftIsNear ? leftOffset : rightOffset;
    const int nearEnd = edge + out * border.gain;
    const int farEnd = nearEnd + out * (border.mixed + 1);
    left.last = leftIsNear ? nearEnd : farEnd;
    right.first = leftIsNear ? farEnd : nearEnd;
    (leftIsNear ? left.clearRight : right.clearLeft) = border.isClear;
    (leftIsNear ? left.rightExtra : right.leftExtra) = static_cast<float>(border.extra);
}

} // namespace

cv::Mat withoutLevels(const cv::Mat& depth, double reach) {
    const double level = visibleLevel(depth, reach);
    if (level == 0) return depth;
    const cv::Mat given = withinRange(depth);
    const Sweep sweep(given, level);
    cv::Mat now = given.clone();
    cv::Mat next(depth.size(), CV_32FC1);
    for (const int stride : kStrides) {
        for (int i = 0; i < kSweeps; ++i) {
            overRows(depth.rows, [&](int y) { sweep.row(now, y, stride, next.ptr<float>(y)); });
            cv::swap(now, next);
        }
    }
    return now;
}

void cutSurfaces(const std::uint8_t* bgr, std::vector<float>& offsets,
                 const LayeredSettings& options, std::vector<LayeredSurface>& surfaces) {
    const int width = static_cast<int>(offsets.size());
    const double tear = options.tearStep();
    std::vector<float> buffer;
    std::vector<int> steps;
    dilateNear(offsets, tear, options.edgeDilationPixels, buffer, steps);
    findSteps(offsets.data(), offsets.size(), tear, steps);
    steps.push_back(width - 1);
    surfaces.clear();
    int first = 0;
    for (const int last : steps) {
        LayeredSurface surface;
        surface.first = first;
        surface.last = last;
        surfaces.push_back(surface);
        first = last + 1;
    }
    std::vector<int> lengths; // before any border moves, so left and right are symmetric
    lengths.reserve(surfaces.size());
    for (const LayeredSurface& surface : surfaces)
        lengths.push_back(surface.last - surface.first + 1);
    for (std::size_t i = 1; i < surfaces.size(); ++i)
        placeBorder(bgr, options.edgeDilationPixels, lengths[i - 1], lengths[i], surfaces[i - 1],
                    surfaces[i], offsets);
}

BorderShares::BorderShares(const cv::Mat& depth, double focus, int mixedPixels)
    : depth_(depth), focus_(static_cast<float>(focus)), mostColumns_(4 * (mixedPixels + 1)) {
    const double sigma = 0.7 + mixedPixels;
    const int reach = static_cast<int>(std::ceil(2.5 * sigma));
    for (int k = -reach; k <= reach; ++k)
        weights_.push_back(
            static_cast<int>(std::lround(256 * std::exp(-k * k / (2 * sigma * sigma)))));
    if (mixedPixels == 0) return;
    const int side = 2 * mixedPixels + 1;
    depth_ = cv::Mat(); // in new memory
    cv::erode(withinRange(depth), depth_,
              cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}), {-1, -1}, 1,
              cv::BORDER_REPLICATE);
}

// Share of the px around a px whose depth is not larger, in 1/256.
int BorderShares::shareBehind(int row, int x, float middle) const {
    const int reach = static_cast<int>(weights_.size()) / 2;
    std::int64_t all = 0;
    std::int64_t behind = 0;
    for (int v = -reach; v <= reach; ++v) {
        const auto* const depths = depth_.ptr<float>(std::clamp(row + v, 0, depth_.rows - 1));
        int sum = 0;
        int sumBehind = 0;
        for (int u = -reach; u <= reach; ++u) {
            const int weight = weights_[static_cast<std::size_t>(u + reach)];
            sum += weight;
            const bool isNear = depths[std::clamp(x + u, 0, depth_.cols - 1)] > middle; // not NaN
            if (!isNear) sumBehind += weight;
        }
        const std::int64_t weight = weights_[static_cast<std::size_t>(v + reach)];
        all += weight * sum;
        behind += weight * sumBehind;
    }
    // cppcheck-suppress zerodiv // there is always a weight
    return static_cast<int>((256 * behind + all / 2) / all);
}

void BorderShares::find(int row, const std::vector<float>& offsets,
                        std::vector<LayeredSurface>& surfaces, std::uint8_t* shares) const {
    constexpr int kLeastShare = 3; // in 1/256; less is not seen
    std::fill_n(shares, depth_.cols, std::uint8_t{0});
    const auto offsetAt = [&](int x) { return offsets[static_cast<std::size_t>(x)]; };
    // @param end column of the near surface, at the border
    // @param out direction to the surface behind, 1 or -1
    const auto soften = [&](int end, int out, int most, float behind) {
        const float middle = focus_ + (offsetAt(end) + behind) / 2;
        for (int k = 0; k < most; ++k) {
            const int share = shareBehind(row, end - out * k, middle);
            if (share < kLeastShare) return k;
            shares[end - out * k] = static_cast<std::uint8_t>(std::min(share, 255));
        }
        return most;
    };
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        LayeredSurface& surface = surfaces[i];
        // The borders of thin things stay apart, so that a px belongs to one of them.
        const int most = std::min(mostColumns_, (surface.last - surface.first) / 2);
        if (i > 0) {
            const float behind = offsetAt(surfaces[i - 1].last);
            if (behind < offsetAt(surface.first) && !surface.clearLeft)
                surface.softLeft = soften(surface.first, -1, most, behind);
        }
        if (i + 1 < surfaces.size()) {
            const float behind = offsetAt(surfaces[i + 1].first);
            if (behind < offsetAt(surface.last) && !surface.clearRight)
                surface.softRight = soften(surface.last, 1, most, behind);
        }
    }
}

} // namespace altiro3D
