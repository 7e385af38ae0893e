// Soft borders: what is behind px that show two surfaces.

#include "views/views_layered_soft.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "views/views_layered_soft.cpp"
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

SoftPixel SoftBorders::at(std::int32_t place, int column, float shift) const {
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
    const int start = mirrored ? width_ - 1 - column : column;
    result.now = edge.placeAt((start - edge.first) * kSubColumns +
                              static_cast<std::int32_t>(moved + (moved < 0 ? -0.5F : 0.5F)));
    const std::int32_t own = mirrored ? ((width_ - 1) << kSubColumnBits) - place : place;
    result.before = edge.placeAt(own - (edge.first << kSubColumnBits));
    return result;
}

std::size_t SoftBorders::find(const LayeredRoom& room, std::size_t count,
                              std::int32_t* found) const {
    return HWY_DYNAMIC_DISPATCH(softPixelsOn)(room, count, shares_.data(), 2 * stride_, found);
}

} // namespace altiro3D
#endif
