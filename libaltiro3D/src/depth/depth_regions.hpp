#pragma once

#include "depth/padded_plane.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// B, G and R, 0..255.
using Colours = std::array<PaddedPlane<float>, 3>;

/// Where the scan of a row begins. Of equal colour differences, the first in the scan goes first.
enum class Scan { FromLeft, FromRight };

/// A picture divided into regions of similar colour, at several coarsenesses. All of its regions
/// consist of the same pieces, which are far fewer than the px.
struct PictureRegions {
    struct Division {
        std::size_t regions = 0;
        std::vector<std::uint32_t> regionOf; ///< Of each piece, 0..regions-1.
    };
    std::size_t pieces = 0;
    std::vector<std::uint32_t> pieceOf;             ///< Of each px, row by row, 0..pieces-1.
    std::vector<std::array<Division, 2>> divisions; ///< Per coarseness; by Scan.
};

/// Finds regions: merges neighbours in the order of their colour difference, as long as the
/// difference is not larger than the largest difference inside each side plus coarseness / size
/// (the criterion of Felzenszwalb and Huttenlocher 2004). Then regions that are smaller than 1/300
/// of the picture are merged with others, in the same order.
/// @param coarseness in units of the range of a channel, ascending
PictureRegions findRegions(const Colours& colours, const std::vector<float>& coarseness);

} // namespace altiro3D
