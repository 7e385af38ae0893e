// Method Fast: view(x, y) = photo(x + shift (depth(x, y) - focus), y), linear, borders repeated.
// Each refinement reads the depth again at the source position found so far. Without refinement,
// places are computed in whole numbers (fast_row.hpp) unless the parallax is very large.

#include "base/pixel_rows.hpp"
#include "views/depth_offsets.hpp"
#include "views/fast/fast_row.hpp"
#include "views/view_methods.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/core.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/fast/fast.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// Source positions of view pixels in a row of the photo, by method Fast: column + shift * offset,
// clamped to the row. Each refinement step reads the offset again, linearly, at the position found
// so far. All rows are padded (kRowPadding); the padding is read and written.
// @param columns column of each of `count` pixels
// @param ownOffsets depth - focus in that column
// @param shifts p S/2 of each, px, finite
// @param offsets depth - focus of each column of the photo; the last one is repeated
// @param width columns of the photo
// @param refinement number of steps, >= 0
// @param places result, 0..width-1
//
// Loads and stores limit the speed; with refinement, one gather of two offsets per step.
void fastPlacesOn(const float* HWY_RESTRICT columns, const float* HWY_RESTRICT ownOffsets,
                  const float* HWY_RESTRICT shifts, std::size_t count,
                  const float* HWY_RESTRICT offsets, int width, int refinement,
                  float* HWY_RESTRICT places) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const auto left = hn::Zero(d);
    const auto right = hn::Set(d, static_cast<float>(width - 1));
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto column = hn::LoadU(d, columns + i);
        const auto shift = hn::LoadU(d, shifts + i);
        auto place = hn::Add(column, hn::Mul(shift, hn::LoadU(d, ownOffsets + i)));
        place = hn::Min(hn::Max(place, left), right);
        for (int step = 0; step < refinement; ++step) {
            const auto before = hn::ConvertTo(whole, place);
            const auto first = gatherFloats(d, offsets, before);
            const auto second = gatherFloats(d, offsets + 1, before);
            const auto part = hn::Sub(place, hn::ConvertTo(d, before));
            const auto offset = hn::Add(first, hn::Mul(part, hn::Sub(second, first)));
            place = hn::Add(column, hn::Mul(shift, offset));
            place = hn::Min(hn::Max(place, left), right);
        }
        hn::StoreU(place, d, places + i);
    }
}

// Samples at places in 1/32 px. A gather of four bytes, of which two are used, limits the speed.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void gatherSamples(D whole, const std::uint8_t* plane, V place,
                              std::uint8_t* HWY_RESTRICT values) {
    const auto byte = hn::Set(whole, 255);
    const auto four = gatherBytes4(whole, plane, hn::ShiftRight<5>(place));
    const auto first = hn::And(four, byte);
    const auto second = hn::And(hn::ShiftRight<8>(four), byte);
    const auto product = hn::Mul(hn::Sub(second, first), hn::And(place, hn::Set(whole, 31)));
    const auto sum = hn::Add(hn::ShiftLeft<5>(first), product);
    storeBytes(whole, hn::ShiftRight<5>(hn::Add(sum, hn::Set(whole, 16))), values);
}

#if HWY_TARGET != HWY_SCALAR
// The same at places in 1/32 px from the start of a window.
template <int kTables, class V>
HWY_INLINE void windowSamples(const ByteWindow<kTables>& window, V place,
                              std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int16_t> narrow;
    const hn::Rebind<std::uint8_t, decltype(narrow)> bytes;
    const auto pairs = window.pairs(hn::ShiftRight<5>(place));
    const auto sum = mixPairs<5>(pairs, hn::And(place, hn::Set(narrow, 31)));
    // (sum + 16) >> 5, as (sum 2^10 + 2^14) >> 15
    const auto value = hn::MulFixedPoint15(sum, hn::Set(narrow, 1 << 10));
    hn::StoreU(hn::DemoteTo(bytes, value), bytes, values);
}
#endif

// Calls inWindow(window, first pixel, column where it starts) and elsewhere(first pixel) for runs
// of kWindowPixels pixels.
template <int kTables, class W, class E>
HWY_INLINE void forWindowsOf(const FastRow& row, [[maybe_unused]] const W& inWindow,
                             const E& elsewhere) {
    for (std::size_t begin = 0; begin < row.count; begin += kWindowPixels) {
        [[maybe_unused]] const std::int32_t from = row.windows[begin / kWindowPixels];
#if HWY_TARGET != HWY_SCALAR
        if (HWY_LIKELY(from >= 0)) {
            inWindow(ByteWindow<kTables>(row.plane + from), begin, from);
            continue;
        }
#endif
        elsewhere(begin);
    }
}

template <class W, class E>
HWY_INLINE void forWindows(const FastRow& row, const W& inWindow, const E& elsewhere) {
    switch (row.tables) {
    case 2:
        return forWindowsOf<2>(row, inWindow, elsewhere);
    case 3:
        return forWindowsOf<3>(row, inWindow, elsewhere);
    default:
        return forWindowsOf<4>(row, inWindow, elsewhere);
    }
}

// Samples a plane linearly at places in whole numbers, with the rounding of cv::remap.
// @param shifts wholeShift() of each pixel, in kShiftSteps
// @param values result, `count` and padding
//
// Arithmetic limits the speed: some 25 operations per vector of 16-bit lanes.
void fastWholeSamplesOn(const FastRow& row, const std::int16_t* HWY_RESTRICT shifts,
                        std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::int16_t> d;
    const int last = 32 * (row.width - 1);
    forWindows(
        row,
        [&](const auto& window, std::size_t begin, std::int32_t from) HWY_ATTR {
            const auto left = hn::Set(d, static_cast<std::int16_t>(std::max(-32 * from, -32768)));
            const auto right =
                hn::Set(d, static_cast<std::int16_t>(std::min(last - 32 * from, 32767)));
            for (std::size_t i = begin; i < begin + kWindowPixels; i += hn::Lanes(d)) {
                const auto away =
                    hn::MulFixedPoint15(hn::LoadU(d, shifts + i), hn::LoadU(d, row.offsets + i));
                const auto place = hn::Add(hn::LoadU(d, row.inWindow + i), away);
                windowSamples(window, hn::Min(hn::Max(place, left), right), values + i);
            }
        },
        [&](std::size_t begin) HWY_ATTR {
            const hn::ScalableTag<std::int32_t> whole;
            const hn::Rebind<std::int16_t, decltype(whole)> narrow;
            const auto left = hn::Zero(whole);
            const auto right = hn::Set(whole, last);
            for (std::size_t i = begin; i < begin + kWindowPixels; i += hn::Lanes(whole)) {
                const auto away = hn::MulFixedPoint15(hn::LoadU(narrow, shifts + i),
                                                      hn::LoadU(narrow, row.offsets + i));
                const auto place =
                    hn::Add(hn::LoadU(whole, row.columns + i), hn::PromoteTo(whole, away));
                gatherSamples(whole, row.plane, hn::Min(hn::Max(place, left), right), values + i);
            }
        });
}

// Samples a plane linearly at given places, rounded to 1/32 px, with the rounding of cv::remap.
// @param places from fastPlaces()
// @param values result, `count` and padding
void fastSamplesAtOn(const FastRow& row, const float* HWY_RESTRICT places,
                     std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> whole;
    const std::size_t lanes = hn::Lanes(d);
    const auto placesAt = [&](std::size_t i) HWY_ATTR {
        return smallNearestInt(d, hn::Mul(hn::LoadU(d, places + i), hn::Set(d, 32.0F)));
    };
    forWindows(
        row,
        [&]([[maybe_unused]] const auto& window, [[maybe_unused]] std::size_t begin,
            [[maybe_unused]] std::int32_t from) HWY_ATTR {
#if HWY_TARGET != HWY_SCALAR
            const OrderedPack pack;
            const auto start = hn::Set(whole, 32 * from);
            for (std::size_t i = begin; i < begin + kWindowPixels; i += 2 * lanes)
                windowSamples(
                    window, pack(hn::Sub(placesAt(i), start), hn::Sub(placesAt(i + lanes), start)),
                    values + i);
#endif
        },
        [&](std::size_t begin) HWY_ATTR {
            for (std::size_t i = begin; i < begin + kWindowPixels; i += lanes)
                gatherSamples(whole, row.plane, placesAt(i), values + i);
        });
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(fastPlacesOn);
HWY_EXPORT(fastWholeSamplesOn);
HWY_EXPORT(fastSamplesAtOn);

namespace {

// Offsets of a row of depth; the last one is repeated.
void readOffsets(const cv::Mat& depth, int row, double focus, std::vector<float>& offsets) {
    const auto* values = depth.ptr<float>(row);
    offsetsFromFocus(values, static_cast<std::size_t>(depth.cols), focus, offsets.data());
    offsets[static_cast<std::size_t>(depth.cols)] =
        offsets[static_cast<std::size_t>(depth.cols - 1)];
}

// Pixels of a row, as FastRow.
class FastPixels {
  public:
    // @param columns must outlive this @param reach largest distance of positions from them, px
    FastPixels(const std::vector<int>& columns, int reach, int width)
        : shown_(columns), columns_(paddedRow<std::int32_t>(columns.size())),
          inWindow_(paddedRow<std::int16_t>(columns.size())), offsets_(inWindow_),
          windows_(columns, reach), width_(width) {
        for (std::size_t i = 0; i < columns.size(); ++i) {
            columns_[i] = 32 * columns[i];
            const std::int32_t from = windows_.starts[i / kWindowPixels];
            if (from >= 0) inWindow_[i] = static_cast<std::int16_t>(32 * (columns[i] - from));
        }
    }

    // @param offsets wholeOffsets() of each column of the photo
    void open(const std::vector<std::int32_t>& offsets) {
        pickColumns(shown_.data(), shown_.size(), offsets.data(), offsets_.data());
    }

    FastRow row(const std::uint8_t* plane) const {
        return {plane,           columns_.data(),        inWindow_.data(),
                offsets_.data(), windows_.starts.data(), windows_.tables,
                width_,          shown_.size()};
    }

  private:
    const std::vector<int>& shown_;     // columns of the pixels
    std::vector<std::int32_t> columns_; // see FastRow
    std::vector<std::int16_t> inWindow_;
    std::vector<std::int16_t> offsets_;
    RowWindows windows_;
    int width_;
};

class FastSampler : public SubpixelSampler {
  public:
    // @param whole whether to compute in whole numbers, without refinement
    FastSampler(const cv::Mat& photo, const cv::Mat& depth, double focus, int refinement,
                bool whole, const std::vector<int>& columns, double largestShift)
        : photo_(photo), depth_(depth), focus_(focus), refinement_(refinement), whole_(whole),
          columns_(columns),
          pixels_(columns,
                  static_cast<int>(std::ceil(
                      std::min(largestShift * std::max(focus, 1 - focus), 1.0 * photo.cols))),
                  photo.cols),
          offsets_(paddedRow<float>(static_cast<std::size_t>(photo.cols))) {
        for (std::vector<std::uint8_t>& plane : planes_)
            plane = paddedRow<std::uint8_t>(static_cast<std::size_t>(photo.cols));
        if (whole_) {
            wholeOffsets_ = paddedRow<std::int32_t>(static_cast<std::size_t>(photo.cols));
            return;
        }
        columnPlaces_ = paddedRow<float>(columns.size());
        ownOffsets_ = places_ = columnPlaces_;
        std::copy(columns.begin(), columns.end(), columnPlaces_.begin());
    }

    void open(int row) override {
        const auto width = static_cast<std::size_t>(photo_.cols);
        if (whole_) {
            still_ = wholeOffsets(depth_.ptr<float>(row), width, focus_, wholeOffsets_.data());
        } else {
            readOffsets(depth_, row, focus_, offsets_);
            still_ = std::all_of(offsets_.begin(), offsets_.begin() + photo_.cols,
                                 [](float offset) { return offset == 0; });
        }
        if (still_) return;
        splitRow(photo_.ptr<std::uint8_t>(row), width, planes_[0].data(), planes_[1].data(),
                 planes_[2].data());
        for (std::vector<std::uint8_t>& plane : planes_)
            std::fill_n(plane.begin() + photo_.cols, 4, plane[width - 1]);
        if (whole_) return pixels_.open(wholeOffsets_);
        pickColumns(columns_.data(), columns_.size(), offsets_.data(), ownOffsets_.data());
    }

    bool still() const override { return still_; }

    void sample(int channel, const float* shifts, std::uint8_t* values) override {
        HWY_DYNAMIC_DISPATCH(fastPlacesOn)
        (columnPlaces_.data(), ownOffsets_.data(), shifts, columns_.size(), offsets_.data(),
         photo_.cols, refinement_, places_.data());
        HWY_DYNAMIC_DISPATCH(fastSamplesAtOn)(rowOf(channel), places_.data(), values);
    }

    void sampleBySteps(const std::array<const std::int16_t*, 3>& shifts,
                       const std::array<std::uint8_t*, 3>& values) override {
        for (std::size_t channel = 0; channel < 3; ++channel)
            HWY_DYNAMIC_DISPATCH(fastWholeSamplesOn)
        (rowOf(static_cast<int>(channel)), shifts[channel], values[channel]);
    }

  private:
    FastRow rowOf(int channel) const {
        return pixels_.row(planes_[static_cast<std::size_t>(channel)].data());
    }

    const cv::Mat& photo_;
    const cv::Mat& depth_;
    double focus_;
    int refinement_;
    bool whole_;
    const std::vector<int>& columns_;
    FastPixels pixels_;
    bool still_ = false;
    std::array<std::vector<std::uint8_t>, 3> planes_;
    std::vector<float> offsets_; // offsets of the row of the photo
    std::vector<std::int32_t> wholeOffsets_;
    // unless in whole numbers, for each requested column
    std::vector<float> columnPlaces_;
    std::vector<float> ownOffsets_;
    std::vector<float> places_;
};

class FastRows : public RowRenderer {
  public:
    // @param whole whether the sampler computes in whole numbers
    FastRows(const cv::Mat& photo, bool whole, std::unique_ptr<SubpixelSampler> sampler)
        : photo_(photo), whole_(whole), sampler_(std::move(sampler)) {
        const auto width = static_cast<std::size_t>(photo.cols);
        shifts_ = paddedRow<float>(width);
        wholeShifts_ = paddedRow<std::int16_t>(width);
        planes_.fill(paddedRow<std::uint8_t>(width));
    }

    void render(int row, const std::vector<double>& shifts,
                const std::vector<std::uint8_t*>& views) override {
        sampler_->open(row);
        for (std::size_t i = 0; i < shifts.size(); ++i)
            renderView(row, shifts[i], views[i]);
    }

  private:
    void renderView(int row, double shift, std::uint8_t* bgr) {
        const auto width = static_cast<std::size_t>(photo_.cols);
        if (shift == 0 || sampler_->still()) {
            std::memcpy(bgr, photo_.ptr<std::uint8_t>(row), 3 * width);
            return;
        }
        if (whole_) {
            std::fill(wholeShifts_.begin(), wholeShifts_.end(),
                      wholeShift(shift, double{kShiftSteps}));
            const std::int16_t* const same = wholeShifts_.data();
            sampler_->sampleBySteps({same, same, same},
                                    {planes_[0].data(), planes_[1].data(), planes_[2].data()});
        } else {
            const double bounded = std::clamp(shift, -kMaxShift, kMaxShift);
            std::fill(shifts_.begin(), shifts_.end(), static_cast<float>(bounded));
            for (int channel = 0; channel < 3; ++channel)
                sampler_->sample(channel, shifts_.data(),
                                 planes_[static_cast<std::size_t>(channel)].data());
        }
        interleaveRow(planes_[0].data(), planes_[1].data(), planes_[2].data(), width, bgr);
    }

    const cv::Mat& photo_;
    bool whole_;
    std::unique_ptr<SubpixelSampler> sampler_;
    std::vector<float> shifts_;
    std::vector<std::int16_t> wholeShifts_;
    std::array<std::vector<std::uint8_t>, 3> planes_;
};

class FastRenderer : public ViewRenderer {
  public:
    FastRenderer(const cv::Mat& photo, const cv::Mat& depth, const ViewOptions& options,
                 double largestShift)
        : photo_(photo), depth_(depth), focus_(options.focus), refinement_(options.refinement),
          largestShift_(largestShift),
          whole_(refinement_ == 0 && largestShift < double{kMaxWholeShift}),
          columns_(static_cast<std::size_t>(photo.cols)) {
        std::iota(columns_.begin(), columns_.end(), 0);
    }

    void render(double shiftPixels, cv::Mat& view) const override {
        FastRows rows(photo_, whole_, sampler(columns_, {}, std::abs(shiftPixels)));
        const std::vector<double> shifts = {shiftPixels};
        for (int y = 0; y < photo_.rows; ++y)
            rows.render(y, shifts, {view.ptr<std::uint8_t>(y)});
    }

    bool makesRows() const override { return true; }

    std::unique_ptr<RowRenderer> rowRenderer() const override {
        return std::make_unique<FastRows>(photo_, whole_, sampler(columns_, {}, largestShift_));
    }

    double shiftSteps(double largestShift) const override {
        static_cast<void>(largestShift);
        return whole_ ? double{kShiftSteps} : 0;
    }

    std::unique_ptr<SubpixelSampler> sampler(const std::vector<int>& columns,
                                             const std::vector<std::uint8_t>& parts,
                                             double largestShift) const override {
        static_cast<void>(parts);
        return std::make_unique<FastSampler>(photo_, depth_, focus_, refinement_, whole_, columns,
                                             largestShift);
    }

  private:
    cv::Mat photo_;
    cv::Mat depth_;
    double focus_;
    int refinement_;
    double largestShift_;
    bool whole_;               // whether places are computed in whole numbers
    std::vector<int> columns_; // all
};

} // namespace

std::unique_ptr<ViewRenderer> makeFastRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               const ViewOptions& options, double largestShift) {
    return std::make_unique<FastRenderer>(photo, depth, options, largestShift);
}

} // namespace altiro3D
#endif
