#pragma once

#include "slide/slide_solver.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace altiro3D {

/// Inverse depths of the points at rest.
std::vector<double> depthsOf(const SlidePath& path);

/// What the camera may have done.
struct FoundPaths {
    SlidePath best;
    /// Set if the camera seems to follow a thing: another path that explains the tracks not much
    /// worse. In it, near and far are exchanged, the camera moves the other way; turns compensate.
    std::optional<SlidePath> reversed;
    double worse = 1; ///< Ratio of the residuals of `reversed` to those of `best`, 1 or more.
};

/// Finds cameras and points that explain the tracks: least squares of the places where points are
/// seen (Gauss-Newton steps, Levenberg's damping; points are eliminated) with less weight for far
/// residuals. Weak prior knowledge (a hand turns the camera by a few degrees, the path is nearly
/// straight) decides what the tracks leave open. Then the scene's axes turn along the path: places
/// are (position, small, small); positions are 0..1, and fall if the camera moves to the left.
/// @param tracks each of 2 pictures at least @param pictures their number, 2 at least
FoundPaths findPaths(const std::vector<SlideTrack>& tracks, int pictures, const SlideGuess& guess);

/// Whether near and far things move apart vertically rather than horizontally.
/// @param pixel size of a px in which tracks were found, widths
bool movesUpright(const std::vector<SlideTrack>& tracks, int pictures, double pixel);

/// The tracks of pictures that are turned clockwise by a quarter.
/// @param aspect height : width of the pictures before
std::vector<SlideTrack> turnedByAQuarter(std::vector<SlideTrack> tracks, double aspect);

/// The longest part of the path in one direction; steps back that are small do not end it.
/// @return indices of its cameras, ascending, whose positions only grow or only fall
std::vector<std::size_t> longestStretch(const std::vector<SlideCamera>& cameras);

} // namespace altiro3D
