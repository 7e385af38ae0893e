// Method Layered: each pixel of a row shows the front-most surface there. A background behind near
// things is painted once.

#include "views/view_methods.hpp"

#include "base/pixel_rows.hpp"
#include "views/row_pixels.hpp"
#include "views/views_layered_ends.hpp"
#include "views/views_layered_scene.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Pixels processed together: their data fits into the first-level cache. A multiple of
// kWindowPixels.
constexpr std::size_t kPixelsAtATime = 512;

// Reads pixels at given columns of the photo, one row at a time.
class LayeredReader {
  public:
    LayeredReader(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns)
        : photo_(photo), scene_(scene), columns_(columns), near_(columns, scene.reachColumns),
          anywhere_(columns, scene.width), columnPlaces_(paddedRow<float>(columns.size())),
          places_(paddedRow<std::int32_t>(columns.size())) {
        for (std::vector<std::int32_t>* list : room_.all())
            *list = places_;
        for (std::vector<float>* values : copies_.all())
            *values = columnPlaces_;
        isWholeRow_ = static_cast<int>(columns.size()) == scene.width;
        for (std::size_t i = 0; i < columns.size(); ++i) {
            if (columns[i] != static_cast<int>(i)) isWholeRow_ = false;
            columnPlaces_[i] = static_cast<float>(columns[i]);
            places_[i] = columns[i] << kSubColumnBits;
        }
    }

    std::size_t count() const { return columns_.size(); }
    bool still() const { return scene_.flat || scene_.still[static_cast<std::size_t>(row_)] != 0; }
    const std::uint8_t* bgr() const { return photo_.ptr<std::uint8_t>(row_); }

    // @param bounded whether all shifts are within the reach of the scene
    void open(int row, bool bounded) {
        row_ = row;
        if (still()) return;
        tables_ = scene_.tables(row);
        bounded_ = bounded;
        layeredColumns(tables_, scratch_, known_);
        if (!isWholeRow_) {
            for (std::size_t i = 0; i < known_.all().size(); ++i)
                pickColumns(columns_.data(), columns_.size(), known_.all()[i]->data(),
                            copies_.all()[i]->data());
        }
        listSurfaces();
        splitPlanes();
    }

    // Finds what `size` pixels show, starting with the pixel `begin`.
    // @param shifts shifts of all pixels, as for SubpixelSampler::sample()
    void find(const float* shifts, std::size_t begin, std::size_t size) {
        begin_ = begin;
        size_ = size;
        shifts_ = shifts + begin;
        const LayeredSurfaces surfaces = {
            left_.data(), right_.data(), {0, mirroredSurfaces_, static_cast<int>(left_.size())}};
        counts_ = layeredPlaces(tables_, surfaces, pixels(), shifts_, bounded_, room_.pointers());
        searchHardOnes();
    }

    // Reads a channel of the pixels of find(). @param values values of all pixels
    void read(int channel, std::uint8_t* values) const {
        const std::uint8_t* plane =
            planes_[static_cast<std::size_t>(channel)].data() + kTablePadding;
        values += begin_;
        layeredSamples(pixels(), plane, room_.places.data(), values);
        for (std::size_t i = 0; i < counts_.mixed; ++i) {
            std::uint8_t& value = values[room_.mixed[i]];
            value = static_cast<std::uint8_t>(
                coveredBy(sampleAt(plane, room_.covers[i]), value, room_.parts[i]));
        }
        for (std::size_t i = 0; i < counts_.hard; ++i)
            values[room_.hard[i]] = static_cast<std::uint8_t>(colourOf(hard_[i], plane));
    }

  private:
    // The memory of a LayeredRoom.
    struct Room {
        std::vector<std::int32_t> places, hard, hardColumns, mixed, covers, parts, open,
            openColumns;

        std::array<std::vector<std::int32_t>*, 8> all() {
            return {&places, &hard, &hardColumns, &mixed, &covers, &parts, &open, &openColumns};
        }
        LayeredRoom pointers() {
            return {places.data(), hard.data(),  hardColumns.data(), mixed.data(),
                    covers.data(), parts.data(), open.data(),        openColumns.data()};
        }
    };

    LayeredPixels pixels() const {
        const RowWindows& windows = bounded_ ? near_ : anywhere_;
        const LayeredColumns& values = isWholeRow_ ? known_ : copies_;
        return {columnPlaces_.data() + begin_,
                places_.data() + begin_,
                values.offsets.data() + begin_,
                values.slopes.data() + begin_,
                values.from.data() + begin_,
                values.to.data() + begin_,
                values.first.data() + begin_,
                values.mirroredFirst.data() + begin_,
                bounded_ ? scene_.reachColumns : scene_.width,
                windows.starts.data() + begin_ / kWindowPixels,
                windows.tables,
                size_};
    }

    void searchHardOnes() {
        const LayeredSearch search(scene_, row_, strips_);
        hard_.resize(counts_.hard);
        for (std::size_t i = 0; i < counts_.hard; ++i) {
            const auto pixel = static_cast<std::size_t>(room_.hard[i]);
            const int column = columns_[begin_ + pixel];
            const int direction = shifts_[pixel] < 0 ? 1 : 0;
            const int x = direction == 0 ? column : scene_.width - 1 - column;
            hard_[i] = search.at(direction, x, std::abs(shifts_[pixel]), room_.hardColumns[i]);
        }
    }

    // Lists the surfaces of both directions as LayeredSurfaces.
    void listSurfaces() {
        constexpr float kNoBorder = -1e9F;
        const LayeredRow* rows[] = {&scene_.rows[0][static_cast<std::size_t>(row_)],
                                    &scene_.rows[1][static_cast<std::size_t>(row_)]};
        strips_[0] = 2 * scene_.stride();
        strips_[1] = strips_[0] + static_cast<int>(rows[0]->strips.size() / 4);
        mirroredSurfaces_ = static_cast<int>(rows[0]->surfaces.size());
        left_.clear();
        right_.clear();
        for (int direction = 0; direction < 2; ++direction) {
            for (const LayeredSurface& surface : rows[direction]->surfaces) {
                const auto strip = static_cast<float>(strips_[direction] + surface.hiddenAt(0));
                left_.push_back({static_cast<float>(surface.first),
                                 static_cast<float>(surface.hidden),
                                 surface.hidden > 0 ? kNoBorder : 1 + surface.leftExtra, strip});
                right_.push_back({static_cast<float>(surface.last),
                                  static_cast<float>(surface.beyond), 1 + surface.rightExtra,
                                  strip});
            }
        }
    }

    // Planes of the row and of the mirrored row, with their last px repeated on both sides, and of
    // the painted strips.
    void splitPlanes() {
        const auto width = static_cast<std::size_t>(scene_.width);
        const LayeredRow* rows[] = {&scene_.rows[0][static_cast<std::size_t>(row_)],
                                    &scene_.rows[1][static_cast<std::size_t>(row_)]};
        const std::size_t painted = (rows[0]->strips.size() + rows[1]->strips.size()) / 4;
        const std::size_t size =
            kTablePadding + 2 * static_cast<std::size_t>(scene_.stride()) + painted + kRowPadding;
        for (std::vector<std::uint8_t>& plane : planes_)
            plane.resize(std::max(plane.size(), size));
        splitRow(bgr(), width, planes_[0].data() + kTablePadding, planes_[1].data() + kTablePadding,
                 planes_[2].data() + kTablePadding);
        for (std::size_t channel = 0; channel < 3; ++channel) {
            std::uint8_t* row = planes_[channel].data() + kTablePadding;
            std::uint8_t* mirrored = row + scene_.stride();
            std::reverse_copy(row, row + width, mirrored);
            for (std::uint8_t* begin : {row, mirrored}) {
                std::memset(begin - kTablePadding, begin[0], kTablePadding);
                std::memset(begin + width, begin[width - 1], kTablePadding);
            }
            for (int direction = 0; direction < 2; ++direction) {
                const std::vector<std::uint8_t>& strips = rows[direction]->strips;
                std::uint8_t* to = row + strips_[direction];
                for (std::size_t i = channel; i < strips.size(); i += 4)
                    *to++ = strips[i];
            }
        }
    }

    const cv::Mat& photo_;
    const LayeredScene& scene_;
    const std::vector<int>& columns_;
    int row_ = 0;
    bool bounded_ = true;
    LayeredTables tables_;
    LayeredColumns known_;
    LayeredColumns copies_;   // of each pixel's column
    bool isWholeRow_ = false; // pixels and columns are the same
    std::vector<float> scratch_;
    RowWindows near_;                 // within the reach of the scene
    RowWindows anywhere_;             // beyond it
    std::vector<float> columnPlaces_; // all pixels, see LayeredPixels
    std::vector<std::int32_t> places_;
    Room room_;
    LayeredCounts counts_;
    std::vector<LayeredPixel> hard_;
    std::size_t begin_ = 0; // the pixels of find()
    std::size_t size_ = 0;
    const float* shifts_ = nullptr;
    std::vector<LayeredEnd> left_; // see LayeredSurfaces
    std::vector<LayeredEnd> right_;
    int mirroredSurfaces_ = 0;
    int strips_[2] = {0, 0};
    std::array<std::vector<std::uint8_t>, 3> planes_;
};

class LayeredSampler : public SubpixelSampler {
  public:
    LayeredSampler(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns,
                   double largestShift)
        : columns_(columns), reader_(photo, scene, columns),
          bounded_(largestShift <= static_cast<double>(scene.reachPixels)) {}

    void open(int row) override { reader_.open(row, bounded_); }

    bool still() const override { return reader_.still(); }

    void sample(int channel, const float* shifts, std::uint8_t* values) override {
        for (std::size_t begin = 0; begin < columns_.size(); begin += kPixelsAtATime) {
            reader_.find(shifts, begin, std::min(kPixelsAtATime, columns_.size() - begin));
            reader_.read(channel, values);
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
            render(static_cast<float>(std::clamp(shifts[i], -kMaxShift, kMaxShift)), views[i]);
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

    bool makesRows() const override { return true; }

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
