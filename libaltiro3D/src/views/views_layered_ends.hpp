#pragma once

#include "views/views_layered_scene.hpp"

namespace altiro3D {

/// Contents of a pixel at or behind the end of a surface: covers of parts of the pixel, from front
/// to back.
struct LayeredPixel {
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

    /// Finds what the pixel at column `x` shows in the view shifted by `shift`.
    ///
    /// @param direction 0, or 1 for the mirrored row, in which x and column then count
    /// @param shift >= 0, px
    /// @param column start of the search: no column to its right reaches x
    LayeredPixel at(int direction, int x, float shift, int column) const;

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
int colourOf(const LayeredPixel& pixel, const F& coverOf) {
    int result = coverOf(pixel.count - 1);
    for (int i = pixel.count - 1; i-- > 0;)
        result = coveredBy(coverOf(i), result, pixel.coverage[i]);
    return result;
}

} // namespace altiro3D
