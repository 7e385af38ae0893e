// Method Fast: view(x, y) = photo(x + shift (depth(x, y) - focus), y), linear, borders repeated.
// Each refinement reads the depth again at the source position found so far. Without refinement,
// places are computed in whole numbers (fast_row.hpp) unless the parallax is very large.

#include "base/pixel_rows.hpp"
#include "views/depth_offsets.hpp"
#include "views/fast/fast_row.hpp"
#include "views/fast/row_pixels.hpp"
#include "views/view_methods.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/core.hpp>

namespace altiro3D {

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
        if (whole_) {
            pixels_.open(wholeOffsets_);
            return;
        }
        pickColumns(columns_.data(), columns_.size(), offsets_.data(), ownOffsets_.data());
    }

    bool still() const override { return still_; }

    void sample(int channel, const float* shifts, std::uint8_t* values) override {
        fastPlaces(columnPlaces_.data(), ownOffsets_.data(), shifts, columns_.size(),
                   offsets_.data(), photo_.cols, refinement_, places_.data());
        fastSamplesAt(rowOf(channel), places_.data(), values);
    }

    void sampleWhole(const std::array<const std::int16_t*, 3>& shifts,
                     const std::array<std::uint8_t*, 3>& values) override {
        for (std::size_t channel = 0; channel < 3; ++channel)
            fastWholeSamples(rowOf(static_cast<int>(channel)), shifts[channel], values[channel]);
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
    std::vector<float> offsets_; // of the row of the photo
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
            sampler_->sampleWhole({same, same, same},
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
