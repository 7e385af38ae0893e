#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::test {

// A made-up world whose depth is known exactly, for references and examples. Metres; x to the
// right, y up, z away from the camera; colours are linear RGB, 0..1.
//
//        y                      All cameras stand on the line (cameraX, cameraHeight, 0) and look
//        |   z                  along +z, never turned. The frustum is off-axis: every camera sees
//        |  /                   the same window at z = focusDistance, so what is there stays put,
//        | /                    nearer content moves left when the camera moves right, and farther
//        +------ x              content moves right.

/// What a solid's surface looks like.
enum class Pattern { Plain, Tiles, Checker, Stripes, Wood, Marble, Leaves, Water, Plaster };

/// A surface: two colours in a pattern, and how it shines.
struct Material {
    Pattern pattern = Pattern::Plain;
    cv::Vec3d first{0.8, 0.8, 0.8};  ///< Linear RGB.
    cv::Vec3d second{0.4, 0.4, 0.4}; ///< Linear RGB.
    double size = 0.5; ///< Length of one repetition of the pattern, m (Stripes: count).
    double gloss = 0;  ///< Reflection at a right angle, 0 (dull) .. 1 (mirror).
};

/// The form of a solid.
enum class Form {
    Ellipsoid, ///< Half axes `half`.
    Box,       ///< Half sides `half`, turned about the vertical by `yawDegrees`.
    Frustum, ///< Vertical: radius `half[0]` at the bottom, `half[2]` at the top, height 2 half[1].
    Plane    ///< Horizontal and endless, at the height of `centre`.
};

/// One thing in the world.
struct Solid {
    Form form = Form::Ellipsoid;
    cv::Vec3d centre{0, 0, 0};
    cv::Vec3d half{1, 1, 1};
    double yawDegrees = 0; ///< Only for Box.
    Material material;
};

Solid sphere(const cv::Vec3d& centre, double radius, const Material& material = {});
Solid ellipsoid(const cv::Vec3d& centre, const cv::Vec3d& halfAxes, const Material& material = {});
Solid box(const cv::Vec3d& centre, const cv::Vec3d& halfSides, double yawDegrees = 0,
          const Material& material = {});
/// Stands on `foot`; a cylinder where the radii are equal, a cone where the upper one is 0.
Solid frustum(const cv::Vec3d& foot, double height, double lowerRadius, double upperRadius,
              const Material& material = {});
Solid plane(double height, const Material& material = {});

/// The world and how it is looked at.
struct Scene {
    std::vector<Solid> solids;
    cv::Vec3d toLight{-0.5, 0.8, -0.35}; ///< Towards the sun; any length.
    double cameraHeight = 0;             ///< m.
    double focalWidths = 1.25;           ///< Focal length in picture widths: f_px = this x columns.
    double horizon = 0.5;                ///< Row of the horizon as a part of the picture's height.
    double focusDistance = 4;            ///< Distance of zero parallax, m.
    double nearDistance = 1;             ///< Distance whose relative inverse depth is 1, m.
    double farDistance = 100;            ///< Distance whose relative inverse depth is 0, m.
    double hazeDistance = 0;             ///< Where haze hides 63 %, m; 0 = none.
};

/// One picture of a scene. Pixel (x, y) of `metric` and `depth` belongs to the ray through the
/// pixel's centre, so depth steps are never mixed.
struct Rendering {
    cv::Mat photo;  ///< [rows x cols, CV_8UC3, BGR]
    cv::Mat depth;  ///< [rows x cols, CV_32FC1, 0..1, 1 = nearDistance, 0 = farDistance and beyond]
    cv::Mat metric; ///< [rows x cols, CV_32FC1, z in m, +inf where there is only sky]
};

/// Where a point is seen, in px from the picture's upper left corner (the centre of the upper left
/// pixel is at 0.5, 0.5).
cv::Point2d project(const Scene& scene, cv::Size size, double cameraX, const cv::Vec3d& point);

/// Relative inverse depth of a distance, 0..1.
double relativeInverseDepth(const Scene& scene, double z);

/// Renders a scene. Equal arguments give equal pictures, whatever the number of threads.
///
/// @param cameraX position on the camera line, m
/// @param samplesPerPixel rays for the colour of one pixel; rounded up to a square number
Rendering render(const Scene& scene, cv::Size size, double cameraX, int samplesPerPixel);

/// The results of single rays, for pictures in which each px has its own camera. Unlike render(),
/// it has no noise: light is sampled the same way everywhere. Thread-safe.
class RayCaster {
  public:
    explicit RayCaster(const Scene& scene);

    /// Colour of a part of the picture, BGR: the mean of 4 rays, of 16 where those differ visibly.
    ///
    /// @param size of the picture, px
    /// @param cameraX position on the camera line, m
    /// @param part what is averaged, in px, see project()
    cv::Vec3b colour(cv::Size size, double cameraX, const cv::Rect2d& part) const;

    /// Relative inverse depth at a point of the picture, in px.
    double depth(cv::Size size, double cameraX, const cv::Point2d& at) const;

  private:
    struct Impl;
    std::shared_ptr<const Impl> impl_;
};

/// A sunny terrace above the sea, made for portrait pictures (3:4): something at every distance
/// from 2 m to the horizon, thin things, holes, mirrors and textures of all kinds.
Scene sampleScene();

} // namespace altiro3D::test
