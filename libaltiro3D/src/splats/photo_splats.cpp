#include "base/checks.hpp"
#include "splats/splat_collector.hpp"
#include "views/layered/layered_pixels.hpp"
#include "views/view_methods.hpp"

#include <algorithm>

namespace altiro3D {

namespace {

// Distances of depth 1 and 0. Steps of .spz are 1/4096, and its range ends at 2048.
constexpr double kNear = 10;
constexpr double kFar = 100;
constexpr float kOpacity = 0.999F;
constexpr double kThickness = 0.1; // of a splat, in its own radii

double distanceOf(double depth) {
    return 1 / (1 / kFar + depth * (1 / kNear - 1 / kFar));
}

// Makes flat splats of px: (9.6).
class PixelSplats {
  public:
    PixelSplats(const CameraIntrinsics& lens, double radius) : lens_(lens), radius_(radius) {}

    Splat of(const LayeredPixel& pixel) const {
        const double z = distanceOf(static_cast<double>(pixel.depth));
        const cv::Vec3d ray((pixel.x - lens_.cx) / lens_.fx, (pixel.y - lens_.cy) / lens_.fy, 1);
        Splat splat;
        splat.centre = z * ray;
        for (int c = 0; c < 3; ++c)
            splat.colour[c] = static_cast<float>(pixel.bgr[2 - c]) / 255;
        splat.opacity = kOpacity * pixel.share;
        // how its place moves from px to px, along the slope of its surface
        const double fall = -z * z * (1 / kNear - 1 / kFar);
        const cv::Vec3d across =
            cv::Vec3d(z / lens_.fx, 0, 0) + fall * static_cast<double>(pixel.across) * ray;
        const cv::Vec3d down =
            cv::Vec3d(0, z / lens_.fy, 0) + fall * static_cast<double>(pixel.down) * ray;
        place(across, down, splat);
        return splat;
    }

  private:
    // The ellipse of two vectors in their plane: its axes and their lengths.
    void place(const cv::Vec3d& a, const cv::Vec3d& b, Splat& splat) const {
        const cv::Vec3d x = a / cv::norm(a);
        const cv::Vec3d z = a.cross(b) / cv::norm(a.cross(b));
        const cv::Vec3d y = z.cross(x);
        // covariance a a' + b b' in the axes x and y
        const double xx = a.dot(x) * a.dot(x) + b.dot(x) * b.dot(x);
        const double xy = b.dot(x) * b.dot(y);
        const double yy = b.dot(y) * b.dot(y);
        const double angle = std::atan2(2 * xy, xx - yy) / 2;
        const double middle = (xx + yy) / 2;
        const double swing = std::hypot((xx - yy) / 2, xy);
        const cv::Vec3d first = std::cos(angle) * x + std::sin(angle) * y;
        const double large = radius_ * std::sqrt(middle + swing);
        const double small = radius_ * std::sqrt(std::max(middle - swing, 0.0));
        splat.radii = {static_cast<float>(large), static_cast<float>(small),
                       static_cast<float>(kThickness * small)};
        splat.rotation = quaternionOf(first, z.cross(first), z);
    }

    // The quaternion of the rotation whose matrix has these columns.
    static cv::Vec4f quaternionOf(const cv::Vec3d& x, const cv::Vec3d& y, const cv::Vec3d& z) {
        cv::Vec4d q(1 + x[0] + y[1] + z[2], y[2] - z[1], z[0] - x[2], x[1] - y[0]);
        if (q[0] < 0.01) // turned by nearly half a turn: about x or y, as z points forward
            q = x[0] > y[1]
                    ? cv::Vec4d(y[2] - z[1], 1 + x[0] - y[1] - z[2], x[1] + y[0], x[2] + z[0])
                    : cv::Vec4d(z[0] - x[2], x[1] + y[0], 1 + y[1] - x[0] - z[2], y[2] + z[1]);
        return q / cv::norm(q);
    }

    CameraIntrinsics lens_;
    double radius_;
};

} // namespace

SplatScene splatsOf(const Scene& scene, const PhotoSplatOptions& options) try {
    checkScene(scene);
    checkRange("viewDegrees", options.viewDegrees, 1, 150, " degrees");
    checkRange("radius", options.radius, 0.05, 5, " px");
    checkRange("focus", options.focus, 0, 1);
    checkRange("reach", options.reachPercent, 0, 100, " %");
    const cv::Size size = scene.photo.size();
    SplatCamera camera;
    camera.size = size;
    const double focal = size.height / (2 * std::tan(options.viewDegrees * CV_PI / 360));
    camera.intrinsics = {focal, focal, (size.width - 1) / 2.0, (size.height - 1) / 2.0};
    LayeredSettings settings;
    settings.hidden = scene.hidden;
    settings.mixedPixels = scene.mixedPixels;
    settings.reachPixels = std::max(options.reachPercent / 200 * size.width, 1.0);
    const PixelSplats pixelSplats(camera.intrinsics, options.radius);
    SplatScene result;
    const std::vector<LayeredPixel> pixels =
        layeredPixels(scene.photo, scene.depth, options.focus, settings);
    result.splats.reserve(pixels.size());
    for (LayeredPixel pixel : pixels) {
        result.splats.push_back(pixelSplats.of(pixel));
        const bool isAtBorder = pixel.y == 0 || pixel.y + 1 == size.height;
        if (!isAtBorder) continue;
        pixel.y += pixel.y == 0 ? -1 : 1; // beyond it, else one would see through it
        result.splats.push_back(pixelSplats.of(pixel));
    }
    result.camera = camera;
    result.focusDistance = distanceOf(options.focus);
    return result;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
