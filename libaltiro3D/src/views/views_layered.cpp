// Method Layered: each pixel of a row shows the front-most surface there. A background behind near
// things is painted once.

#include "views/view_methods.hpp"

#include "base/pixel_rows.hpp"
#include "views/row_pixels.hpp"
#include "views/views_layered_columns.hpp"
#include "views/views_layered_ends.hpp"
#include "views/views_layered_lines.hpp"
#include "views/views_layered_scene.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Pixels of each part that are processed together. A multiple of kWindowPixels.
constexpr std::size_t kPixelsAtATime = 2048;
// Views of which a row is processed together, so the lists of pixels to search are long.
constexpr std::size_t kViewsAtATime = 8;

// Reads pixels at given columns of the photo, one row at a time. Several parts (channels or views)
// share the columns.
class LayeredReader {
  public:
    LayeredReader(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns,
                  std::size_t parts)
        : photo_(photo), scene_(scene), columns_(columns), near_(columns, scene.reachColumns),
          anywhere_(columns, scene.width), blocks_(layeredBlocks(columns)),
          columnPlaces_(paddedRow<float>(columns.size())),
          places_(paddedRow<std::int32_t>(columns.size())),
          room_(parts, std::min(columns.size(), kPixelsAtATime)) {
        for (std::vector<float>* values : copies_.all())
            *values = columnPlaces_;
        for (std::vector<std::int16_t>* values : lines_.all())
            values->assign(columns.size() + kRowPadding, INT16_MAX);
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

    void open(int row) {
        row_ = row;
        if (still()) return;
        tables_ = scene_.tables(row);
        layeredColumns(tables_, scratch_, known_);
        for (std::size_t i = 0; i < lines_.all().size(); ++i)
            pickColumns(columns_.data(), columns_.size(), known_.lines.all()[i]->data(),
                        lines_.all()[i]->data());
        isPicked_ = isWholeRow_;
        listSurfaces();
        splitPlanes();
    }

    // Finds what the pixels show and gives it to read(part, begin).
    // @param shifts of the pixels of each part, as for SubpixelSampler::sampleWhole()
    template <class F>
    void find(const std::int16_t* const* shifts, std::size_t parts, const F& read) {
        bounded_ = true;
        for (begin_ = 0; begin_ < columns_.size(); begin_ += kPixelsAtATime) {
            LayeredOpenCounts open;
            for (std::size_t part = 0; part < parts; ++part) {
                if (layeredLines(linePixels(shifts[part]), room_.away(part), room_.windows(part),
                                 room_.shifts.data()))
                    guess(part, open);
            }
            findEnds(open);
            for (std::size_t part = 0; part < parts; ++part)
                read(part, begin_);
        }
    }

    // The same for one part and shifts that may be beyond the reach of the scene, in px.
    template <class F>
    void findAnywhere(const float* shifts, const F& read) {
        bounded_ = false;
        for (begin_ = 0; begin_ < columns_.size(); begin_ += kPixelsAtATime) {
            std::fill_n(room_.away(0), size() + kRowPadding, kNotOnLine);
            std::fill_n(room_.windows(0), size() / kWindowPixels + 1, kOpenBlock);
            std::copy_n(shifts + begin_, size(), room_.shifts.begin());
            LayeredOpenCounts open;
            guess(0, open);
            findEnds(open);
            read(0, begin_);
        }
    }

    // Reads a channel of the pixels just found. @param values of these pixels
    void read(std::size_t part, int channel, std::uint8_t* values) const {
        const std::uint8_t* plane =
            planes_[static_cast<std::size_t>(channel)].data() + kTablePadding;
        layeredSamples(pixels(part), plane, room_.places.data() + part * room_.stride, values);
        const auto first = static_cast<std::int32_t>(part * room_.stride);
        const auto end = static_cast<std::int32_t>((part + 1) * room_.stride);
        for (std::size_t i = 0; i < counts_.mixed; ++i) {
            const std::int32_t pixel = room_.mixed[i];
            if (pixel < first || pixel >= end) continue;
            std::uint8_t& value = values[pixel - first];
            value = static_cast<std::uint8_t>(
                coveredBy(sampleAt(plane, room_.covers[i]), value, room_.shares[i]));
        }
        for (std::size_t i = 0; i < counts_.hard; ++i) {
            const std::int32_t pixel = room_.hard.pixels[i];
            if (pixel >= first && pixel < end)
                values[pixel - first] = static_cast<std::uint8_t>(colourOf(hard_[i], plane));
        }
    }

  private:
    // The memory of a LayeredRoom, and more of the pixels being found, as in LayeredPixels.
    struct Room {
        // @param count pixels of each part
        Room(std::size_t parts, std::size_t count)
            : stride((count / kWindowPixels + 1) * kWindowPixels),
              places(parts * stride + kRowPadding), hardColumns(places), mixed(places),
              covers(places), shares(places),
              endColumns(places), open{List(places.size()), List(places.size())},
              hard(places.size()), shifts(stride + kRowPadding), away_(places.size()),
              windows_(parts * stride / kWindowPixels) {}

        // The memory of a LayeredList.
        struct List {
            explicit List(std::size_t size) : pixels(size), columns(size), shifts(size) {}
            std::vector<std::int32_t> pixels;
            std::vector<float> columns, shifts;

            LayeredList pointers() { return {pixels.data(), columns.data(), shifts.data()}; }
        };

        std::size_t stride; // pixels from part to part
        std::vector<std::int32_t> places, hardColumns, mixed, covers, shares, endColumns;
        List open[2];
        List hard;
        std::vector<float> shifts; // of the pixels of one part, px

        std::int16_t* away(std::size_t part) { return away_.data() + part * stride; }
        const std::int16_t* away(std::size_t part) const { return away_.data() + part * stride; }
        std::int32_t* windows(std::size_t part) {
            return windows_.data() + part * (stride / kWindowPixels);
        }
        const std::int32_t* windows(std::size_t part) const {
            return windows_.data() + part * (stride / kWindowPixels);
        }
        LayeredRoom pointers() {
            return {places.data(),   {open[0].pointers(), open[1].pointers()},
                    hard.pointers(), hardColumns.data(),
                    mixed.data(),    covers.data(),
                    shares.data(),   endColumns.data()};
        }

      private:
        std::vector<std::int16_t> away_;
        std::vector<std::int32_t> windows_;
    };

    // Number of pixels of each part being found.
    std::size_t size() const { return std::min(kPixelsAtATime, columns_.size() - begin_); }

    LayeredLinePixels linePixels(const std::int16_t* shifts) const {
        const std::size_t block = begin_ / kWindowPixels;
        return {lines_.offsets.data() + begin_,
                lines_.slopes.data() + begin_,
                lines_.from.data() + begin_,
                lines_.to.data() + begin_,
                blocks_.columns.data() + begin_,
                blocks_.starts.data() + block,
                near_.starts.data() + block,
                shifts + begin_,
                scene_.reachPixels,
                size()};
    }

    LayeredPixels pixels(std::size_t part) const {
        const RowWindows& windows = bounded_ ? near_ : anywhere_;
        const LayeredColumns& values = isWholeRow_ ? known_ : copies_;
        const std::size_t block = begin_ / kWindowPixels;
        return {columnPlaces_.data() + begin_,
                places_.data() + begin_,
                values.offsets.data() + begin_,
                values.slopes.data() + begin_,
                values.from.data() + begin_,
                values.to.data() + begin_,
                values.first.data() + begin_,
                values.mirroredFirst.data() + begin_,
                bounded_ ? scene_.reachColumns : scene_.width,
                windows.starts.data() + block,
                windows.tables,
                blocks_.columns.data() + begin_,
                blocks_.starts.data() + block,
                room_.away(part),
                room_.windows(part),
                size()};
    }

    // Finds what pixels of open blocks show and lists the others.
    void guess(std::size_t part, LayeredOpenCounts& open) {
        if (!isPicked_) {
            for (std::size_t i = 0; i < known_.all().size(); ++i)
                pickColumns(columns_.data(), columns_.size(), known_.all()[i]->data(),
                            copies_.all()[i]->data());
            isPicked_ = true;
        }
        layeredGuesses(tables_, pixels(part), room_.shifts.data(), part * room_.stride,
                       room_.pointers(), open);
    }

    // Finds what the listed pixels show.
    void findEnds(const LayeredOpenCounts& open) {
        counts_ = {};
        const LayeredSurfaces surfaces = {left_.data(),
                                          right_.data(),
                                          endOffsets_.data(),
                                          {0, mirroredSurfaces_, static_cast<int>(left_.size())}};
        const LayeredRoom room = room_.pointers();
        const bool inOrder = scene_.rows[0][static_cast<std::size_t>(row_)].inOrder;
        const bool amongSurfaces = bounded_ && inOrder;
        if (!amongSurfaces && tables_.bounds == nullptr)
            bounds_.describe(scene_.reachColumns, tables_);
        for (int direction = 0; direction < 2; ++direction) {
            const std::size_t size = open.size[direction];
            if (amongSurfaces) {
                layeredAmongSurfaces(tables_, surfaces, scene_.reachColumns, direction, size, room,
                                     counts_);
            } else {
                layeredWalk(tables_, surfaces, bounded_, size, room.open[direction], room, counts_);
            }
        }
        const LayeredSearch search(scene_, row_, tables_, strips_);
        hard_.resize(counts_.hard);
        for (std::size_t i = 0; i < counts_.hard; ++i) {
            const int column = static_cast<int>(room_.hard.columns[i]);
            const float shift = room_.hard.shifts[i];
            const int direction = shift < 0 ? 1 : 0;
            const int x = direction == 0 ? column : scene_.width - 1 - column;
            hard_[i] = search.at(direction, x, std::abs(shift), room_.hardColumns[i]);
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
        endOffsets_.clear();
        for (int direction = 0; direction < 2; ++direction) {
            const std::size_t begin = left_.size();
            for (const LayeredSurface& surface : rows[direction]->surfaces) {
                const auto strip = static_cast<float>(strips_[direction] + surface.hiddenAt(0));
                left_.push_back({static_cast<float>(surface.first),
                                 static_cast<float>(surface.hidden),
                                 surface.hidden > 0 ? kNoBorder : 1 + surface.leftExtra, strip});
                right_.push_back({static_cast<float>(surface.last),
                                  static_cast<float>(surface.beyond), 1 + surface.rightExtra,
                                  strip});
                const auto offsetAt = [&](int column) {
                    const std::int16_t* words = tables_.words + direction * tables_.stride;
                    return static_cast<float>(wordOffset(words[column])) * 0x1p18F;
                };
                endOffsets_.push_back({offsetAt(surface.first), offsetAt(surface.last)});
                endOffsets_.back().passing = passing(begin);
            }
        }
    }

    // LayeredEndOffsets::passing of the last surface. @param begin the first one of its direction
    float passing(std::size_t begin) const {
        constexpr float kRounding = 0.01F; // px
        const float last = right_.back().column;
        const float offset = endOffsets_.back().last;
        // what is farther away does not come into the gap within the reach
        const float farthest =
            bounded_ ? last - static_cast<float>(2 * scene_.reachColumns + kEndReach) : 0;
        float least = kNeverPasses;
        for (std::size_t i = right_.size() - 1; i-- > begin && right_[i].column >= farthest;) {
            const float nearer = offset - endOffsets_[i].last;
            const float way = last - right_[i].column - right_[i].painted - right_[i].border;
            if (nearer > 0) least = std::min(least, std::max(way - kRounding, 0.0F) / nearer);
        }
        return least;
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
            reverseRow(row, width, mirrored);
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
    LayeredBounds bounds_; // of rows that are searched column by column
    LayeredColumns known_;
    LayeredLines<std::int16_t> lines_; // of each pixel's column
    LayeredColumns copies_;            // of each pixel's column, if isPicked_ and not isWholeRow_
    bool isPicked_ = false;
    bool isWholeRow_ = false; // pixels and columns are the same
    std::vector<float> scratch_;
    RowWindows near_;     // within the reach of the scene
    RowWindows anywhere_; // beyond it
    LayeredBlocks blocks_;
    std::vector<float> columnPlaces_; // all pixels, see LayeredPixels
    std::vector<std::int32_t> places_;
    Room room_;
    LayeredCounts counts_;
    std::vector<LayeredPixel> hard_;
    std::size_t begin_ = 0;        // the first pixel being found
    std::vector<LayeredEnd> left_; // see LayeredSurfaces
    std::vector<LayeredEnd> right_;
    std::vector<LayeredEndOffsets> endOffsets_;
    int mirroredSurfaces_ = 0;
    int strips_[2] = {0, 0};
    std::array<std::vector<std::uint8_t>, 3> planes_;
};

// Steps per px of shifts up to the largest; 0 if they may be beyond the reach of the scene.
double shiftStepsOf(const LayeredScene& scene, double largestShift) {
    const auto reach = static_cast<double>(scene.reachPixels);
    return reach > 0 && largestShift <= reach ? kWholeReach / reach : 0;
}

class LayeredSampler : public SubpixelSampler {
  public:
    LayeredSampler(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns,
                   double largestShift)
        : reader_(photo, scene, columns, 3), steps_(shiftStepsOf(scene, largestShift)) {
        if (steps_ > 0) wholeShifts_ = paddedRow<std::int16_t>(columns.size());
    }

    void open(int row) override { reader_.open(row); }

    bool still() const override { return reader_.still(); }

    void sample(int channel, const float* shifts, std::uint8_t* values) override {
        const auto read = [&](std::size_t, std::size_t begin) {
            reader_.read(0, channel, values + begin);
        };
        if (steps_ == 0) {
            reader_.findAnywhere(shifts, read);
            return;
        }
        for (std::size_t i = 0; i < reader_.count(); ++i)
            wholeShifts_[i] = wholeShift(static_cast<double>(shifts[i]), steps_);
        const std::int16_t* const whole[] = {wholeShifts_.data()};
        reader_.find(whole, 1, read);
    }

    void sampleWhole(const std::array<const std::int16_t*, 3>& shifts,
                     const std::array<std::uint8_t*, 3>& values) override {
        reader_.find(shifts.data(), 3, [&](std::size_t channel, std::size_t begin) {
            reader_.read(channel, static_cast<int>(channel), values[channel] + begin);
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
        : scene_(scene), reader_(photo, scene, columns, kViewsAtATime),
          shifts_(paddedRow<float>(columns.size())) {
        wholeShifts_.fill(paddedRow<std::int16_t>(columns.size()));
        planes_.fill(paddedRow<std::uint8_t>(columns.size()));
    }

    void render(int row, const std::vector<double>& shifts,
                const std::vector<std::uint8_t*>& views) override {
        reader_.open(row);
        const std::int16_t* together[kViewsAtATime] = {};
        std::uint8_t* targets[kViewsAtATime] = {};
        std::size_t count = 0;
        const auto renderThese = [&] {
            reader_.find(together, count, [&](std::size_t part, std::size_t begin) {
                read(part, begin, targets[part]);
            });
            count = 0;
        };
        for (std::size_t i = 0; i < shifts.size(); ++i) {
            if (shifts[i] == 0 || reader_.still()) {
                std::memcpy(views[i], reader_.bgr(), 3 * reader_.count());
                continue;
            }
            const double steps = shiftStepsOf(scene_, std::abs(shifts[i]));
            if (steps == 0) {
                renderBeyond(shifts[i], views[i]);
                continue;
            }
            std::vector<std::int16_t>& whole = wholeShifts_[count];
            std::fill(whole.begin(), whole.end(), wholeShift(shifts[i], steps));
            together[count] = whole.data();
            targets[count] = views[i];
            if (++count == kViewsAtATime) renderThese();
        }
        if (count > 0) renderThese();
    }

  private:
    // A view beyond the reach of the scene.
    void renderBeyond(double shift, std::uint8_t* bgr) {
        std::fill(shifts_.begin(), shifts_.end(),
                  static_cast<float>(std::clamp(shift, -kMaxShift, kMaxShift)));
        reader_.findAnywhere(shifts_.data(),
                             [&](std::size_t, std::size_t begin) { read(0, begin, bgr); });
    }

    // @param bgr the whole row
    void read(std::size_t part, std::size_t begin, std::uint8_t* bgr) {
        for (int channel = 0; channel < 3; ++channel)
            reader_.read(part, channel, planes_[static_cast<std::size_t>(channel)].data());
        interleaveRow(planes_[0].data(), planes_[1].data(), planes_[2].data(),
                      std::min(kPixelsAtATime, reader_.count() - begin), bgr + 3 * begin);
    }

    const LayeredScene& scene_;
    LayeredReader reader_;
    std::vector<float> shifts_;
    std::array<std::vector<std::int16_t>, kViewsAtATime> wholeShifts_;
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
