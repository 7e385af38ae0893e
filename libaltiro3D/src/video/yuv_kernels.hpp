#pragma once

#include "altiro3D/video_types.hpp"

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// What makes Y, U and V of blue, green and red:
/// out = (sum over c of floor(128 c weight / 65536) + offset) >> shift, clamped.
struct YuvWeights {
    std::int16_t weight[3][3] = {}; ///< [Y, U, V][B, G, R]
    std::int16_t offset[3] = {};    ///< With the rounding.
    int shift = 6;                  ///< 6 for 8 bits, 4 for 10.
};

/// @param matrix not Rgb @param bits 8 or 10
YuvWeights yuvWeights(ColourMatrix matrix, ColourRange range, int bits);

/// Y, U and V of a row of pixels, at most 0.05 (8 bits) or 0.2 (10 bits) beside the exact number
/// before it is rounded; grey has exactly the middle U and V. The same on every instruction set.
///
/// @param bgr 3 bytes per pixel
/// @param y, u, v one value per pixel
void bgrToYuv(const std::uint8_t* bgr, std::size_t count, const YuvWeights& weights,
              std::uint8_t* y, std::uint8_t* u, std::uint8_t* v);
void bgrToYuv(const std::uint8_t* bgr, std::size_t count, const YuvWeights& weights,
              std::uint16_t* y, std::uint16_t* u, std::uint16_t* v);

/// What makes blue, green and red of Y, U and V: with y = 128 (Y - black), u = 256 (U - 128) and v
/// likewise, out = (sum of floor(y luma / 65536), floor(u b / 65536) ... + offset) >> 5, clamped.
struct BgrWeights {
    std::int16_t black = 16;   ///< Y of black.
    std::int16_t luma = 0;     ///< On y, for all three.
    std::int16_t blueOfU = 0;  ///< On u, for blue.
    std::int16_t greenOfU = 0; ///< On u, for green.
    std::int16_t greenOfV = 0; ///< On v, for green.
    std::int16_t redOfV = 0;   ///< On v, for red.
};

/// @param matrix not Rgb
BgrWeights bgrWeights(ColourMatrix matrix, ColourRange range);

/// Pixels of a row of Y, U and V, at most 0.1 beside the exact number before it is rounded; grey
/// stays grey. The same on every instruction set.
///
/// @param y, u, v one byte per pixel
/// @param bgr 3 bytes per pixel
void yuvToBgr(const std::uint8_t* y, const std::uint8_t* u, const std::uint8_t* v,
              std::size_t count, const BgrWeights& weights, std::uint8_t* bgr);

} // namespace altiro3D
