#include "altiro3D/lens_view.hpp"

#include "altiro3D/display.hpp"
#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "display/lens_phase.hpp"
#include "native/eye_blur.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr double kUsualConeDegrees = 40;
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
// nearer than the best so far. Reads one row and updates three rows of numbers; arithmetic limits
// the speed.
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
    cv::parallel_for_(cv::Range(0, rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            nearestLit(phases.columnPhases(y, channel), phases.rowPhase(y, channel), columns, lit,
                       nearest.ptr<std::uint16_t>(y));
        }
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

} // namespace

double viewConeDegrees(const Calibration& calibration) {
    if (calibration.viewCone > 0) return calibration.viewCone;
    const DisplayModel* model = findDisplayModel(calibration);
    return model != nullptr ? model->viewConeDegrees : kUsualConeDegrees;
}

LensEye eyeAtAngle(const Calibration& calibration, double angleDegrees) {
    check(std::isfinite(angleDegrees), "angleDegrees",
          "is " + numberText(angleDegrees) + ", expected a finite number");
    return {0.5 + angleDegrees / viewConeDegrees(calibration), 0};
}

LensEye eyeAtView(int view, int viewCount) {
    check(viewCount >= 1 && viewCount <= 4096, "viewCount",
          "is " + std::to_string(viewCount) + ", expected 1..4096");
    check(view >= 0 && view < viewCount, "view",
          "is " + std::to_string(view) + ", expected 0.." + std::to_string(viewCount - 1));
    return {(view + 0.5) / viewCount, 1.0 / viewCount};
}

double eyeBlur(const Calibration& calibration, double distanceCentimetres) {
    constexpr double kPixels = 3; // of a Portrait at 50 cm
    check(distanceCentimetres >= 10 && distanceCentimetres <= 1000, "distanceCentimetres",
          "is " + numberText(distanceCentimetres) + ", expected 10..1000");
    return std::min(kPixels * calibration.DPI / 324 * distanceCentimetres / 50, kMaxBlur);
}

void simulateView(const cv::Mat& native, const Calibration& calibration, const LensEye& eye,
                  cv::Mat& seen, InvertViews invert) {
    const LensPhases phases(lensGeometry(calibration, invert));
    const LensGeometry& g = phases.geometry();
    checkType(native, {CV_8UC3}, "native", "8-bit BGR");
    check(std::isfinite(eye.phase), "phase",
          "is " + numberText(eye.phase) + ", expected a finite number");
    check(eye.spot == 0 || (eye.spot >= kMinSpot && eye.spot <= 1), "spot",
          "is " + numberText(eye.spot) + ", expected 0 or 1/4096..1");
    check(eye.blur >= 0 && eye.blur <= kMaxBlur, "blur",
          "is " + numberText(eye.blur) + ", expected 0..64");
    if (native.size() != cv::Size(g.panelWidth, g.panelHeight)) {
        throw Error(ErrorCode::Mismatch, "native",
                    "has " + sizeText(native.size()) + " px, expected the panel's " +
                        pairText(g.panelWidth, g.panelHeight) + " px");
    }
    const cv::Mat source = shareMemory(native, seen) ? native.clone() : native;
    seen.create(source.size(), source.type());
    if (eye.blur > 0) {
        seeBlurred(source, phases, eye.phase, eye.blur, seen);
    } else {
        const LitPhases lit = litPhases(eye, phases);
        for (int channel = 0; channel < 3; ++channel)
            lightChannel(source, phases, lit, channel, seen);
    }
    if (g.mirrorX || g.mirrorY) cv::flip(seen, seen, g.mirrorX ? (g.mirrorY ? -1 : 1) : 0);
}

} // namespace altiro3D
