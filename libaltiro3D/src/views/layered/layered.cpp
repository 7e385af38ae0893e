// Method Layered: each pixel of a row shows the front-most surface there. A background behind near
// things is painted once.

#include "views/view_methods.hpp"

#include "base/pixel_rows.hpp"
#include "views/layered/layered_reader.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Steps per px of shifts up to the largest; 0 if they may be beyond the reach of the scene.
double shiftStepsOf(const LayeredScene& scene, double largestShift) {
    const auto reach = static_cast<double>(scene.reachPixels);
    return reach > 0 && largestShift <= reach ? kWholeReach / reach : 0;
}

class LayeredSampler : public SubpixelSampler {
  public:
    LayeredSampler(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns,
                   const std::vector<std::uint8_t>& parts, double largestShift)
        : reader_(photo, scene, columns, parts), steps_(shiftStepsOf(scene, largestShift)) {
        if (steps_ > 0) wholeShifts_ = paddedRow<std::int16_t>(columns.size());
    }

    void open(int row) override { reader_.open(row); }

    bool still() const override { return reader_.still(); }

    void sample(int channel, const float* shifts, std::uint8_t* values) override {
        const auto read = [&](std::size_t begin) { reader_.read(channel, values + begin); };
        if (steps_ == 0) {
            reader_.findAnywhere(shifts, read);
            return;
        }
        for (std::size_t i = 0; i < reader_.count(); ++i)
            wholeShifts_[i] = wholeShift(static_cast<double>(shifts[i]), steps_);
        reader_.find(wholeShifts_.data(), read);
    }

    void sampleWhole(const std::array<const std::int16_t*, 3>& shifts,
                     const std::array<std::uint8_t*, 3>& values) override {
        for (std::size_t channel = 0; channel < 3; ++channel)
            reader_.find(shifts[channel], [&](std::size_t begin) {
                reader_.read(static_cast<int>(channel), values[channel] + begin);
            });
    }

  private:
    LayeredReader reader_;
    double steps_; // see ViewRenderer::shiftSteps()
    std::vector<std::int16_t> wholeShifts_;
};

class LayeredRows : public RowRenderer {
  public:
    LayeredRows(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns)
        : scene_(scene), reader_(photo, scene, columns, {}),
          shifts_(paddedRow<float>(columns.size())),
          wholeShifts_(paddedRow<std::int16_t>(columns.size())) {
        planes_.fill(paddedRow<std::uint8_t>(columns.size()));
    }

    void render(int row, const std::vector<double>& shifts,
                const std::vector<std::uint8_t*>& views) override {
        reader_.open(row);
        for (std::size_t i = 0; i < shifts.size(); ++i) {
            if (shifts[i] == 0 || reader_.still()) {
                std::memcpy(views[i], reader_.bgr(), 3 * reader_.count());
                continue;
            }
            const auto read = [&](std::size_t begin) { this->read(begin, views[i]); };
            const double steps = shiftStepsOf(scene_, std::abs(shifts[i]));
            if (steps == 0) {
                const double shift = std::clamp(shifts[i], -kMaxShift, kMaxShift);
                std::fill(shifts_.begin(), shifts_.end(), static_cast<float>(shift));
                reader_.findAnywhere(shifts_.data(), read);
            } else {
                std::fill(wholeShifts_.begin(), wholeShifts_.end(), wholeShift(shifts[i], steps));
                reader_.find(wholeShifts_.data(), read);
            }
        }
    }

  private:
    // @param bgr the whole row
    void read(std::size_t begin, std::uint8_t* bgr) {
        for (int channel = 0; channel < 3; ++channel)
            reader_.read(channel, planes_[static_cast<std::size_t>(channel)].data());
        interleaveRow(planes_[0].data(), planes_[1].data(), planes_[2].data(),
                      std::min(LayeredReader::kPixelsAtATime, reader_.count() - begin),
                      bgr + 3 * begin);
    }

    const LayeredScene& scene_;
    LayeredReader reader_;
    std::vector<float> shifts_;
    std::vector<std::int16_t> wholeShifts_;
    std::array<std::vector<std::uint8_t>, 3> planes_;
};

class LayeredRenderer : public ViewRenderer {
  public:
    LayeredRenderer(const cv::Mat& photo, const cv::Mat& depth, double focus,
                    const LayeredSettings& options)
        : photo_(photo), columns_(static_cast<std::size_t>(photo.cols)),
          scene_(layeredScene(photo, withoutLevels(depth, options.reachPixels), focus, options)) {
        std::iota(columns_.begin(), columns_.end(), 0);
    }

    void render(double shiftPixels, cv::Mat& view) const override {
        LayeredRows rows(photo_, scene_, columns_);
        const std::vector<double> shifts = {shiftPixels};
        for (int y = 0; y < photo_.rows; ++y)
            rows.render(y, shifts, {view.ptr<std::uint8_t>(y)});
    }

    bool makesRows() const override { return true; }

    std::unique_ptr<RowRenderer> rowRenderer() const override {
        return std::make_unique<LayeredRows>(photo_, scene_, columns_);
    }

    double shiftSteps(double largestShift) const override {
        return shiftStepsOf(scene_, largestShift);
    }

    bool readsBetweenColumns() const override { return true; }

    std::unique_ptr<SubpixelSampler> sampler(const std::vector<int>& columns,
                                             const std::vector<std::uint8_t>& parts,
                                             double largestShift) const override {
        return std::make_unique<LayeredSampler>(photo_, scene_, columns, parts, largestShift);
    }

  private:
    cv::Mat photo_;
    std::vector<int> columns_; // all
    LayeredScene scene_;
};

} // namespace

std::unique_ptr<ViewRenderer> makeLayeredRenderer(const cv::Mat& photo, const cv::Mat& depth,
                                                  double focus, const LayeredSettings& options) {
    return std::make_unique<LayeredRenderer>(photo, depth, focus, options);
}

} // namespace altiro3D
