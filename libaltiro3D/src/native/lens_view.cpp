#include "altiro3D/lens_view.hpp"

#include "altiro3D/display.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "base/srgb_light.hpp"
#include "display/lens_phase.hpp"
#include "native/panel_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace altiro3D {

namespace {

constexpr double kUsualConeDegrees = 40;
constexpr double kPrintSpot = 1.5; // px, which have no sub-pixels
constexpr double kMinSpot = 1.0 / 4096;
constexpr double kMaxBlur = 64;
constexpr std::uint16_t kNone = 0x7fff; // no column: panels have at most 16384

// The lit phases: first, first + 1, ... first + count - 1 modulo 2^32, in 2^-32 lens periods.
struct LitPhases {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
};

// Reduced by the error of a phase on both sides, so no sub-pixel of a neighbouring view is lit.
LitPhases litPhases(const LensEye& eye, const LensPhases& phases) {
    constexpr double kOne = 4294967296.0;
    const double spot = eye.spot > 0 ? eye.spot : 1 / phases.geometry().lensPeriodSubpixels;
    const double low = eye.phase - std::min(spot, 1.0) / 2;
    const double margin = phases.phaseError() + 1.0;
    const double first = std::floor((low - std::floor(low)) * kOne + margin);
    const double count = std::floor(std::min(spot, 1.0) * kOne - 2 * margin);
    return {static_cast<std::uint32_t>(static_cast<std::uint64_t>(first)),
            static_cast<std::uint32_t>(std::max(count, 0.0))};
}

// For each column of a row, finds the nearest lit column, on a tie the left one; kNone without any.
// Reads `columns` phases and writes as many columns twice; memory limits the speed.
void nearestLit(const std::uint32_t* columnPhases, std::uint32_t rowPhase, int columns,
                const LitPhases& lit, std::uint16_t* nearest) {
    std::uint16_t last = kNone;
    for (int x = 0; x < columns; ++x) {
        if (columnPhases[x] + rowPhase - lit.first < lit.count) last = static_cast<uint16_t>(x);
        nearest[x] = last;
    }
    std::uint16_t next = kNone;
    for (int x = columns - 1; x >= 0; --x) {
        if (nearest[x] == x) next = nearest[x];
        if (next != kNone && (nearest[x] == kNone || next - x < x - nearest[x])) nearest[x] = next;
    }
}

// Includes one more row, which must have a lit column: takes its nearest column where that is
// nearer than the best so far. Reads one row, updates three; arithmetic limits the speed.
void takeNearer(const std::uint16_t* nearest, int columns, int rowDistance, int row, int* best,
                int* bestRow, int* bestColumn) {
    for (int x = 0; x < columns; ++x) {
        const int across = nearest[x] - x;
        const int distance = across * across + rowDistance * rowDistance;
        const bool nearer = distance < best[x];
        best[x] = nearer ? distance : best[x];
        bestRow[x] = nearer ? row : bestRow[x];
        bestColumn[x] = nearer ? nearest[x] : bestColumn[x];
    }
}

// Fills one colour of the picture.
void lightChannel(const cv::Mat& native, const LensPhases& phases, const LitPhases& lit,
                  int channel, cv::Mat& seen) {
    const int columns = native.cols;
    const int rows = native.rows;
    const int place = 2 - channel; // index of the colour in a BGR px
    cv::Mat nearest(native.size(), CV_16UC1);
    overRows(rows, [&](int y) {
        nearestLit(phases.columnPhases(y, channel), phases.rowPhase(y, channel), columns, lit,
                   nearest.ptr<std::uint16_t>(y));
    });
    std::vector<int> litRows; // if one column is lit, all columns have a nearest one
    for (int y = 0; y < rows; ++y)
        if (*nearest.ptr<std::uint16_t>(y) != kNone) litRows.push_back(y);
    constexpr int kFar = std::numeric_limits<int>::max();
    cv::parallel_for_(cv::Range(0, rows), [&](const cv::Range& range) {
        std::vector<int> best(static_cast<std::size_t>(columns));
        std::vector<int> bestRow(best.size());
        std::vector<int> bestColumn(best.size());
        for (int y = range.start; y < range.end; ++y) {
            std::fill(best.begin(), best.end(), kFar);
            int worst = kFar;
            auto below =
                std::upper_bound(litRows.begin(), litRows.end(), y); // y itself belongs to `above`
            auto above = below;
            while (above != litRows.begin() || below != litRows.end()) {
                const int up = above != litRows.begin() ? y - *(above - 1) : kFar;
                const int down = below != litRows.end() ? *below - y : kFar;
                const int d = std::min(up, down);
                if (d > 0 && d > worst / d) break;
                const auto take = [&](int row) {
                    takeNearer(nearest.ptr<std::uint16_t>(row), columns, d, row, best.data(),
                               bestRow.data(), bestColumn.data());
                };
                if (up == d) take(*--above);
                if (down == d) take(*below++);
                worst = *std::max_element(best.begin(), best.end());
            }
            uchar* out = seen.ptr<uchar>(y) + place;
            for (int x = 0; x < columns; ++x, out += 3) {
                const auto i = static_cast<std::size_t>(x);
                *out = litRows.empty() ? uchar{0}
                                       : native.ptr<uchar>(bestRow[i])[3 * bestColumn[i] + place];
            }
        }
    });
}

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

    // Reads a Native's row twice, writes its light, 3 floats a px; arithmetic limits the speed.
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
        for (int i = 0; i < 3 * columns; ++i) { // thirds of px, with the light that the lens shows
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

    // On panels with cells, the sub-pixels of one colour are the nearest ones over more or less
    // than a third of the width. The gains give each colour the light of a third. Cells repeat
    // after 4 rows.
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

// What an eye sees of a Native: the light of the sub-pixel that each lens shows in each row, over
// the width of the lens, blurred. Mirrored panels stay mirrored.
// @param native [panel, CV_8UC3, BGR]
// @param phases of the display
// @param phase that the eye sees
// @param blur standard deviation for luminance, px, > 0; colour is blurred twice as far
// @param seen [as native]; no memory in common with it
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

// The same display turned by a quarter: what is up comes to the right.
Calibration turned(const Calibration& calibration) {
    Calibration c = calibration;
    std::swap(c.screenW, c.screenH);
    c.slope = 1 / c.slope;
    if (c.slope < 0) c.center = -c.center; // the phase is negated
    if (c.subpixelCells.empty()) c.subpixelCells.push_back({{0, 1.0 / 3, 2.0 / 3}, {0, 0, 0}});
    for (SubpixelCell& cell : c.subpixelCells)
        std::swap(cell.x, cell.y);
    return c;
}

cv::Mat turned(const cv::Mat& picture) {
    cv::Mat result;
    cv::transpose(picture, result);
    cv::flip(result, result, -1);
    return result;
}

// For horizontal lenses: turns display and Native by a quarter, so that the lenses are vertical.
void simulateLying(const cv::Mat& native, const Calibration& calibration, const LensEye& eye,
                   cv::Mat& seen, bool inverted) {
    const bool isNegated = calibration.slope < 0;
    cv::Mat standing;
    simulateView(turned(native), turned(calibration), eye, standing,
                 inverted != isNegated ? InvertViews::On : InvertViews::Off);
    seen = turned(standing);
}

} // namespace

double viewConeDegrees(const Calibration& calibration) {
    if (calibration.viewCone > 0) return calibration.viewCone;
    const DisplayModel* model = findDisplayModel(calibration);
    return model != nullptr ? model->viewConeDegrees : kUsualConeDegrees;
}

LensEye eyeAtAngle(const Calibration& calibration, double angleDegrees) {
    checkNumber(std::isfinite(angleDegrees), "angleDegrees", angleDegrees, "a finite number");
    return {0.5 + angleDegrees / viewConeDegrees(calibration), 0};
}

LensEye eyeAtView(int view, int viewCount) {
    checkRange("viewCount", viewCount, 1, 4096);
    checkRange("view", view, 0, viewCount - 1);
    return {(view + 0.5) / viewCount, 1.0 / viewCount};
}

double eyeBlur(const Calibration& calibration, double distanceCentimetres) {
    constexpr double kPixels = 3; // px of a Portrait at 50 cm
    checkRange("distanceCentimetres", distanceCentimetres, 10, 1000);
    return std::min(kPixels * calibration.DPI / 324 * distanceCentimetres / 50, kMaxBlur);
}

void simulateView(const cv::Mat& native, const Calibration& calibration, const LensEye& eye,
                  cv::Mat& seen, InvertViews invert) try {
    const LensPhases phases(lensGeometry(calibration, invert));
    const LensGeometry& g = phases.geometry();
    requirePanelSize(g, "simulated view");
    checkType(native, {CV_8UC3}, "native", "8-bit BGR");
    checkNumber(std::isfinite(eye.phase), "phase", eye.phase, "a finite number");
    checkNumber(eye.spot == 0 || (eye.spot >= kMinSpot && eye.spot <= 1), "spot", eye.spot,
                "0 or 1/4096..1");
    checkRange("blur", eye.blur, 0, kMaxBlur);
    checkSize(native.size(), {g.panelWidth, g.panelHeight}, "native", "the panel's ");
    const bool isPrint = calibration.sheet && calibration.sheet->isPrint;
    check(eye.blur == 0 || !isPrint, "eye",
          "blurs the light of sub-pixels, which a print has not, expected one without blur");
    if (calibration.sheet && g.isLying() && g.cells.size() < 2 && !g.mirrorX && !g.mirrorY)
        return simulateLying(native, calibration, eye, seen, g.inverted);
    LensEye shown = eye;
    if (const std::vector<int>& order = g.viewOrder; !order.empty()) { // phase that shows the view
        const auto count = static_cast<double>(order.size());
        const double place = (eye.phase - std::floor(eye.phase)) * count;
        const auto slot = std::find(order.begin(), order.end(), static_cast<int>(place));
        shown.phase += (static_cast<double>(slot - order.begin()) - std::floor(place)) / count;
    }
    const cv::Mat source = shareMemory(native, seen) ? native.clone() : native;
    seen.create(source.size(), source.type());
    if (eye.blur > 0) {
        seeBlurred(source, phases, shown.phase, eye.blur, seen);
    } else {
        if (isPrint && eye.spot == 0) // an eye between two px sees both
            shown.spot = std::min(1.0, kPrintSpot * 3 / g.lensPeriodSubpixels);
        const LitPhases lit = litPhases(shown, phases);
        for (int channel = 0; channel < 3; ++channel)
            lightChannel(source, phases, lit, channel, seen);
    }
    if (g.mirrorX || g.mirrorY) cv::flip(seen, seen, g.mirrorX ? (g.mirrorY ? -1 : 1) : 0);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
