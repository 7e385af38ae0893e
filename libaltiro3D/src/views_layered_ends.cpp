// What pixels show at the ends of surfaces: borders that cover part of a pixel, the background that
// is painted beside surfaces, and, behind all that, the next surface.

#include "views_layered_ends.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D {

namespace {

constexpr int kSubColumns = 1 << kSubColumnBits;

// One search; all that it needs at hand.
class Search {
  public:
    Search(const LayeredTables& tables, const LayeredRow& row, int direction, int x, float shift)
        : surfaces_(row.surfaces.data()), surfaceCount_(static_cast<int>(row.surfaces.size())),
          words_(tables.words + direction * tables.stride),
          left_(tables.left + direction * tables.stride),
          surfaceOf_(tables.surfaces + direction * tables.stride), x_(static_cast<float>(x)),
          unit_(shift * tables.scale) {}

    void run(int column, LayeredPixel& pixel) {
        pixel_ = &pixel;
        for (int k = surfaceOf_[column]; k >= 0; --k)
            if (visit(k, std::min(column, surfaces_[k].last))) return;
        if (!showsHidden(0)) takeLast();
    }

  private:
    float offset(int column) const { return static_cast<float>(wordOffset(words_[column])); }
    float placeOf(int column) const { return static_cast<float>(column) - unit_ * offset(column); }

    // Lays something over what comes next. True if nothing below it can be seen.
    bool cover(const LayeredPlace& place, float coverage) {
        if (!(coverage > 0)) return false;
        const auto part =
            static_cast<int>(std::min(coverage, 1.0F) * static_cast<float>(kSubColumns) + 0.5F);
        if (part == 0) return false;
        const bool full = part >= kSubColumns || pixel_->count + 1 == LayeredPixel::kMost;
        pixel_->place[pixel_->count] = place;
        pixel_->coverage[pixel_->count] = full ? kSubColumns : part;
        ++pixel_->count;
        return full;
    }

    LayeredPlace photo(int k, int column, float subColumns) const {
        LayeredPlace place;
        place.surface = k;
        const auto sub = static_cast<int>(std::lrint(subColumns));
        place.column = column + sub / kSubColumns;
        place.part = sub % kSubColumns;
        return place;
    }

    // `distance` px beside a surface, >= 0.
    LayeredPlace painted(LayeredPlace::Kind kind, int k, float distance, int prepared) const {
        const LayeredSurface& surface = surfaces_[k];
        const float inside = std::min(distance, static_cast<float>(prepared));
        const int sub = static_cast<int>(inside * static_cast<float>(kSubColumns) + 0.5F);
        LayeredPlace place;
        place.surface = k;
        place.column = sub / kSubColumns;
        place.part = sub % kSubColumns;
        if (place.column == 0 && place.part == 0) {
            place.column = kind == LayeredPlace::Kind::Hidden ? surface.first : surface.last;
            return place;
        }
        place.kind = kind;
        return place;
    }

    // Columns `from` and to the left of it, of surface k. True if the pixel is done.
    bool visit(int k, int from) {
        const LayeredSurface& surface = surfaces_[k];
        for (int column = from; column >= surface.first;) {
            const float start = placeOf(column);
            if (start <= x_) {
                if (column == surface.last) return endOf(k, x_ - start);
                const float steps = (x_ - start) * static_cast<float>(kSubColumns);
                return cover(photo(k, column, steps / (placeOf(column + 1) - start)), 1);
            }
            const std::int16_t bound = left_[column - 1];
            const float farthest = x_ + unit_ * static_cast<float>(wordOffset(bound));
            const int next = static_cast<int>(
                std::max(std::floor(farthest), static_cast<float>(column - 1 - kWindow)));
            column = std::min(column - 1, next);
        }
        if (surface.hidden > 0) return false; // it ends behind something
        const float border = x_ + 1 - placeOf(surface.first) + surface.leftExtra;
        return cover(photo(k, surface.first, 0), border);
    }

    // At or beyond the last column of surface k, by `distance`.
    bool endOf(int k, float distance) {
        const LayeredSurface& surface = surfaces_[k];
        const auto beyond = static_cast<float>(surface.beyond);
        const LayeredPlace place = painted(LayeredPlace::Kind::Beyond, k, distance, surface.beyond);
        if (distance <= beyond) return cover(place, 1);
        if (last_.surface < 0) {
            last_ = place;
            if (k + 1 < surfaceCount_) {
                last_ = painted(LayeredPlace::Kind::Hidden, k + 1, 1e9F, surfaces_[k + 1].hidden);
            }
        }
        if (cover(place, beyond + 1 - distance + surface.rightExtra)) return true;
        return showsHidden(k + 1);
    }

    // Whether the pixel shows what is painted left of surface k or of one further right.
    bool showsHidden(int k) {
        for (; k < surfaceCount_; ++k) {
            const LayeredSurface& surface = surfaces_[k];
            if (surface.hidden == 0) continue;
            const float distance = placeOf(surface.first) - x_;
            if (distance < 0) continue;
            const float over = distance - static_cast<float>(surface.hidden);
            const LayeredPlace place =
                painted(LayeredPlace::Kind::Hidden, k, distance, surface.hidden);
            if (cover(place, 1 - std::max(over, 0.0F))) return true;
        }
        return false;
    }

    // Nothing is prepared so far out: the last thing that was goes on.
    void takeLast() {
        if (last_.surface < 0) {
            last_ = painted(LayeredPlace::Kind::Hidden, 0, 1e9F, surfaces_[0].hidden);
        }
        cover(last_, 1);
    }

    const LayeredSurface* surfaces_;
    int surfaceCount_;
    const std::int16_t* words_;
    const std::int16_t* left_;
    const std::int16_t* surfaceOf_;
    float x_;
    float unit_; // px per unit of the offsets
    LayeredPixel* pixel_ = nullptr;
    LayeredPlace last_ = [] {
        LayeredPlace none;
        none.surface = -1;
        return none;
    }();
};

} // namespace

LayeredPixel LayeredSearch::at(int direction, int x, float shift, int column) const {
    LayeredPixel pixel;
    Search(tables_, *rows_[direction], direction, x, shift).run(column, pixel);
    return pixel;
}

namespace {

// One channel `distance` px beside a surface, or in it.
int paintedAt(const LayeredPlace& place, int distance, const LayeredSurface& surface,
              const LayeredRow& row, const std::uint8_t* plane, int channel) {
    const bool hidden = place.kind == LayeredPlace::Kind::Hidden;
    if (distance < 1) return plane[hidden ? surface.first : surface.last];
    const int k = std::min(distance, hidden ? surface.hidden : surface.beyond);
    return row.strips[static_cast<std::size_t>(
        4 * (hidden ? surface.hiddenAt(k) : surface.beyondAt(k)) + channel)];
}

} // namespace

std::uint8_t LayeredSearch::colour(int direction, const LayeredPixel& pixel,
                                   const std::uint8_t* plane, int channel) const {
    const LayeredRow& row = *rows_[direction];
    const auto value = [&](const LayeredPlace& place) {
        const LayeredSurface& surface = row.surfaces[static_cast<std::size_t>(place.surface)];
        int first = 0;
        int second = 0;
        if (place.kind == LayeredPlace::Kind::Photo) {
            first = plane[place.column];
            second = plane[std::min(place.column + 1, surface.last)];
        } else {
            first = paintedAt(place, place.column, surface, row, plane, channel);
            second = paintedAt(place, place.column + 1, surface, row, plane, channel);
        }
        const int sum = (first << kSubColumnBits) + (second - first) * place.part;
        return (sum + kSubColumns / 2) >> kSubColumnBits; // as layeredSamples()
    };
    int result = value(pixel.place[pixel.count - 1]);
    for (int i = pixel.count - 1; i-- > 0;) {
        const int over = pixel.coverage[i];
        result = (over * value(pixel.place[i]) + (kSubColumns - over) * result + kSubColumns / 2) >>
                 kSubColumnBits;
    }
    return static_cast<std::uint8_t>(result);
}

} // namespace altiro3D
