#include "native/eye_blur.hpp"

#include "base/srgb_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace altiro3D {

namespace {

constexpr std::array<float, 3> kLuminance{0.0722F, 0.7152F, 0.2126F}; // BT.709, BGR
constexpr double kColourBlur = 2;                                     // times that of luminance

// What leaves the lenses in one direction: docs/mathematics.md, 2a.
class LensLight {
  public:
    LensLight(const cv::Mat& native, const LensPhases& phases, double phase)
        : native_(native), phases_(phases),
          eye_(static_cast<std::int64_t>((phase - std::floor(phase)) * kOne)) {
        const LensGeometry& g = phases.geometry();
        const double pixel = (g.inverted ? -1 : 1) * g.periodsPerWidth / g.panelWidth;
        for (int x = 0; x < g.panelWidth; ++x)
            expected_.push_back(std::llround(x * pixel * kOne));
        if (!g.cells.empty()) balance();
    }

    // Reads a row of the Native twice, writes its light, 3 floats a px; arithmetic limits the
    // speed.
    void row(int y, float* light) const {
        struct Lit {
            std::uint64_t distance = std::numeric_limits<std::uint64_t>::max();
            int index = 0; // in the row, BGR
        };
        const int columns = native_.cols;
        std::vector<std::int64_t> places(3 * static_cast<std::size_t>(columns)); // BGR
        placesOf(y, places);
        const auto lensOf = [](std::int64_t place) { return (place + kHalf) >> 32; };
        const auto ends = std::minmax_element(places.begin(), places.end());
        const std::int64_t first = lensOf(*ends.first);
        std::vector<Lit> lenses(static_cast<std::size_t>(lensOf(*ends.second) - first + 1));
        for (int i = 0; i < 3 * columns; ++i) {
            const std::int64_t place = places[static_cast<std::size_t>(i)];
            const std::int64_t lens = lensOf(place);
            const auto distance = static_cast<std::uint64_t>(std::abs(place - lens * kPeriod));
            Lit& lit = lenses[static_cast<std::size_t>(lens - first)];
            if (distance < lit.distance) lit = {distance, i};
        }
        std::fill_n(light, 3 * columns, 0.0F);
        const uchar* row = native_.ptr<uchar>(y);
        for (int i = 0; i < 3 * columns; ++i) { // a third of a px, the light of three sub-pixels
            const std::int64_t lens = lensOf(places[static_cast<std::size_t>(i)]);
            const int lit = lenses[static_cast<std::size_t>(lens - first)].index;
            const int colour = lit % 3;
            light[i - i % 3 + colour] +=
                gains_[static_cast<std::size_t>(colour)] * srgb_.ofCode(row[lit]);
        }
    }

    const SrgbLight& srgb() const { return srgb_; }

  private:
    static constexpr double kOne = 4294967296.0;
    static constexpr std::int64_t kPeriod = std::int64_t{1} << 32;
    static constexpr std::int64_t kHalf = kPeriod / 2;

    // The place of each sub-pixel of a row, in 2^-32 lenses from the eye's line in one of them.
    void placesOf(int y, std::vector<std::int64_t>& places) const {
        const std::uint32_t start = phases_.columnPhases(y, 0)[0] + phases_.rowPhase(y, 0);
        for (int colour = 0; colour < 3; ++colour) {
            const std::uint32_t* columns = phases_.columnPhases(y, 2 - colour);
            const std::uint32_t row = phases_.rowPhase(y, 2 - colour);
            for (int x = 0; x < native_.cols; ++x) {
                const std::int64_t near = start + expected_[static_cast<std::size_t>(x)];
                const auto off =
                    static_cast<std::int32_t>(columns[x] + row - static_cast<std::uint32_t>(near));
                places[static_cast<std::size_t>(3 * x + colour)] = near + off - eye_;
            }
        }
    }

    // On panels with cells the sub-pixels of a colour are the nearest ones over more or less than a
    // third of the width. Gives each colour the light of a third. Cells repeat after 4 rows.
    void balance() {
        std::array<double, 3> widths{};
        std::vector<std::int64_t> places(3 * expected_.size());
        std::vector<std::pair<std::int64_t, std::size_t>> order(places.size());
        for (int y = 0; y < 4; ++y) {
            placesOf(y, places);
            for (std::size_t i = 0; i < places.size(); ++i)
                order[i] = {places[i], i % 3};
            std::sort(order.begin(), order.end());
            for (std::size_t i = 1; i + 1 < order.size(); ++i)
                widths[order[i].second] +=
                    static_cast<double>(order[i + 1].first - order[i - 1].first);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            gains_[i] = static_cast<float>((widths[0] + widths[1] + widths[2]) / (3 * widths[i]));
        }
    }

    const cv::Mat& native_;
    const LensPhases& phases_;
    std::int64_t eye_;
    std::vector<std::int64_t> expected_;  // place of each px from the first, within half a lens
    std::array<float, 3> gains_{1, 1, 1}; // BGR
    const SrgbLight& srgb_ = SrgbLight::instance();
};

// Weights of a Gaussian from the middle on, 4 standard deviations.
std::vector<float> gaussian(double sigma) {
    const int reach = static_cast<int>(std::ceil(4 * sigma));
    std::vector<double> weights;
    double sum = 0;
    for (int i = 0; i <= reach; ++i) {
        weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
        sum += (i == 0 ? 1 : 2) * weights.back();
    }
    std::vector<float> kernel;
    for (const double weight : weights)
        kernel.push_back(static_cast<float>(weight / sum));
    return kernel;
}

// Index of a row or column that is reflected at the ends: 1 0 | 0 1 2 | 2 1
int reflected(int i, int count) {
    const int turn = 2 * count;
    const int inTurn = (i % turn + turn) % turn;
    return std::min(inTurn, turn - 1 - inTurn);
}

// Blurs rows down, then the result across. Reads the rows, writes one; memory limits the speed.
class Blur {
  public:
    Blur(double sigma, int columns, int channels)
        : kernel_(gaussian(sigma)), columns_(columns), channels_(channels),
          down_(static_cast<std::size_t>(channels * (columns + 2 * reach()))),
          across_(static_cast<std::size_t>(channels * columns)) {}

    int reach() const { return static_cast<int>(kernel_.size()) - 1; }

    // @param rows the row in the middle of 2 reach() + 1, which are `step` apart
    const float* row(const float* middle, std::ptrdiff_t step) {
        const int count = columns_ * channels_;
        float* down = down_.data() + reach() * channels_;
        for (int i = 0; i < count; ++i)
            down[i] = kernel_[0] * middle[i];
        for (int k = 1; k <= reach(); ++k) {
            const float weight = kernel_[static_cast<std::size_t>(k)];
            const float* above = middle - k * step;
            const float* below = middle + k * step;
            for (int i = 0; i < count; ++i)
                down[i] += weight * (above[i] + below[i]);
        }
        for (int x = 1; x <= reach(); ++x) {
            for (int c = 0; c < channels_; ++c) {
                down[-x * channels_ + c] = down[reflected(-x, columns_) * channels_ + c];
                const int beyond = columns_ - 1 + x;
                down[beyond * channels_ + c] = down[reflected(beyond, columns_) * channels_ + c];
            }
        }
        float* across = across_.data();
        for (int i = 0; i < count; ++i)
            across[i] = kernel_[0] * down[i];
        for (int k = 1; k <= reach(); ++k) {
            const float weight = kernel_[static_cast<std::size_t>(k)];
            const int away = k * channels_;
            for (int i = 0; i < count; ++i)
                across[i] += weight * (down[i - away] + down[i + away]);
        }
        return across;
    }

  private:
    std::vector<float> kernel_;
    int columns_;
    int channels_;
    std::vector<float> down_;
    std::vector<float> across_;
};

} // namespace

void seeBlurred(const cv::Mat& native, const LensPhases& phases, double phase, double blur,
                cv::Mat& seen) {
    constexpr int kStripe = 64; // rows; their light and that of rows around them is kept
    const LensLight light(native, phases, phase);
    const int columns = native.cols;
    const int stripes = (native.rows + kStripe - 1) / kStripe;
    cv::parallel_for_(cv::Range(0, stripes), [&](const cv::Range& range) {
        Blur colour(kColourBlur * blur, columns, 3);
        Blur luminance(blur, columns, 1);
        const int reach = colour.reach();
        cv::Mat colours(kStripe + 2 * reach, 3 * columns, CV_32FC1);
        cv::Mat greys(colours.rows, columns, CV_32FC1);
        for (int stripe = range.start; stripe < range.end; ++stripe) {
            const int first = stripe * kStripe;
            const int last = std::min(first + kStripe, native.rows);
            for (int y = first - reach; y < last + reach; ++y) {
                auto* from = colours.ptr<float>(y - first + reach);
                auto* to = greys.ptr<float>(y - first + reach);
                light.row(reflected(y, native.rows), from);
                for (int x = 0; x < columns; ++x, from += 3) {
                    to[x] =
                        kLuminance[0] * from[0] + kLuminance[1] * from[1] + kLuminance[2] * from[2];
                }
            }
            for (int y = first; y < last; ++y) {
                const int row = y - first + reach;
                const float* c = colour.row(colours.ptr<float>(row), 3 * columns);
                const float* l = luminance.row(greys.ptr<float>(row), columns);
                auto* out = seen.ptr<uchar>(y);
                for (int x = 0; x < columns; ++x, c += 3, out += 3) {
                    const float own =
                        kLuminance[0] * c[0] + kLuminance[1] * c[1] + kLuminance[2] * c[2];
                    const float scale = own > 0 ? l[x] / own : 0.0F;
                    for (int i = 0; i < 3; ++i)
                        out[i] = light.srgb().code(scale * c[i]);
                }
            }
        }
    });
}

} // namespace altiro3D
