// Method Fast: view(x, y) = photo(x + shift (depth(x, y) - focus), y), linear, borders repeated.
// Each refinement reads the depth again at the source position found so far.

#include "base/pixel_rows.hpp"
#include "views/row_pixels.hpp"
#include "views/view_methods.hpp"
#include "views/views_fast_row.hpp"

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

// Rows processed together: their map and pixels fit into the second-level cache.
constexpr int kRowsAtATime = 16;

float boundedShift(double shiftPixels) {
    return static_cast<float>(std::clamp(shiftPixels, -kMaxShift, kMaxShift));
}

// Offsets of a row of depth; the last one is repeated.
void readOffsets(const cv::Mat& depth, int row, double focus, std::vector<float>& offsets) {
    const auto* values = depth.ptr<float>(row);
    std::transform(values, values + depth.cols, offsets.begin(),
                   [focus](float value) { return offsetFromFocus(value, focus); });
    offsets[static_cast<std::size_t>(depth.cols)] =
        offsets[static_cast<std::size_t>(depth.cols - 1)];
}

// Pixels of a row, as FastRow.
class FastPixels {
  public:
    // @param reach largest distance of positions from their columns, px
    FastPixels(const std::vector<int>& columns, int reach, int width)
        : places_(paddedRow<float>(columns.size())), offsets_(places_), runs_(columns),
          windows_(columns, reach), width_(width) {
        std::transform(columns.begin(), columns.end(), places_.begin(),
                       [](int column) { return 32.0F * static_cast<float>(column); });
    }

    // @param offsets depth - focus of each column of the photo
    void open(const std::vector<float>& offsets) {
        runs_.copy(offsets.data(), offsets_.data());
        for (float& offset : offsets_)
            offset *= 32;
    }

    FastRow row(const std::uint8_t* plane, std::size_t count) const {
        return {plane,  places_.data(), offsets_.data(), windows_.starts.data(), windows_.tables,
                width_, count};
    }

  private:
    std::vector<float> places_;
    std::vector<float> offsets_;
    ColumnRuns runs_;
    RowWindows windows_;
    int width_;
};

class FastSampler : public SubpixelSampler {
  public:
    FastSampler(const cv::Mat& photo, const cv::Mat& depth, double focus, int refinement,
                const std::vector<int>& columns, double largestShift)
        : photo_(photo), depth_(depth), focus_(focus), refinement_(refinement), columns_(columns),
          pixels_(columns,
                  static_cast<int>(std::ceil(
                      std::min(largestShift * std::max(focus, 1 - focus), 1.0 * photo.cols))),
                  photo.cols),
          offsets_(paddedRow<float>(static_cast<std::size_t>(photo.cols))) {
        for (std::vector<std::uint8_t>& plane : planes_)
            plane = paddedRow<std::uint8_t>(static_cast<std::size_t>(photo.cols));
        if (refinement_ == 0) return;
        columnPlaces_ = paddedRow<float>(columns.size());
        ownOffsets_ = places_ = columnPlaces_;
        std::copy(columns.begin(), columns.end(), columnPlaces_.begin());
    }

    void open(int row) override {
        readOffsets(depth_, row, focus_, offsets_);
        still_ = std::all_of(offsets_.begin(), offsets_.begin() + photo_.cols,
                             [](float offset) { return offset == 0; });
        if (still_) return;
        const auto width = static_cast<std::size_t>(photo_.cols);
        splitRow(photo_.ptr<std::uint8_t>(row), width, planes_[0].data(), planes_[1].data(),
                 planes_[2].data());
        for (std::vector<std::uint8_t>& plane : planes_)
            std::fill_n(plane.begin() + photo_.cols, 4, plane[width - 1]);
        pixels_.open(offsets_);
        if (refinement_ == 0) return;
        for (std::size_t i = 0; i < columns_.size(); ++i)
            ownOffsets_[i] = offsets_[static_cast<std::size_t>(columns_[i])];
    }

    bool still() const override { return still_; }

    void sample(int channel, const float* shifts, std::uint8_t* values) override {
        const FastRow row =
            pixels_.row(planes_[static_cast<std::size_t>(channel)].data(), columns_.size());
        if (refinement_ == 0) {
            fastSamples(row, shifts, values);
            return;
        }
        fastPlaces(columnPlaces_.data(), ownOffsets_.data(), shifts, columns_.size(),
                   offsets_.data(), photo_.cols, refinement_, places_.data());
        fastSamplesAt(row, places_.data(), values);
    }

  private:
    const cv::Mat& photo_;
    const cv::Mat& depth_;
    double focus_;
    int refinement_;
    const std::vector<int>& columns_;
    FastPixels pixels_;
    bool still_ = false;
    std::array<std::vector<std::uint8_t>, 3> planes_;
    std::vector<float> offsets_; // of the row of the photo
    // with refinement only, for each requested column
    std::vector<float> columnPlaces_;
    std::vector<float> ownOffsets_;
    std::vector<float> places_;
};

class FastRenderer : public ViewRenderer {
  public:
    FastRenderer(const cv::Mat& photo, const cv::Mat& depth, const ViewOptions& options)
        : photo_(photo), depth_(depth), focus_(options.focus), refinement_(options.refinement) {}

    void render(double shiftPixels, cv::Mat& view) const override {
        const auto width = static_cast<std::size_t>(photo_.cols);
        const int rowsAtATime = std::min(kRowsAtATime, photo_.rows);
        const int padded = photo_.cols + static_cast<int>(kRowPadding);
        cv::Mat mapX(rowsAtATime, padded, CV_32FC1);
        cv::Mat mapY(rowsAtATime, photo_.cols, CV_32FC1);
        std::vector<float> columns = paddedRow<float>(width);
        for (std::size_t x = 0; x < width; ++x)
            columns[x] = static_cast<float>(x);
        std::vector<float> offsets = paddedRow<float>(width);
        const std::vector<float> shifts(offsets.size(), boundedShift(shiftPixels));
        for (int y0 = 0; y0 < photo_.rows; y0 += rowsAtATime) {
            const int rows = std::min(rowsAtATime, photo_.rows - y0);
            for (int i = 0; i < rows; ++i) {
                readOffsets(depth_, y0 + i, focus_, offsets);
                fastPlaces(columns.data(), offsets.data(), shifts.data(), width, offsets.data(),
                           photo_.cols, refinement_, mapX.ptr<float>(i));
                std::fill_n(mapY.ptr<float>(i), photo_.cols, static_cast<float>(y0 + i));
            }
            cv::Mat target = view.rowRange(y0, y0 + rows);
            cv::remap(photo_, target, mapX(cv::Rect(0, 0, photo_.cols, rows)),
                      mapY.rowRange(0, rows), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
        }
    }

    std::unique_ptr<SubpixelSampler> sampler(const std::vector<int>& columns,
                                             double largestShift) const override {
        return std::make_unique<FastSampler>(photo_, depth_, focus_, refinement_, columns,
                                             largestShift);
    }

  private:
    cv::Mat photo_;
    cv::Mat depth_;
    double focus_;
    int refinement_;
};

} // namespace

std::unique_ptr<ViewRenderer> makeFastRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                               const ViewOptions& options) {
    return std::make_unique<FastRenderer>(photo, depth, options);
}

} // namespace altiro3D
