#pragma once

#include "slide/slide_solver.hpp"

#include <string>
#include <vector>

namespace altiro3D {

// What a clip must have; each throws Error BadFormat with a reason and a number.

/// @param corners that can be followed @param name of the clip
void requireCorners(int corners, const std::string& name);

/// A camera that does not stand.
void requireMotion(const std::vector<SlideTrack>& tracks, const std::string& name);

/// A scene at rest, and a camera that moves sideways far enough.
/// @param parallax between near and far over the path, widths
void requireSlide(const SlidePath& path, const std::vector<SlideTrack>& tracks, double parallax,
                  const std::string& name);

} // namespace altiro3D
