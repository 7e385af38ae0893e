#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

// The model of a slide. Lengths along the path have any unit, picture coordinates are in widths of
// the picture from its middle, x to the right and y down. A point at (x, y, 1) / q, whose inverse
// depth is q, is seen by a camera at `place` along
//
//     p = turn ((x, y, 1) - q place)
//
// so it moves by q times the camera's way, and by its turns whatever q is: docs/mathematics.md, 8.

/// One picture's camera.
struct SlideCamera {
    cv::Matx33d turn = cv::Matx33d::eye(); ///< From the axes of the scene to those of the camera.
    cv::Vec3d place{0, 0, 0};              ///< Along the path, downwards, forwards.
    double zoom = 0;                       ///< Logarithm of the magnification.
    double shear = 0;                      ///< Widths to the right per width down: rolling shutter.
};

/// What all cameras have in common.
struct SlideLens {
    double focal = 0.866; ///< Focal length in widths: 60 degrees of view.
    double bend = 0;      ///< Distortion: radii grow by the factor 1 + bend r^2, r in widths.
};

/// A point of the scene, at (x, y, 1) / q.
struct SlidePoint {
    double x = 0;
    double y = 0;
    double q = 1;
};

/// Where a camera sees something, in widths from the middle. @param p in the camera's axes
cv::Point2d seenAt(const cv::Vec3d& p, const SlideCamera& camera, const SlideLens& lens);
/// As above, for a point of the scene.
cv::Point2d seenAt(const SlidePoint& point, const SlideCamera& camera, const SlideLens& lens);

/// A corner that was followed through neighbouring pictures.
struct SlideTrack {
    int first = 0;               ///< The first picture.
    std::vector<cv::Point2d> at; ///< In this and the following pictures, widths from the middle.
    int end() const { return first + static_cast<int>(at.size()); }
};

/// What the camera did.
struct SlidePath {
    std::vector<SlideCamera> cameras;
    SlideLens lens;
    std::vector<SlidePoint> points; ///< One for each track.
    std::vector<char> fits; ///< Whether a track is used: that of a point at rest, not far off.
    double misfitShare = 0; ///< Share of the tracks that do not fit.
    /// Residual of each picture, right and down: root mean square without the largest 5 %, widths.
    std::vector<cv::Vec2d> residual;
    double forwards = 0; ///< Cosine between the path and the direction of view, 0..1.
};

/// Prior knowledge.
struct SlideGuess {
    double pixel = 1.0 / 640; ///< Size of a px in which tracks were found, widths.
    SlideLens lens;
    bool isLensKnown = false;
    bool isTurntable = false; ///< The camera stands, and the thing with the tracks turns.
};

/// Rotation about an axis. @param angles the axis, as long as the angle is large, radians
cv::Matx33d turnBy(const cv::Vec3d& angles);

/// Finds the cameras, the lens and the points that explain tracks best, from a guess in `path`, and
/// which tracks fit. As findPaths(), but keeps the axes of the scene.
void solvePath(const std::vector<SlideTrack>& tracks, const SlideGuess& guess, SlidePath& path);

} // namespace altiro3D
