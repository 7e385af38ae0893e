// Pixels at the ends of surfaces: borders that cover part of a pixel, the background painted beside
// surfaces and, behind both, the next surface.

#include "views/views_layered_ends.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace altiro3D {

namespace {

constexpr int kSubColumns = 1 << kSubColumnBits;

// One search.
class Search {
  public:
    // @param strips first column of the direction's strips in the planes
    Search(const LayeredTables& tables, const LayeredRow& row, int direction, int strips, int x,
           float shift)
        : surfaces_(row.surfaces.data()), surfaceCount_(static_cast<int>(row.surfaces.size())),
          words_(tables.words + direction * tables.stride),
          surfaceOf_(tables.surfaces + direction * tables.stride), base_(direction * tables.stride),
          strips_(strips), x_(static_cast<float>(x)), unit_(shift * tables.scale) {}

    LayeredPixel run(int column) {
        if (unit_ == 0) { // the photo itself, whatever is beside the column
            cover((base_ << kSubColumnBits) + subColumns(x_), 1);
            return pixel_;
        }
        for (int k = column < 0 ? -1 : surfaceOf_[column]; k >= 0; --k)
            if (visit(k, std::min(column, surfaces_[k].last))) return pixel_;
        if (!showsHidden(0)) takeLast();
        return pixel_;
    }

  private:
    float offsetOf(int column) const { return static_cast<float>(wordOffset(words_[column])); }

    float placeOf(int column) const {
        return static_cast<float>(column) - unit_ * offsetOf(column);
    }

    // Place of the pixel between a column left of it, or at it, and the next one.
    std::int32_t placeAfter(int column) const {
        const float start = placeOf(column);
        const float steps = (x_ - start) * static_cast<float>(kSubColumns);
        const float part = steps / (placeOf(column + 1) - start);
        return ((base_ + column) << kSubColumnBits) + static_cast<std::int32_t>(std::lrint(part));
    }

    static std::int32_t subColumns(float distance) {
        return static_cast<std::int32_t>(distance * static_cast<float>(kSubColumns) + 0.5F);
    }

    // Adds a cover above the later ones. True if it hides everything below.
    bool cover(std::int32_t place, float coverage) {
        if (!(coverage > 0)) return false;
        const int part = subColumns(std::min(coverage, 1.0F));
        if (part == 0) return false;
        const bool full = part >= kSubColumns || pixel_.count + 1 == LayeredPixel::kMax;
        pixel_.place[pixel_.count] = place;
        pixel_.coverage[pixel_.count] = full ? kSubColumns : part;
        ++pixel_.count;
        return full;
    }

    // Place of the background painted `distance` px left of surface k, limited to the painted
    // columns.
    std::int32_t hiddenPlace(int k, float distance) const {
        const LayeredSurface& surface = surfaces_[k];
        const float inside = std::min(distance, static_cast<float>(surface.hidden));
        return ((strips_ + surface.hiddenAt(0)) << kSubColumnBits) - subColumns(inside);
    }

    // Place of the background painted `distance` px right of surface k, limited to the painted
    // columns; without any, of its last column in the photo.
    std::int32_t beyondPlace(int k, float distance) const {
        const LayeredSurface& surface = surfaces_[k];
        if (surface.beyond == 0) return (base_ + surface.last) << kSubColumnBits;
        const float inside = std::min(distance, static_cast<float>(surface.beyond));
        return ((strips_ + surface.beyondAt(0)) << kSubColumnBits) + subColumns(inside);
    }

    // Searches surface k from column `from` to the left. True if the pixel is complete.
    bool visit(int k, int from) {
        const LayeredSurface& surface = surfaces_[k];
        for (int column = from; column >= surface.first; --column) {
            const float start = placeOf(column);
            if (start > x_) continue;
            if (column == surface.last) return endOf(k, x_ - start);
            return cover(placeAfter(column), 1);
        }
        if (surface.hidden > 0) return false; // its end is hidden
        const float border = x_ + (1 + surface.leftExtra) - placeOf(surface.first);
        return cover((base_ + surface.first) << kSubColumnBits, border);
    }

    // The pixel is `distance` px beyond the last column of surface k. True if it is complete.
    bool endOf(int k, float distance) {
        const LayeredSurface& surface = surfaces_[k];
        const auto beyond = static_cast<float>(surface.beyond);
        const std::int32_t place = beyondPlace(k, distance);
        if (distance <= beyond) return cover(place, 1);
        if (!last_) last_ = k + 1 < surfaceCount_ ? hiddenPlace(k + 1, kFar) : place;
        if (cover(place, beyond + (1 + surface.rightExtra) - distance)) return true;
        return showsPassed(k) || showsHidden(k + 1);
    }

    // What a surface shows at the pixel.
    struct Content {
        std::int32_t place = 0;
        float coverage = 0; // > 0: it covers this part of the pixel, or more than all
        float offset = 0;
    };

    Content contentOf(int k) const {
        const LayeredSurface& surface = surfaces_[k];
        const float first = placeOf(surface.first);
        if (x_ < first) {
            const float away = first - x_;
            const float offset = offsetOf(surface.first);
            if (surface.hidden > 0)
                return {hiddenPlace(k, away), static_cast<float>(1 + surface.hidden) - away,
                        offset};
            return {(base_ + surface.first) << kSubColumnBits, (1 + surface.leftExtra) - away,
                    offset};
        }
        const float last = placeOf(surface.last);
        if (x_ >= last) {
            const auto painted = static_cast<float>(1 + surface.beyond);
            return {beyondPlace(k, x_ - last), painted + surface.rightExtra - (x_ - last),
                    offsetOf(surface.last)};
        }
        int column = surface.last - 1;
        while (placeOf(column) > x_)
            --column;
        return {placeAfter(column), 1, offsetOf(column)};
    }

    // Covers the pixel, at which surface k has ended, with surfaces further left that are nearer
    // than what is painted left of those further right: surface k has passed them. True if the
    // pixel is complete.
    bool showsPassed(int k) {
        float behind = -kFar;
        for (int right = k + 1; right < surfaceCount_ && behind == -kFar; ++right) {
            const Content painted = surfaces_[right].hidden > 0 ? contentOf(right) : Content();
            if (painted.coverage > 0) behind = painted.offset;
        }
        for (float front = kFar;;) { // from front to back
            Content nearest;
            nearest.offset = behind;
            for (int left = k - 1; left >= 0 && canReach(surfaces_[left].last); --left) {
                const Content content = contentOf(left);
                if (content.coverage > 0 && content.offset > nearest.offset &&
                    content.offset < front)
                    nearest = content;
            }
            if (!(nearest.coverage > 0)) return false;
            if (cover(nearest.place, nearest.coverage)) return true;
            front = nearest.offset;
        }
    }

    // Whether the end of a surface at this column can lie at the pixel or right of it.
    bool canReach(int column) const {
        constexpr int kBeyond = 2 * kEndReach; // painted columns and border
        return static_cast<float>(column + kBeyond) + unit_ * static_cast<float>(kMaxOffset) >= x_;
    }

    // Covers the pixel with the background painted left of surface k or of one further right. True
    // if the pixel is complete.
    bool showsHidden(int k) {
        for (; k < surfaceCount_; ++k) {
            const LayeredSurface& surface = surfaces_[k];
            if (surface.hidden == 0) continue;
            const float distance = placeOf(surface.first) - x_;
            if (distance < 0) continue;
            const float over = distance - static_cast<float>(surface.hidden);
            if (cover(hiddenPlace(k, distance), 1 - std::max(over, 0.0F))) return true;
        }
        return false;
    }

    // Beyond the prepared reach, the last prepared px is repeated.
    void takeLast() { cover(last_.value_or(hiddenPlace(0, kFar)), 1); }

    static constexpr float kFar = 1e9F; // more than any painted width

    const LayeredSurface* surfaces_;
    int surfaceCount_;
    const std::int16_t* words_;
    const std::int16_t* surfaceOf_;
    int base_;
    int strips_;
    float x_;
    float unit_; // px per unit of the offsets
    LayeredPixel pixel_;
    std::optional<std::int32_t> last_; // the candidate for takeLast()
};

} // namespace

LayeredPixel LayeredSearch::at(int direction, int x, float shift, int column) const {
    return Search(tables_, *rows_[direction], direction, strips_[direction], x, shift).run(column);
}

} // namespace altiro3D
