#pragma once

#include "slide/slide_solver.hpp"

#include <cstddef>
#include <vector>

namespace altiro3D {

/// Finds cameras and points that explain the tracks: least squares of the places where points are
/// seen (Gauss-Newton steps, Levenberg's damping; points are eliminated), in which far residuals
/// weigh less. Weak prior knowledge (a hand turns the camera by a few degrees, the path is nearly
/// straight) decides what the tracks leave open. Then the axes of the scene are turned along the
/// path: places are (position, small, small), positions begin at 0 and grow to 1 or fall to -1. If
/// the camera turns as if it followed a thing, the better one of this path and its reverse is
/// given.
///
/// @param tracks each of 2 pictures at least @param pictures their number, 2 at least
SlidePath findPath(const std::vector<SlideTrack>& tracks, int pictures, const SlideGuess& guess);

/// The other path that explains nearly the same tracks: near and far are exchanged, the camera
/// moves the other way, and turns make up for it. Only what hides what tells the two apart if the
/// camera was turned to follow a thing.
/// @param path from findPath() of the same tracks
SlidePath reversedPath(const SlidePath& path, const std::vector<SlideTrack>& tracks,
                       const SlideGuess& guess);

/// The longest part of the path in one direction; steps back that are small do not end it.
/// @return indices of its cameras, ascending, whose positions only grow or only fall
std::vector<std::size_t> longestStretch(const std::vector<SlideCamera>& cameras);

} // namespace altiro3D
