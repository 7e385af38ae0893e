#pragma once

#include "views_layered_scene.hpp"

namespace altiro3D {

/// Where in a row a colour is read.
struct LayeredPlace {
    enum class Kind : std::uint8_t { Photo, Hidden, Beyond };
    Kind kind = Kind::Photo; ///< A column of the photo, or one painted beside a surface.
    int surface = 0;         ///< Index of the surface.
    int column = 0;          ///< Photo: column; else distance from the surface, px, >= 1.
    int part = 0;            ///< 1/256 px to the right of it (Hidden: to the left), 0..255.
};

/// What a pixel shows at or behind the end of a surface: things that cover parts of it, one over
/// the other.
struct LayeredPixel {
    static constexpr int kMost = 4;
    LayeredPlace place[kMost];
    int coverage[kMost] = {}; ///< In 1/256 of what those before leave; the last one covers all.
    int count = 0;
};

/// Searches one row of a scene in one direction, exactly and one pixel at a time.
class LayeredSearch {
  public:
    /// @param scene must outlive this @param row of the photo
    LayeredSearch(const LayeredScene& scene, int row)
        : tables_(scene.tables(row)), rows_{&scene.rows[0][static_cast<std::size_t>(row)],
                                            &scene.rows[1][static_cast<std::size_t>(row)]} {}

    /// What the pixel at column `x` shows in the view shifted by `shift`.
    ///
    /// @param direction 0, or 1 for the mirrored row; x and column count in it
    /// @param shift >= 0, px
    /// @param column nothing to the right of it reaches x
    LayeredPixel at(int direction, int x, float shift, int column) const;

    /// The colour of a pixel.
    /// @param plane one channel of the row, mirrored for direction 1
    /// @param channel which it is: 0 blue, 1 green, 2 red
    std::uint8_t colour(int direction, const LayeredPixel& pixel, const std::uint8_t* plane,
                        int channel) const;

  private:
    LayeredTables tables_;
    const LayeredRow* rows_[2]; // per direction
};

} // namespace altiro3D
