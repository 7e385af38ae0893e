#pragma once

#include "altiro3D/video_io.hpp"

#include <cstddef>
#include <cstdint>

namespace altiro3D {

/// Weights that convert blue, green and red to Y, U and V: out = (sum over c of floor(128 c weight
/// / 65536) + offset) >> shift, clamped.
struct YuvWeights {
    std::int16_t weight[3][3] = {}; ///< [Y, U, V][B, G, R]
    std::int16_t offset[3] = {};    ///< Including rounding.
    int shift = 6;                  ///< 6 for 8 bits, 4 for 10.
};

/// @param matrix not Rgb @param bits 8 or 10
YuvWeights yuvWeights(ColourMatrix matrix, ColourRange range, int bits);

/// Converts a row of pixels to Y, U and V. Before rounding, results differ from the exact value by
/// at most 0.05 (8 bits) or 0.2 (10 bits). Grey has exactly the middle U and V. Results are the
/// same on every instruction set.
/// @param bgr 3 bytes per pixel
/// @param y, u, v one value per pixel
void bgrToYuv(const std::uint8_t* bgr, std::size_t count, const YuvWeights& weights,
              std::uint8_t* y, std::uint8_t* u, std::uint8_t* v);
void bgrToYuv(const std::uint8_t* bgr, std::size_t count, const YuvWeights& weights,
              std::uint16_t* y, std::uint16_t* u, std::uint16_t* v);

/// Weights that convert Y, U and V to blue, green and red. With y = 128 (Y - black), u = 256 (U -
/// 128) and v likewise, out = (sum of floor(y luma / 65536), floor(u b / 65536) ... + offset) >> 5,
/// clamped.
struct BgrWeights {
    std::int16_t black = 16;   ///< Y of black.
    std::int16_t luma = 0;     ///< Weight of y, for all three.
    std::int16_t blueOfU = 0;  ///< Weight of u, for blue.
    std::int16_t greenOfU = 0; ///< Weight of u, for green.
    std::int16_t greenOfV = 0; ///< Weight of v, for green.
    std::int16_t redOfV = 0;   ///< Weight of v, for red.
};

/// @param matrix not Rgb
BgrWeights bgrWeights(ColourMatrix matrix, ColourRange range);

/// Converts a row of Y, U and V to pixels. Before rounding, results differ from the exact value by
/// at most 0.1. Grey stays grey. Results are the same on every instruction set.
/// @param y, u, v one byte per pixel
/// @param bgr 3 bytes per pixel
void yuvToBgr(const std::uint8_t* y, const std::uint8_t* u, const std::uint8_t* v,
              std::size_t count, const BgrWeights& weights, std::uint8_t* bgr);

} // namespace altiro3D
