// Ends of surfaces: soft borders (what is behind px that show two surfaces), and the exact search
// (borders that cover part of a pixel, the background painted beside surfaces and, behind both, the
// next surface).

#include "views/layered/layered_ends.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/layered/layered_ends.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// Reads the place of each pixel of open blocks, and two shares there; writes the indices of those
// with a share. A gather of four bytes for each pixel limits the speed.
// @param columns number of shares; places further right have none
std::size_t softPixelsOn(const LayeredRoom& room, std::size_t pixelCount,
                         const std::uint8_t* HWY_RESTRICT shares, int columns,
                         std::int32_t* HWY_RESTRICT found) {
    const std::int32_t* HWY_RESTRICT places = room.places.data();
    const hn::ScalableTag<std::int32_t> d;
    const auto end = hn::Set(d, columns);
    const auto none = hn::Zero(d);
    const auto two = hn::Set(d, 0xFFFF);
    std::size_t count = 0;
    for (std::size_t begin = 0; begin < pixelCount; begin += kBlockPixels) {
        if (room.openBlocks[begin / kBlockPixels] == 0) continue;
        const std::size_t blockEnd = std::min(begin + kBlockPixels, pixelCount);
        for (std::size_t i = begin; i < blockEnd; i += hn::Lanes(d)) {
            const auto column = hn::ShiftRight<kSubColumnBits>(hn::LoadU(d, places + i));
            const auto valid = hn::AndNot(hn::Lt(column, none), hn::Lt(column, end));
            const auto both = gatherBytes4(d, shares, hn::IfThenElseZero(valid, column));
            const auto soft = hn::And(valid, hn::Ne(hn::And(both, two), none));
            if (hn::AllFalse(d, soft)) continue;
            const ChosenLanes chosen(d, hn::And(soft, hn::FirstN(d, blockEnd - i)));
            chosen.store(hn::Iota(d, static_cast<std::int32_t>(i)), found + count);
            count += chosen.count();
        }
    }
    return count;
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(softPixelsOn);

void SoftBorders::open(const LayeredScene& scene, int row, const LayeredTables& tables,
                       const int (&strips)[2]) {
    edges_.clear();
    if (tables.shares == nullptr) return;
    width_ = tables.width;
    stride_ = tables.stride;
    const auto width = static_cast<std::size_t>(width_);
    edgeOf_.resize(width);
    const auto rowOf = [&](int direction) -> const LayeredRow& {
        return scene.rows[direction][static_cast<std::size_t>(row)];
    };
    // @param direction 0 if the surface behind is further right
    // @param behind its index in that direction
    // @param first, count columns of the border
    const auto add = [&](int direction, std::size_t behind, int first, int count) {
        if (count == 0) return;
        std::fill_n(edgeOf_.begin() + first, count, static_cast<std::int16_t>(edges_.size()));
        const LayeredSurface& surface = rowOf(direction).surfaces[behind];
        const int column = direction * stride_ + surface.first;
        Edge edge;
        edge.direction = direction;
        edge.first = surface.first;
        edge.offset = tables.scale * static_cast<float>(wordOffset(tables.words[column]));
        edge.place = column << kSubColumnBits;
        edge.length = (surface.last - surface.first) << kSubColumnBits;
        edge.strip = (strips[direction] + surface.hiddenAt(0)) << kSubColumnBits;
        edge.painted = surface.hidden << kSubColumnBits;
        edges_.push_back(edge);
    };
    const std::vector<LayeredSurface>& surfaces = rowOf(0).surfaces;
    for (std::size_t k = 0; k < surfaces.size(); ++k) {
        const LayeredSurface& near = surfaces[k];
        add(1, surfaces.size() - k, near.first, near.softLeft);
        add(0, k + 1, near.last + 1 - near.softRight, near.softRight);
    }
    if (edges_.empty()) return;
    const auto stride = static_cast<std::size_t>(stride_);
    shares_.assign(2 * stride + kRowPadding, 0);
    std::copy_n(tables.shares, width, shares_.begin());
    std::reverse_copy(tables.shares, tables.shares + width, shares_.data() + stride);
}

std::int32_t SoftBorders::Edge::placeAt(std::int32_t distance) const {
    return distance >= 0 ? place + std::min(distance, length)
                         : strip + std::max(distance, -painted);
}

SoftPixel SoftBorders::at(std::int32_t place, std::int32_t own, float shift) const {
    constexpr float kFar = 1e9F; // more than any photo, in 1/256 px
    constexpr std::int32_t kSubColumns = 1 << kSubColumnBits;
    SoftPixel result;
    if (place < 0 || place >> kSubColumnBits >= 2 * stride_) return result; // painted
    if (place >> kSubColumnBits >= stride_)                                 // mirrored
        place = ((stride_ + width_ - 1) << kSubColumnBits) - place;
    const int left = place >> kSubColumnBits;
    const int part = place & (kSubColumns - 1);
    const int share = shares_[static_cast<std::size_t>(left)];
    const int next = part > 0 ? shares_[static_cast<std::size_t>(left) + 1] : 0;
    result.share = (share * (kSubColumns - part) + next * part + kSubColumns / 2) >> kSubColumnBits;
    if (result.share == 0) return result;
    const int softColumn = share > 0 ? left : left + 1;
    const Edge& edge =
        edges_[static_cast<std::size_t>(edgeOf_[static_cast<std::size_t>(softColumn)])];
    const bool mirrored = edge.direction == 1;
    const float moved =
        std::clamp((mirrored ? -shift : shift) * edge.offset * kSubColumns, -kFar, kFar);
    const std::int32_t first = edge.first << kSubColumnBits;
    const auto inDirection = [&](std::int32_t at) {
        return mirrored ? ((width_ - 1) << kSubColumnBits) - at : at;
    };
    result.now = edge.placeAt(inDirection(own) - first +
                              static_cast<std::int32_t>(moved + (moved < 0 ? -0.5F : 0.5F)));
    result.before = edge.placeAt(inDirection(place) - first);
    return result;
}

std::size_t SoftBorders::find(const LayeredRoom& room, std::size_t count,
                              std::int32_t* found) const {
    return HWY_DYNAMIC_DISPATCH(softPixelsOn)(room, count, shares_.data(), 2 * stride_, found);
}

namespace {

constexpr int kSubColumns = 1 << kSubColumnBits;

class Search {
  public:
    // @param strips first column of the direction's strips in the planes
    Search(const LayeredTables& tables, const LayeredRow& row, int direction, int strips, float x,
           float shift)
        : surfaces_(row.surfaces.data()), surfaceCount_(static_cast<int>(row.surfaces.size())),
          words_(tables.words + direction * tables.stride),
          surfaceOf_(tables.surfaces + direction * tables.stride), base_(direction * tables.stride),
          strips_(strips), x_(x), unit_(shift * tables.scale) {}

    LayeredCovers run(int column) {
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
        const bool full = part >= kSubColumns || pixel_.count + 1 == LayeredCovers::kMax;
        pixel_.place[pixel_.count] = place;
        pixel_.coverage[pixel_.count] = full ? kSubColumns : part;
        ++pixel_.count;
        return full;
    }

    // Place of the background `distance` px left of surface k, limited to the painted columns.
    std::int32_t hiddenPlace(int k, float distance) const {
        const LayeredSurface& surface = surfaces_[k];
        const float inside = std::min(distance, static_cast<float>(surface.hidden));
        return ((strips_ + surface.hiddenAt(0)) << kSubColumnBits) - subColumns(inside);
    }

    // Place of the background painted `distance` px right of surface k, limited to the painted
    // columns. If none are painted: place of the surface's last column in the photo.
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

    // Surface k has ended at the pixel. Covers the pixel with surfaces further left that are nearer
    // than the background painted left of the next surfaces at the right: surface k has passed
    // them. True if the pixel is complete.
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
    LayeredCovers pixel_;
    std::optional<std::int32_t> last_; // the candidate for takeLast()
};

} // namespace

LayeredCovers LayeredSearch::at(int direction, float x, float shift, int column) const {
    return Search(tables_, *rows_[direction], direction, strips_[direction], x, shift).run(column);
}

} // namespace altiro3D
#endif
