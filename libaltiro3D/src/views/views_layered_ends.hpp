#pragma once

#include "views/views_layered_scene.hpp"

namespace altiro3D {

/// What a pixel shows at or behind the end of a surface: things that cover parts of it, one over
/// the other.
struct LayeredPixel {
    static constexpr int kMost = 4;
    std::int32_t place[kMost] = {}; ///< As those of layeredPlaces().
    int coverage[kMost] = {};       ///< In 1/256 of what those before leave; the last covers all.
    int count = 0;
};

/// Searches one row of a scene, exactly and one pixel at a time.
class LayeredSearch {
  public:
    /// @param scene must outlive this @param row of the photo
    /// @param strips columns in the planes where the strips of either direction begin
    LayeredSearch(const LayeredScene& scene, int row, const int (&strips)[2])
        : tables_(scene.tables(row)), rows_{&scene.rows[0][static_cast<std::size_t>(row)],
                                            &scene.rows[1][static_cast<std::size_t>(row)]},
          strips_{strips[0], strips[1]} {}

    /// What the pixel at column `x` shows in the view shifted by `shift`.
    ///
    /// @param direction 0, or 1 for the mirrored row; x and column count in it
    /// @param shift > 0, px
    /// @param column nothing to the right of it reaches x
    LayeredPixel at(int direction, int x, float shift, int column) const;

  private:
    LayeredTables tables_;
    const LayeredRow* rows_[2]; // per direction
    int strips_[2];
};

/// One channel at a place, as layeredSamples() reads it.
inline int sampleAt(const std::uint8_t* plane, std::int32_t place) {
    const std::uint8_t* first = plane + (place >> kSubColumnBits);
    const int part = place & ((1 << kSubColumnBits) - 1);
    const int sum = (first[0] << kSubColumnBits) + (first[1] - first[0]) * part;
    return (sum + (1 << (kSubColumnBits - 1))) >> kSubColumnBits;
}

/// A value of which a part is covered by another. @param part 0..256 of 256
inline int coveredBy(int cover, int value, int part) {
    constexpr int kAll = 1 << kSubColumnBits;
    return (part * cover + (kAll - part) * value + kAll / 2) >> kSubColumnBits;
}

/// One channel of a pixel. @param plane the channel, laid out as for layeredSamples()
inline int colourOf(const LayeredPixel& pixel, const std::uint8_t* plane) {
    int result = sampleAt(plane, pixel.place[pixel.count - 1]);
    for (int i = pixel.count - 1; i-- > 0;)
        result = coveredBy(sampleAt(plane, pixel.place[i]), result, pixel.coverage[i]);
    return result;
}

} // namespace altiro3D
