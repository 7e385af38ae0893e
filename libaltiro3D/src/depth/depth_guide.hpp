#pragma once

#include "depth/padded_plane.hpp"

#include <array>
#include <cstdint>

namespace altiro3D {

/// The planes of a picture: B, G, R.
using Guide = std::array<PaddedPlane<std::uint8_t>, 3>;

/// Guided filter (He, Sun, Tang 2010) with the colours as guide: in each window the depth is a
/// linear function of the colour, so its steps move to the photo's edges and flat parts stay flat.
/// @param depth as large as the guide, multiples of kGrid; becomes the result
void followEdges(const Guide& guide, PaddedPlane<float>& depth);

} // namespace altiro3D
