#pragma once

#include "views/layered/layered_scene.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// Contents of a pixel at or behind the end of a surface: covers of its parts, from front to back.
struct LayeredCovers {
    static constexpr int kMax = 4;
    std::int32_t place[kMax] = {}; ///< Places as in LayeredRoom.
    /// In 1/256 of what the covers before leave visible; the last one covers all.
    int coverage[kMax] = {};
    int count = 0;
};

/// Searches one row of a scene exactly, one pixel at a time.
class LayeredSearch {
  public:
    /// @param scene must outlive this object
    /// @param row row of the photo
    /// @param tables its tables
    /// @param strips first column of the strips of each direction in the planes
    LayeredSearch(const LayeredScene& scene, int row, const LayeredTables& tables,
                  const int (&strips)[2])
        : tables_(tables), rows_{&scene.rows[0][static_cast<std::size_t>(row)],
                                 &scene.rows[1][static_cast<std::size_t>(row)]},
          strips_{strips[0], strips[1]} {}

    /// Finds what the pixel at `x` shows in the view shifted by `shift`.
    /// @param direction 0, or 1 for the mirrored row, in which x and column then count
    /// @param x px, a multiple of 1/256
    /// @param shift >= 0, px
    /// @param column start of the search: no column to its right reaches x
    LayeredCovers at(int direction, float x, float shift, int column) const;

  private:
    LayeredTables tables_;
    const LayeredRow* rows_[2]; // per direction
    int strips_[2];
};

/// Blends a value with one that covers part of it. @param part 0..256, in 1/256
inline int coveredBy(int cover, int value, int part) {
    constexpr int kAll = 1 << kSubColumnBits;
    return (part * cover + (kAll - part) * value + kAll / 2) >> kSubColumnBits;
}

/// One channel of a pixel. @param coverOf(i) that channel of cover i
template <class F>
int colourOf(const LayeredCovers& pixel, const F& coverOf) {
    int result = coverOf(pixel.count - 1);
    for (int i = pixel.count - 1; i-- > 0;)
        result = coveredBy(coverOf(i), result, pixel.coverage[i]);
    return result;
}

/// A px of a view at a soft border (docs/mathematics.md, (3.8)). It moves with the near surface,
/// but it also shows what is behind: `share` of what was there in the photo is replaced by what is
/// there in the view.
struct SoftPixel {
    std::int32_t pixel = 0;  ///< Index in LayeredRoom::places.
    int share = 0;           ///< In 1/256, 0..255.
    std::int32_t now = 0;    ///< Place of what is behind in the view,
    std::int32_t before = 0; ///< and of what was behind in the photo.

    /// One channel of the px. @param plane the channel, laid out as for layeredSamples()
    int colour(int value, const std::uint8_t* plane) const {
        const int change = sampleAt(plane, now) - sampleAt(plane, before);
        return std::clamp(value + ((share * change + 128) >> 8), 0, 255);
    }
};

/// The soft borders of one row.
class SoftBorders {
  public:
    /// Describes a row. @param strips first column of the strips of each direction in the planes
    void open(const LayeredScene& scene, int row, const LayeredTables& tables,
              const int (&strips)[2]);

    bool any() const { return !edges_.empty(); }

    /// What is behind a place of the view.
    /// @param place as in LayeredRoom
    /// @param own place of the pixel in the photo, 1/256 px
    /// @param shift of the view, px
    /// @return its `pixel` is not set; share 0 where the border is hard
    SoftPixel at(std::int32_t place, std::int32_t own, float shift) const;

    /// Lists the pixels of open blocks whose places may have a soft border.
    /// @param count pixels
    /// @param found result: indices of the pixels; at least as many entries as pixels, and padding
    /// @return number of the pixels found
    std::size_t find(const LayeredRoom& room, std::size_t count, std::int32_t* found) const;

  private:
    // The surface behind a soft border, in the direction in which it continues to the left.
    struct Edge {
        int direction = 0;
        int first = 0;            // its first column
        float offset = 0;         // offset of that column, px per px of shift
        std::int32_t place = 0;   // place of that column in the plane
        std::int32_t length = 0;  // length of its part that the photo shows, in 1/256 px
        std::int32_t strip = 0;   // place of that column in the strip painted to its left
        std::int32_t painted = 0; // length of the strip, in 1/256 px

        // @param distance from the first column to the right, in 1/256 px
        std::int32_t placeAt(std::int32_t distance) const;
    };

    int width_ = 0;
    int stride_ = 0;
    std::vector<Edge> edges_;          // none: all borders are hard
    std::vector<std::int16_t> edgeOf_; // index in edges_ of each column with a share
    std::vector<std::uint8_t> shares_; // shares of the row and of the mirrored row
};

} // namespace altiro3D
