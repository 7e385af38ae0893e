// Method Layered: each row of a view shows, at each pixel, the front-most surface there; behind
// near things lies a background that is painted once.

#include "views_layered.hpp"

#include "native_row_kernels.hpp"
#include "views_layered_ends.hpp"
#include "views_layered_scene.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Few enough pixels that all that is known of them stays in the first-level cache.
constexpr std::size_t kPixelsAtATime = 512;

// Reads pixels of one row at a time, at given columns of the photo.
class LayeredReader {
  public:
    LayeredReader(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns)
        : photo_(photo), scene_(scene), columns_(columns),
          places_(paddedRow<std::int32_t>(count())), ends_(places_), endColumns_(places_),
          open_(places_), guesses_(places_) {
        columnPlaces_ = paddedRow<float>(count());
        std::copy(columns.begin(), columns.end(), columnPlaces_.begin());
        for (std::vector<float>& clear : clear_)
            clear = columnPlaces_;
        const auto planeSize = 2 * static_cast<std::size_t>(scene.stride());
        for (std::vector<std::uint8_t>& plane : planes_)
            plane = paddedRow<std::uint8_t>(planeSize);
    }

    std::size_t count() const { return columns_.size(); }
    bool still() const { return scene_.flat || scene_.still[static_cast<std::size_t>(row_)] != 0; }
    const std::uint8_t* bgr() const { return photo_.ptr<std::uint8_t>(row_); }

    // @param bounded whether no shift will be larger than the scene was made for
    void open(int row, bool bounded) {
        row_ = row;
        if (still()) return;
        tables_ = scene_.tables(row);
        bounded_ = bounded;
        const std::int16_t* words = tables_.words;
        const float* clear = tables_.clear;
        const float* mirroredClear = clear + tables_.stride + scene_.width - 1;
        for (std::size_t i = 0; i < count(); ++i) {
            const int x = columns_[i];
            const int rise = wordOffset(words[x + 2]) - wordOffset(words[x - 2]);
            guesses_[i] = columnGuess(words[x], rise);
            clear_[0][i] = clear[x];
            clear_[1][i] = mirroredClear[-x];
        }
        splitPlanes();
    }

    // Searches what some of the pixels show, from the pixel `begin` on.
    // @param shifts of all pixels, as SubpixelSampler::sample()
    void find(const float* shifts, std::size_t begin, std::size_t size) {
        begin_ = begin;
        size_ = size;
        const LayeredRoom room = {places_.data(), ends_.data(), endColumns_.data(), open_.data()};
        endCount_ = layeredPlaces(tables_, pixels(), shifts + begin, bounded_, room);
    }

    // Reads a channel of what find() found, but for the pixels at ends.
    // @param values of all pixels
    void read(int channel, std::uint8_t* values) const {
        layeredSamples(tables_, pixels(), plane(channel, 0), places_.data(), values + begin_);
    }

    // Calls put(pixel, colour of a channel) for all pixels at ends that find() found.
    template <class Put>
    void readEnds(const float* shifts, const Put& put) const {
        const LayeredSearch search(scene_, row_);
        for (std::size_t k = 0; k < endCount_; ++k) {
            const auto i = begin_ + static_cast<std::size_t>(ends_[k]);
            const int column = columns_[i];
            if (shifts[i] == 0) {
                put(i, [&](int channel) { return plane(channel, 0)[column]; });
                continue;
            }
            const int direction = shifts[i] < 0 ? 1 : 0;
            const int x = direction == 0 ? column : scene_.width - 1 - column;
            const LayeredPixel pixel = search.at(direction, x, std::abs(shifts[i]), endColumns_[k]);
            put(i, [&](int channel) {
                return search.colour(direction, pixel, plane(channel, direction), channel);
            });
        }
    }

  private:
    LayeredPixels pixels() const {
        return {columnPlaces_.data() + begin_,
                guesses_.data() + begin_,
                {clear_[0].data() + begin_, clear_[1].data() + begin_},
                bounded_ ? scene_.reachColumns : scene_.width,
                size_};
    }

    const std::uint8_t* plane(int channel, int direction) const {
        return planes_[static_cast<std::size_t>(channel)].data() + kTablePadding +
               static_cast<std::ptrdiff_t>(direction) * scene_.stride();
    }

    // Planes of the row and of the mirrored row, their last px repeated on both sides.
    void splitPlanes() {
        const auto width = static_cast<std::size_t>(scene_.width);
        splitRow(bgr(), width, planes_[0].data() + kTablePadding, planes_[1].data() + kTablePadding,
                 planes_[2].data() + kTablePadding);
        for (std::vector<std::uint8_t>& plane : planes_) {
            std::uint8_t* row = plane.data() + kTablePadding;
            std::uint8_t* mirrored = row + scene_.stride();
            std::reverse_copy(row, row + width, mirrored);
            for (std::uint8_t* begin : {row, mirrored}) {
                std::memset(begin - kTablePadding, begin[0], kTablePadding);
                std::memset(begin + width, begin[width - 1], kTablePadding);
            }
        }
    }

    const cv::Mat& photo_;
    const LayeredScene& scene_;
    const std::vector<int>& columns_;
    int row_ = 0;
    LayeredTables tables_;
    std::vector<float> columnPlaces_; // see LayeredPixels
    std::vector<float> clear_[2];
    std::vector<std::int32_t> places_;
    std::vector<std::int32_t> ends_;
    std::vector<std::int32_t> endColumns_;
    std::vector<std::int32_t> open_;
    std::vector<std::int32_t> guesses_;
    bool bounded_ = true;
    std::size_t endCount_ = 0;
    std::size_t begin_ = 0; // pixels that find() looked at
    std::size_t size_ = 0;
    std::array<std::vector<std::uint8_t>, 3> planes_;
};

class LayeredSampler : public SubpixelSampler {
  public:
    LayeredSampler(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns,
                   double largestShift)
        : columns_(columns), reader_(photo, scene, columns),
          bounded_(largestShift <= static_cast<double>(scene.reachPixels)) {}

    void open(int row) override { reader_.open(row, bounded_); }

    void sample(int channel, const float* shifts, std::uint8_t* values) override {
        if (reader_.still()) {
            const std::uint8_t* own = reader_.bgr() + channel;
            for (std::size_t i = 0; i < columns_.size(); ++i)
                values[i] = own[3 * static_cast<std::ptrdiff_t>(columns_[i])];
            return;
        }
        for (std::size_t begin = 0; begin < columns_.size(); begin += kPixelsAtATime) {
            reader_.find(shifts, begin, std::min(kPixelsAtATime, columns_.size() - begin));
            reader_.read(channel, values);
            reader_.readEnds(
                shifts, [&](std::size_t i, const auto& colour) { values[i] = colour(channel); });
        }
    }

  private:
    const std::vector<int>& columns_;
    LayeredReader reader_;
    bool bounded_;
};

class LayeredRows : public RowRenderer {
  public:
    LayeredRows(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns)
        : scene_(scene), reader_(photo, scene, columns), shifts_(paddedRow<float>(columns.size())) {
        planes_.fill(paddedRow<std::uint8_t>(columns.size()));
    }

    void render(int row, const std::vector<double>& shifts,
                const std::vector<std::uint8_t*>& views) override {
        const auto bounded = static_cast<double>(scene_.reachPixels);
        const bool within = std::all_of(shifts.begin(), shifts.end(),
                                        [&](double shift) { return std::abs(shift) <= bounded; });
        reader_.open(row, within);
        for (std::size_t i = 0; i < shifts.size(); ++i)
            render(static_cast<float>(std::clamp(shifts[i], -kLargestShift, kLargestShift)),
                   views[i]);
    }

  private:
    void render(float shift, std::uint8_t* bgr) {
        const std::size_t width = reader_.count();
        if (shift == 0 || reader_.still()) {
            std::memcpy(bgr, reader_.bgr(), 3 * width);
            return;
        }
        std::fill(shifts_.begin(), shifts_.end(), shift);
        reader_.find(shifts_.data(), 0, width);
        for (int channel = 0; channel < 3; ++channel)
            reader_.read(channel, planes_[static_cast<std::size_t>(channel)].data());
        interleaveRow(planes_[0].data(), planes_[1].data(), planes_[2].data(), width, bgr);
        reader_.readEnds(shifts_.data(), [&](std::size_t i, const auto& colour) {
            for (int channel = 0; channel < 3; ++channel)
                bgr[3 * i + static_cast<std::size_t>(channel)] = colour(channel);
        });
    }

    const LayeredScene& scene_;
    LayeredReader reader_;
    std::vector<float> shifts_;
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

    std::unique_ptr<RowRenderer> rowRenderer() const override {
        return std::make_unique<LayeredRows>(photo_, scene_, columns_);
    }

    std::unique_ptr<SubpixelSampler> sampler(const std::vector<int>& columns,
                                             double largestShift) const override {
        return std::make_unique<LayeredSampler>(photo_, scene_, columns, largestShift);
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
