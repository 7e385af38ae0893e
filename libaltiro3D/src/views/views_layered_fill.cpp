// The hidden background of method Layered, painted once for all views in the photo's geometry.

#include "base/large_mat.hpp"
#include "views/depth_offsets.hpp"
#include "views/views_layered_scene.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Sweeps over the painted background, which smooth differences between rows.
constexpr int kSweeps = 4;
// Neighbours belong to one surface if they differ by at most this many tears. A visible neighbour
// must not be nearer by more than one tear, because it would be the occluder.
constexpr double kSameTears = 5;

struct Colour {
    float bgr[3] = {0, 0, 0};
};

constexpr std::int32_t kNoLink = INT32_MIN;

// A painted column.
struct Cell {
    int y = 0;
    int x = 0;
    int strip = 0;    // its index in LayeredRow::strips
    int distance = 0; // distance from the visible part of its surface, px, >= 1
    int inwards = 1;  // direction to the visible part, 1 or -1
    float offset = 0;
    bool isKnown = false; // its colour need not be painted
    // Neighbours: inwards, above, below, outwards, inwards above, inwards below. >= 0: a cell,
    // < 0: -1 - index of a pixel of the photo.
    std::int32_t link[6] = {kNoLink, kNoLink, kNoLink, kNoLink, kNoLink, kNoLink};
};

class Background {
  public:
    // @param known of the hidden background, mirrored as the photo
    Background(const cv::Mat& photo, const HiddenLayer& known, double focus, int direction,
               LayeredScene& scene, double tear)
        : photo_(photo.isContinuous() ? photo : photo.clone()), known_(known), focus_(focus),
          rows_(scene.rows[direction]), scene_(scene), direction_(direction), tear_(tear) {
        measure();
        if (cellCount_ == 0) return;
        collect();
        for (std::size_t i = 0; i < cells_.size(); ++i)
            link(cells_[i], static_cast<std::int32_t>(i));
    }

    void paint() {
        if (cells_.empty()) return;
        colours_.resize(cells_.size());
        takeKnown();
        flowIn();
        for (int sweep = 0; sweep < kSweeps; ++sweep)
            evenOut(sweep % 2 != 0);
        store();
    }

  private:
    void measure() {
        for (const LayeredRow& row : rows_) {
            for (const LayeredSurface& surface : row.surfaces) {
                left_ = std::max(left_, surface.hidden - surface.first);
                right_ = std::max(right_, surface.last + surface.beyond - (photo_.cols - 1));
                cellCount_ += static_cast<std::size_t>(surface.hidden + surface.beyond);
            }
        }
    }

    void collect() {
        owner_ = largeMat(photo_.rows, left_ + photo_.cols + right_, CV_32SC1);
        owner_.setTo(cv::Scalar(-1));
        cells_.reserve(cellCount_);
        for (int y = 0; y < photo_.rows; ++y) {
            const std::int16_t* words = wordsOf(y);
            const auto offset = [&](int x) { return offsetOf(words[x]); };
            for (const LayeredSurface& surface : rows_[static_cast<std::size_t>(y)].surfaces) {
                for (int k = 1; k <= surface.hidden; ++k)
                    add(y, surface.first - k, surface.hiddenAt(k), k, 1, offset(surface.first));
                for (int k = 1; k <= surface.beyond; ++k)
                    add(y, surface.last + k, surface.beyondAt(k), k, -1, offset(surface.last));
            }
        }
    }

    void add(int y, int x, int strip, int distance, int inwards, float offset) {
        Cell cell;
        cell.y = y;
        cell.x = x;
        cell.strip = strip;
        cell.distance = distance;
        cell.inwards = inwards;
        cell.offset = offset;
        // If several hidden surfaces overlap, neighbours link to the one whose visible part is
        // closest.
        std::int32_t& owner = owner_.ptr<std::int32_t>(y)[x + left_];
        if (owner < 0 || cells_[static_cast<std::size_t>(owner)].distance > distance)
            owner = static_cast<std::int32_t>(cells_.size());
        cells_.push_back(cell);
    }

    const std::int16_t* wordsOf(int y) const {
        return scene_.tables(y).words + direction_ * scene_.stride();
    }

    float offsetOf(std::int16_t word) const {
        return scene_.scale * static_cast<float>(wordOffset(word));
    }

    // False for mixed pixels, which lie between two surfaces.
    bool isOfSurface(int y, int x) const {
        const std::int16_t* surfaces = scene_.tables(y).surfaces + direction_ * scene_.stride();
        const auto& row = rows_[static_cast<std::size_t>(y)].surfaces;
        return x <= row[static_cast<std::size_t>(surfaces[x])].last;
    }

    // The pixel or cell at (x, y), if it belongs to the surface of the cell.
    std::int32_t neighbour(const Cell& cell, int y, int x) const {
        if (y < 0 || y >= photo_.rows || x < -left_ || x >= photo_.cols + right_) return kNoLink;
        const auto nearerBy = [&](float offset) {
            return static_cast<double>(offset) - static_cast<double>(cell.offset);
        };
        if (x >= 0 && x < photo_.cols && isOfSurface(y, x)) {
            const double nearer = nearerBy(offsetOf(wordsOf(y)[x]));
            if (nearer <= tear_ && nearer >= -kSameTears * tear_) return -1 - (y * photo_.cols + x);
        }
        const std::int32_t other = owner_.ptr<std::int32_t>(y)[x + left_];
        if (other < 0) return kNoLink;
        const double nearer = nearerBy(cells_[static_cast<std::size_t>(other)].offset);
        return std::abs(nearer) <= kSameTears * tear_ ? other : kNoLink;
    }

    void link(Cell& cell, std::int32_t index) const {
        const int inner = cell.x + cell.inwards;
        cell.link[0] = cell.distance == 1 ? -1 - (cell.y * photo_.cols + inner) : index - 1;
        cell.link[1] = neighbour(cell, cell.y - 1, cell.x);
        cell.link[2] = neighbour(cell, cell.y + 1, cell.x);
        cell.link[3] = neighbour(cell, cell.y, cell.x - cell.inwards);
        cell.link[4] = neighbour(cell, cell.y - 1, inner);
        cell.link[5] = neighbour(cell, cell.y + 1, inner);
    }

    Colour colourOf(std::int32_t link) const {
        if (link >= 0) return colours_[static_cast<std::size_t>(link)];
        const std::uint8_t* pixel = photo_.data + 3 * (-1 - static_cast<std::ptrdiff_t>(link));
        return {{static_cast<float>(pixel[0]), static_cast<float>(pixel[1]),
                 static_cast<float>(pixel[2])}};
    }

    // Colours of the cells at which the layer of known background shows the surface of the cell.
    void takeKnown() {
        if (known_.photo.empty()) return;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            Cell& cell = cells_[i];
            if (cell.x < 0 || cell.x >= photo_.cols) continue;
            const float depth = known_.depth.ptr<float>(cell.y)[cell.x];
            if (std::isnan(depth)) continue;
            const float away = offsetFromFocus(depth, focus_) - cell.offset;
            if (std::abs(static_cast<double>(away)) > kSameTears * tear_) continue;
            cell.isKnown = true;
            const std::uint8_t* bgr = known_.photo.ptr<std::uint8_t>(cell.y) + 3 * cell.x;
            std::copy_n(bgr, 3, colours_[i].bgr);
        }
    }

    // From the visible border inwards, each cell becomes the mean of the neighbours painted before
    // it. Streaks widen with the distance, and colours from above and below flow in.
    void flowIn() {
        constexpr float kWeights[6] = {2, 1, 1, 1, 1, 1};
        std::vector<std::vector<std::size_t>> atDistance;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            const auto distance = static_cast<std::size_t>(cells_[i].distance);
            if (atDistance.size() < distance) atDistance.resize(distance);
            atDistance[distance - 1].push_back(i);
        }
        for (const std::vector<std::size_t>& ring : atDistance) {
            for (const std::size_t i : ring) {
                const Cell& cell = cells_[i];
                if (cell.isKnown) continue;
                Colour sum;
                float weight = 0;
                for (int k = 0; k < 6; ++k) {
                    const std::int32_t link = cell.link[k];
                    const bool painted = link != kNoLink && (link < 0 || isPainted(cell, link));
                    if (painted) addTo(sum, weight, link, kWeights[k]);
                }
                setMean(i, sum, weight);
            }
        }
    }

    // Whether another cell has its colour when this one is painted.
    bool isPainted(const Cell& cell, std::int32_t other) const {
        const Cell& neighbour = cells_[static_cast<std::size_t>(other)];
        return neighbour.isKnown || neighbour.distance < cell.distance;
    }

    // Gauss-Seidel sweep for a membrane fixed at the known neighbours.
    void evenOut(bool backwards) {
        for (std::size_t n = 0; n < cells_.size(); ++n) {
            const std::size_t i = backwards ? cells_.size() - 1 - n : n;
            if (cells_[i].isKnown) continue;
            Colour sum;
            float weight = 0;
            for (int k = 0; k < 4; ++k)
                if (cells_[i].link[k] != kNoLink) addTo(sum, weight, cells_[i].link[k], 1);
            setMean(i, sum, weight);
        }
    }

    void addTo(Colour& sum, float& weight, std::int32_t link, float share) const {
        const Colour colour = colourOf(link);
        for (int c = 0; c < 3; ++c)
            sum.bgr[c] += share * colour.bgr[c];
        weight += share;
    }

    void setMean(std::size_t cell, const Colour& sum, float weight) {
        for (int c = 0; c < 3; ++c)
            colours_[cell].bgr[c] = sum.bgr[c] / weight;
    }

    void store() {
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            const Cell& cell = cells_[i];
            LayeredRow& row = rows_[static_cast<std::size_t>(cell.y)];
            std::uint8_t* bytes = &row.strips[4 * static_cast<std::size_t>(cell.strip)];
            for (int c = 0; c < 3; ++c)
                bytes[c] = cv::saturate_cast<std::uint8_t>(colours_[i].bgr[c]);
        }
    }

    const cv::Mat photo_; // in one piece
    const HiddenLayer known_;
    double focus_;
    std::vector<LayeredRow>& rows_;
    const LayeredScene& scene_;
    int direction_;
    double tear_;
    int left_ = 0;  // columns left of the frame
    int right_ = 0; // columns right of the frame
    std::size_t cellCount_ = 0;
    cv::Mat owner_; // [rows x left + cols + right, CV_32SC1] the cell at each place, -1 = none
    std::vector<Cell> cells_;
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
    Background(seen, known, focus, direction, scene, options.tearStep()).paint();
}

} // namespace altiro3D
