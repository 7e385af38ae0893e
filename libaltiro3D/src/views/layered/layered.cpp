// Method Layered: each pixel shows the front-most surface; the hidden background is painted once.

#include "views/view_methods.hpp"

#include "base/pixel_rows.hpp"
#include "views/layered/layered_ends.hpp"
#include "views/layered/layered_row.hpp"
#include "views/layered/layered_scene.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Reads pixels at given places of the photo, one row at a time (docs/layered.md, "Pixels").
//
// open() lists the surfaces of a row and what is known of its columns before any search. find()
// takes the pixels in batches: lines give most places (layered_lines.cpp), guesses more of them
// (layered_guesses.cpp), and LayeredSearch the rest (layered_ends.cpp); places_, room_ and hard_
// hold what is found. read() then gives one channel of the batch, with borders and soft colours.
class LayeredReader {
  public:
    // @param columns, parts as for ViewRenderer::sampler()
    LayeredReader(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns,
                  const std::vector<std::uint8_t>& parts)
        : photo_(photo), scene_(scene), columns_(columns), parts_(parts),
          columnPlaces_(paddedRow<float>(columns.size())),
          places_(paddedRow<std::int32_t>(columns.size())),
          room_(std::min(columns.size(), kPixelsAtATime)), softPixels_(room_.places.size()) {
        for (std::vector<float>* values : copies_.all())
            *values = columnPlaces_;
        for (std::vector<std::int16_t>* values : lines_.all())
            *values =
                paddedRow<std::int16_t>(columns.size()); // the padding is a line that never moves
        lines_.from = lines_.to =
            std::vector<std::int16_t>(columns.size() + kRowPadding, INT16_MAX);
        isWholeRow_ = static_cast<int>(columns.size()) == scene.width;
        for (std::size_t i = 0; i < columns.size(); ++i) {
            if (columns[i] != static_cast<int>(i)) isWholeRow_ = false;
            places_[i] = (columns[i] << kSubColumnBits) + (parts.empty() ? 0 : parts[i]);
            columnPlaces_[i] = static_cast<float>(places_[i]) / (1 << kSubColumnBits);
        }
        if (std::all_of(parts.begin(), parts.end(), [](std::uint8_t part) { return part == 0; }))
            parts_.clear();
        if (!parts_.empty()) isWholeRow_ = false;
    }

    std::size_t count() const { return columns_.size(); }
    bool still() const { return scene_.flat || scene_.still[static_cast<std::size_t>(row_)] != 0; }
    const std::uint8_t* bgr() const { return photo_.ptr<std::uint8_t>(row_); }

    // Pixels that are found together. A multiple of kBlockPixels.
    static constexpr std::size_t kPixelsAtATime = 2048;

    void open(int row) {
        row_ = row;
        if (still()) return;
        tables_ = scene_.tables(row);
        layeredColumns(tables_, scratch_, known_);
        if (!parts_.empty()) joinColumns();
        for (std::size_t i = 0; i < lines_.all().size(); ++i)
            pickColumns(columns_.data(), columns_.size(), known_.lines.all()[i]->data(),
                        lines_.all()[i]->data());
        for (std::size_t i = 0; i < parts_.size(); ++i) // slopes: 1/32768 px, offsets: 1/512 px
            lines_.offsets[i] = static_cast<std::int16_t>(
                lines_.offsets[i] + lines_.slopes[i] * parts_[i] / (64 << kSubColumnBits));
        isPicked_ = isWholeRow_;
        listSurfaces();
        splitPlanes();
        soft_.open(scene_, row, tables_, strips_);
    }

    // Finds what the pixels show and gives it to read(begin).
    // @param shifts of the pixels, as for SubpixelSampler::sampleBySteps()
    template <class F>
    void find(const std::int16_t* shifts, const F& read) {
        bounded_ = true;
        for (begin_ = 0; begin_ < columns_.size(); begin_ += kPixelsAtATime) {
            clearLists();
            if (layeredLines(linePixels(shifts), room_)) guess();
            findEnds();
            read(begin_);
        }
    }

    // The same for shifts that may be beyond the reach of the scene, in px.
    template <class F>
    void findAnywhere(const float* shifts, const F& read) {
        bounded_ = false;
        for (begin_ = 0; begin_ < columns_.size(); begin_ += kPixelsAtATime) {
            clearLists();
            listAll(shifts + begin_);
            findEnds();
            read(begin_);
        }
    }

    // Reads a channel of the pixels just found. @param values of these pixels
    void read(int channel, std::uint8_t* values) const {
        const std::uint8_t* plane =
            planes_[static_cast<std::size_t>(channel)].data() + kTablePadding;
        layeredSamples(plane, room_.places.data(), size(), values);
        const auto set = [&](std::int32_t pixel, int to) {
            values[pixel] = static_cast<std::uint8_t>(to);
        };
        for (const SoftPixel& behind : behind_)
            set(behind.pixel, behind.colour(values[behind.pixel], plane));
        const bool anySoft = soft_.any();
        for (std::size_t i = 0; i < room_.mixedCount; ++i) {
            int cover = sampleAt(plane, room_.covers[i]);
            if (anySoft) cover = behindCovers_[i].colour(cover, plane);
            set(room_.mixed[i], coveredBy(cover, values[room_.mixed[i]], room_.parts[i]));
        }
        for (std::size_t i = 0; i < hard_.size(); ++i) {
            const auto coverOf = [&](int k) {
                const int cover = sampleAt(plane, hard_[i].place[k]);
                return anySoft ? behindHard_[i][static_cast<std::size_t>(k)].colour(cover, plane)
                               : cover;
            };
            set(room_.hard.pixels[i], colourOf(hard_[i], coverOf));
        }
    }

  private:
    // Number of pixels being found.
    std::size_t size() const { return std::min(kPixelsAtATime, columns_.size() - begin_); }

    LayeredLinePixels linePixels(const std::int16_t* shifts) const {
        return {lines_.offsets.data() + begin_,
                lines_.slopes.data() + begin_,
                lines_.from.data() + begin_,
                lines_.to.data() + begin_,
                places_.data() + begin_,
                shifts + begin_,
                scene_.reachPixels,
                size()};
    }

    LayeredPixels pixels() const {
        const LayeredColumns& values = isWholeRow_ ? known_ : copies_;
        return {columnPlaces_.data() + begin_,
                values.offsets.data() + begin_,
                values.slopes.data() + begin_,
                values.from.data() + begin_,
                values.to.data() + begin_,
                values.first.data() + begin_,
                values.mirroredFirst.data() + begin_,
                size()};
    }

    // Turns what is known of columns into what is known of the places from each to the next one.
    void joinColumns() {
        const auto join = [&](auto& limits, auto none) {
            for (std::size_t x = 0; x + 1 < static_cast<std::size_t>(scene_.width); ++x) {
                const auto least = none < 0 ? std::min(limits[x], limits[x + 1])
                                            : std::max(limits[x], limits[x + 1]);
                limits[x] = known_.first[x] == known_.first[x + 1] ? least : none;
            }
        };
        join(known_.from, 1.0F);
        join(known_.to, -1.0F);
        join(known_.lines.from, -1);
        join(known_.lines.to, -1);
    }

    void clearLists() {
        for (LayeredList* list : {&room_.open[0], &room_.open[1], &room_.hard})
            list->size = 0;
        room_.mixedCount = 0;
    }

    // Finds what pixels of open blocks show and lists the others.
    void guess() {
        if (!isPicked_) {
            for (std::size_t i = 0; i < known_.all().size(); ++i)
                pickColumns(columns_.data(), columns_.size(), known_.all()[i]->data(),
                            copies_.all()[i]->data());
            isPicked_ = true;
        }
        layeredGuesses(tables_, pixels(), room_);
    }

    // Lists all pixels.
    void listAll(const float* shifts) {
        std::fill(room_.openBlocks.begin(), room_.openBlocks.end(), std::uint8_t{1});
        std::copy_n(shifts, size(), room_.shifts.begin());
        for (std::size_t i = 0; i < size(); ++i) {
            LayeredList& list = room_.open[shifts[i] < 0 ? 1 : 0];
            list.pixels[list.size] = static_cast<std::int32_t>(i);
            list.columns[list.size] = columnPlaces_[begin_ + i];
            list.shifts[list.size] = shifts[i];
            ++list.size;
        }
    }

    // Finds what the listed pixels show: layeredAmongSurfaces() (layered_guesses.cpp), then
    // LayeredSearch (layered_ends.cpp).
    void findEnds() {
        const LayeredSurfaces surfaces = {left_.data(),
                                          right_.data(),
                                          endOffsets_.data(),
                                          {0, mirroredSurfaces_, static_cast<int>(left_.size())}};
        for (int direction = 0; direction < 2; ++direction) {
            if (bounded_ && scene_.inOrder) {
                layeredAmongSurfaces(tables_, surfaces, scene_.reachColumns, direction, room_);
            } else {
                leaveToSearch(direction);
            }
        }
        const LayeredSearch search(scene_, row_, tables_, strips_);
        hard_.resize(room_.hard.size);
        for (std::size_t i = 0; i < hard_.size(); ++i) {
            const float column = room_.hard.columns[i];
            const float shift = room_.hard.shifts[i];
            const int direction = shift < 0 ? 1 : 0;
            const float x = direction == 0 ? column : static_cast<float>(scene_.width - 1) - column;
            hard_[i] = search.at(direction, x, std::abs(shift), room_.hardColumns[i]);
        }
        findBehind();
    }

    // Leaves listed pixels to LayeredSearch.
    void leaveToSearch(int direction) {
        const LayeredList& list = room_.open[direction];
        LayeredList& hard = room_.hard;
        const int last = scene_.width - 1;
        for (std::size_t i = 0; i < list.size; ++i) {
            const float column = list.columns[i];
            const int x = static_cast<int>(
                std::ceil(direction == 0 ? column : static_cast<float>(last) - column));
            room_.places[static_cast<std::size_t>(list.pixels[i])] = kSeeEnds;
            hard.pixels[hard.size] = list.pixels[i];
            hard.columns[hard.size] = list.columns[i];
            hard.shifts[hard.size] = list.shifts[i];
            room_.hardColumns[hard.size] =
                bounded_ ? std::min(x + scene_.reachColumns, last) : last;
            ++hard.size;
        }
    }

    // Finds what is behind soft borders.
    void findBehind() {
        behind_.clear();
        if (!soft_.any()) return;
        const auto at = [&](std::int32_t pixel, std::int32_t place) {
            const auto i = static_cast<std::size_t>(pixel);
            SoftPixel soft = soft_.at(place, places_[begin_ + i], room_.shifts[i]);
            soft.pixel = pixel;
            return soft;
        };
        const std::size_t count = soft_.find(room_, size(), softPixels_.data());
        for (std::size_t i = 0; i < count; ++i) {
            const std::int32_t pixel = softPixels_[i];
            behind_.push_back(at(pixel, room_.places[static_cast<std::size_t>(pixel)]));
        }
        behindCovers_.resize(room_.mixedCount);
        for (std::size_t i = 0; i < room_.mixedCount; ++i)
            behindCovers_[i] = at(room_.mixed[i], room_.covers[i]);
        behindHard_.resize(hard_.size());
        for (std::size_t i = 0; i < hard_.size(); ++i)
            for (int k = 0; k < hard_[i].count; ++k)
                behindHard_[i][static_cast<std::size_t>(k)] =
                    at(room_.hard.pixels[i], hard_[i].place[k]);
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
                // without a strip to its right, its last column is the photo's, which may be soft
                const int plain = direction == 0 ? surface.last : scene_.width - 1 - surface.last;
                right_.push_back({static_cast<float>(surface.last),
                                  static_cast<float>(surface.beyond), 1 + surface.rightExtra,
                                  surface.beyond > 0 ? strip : static_cast<float>(plain - 1)});
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
        const float farthest = last - static_cast<float>(2 * scene_.reachColumns + kEndReach);
        float least = kNeverPasses;
        for (std::size_t i = right_.size() - 1; i-- > begin && right_[i].column >= farthest;) {
            const float nearer = offset - endOffsets_[i].last;
            const float way = last - right_[i].column - right_[i].painted - right_[i].border;
            if (nearer > 0) least = std::min(least, std::max(way - kRounding, 0.0F) / nearer);
        }
        return least;
    }

    // Planes of the row and the mirrored row, end px repeated, and of the painted strips.
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
    LayeredLines<std::int16_t> lines_; // lines of each pixel's column
    LayeredColumns copies_;            // per pixel's column, if isPicked_ and not isWholeRow_
    bool isPicked_ = false;
    bool isWholeRow_ = false;         // pixels and columns are the same
    std::vector<std::uint8_t> parts_; // 1/256 px right of the columns; empty if all are at columns
    std::vector<float> scratch_;
    std::vector<float> columnPlaces_;  // all pixels, see LayeredPixels
    std::vector<std::int32_t> places_; // the same, in 1/256 px
    LayeredRoom room_;
    std::vector<LayeredCovers> hard_; // covers of LayeredRoom::hard
    SoftBorders soft_;
    std::vector<std::int32_t> softPixels_; // at soft borders
    std::vector<SoftPixel> behind_;        // what is behind them,
    std::vector<SoftPixel> behindCovers_;  // behind LayeredRoom::covers
    std::vector<std::array<SoftPixel, LayeredCovers::kMax>>
        behindHard_;               // and behind those of hard_
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
                   const std::vector<std::uint8_t>& parts, double largestShift)
        : reader_(photo, scene, columns, parts), steps_(shiftStepsOf(scene, largestShift)) {
        if (steps_ > 0) wholeShifts_ = paddedRow<std::int16_t>(columns.size());
    }

    void open(int row) override { reader_.open(row); }

    bool still() const override { return reader_.still(); }

    void sample(int channel, const float* shifts, std::uint8_t* values) override {
        const auto read = [&](std::size_t begin) { reader_.read(channel, values + begin); };
        if (steps_ == 0) return reader_.findAnywhere(shifts, read);
        for (std::size_t i = 0; i < reader_.count(); ++i)
            wholeShifts_[i] = wholeShift(static_cast<double>(shifts[i]), steps_);
        reader_.find(wholeShifts_.data(), read);
    }

    void sampleBySteps(const std::array<const std::int16_t*, 3>& shifts,
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

class LayeredRowRenderer : public RowRenderer {
  public:
    LayeredRowRenderer(const cv::Mat& photo, const LayeredScene& scene,
                       const std::vector<int>& columns)
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
        LayeredRowRenderer rows(photo_, scene_, columns_);
        const std::vector<double> shifts = {shiftPixels};
        for (int y = 0; y < photo_.rows; ++y)
            rows.render(y, shifts, {view.ptr<std::uint8_t>(y)});
    }

    bool makesRows() const override { return true; }

    std::unique_ptr<RowRenderer> rowRenderer() const override {
        return std::make_unique<LayeredRowRenderer>(photo_, scene_, columns_);
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
