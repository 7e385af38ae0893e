// The hidden background of method Layered, painted once for all views in the photo's geometry.

#include "views/depth_offsets.hpp"
#include "views/layered/layered_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// The share of a cell's colour that is the mean of visible px of its row: of as many px as the cell
// is px away from them, but at most 1 / kRowDivisor of the surface.
constexpr float kRowShare = 0.3F;
constexpr int kRowDivisor = 4;
// Cells this many px behind the first one take half of their colour from the row beside them.
constexpr float kHalfwayPixels = 4;
// Neighbours belong to one surface if they differ by at most this many tears. A visible neighbour
// must not be nearer by more than one tear, because it would be the occluder.
constexpr double kSameTears = 5;

// Blue, green, red, and one that does not count, so a colour fills a register.
struct Colour {
    float bgr[4] = {0, 0, 0, 0};
};

// Neighbours of cells. >= 0: a cell, < 0: -1 - index of a pixel of the photo.
constexpr std::int32_t kNoLink = INT32_MIN;

// The painted columns on one side of a surface of a row. The first of its cells is the one beside
// the visible part; each further one lies one px further outwards.
struct Run {
    int y = 0;
    int x = 0;              // column of the first cell
    int inwards = 1;        // direction to the visible part, 1 or -1
    int strip = 0;          // index of the first cell in LayeredRow::strips
    int length = 0;         // cells
    int visible = 0;        // px of the surface's visible part
    int offset = 0;         // offset of the surface's end, in units of LayeredTables
    std::int32_t first = 0; // index of the first cell
    // neighbours of the first cell: inwards, inwards above, inwards below
    std::int32_t inner = kNoLink;
    std::int32_t innerAbove = kNoLink;
    std::int32_t innerBelow = kNoLink;
};

// Cells and pixels of one row, by column.
class RowMap {
  public:
    // @param left, right columns beside the frame
    RowMap(int left, int width, int right)
        : left_(left), width_(width),
          cells_(static_cast<std::size_t>(left + width + right), kNoCell),
          offsets_(static_cast<std::size_t>(width)) {}

    static constexpr std::int32_t kNoCell = -1;
    static constexpr std::int16_t kMixed = INT16_MIN;

    bool holds(int x) const { return x >= -left_ && x + left_ < static_cast<int>(cells_.size()); }
    std::int32_t& cell(int x) { return cells_[static_cast<std::size_t>(x + left_)]; }
    std::int32_t cell(int x) const { return cells_[static_cast<std::size_t>(x + left_)]; }
    // Offset of a pixel; kMixed for mixed pixels, between two surfaces, and beside the frame.
    int offset(int x) const {
        return x >= 0 && x < width_ ? offsets_[static_cast<std::size_t>(x)] : kMixed;
    }

    // Reads the pixels of a row. @param words LayeredTables::words
    void read(const std::int16_t* words, const std::vector<LayeredSurface>& surfaces) {
        for (int x = 0; x < width_; ++x)
            offsets_[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(wordOffset(words[x]));
        for (std::size_t i = 0; i + 1 < surfaces.size(); ++i)
            std::fill(offsets_.begin() + surfaces[i].last + 1,
                      offsets_.begin() + surfaces[i + 1].first, kMixed);
    }

  private:
    int left_;
    int width_;
    std::vector<std::int32_t> cells_;
    std::vector<std::int16_t> offsets_;
};

class Background {
  public:
    // @param tear see LayeredSettings::tearStep()
    Background(const cv::Mat& photo, int direction, LayeredScene& scene, double tear)
        : photo_(photo.isContinuous() ? photo : photo.clone()), rows_(scene.rows[direction]),
          scene_(scene), direction_(direction),
          tear_(static_cast<int>(std::min(tear / static_cast<double>(scene.scale), kFar))),
          sameTears_(static_cast<int>(
              std::min(kSameTears * tear / static_cast<double>(scene.scale), kFar))) {
        collect();
        link();
    }

    // @param known what is known about the hidden background, mirrored as the photo
    void paint(const HiddenLayer& known, double focus) {
        if (cellCount_ == 0) return;
        colours_.resize(cellCount_);
        if (!known.photo.empty()) take(known, focus);
        flowIn();
        blendWithRows();
        spread(runs_.begin(), runs_.end(), above_);
        spread(runs_.rbegin(), runs_.rend(), below_);
        for (const bool backwards : {false, true})
            evenOut(backwards);
        store();
    }

  private:
    static constexpr double kFar = 1 << 20;   // more than any two offsets differ
    static constexpr std::int16_t kKnown = 0; // distance of cells that are not painted

    void collect() {
        runsOfRow_.reserve(rows_.size() + 1);
        for (std::size_t y = 0; y < rows_.size(); ++y) {
            const std::int16_t* words = wordsOf(static_cast<int>(y));
            runsOfRow_.push_back(runs_.size());
            for (const LayeredSurface& surface : rows_[y].surfaces) {
                left_ = std::max(left_, surface.hidden - surface.first);
                right_ = std::max(right_, surface.last + surface.beyond - (photo_.cols - 1));
                Run run;
                run.y = static_cast<int>(y);
                run.visible = surface.last - surface.first + 1;
                run.x = surface.first - 1;
                run.strip = surface.hiddenAt(1);
                run.length = surface.hidden;
                run.offset = wordOffset(words[surface.first]);
                add(run);
                run.x = surface.last + 1;
                run.inwards = -1;
                run.strip = surface.beyondAt(1);
                run.length = surface.beyond;
                run.offset = wordOffset(words[surface.last]);
                add(run);
            }
        }
        runsOfRow_.push_back(runs_.size());
    }

    void add(Run run) {
        if (run.length == 0) return;
        run.first = static_cast<std::int32_t>(cellCount_);
        longest_ = std::max(longest_, run.length);
        cellCount_ += static_cast<std::size_t>(run.length);
        runs_.push_back(run);
    }

    const std::int16_t* wordsOf(int y) const {
        return scene_.words.ptr<std::int16_t>(y) + kTablePadding + direction_ * scene_.stride();
    }

    Run* runsBegin(int y) { return runs_.data() + runsOfRow_[static_cast<std::size_t>(y)]; }
    Run* runsEnd(int y) { return runs_.data() + runsOfRow_[static_cast<std::size_t>(y) + 1]; }

    // Marks the cells of a row. If several hidden surfaces overlap, neighbours link to the one
    // whose visible part is closest.
    void mark(int y, RowMap& map) {
        map.read(wordsOf(y), rows_[static_cast<std::size_t>(y)].surfaces);
        for (const Run* run = runsBegin(y); run < runsEnd(y); ++run) {
            for (int k = 0; k < run->length; ++k) {
                std::int32_t& cell = map.cell(run->x - k * run->inwards);
                if (cell == RowMap::kNoCell || distances_[static_cast<std::size_t>(cell)] > k + 1)
                    cell = run->first + k;
                const auto own = static_cast<std::size_t>(run->first + k);
                distances_[own] = static_cast<std::int16_t>(k + 1);
                offsets_[own] = static_cast<std::int16_t>(run->offset);
            }
        }
    }

    void unmark(int y, RowMap& map) {
        for (const Run* run = runsBegin(y); run < runsEnd(y); ++run)
            for (int k = 0; k < run->length; ++k)
                map.cell(run->x - k * run->inwards) = RowMap::kNoCell;
    }

    std::int32_t pixelLink(int y, int x) const { return -1 - (y * photo_.cols + x); }

    // The pixel or cell at column x of row y, if it belongs to a surface with this offset.
    std::int32_t neighbour(const RowMap& map, int y, int x, int offset) const {
        if (!map.holds(x)) return kNoLink;
        const int visible = map.offset(x);
        const int nearer = visible - offset;
        if (visible != RowMap::kMixed && nearer <= tear_ && nearer >= -sameTears_)
            return pixelLink(y, x);
        const std::int32_t other = map.cell(x);
        if (other == RowMap::kNoCell) return kNoLink;
        return std::abs(offsets_[static_cast<std::size_t>(other)] - offset) <= sameTears_ ? other
                                                                                          : kNoLink;
    }

    // Finds the neighbours of all cells, with the maps of three rows at a time.
    void link() {
        if (cellCount_ == 0) return;
        distances_.resize(cellCount_);
        offsets_.resize(cellCount_);
        for (std::vector<std::int32_t>* links : {&above_, &below_, &outwards_})
            links->resize(cellCount_, kNoLink);
        std::array<RowMap, 3> maps = {RowMap(left_, photo_.cols, right_),
                                      RowMap(left_, photo_.cols, right_),
                                      RowMap(left_, photo_.cols, right_)};
        mark(0, maps[0]);
        for (int y = 0; y < photo_.rows; ++y) {
            RowMap& below = maps[static_cast<std::size_t>(y + 1) % 3];
            if (y >= 2) unmark(y - 2, below);
            if (y + 1 < photo_.rows) mark(y + 1, below);
            const RowMap& own = maps[static_cast<std::size_t>(y) % 3];
            const RowMap* above = y > 0 ? &maps[static_cast<std::size_t>(y + 2) % 3] : nullptr;
            for (Run* run = runsBegin(y); run < runsEnd(y); ++run)
                link(*run, above, own, y + 1 < photo_.rows ? &below : nullptr);
        }
    }

    // @param above, below null outside of the photo
    void link(Run& run, const RowMap* above, const RowMap& own, const RowMap* below) {
        const int inner = run.x + run.inwards;
        run.inner = pixelLink(run.y, inner);
        if (above != nullptr) run.innerAbove = neighbour(*above, run.y - 1, inner, run.offset);
        if (below != nullptr) run.innerBelow = neighbour(*below, run.y + 1, inner, run.offset);
        for (int k = 0; k < run.length; ++k) {
            const auto cell = static_cast<std::size_t>(run.first + k);
            const int x = run.x - k * run.inwards;
            if (above != nullptr) above_[cell] = neighbour(*above, run.y - 1, x, run.offset);
            if (below != nullptr) below_[cell] = neighbour(*below, run.y + 1, x, run.offset);
            outwards_[cell] = neighbour(own, run.y, x - run.inwards, run.offset);
        }
    }

    // A sum of colours with weights.
    class Mean {
      public:
        void add(const Colour& colour, float share) {
            for (int c = 0; c < 4; ++c)
                sum_.bgr[c] += share * colour.bgr[c];
            weight_ += share;
        }
        Colour get() const {
            Colour result;
            for (int c = 0; c < 4; ++c)
                result.bgr[c] = sum_.bgr[c] / weight_;
            return result;
        }

      private:
        Colour sum_;
        float weight_ = 0;
    };

    Colour colourOf(std::int32_t link) const {
        if (link >= 0) return colours_[static_cast<std::size_t>(link)];
        const std::uint8_t* pixel = photo_.data + 3 * (-1 - static_cast<std::ptrdiff_t>(link));
        return {{static_cast<float>(pixel[0]), static_cast<float>(pixel[1]),
                 static_cast<float>(pixel[2]), 0}};
    }

    // Takes the colours of cells at which the layer shows the surface of the cell.
    void take(const HiddenLayer& known, double focus) {
        for (const Run& run : runs_) {
            const float* depths = known.depth.ptr<float>(run.y);
            const std::uint8_t* colours = known.photo.ptr<std::uint8_t>(run.y);
            for (int k = 0; k < run.length; ++k) {
                const int x = run.x - k * run.inwards;
                if (x < 0 || x >= photo_.cols || std::isnan(depths[x])) continue;
                const float offset = offsetFromFocus(depths[x], focus) / scene_.scale;
                if (std::abs(static_cast<int>(offset) - run.offset) > sameTears_) continue;
                const auto cell = static_cast<std::size_t>(run.first + k);
                distances_[cell] = kKnown;
                std::copy_n(colours + 3 * static_cast<std::ptrdiff_t>(x), 3, colours_[cell].bgr);
            }
        }
    }

    // From the visible border inwards, each cell becomes the mean of the neighbours painted before
    // it. Streaks widen with the distance, and colours from above and below flow in.
    void flowIn() {
        for (const Run& run : runs_)
            flowInto(run.first, 1, run.inner, run.innerAbove, run.innerBelow);
        // A cell needs only cells that are nearer to the visible border, of its row and of the rows
        // beside it. This order goes down the rows, so what is needed is still in the cache.
        const auto stepOf = [](const Run& run, int k) {
            return static_cast<std::size_t>(run.y + 2 * k);
        };
        std::vector<std::int32_t> begin(static_cast<std::size_t>(photo_.rows + 2 * longest_) + 1);
        for (const Run& run : runs_)
            for (int k = 1; k < run.length; ++k)
                ++begin[stepOf(run, k) + 1];
        for (std::size_t i = 1; i < begin.size(); ++i)
            begin[i] += begin[i - 1];
        std::vector<std::int32_t> order(static_cast<std::size_t>(begin.back()));
        for (const Run& run : runs_)
            for (int k = 1; k < run.length; ++k)
                order[static_cast<std::size_t>(begin[stepOf(run, k)]++)] = run.first + k;
        for (const std::int32_t cell : order) {
            const auto before = static_cast<std::size_t>(cell - 1);
            flowInto(cell, distances_[static_cast<std::size_t>(cell)], cell - 1, above_[before],
                     below_[before]);
        }
    }

    void flowInto(std::int32_t index, int distance, std::int32_t inner, std::int32_t innerAbove,
                  std::int32_t innerBelow) {
        const auto cell = static_cast<std::size_t>(index);
        if (distances_[cell] == kKnown) return;
        Mean mean;
        mean.add(colourOf(inner), 2);
        for (const std::int32_t link :
             {above_[cell], below_[cell], outwards_[cell], innerAbove, innerBelow}) {
            const bool painted =
                link != kNoLink &&
                (link < 0 || distances_[static_cast<std::size_t>(link)] < distance);
            if (painted) mean.add(colourOf(link), 1);
        }
        colours_[cell] = mean.get();
    }

    static void mix(Colour& colour, const Colour& other, float share) {
        for (int c = 0; c < 4; ++c)
            colour.bgr[c] += share * (other.bgr[c] - colour.bgr[c]);
    }

    // What is far behind the border differs from it, and is best guessed by a mean.
    void blendWithRows() {
        for (const Run& run : runs_) {
            Mean row;
            for (int k = 0; k < run.length; ++k) {
                if (kRowDivisor * k < run.visible)
                    row.add(colourOf(pixelLink(run.y, run.x + (k + 1) * run.inwards)), 1);
                const auto cell = static_cast<std::size_t>(run.first + k);
                if (distances_[cell] != kKnown) mix(colours_[cell], row.get(), kRowShare);
            }
        }
    }

    // Widens streaks in proportion to their distance from the visible border: a recursive filter
    // along the rows from begin to end.
    // @param before links to the row that comes before
    template <class Iterator>
    void spread(Iterator begin, Iterator end, const std::vector<std::int32_t>& before) {
        for (Iterator run = begin; run != end; ++run) {
            for (int k = 1; k < run->length; ++k) {
                const auto cell = static_cast<std::size_t>(run->first + k);
                if (distances_[cell] == kKnown || before[cell] == kNoLink) continue;
                const auto distance = static_cast<float>(k);
                mix(colours_[cell], colourOf(before[cell]), distance / (distance + kHalfwayPixels));
            }
        }
    }

    // Gauss-Seidel sweep for a membrane fixed at the known neighbours.
    void evenOut(bool backwards) {
        const auto even = [&](const Run& run, int k) {
            const auto cell = static_cast<std::size_t>(run.first + k);
            if (distances_[cell] == kKnown) return;
            Mean mean;
            mean.add(colourOf(k == 0 ? run.inner : run.first + k - 1), 1);
            for (const std::int32_t link : {above_[cell], below_[cell], outwards_[cell]})
                if (link != kNoLink) mean.add(colourOf(link), 1);
            colours_[cell] = mean.get();
        };
        if (!backwards) {
            for (const Run& run : runs_)
                for (int k = 0; k < run.length; ++k)
                    even(run, k);
            return;
        }
        for (auto run = runs_.rbegin(); run != runs_.rend(); ++run)
            for (int k = run->length - 1; k >= 0; --k)
                even(*run, k);
    }

    void store() {
        for (const Run& run : runs_) {
            std::vector<std::uint8_t>& strips = rows_[static_cast<std::size_t>(run.y)].strips;
            for (int k = 0; k < run.length; ++k) {
                const Colour& colour = colours_[static_cast<std::size_t>(run.first + k)];
                std::uint8_t* bytes = strips.data() + 4 * (run.strip - k * run.inwards);
                for (int c = 0; c < 3; ++c)
                    bytes[c] = cv::saturate_cast<std::uint8_t>(colour.bgr[c]);
            }
        }
    }

    const cv::Mat photo_; // in one piece
    std::vector<LayeredRow>& rows_;
    const LayeredScene& scene_;
    int direction_;
    int tear_; // in units of the offsets
    int sameTears_;
    int left_ = 0;    // columns left of the frame
    int right_ = 0;   // columns right of the frame
    int longest_ = 0; // length of the longest run
    std::vector<Run> runs_;
    std::vector<std::size_t> runsOfRow_; // index of the first one of each row
    // values of each cell
    std::size_t cellCount_ = 0;
    std::vector<std::int16_t> distances_; // from the visible part of its surface, px, or kKnown
    std::vector<std::int16_t> offsets_;
    std::vector<std::int32_t> above_; // neighbours
    std::vector<std::int32_t> below_;
    std::vector<std::int32_t> outwards_;
    std::vector<Colour> colours_;
};

cv::Mat mirrored(const cv::Mat& picture) {
    cv::Mat result;
    if (!picture.empty()) cv::flip(picture, result, 1);
    return result;
}

} // namespace

void paintBackground(const cv::Mat& photo, double focus, const LayeredSettings& options,
                     int direction, LayeredScene& scene) {
    cv::Mat seen = photo;
    HiddenLayer known = options.hidden;
    if (direction == 1) {
        seen = mirrored(photo);
        known = {mirrored(known.photo), mirrored(known.depth)};
    }
    Background(seen, direction, scene, options.tearStep()).paint(known, focus);
}

} // namespace altiro3D
