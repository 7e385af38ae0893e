#include "support/scene.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

using namespace altiro3D::test;

namespace {

constexpr double kCameraX = 0.3;
constexpr double kFloatNoise = 1e-5; // metres of some metres, as float

Scene emptyScene() {
    Scene scene;
    scene.focalWidths = 1.1;
    scene.horizon = 0.4;
    scene.cameraHeight = 1.5;
    scene.focusDistance = 3;
    scene.nearDistance = 1;
    scene.farDistance = 50;
    return scene;
}

// The ray through the centre of a pixel, from the formulas of a pinhole: direction (a, b, 1).
cv::Point2d slopes(const Scene& scene, cv::Size size, double cameraX, int x, int y) {
    const double focal = scene.focalWidths * size.width;
    return {(x + 0.5 - size.width * 0.5) / focal - cameraX / scene.focusDistance,
            (scene.horizon * size.height - y - 0.5) / focal};
}

// The column of a small bright ball's middle of gravity in the depth picture.
double columnOfNearThing(const Scene& scene, cv::Size size, double cameraX) {
    const cv::Mat metric = render(scene, size, cameraX, 1).metric;
    double sum = 0;
    double count = 0;
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            if (!std::isfinite(metric.at<float>(y, x))) continue;
            sum += x + 0.5;
            count += 1;
        }
    }
    return sum / count;
}

} // namespace

TEST(Scene, ADistanceToAFloorIsTheFormulas) {
    Scene scene = emptyScene();
    scene.solids = {plane(0)};
    for (const cv::Size size : {cv::Size(31, 47), cv::Size(2, 2), cv::Size(1, 1)}) {
        const cv::Mat metric = render(scene, size, kCameraX, 1).metric;
        for (int y = 0; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) {
                const double down = -slopes(scene, size, kCameraX, x, y).y;
                const float z = metric.at<float>(y, x);
                if (down <= 0) {
                    EXPECT_TRUE(std::isinf(z)) << "sky at " << x << ", " << y;
                } else {
                    EXPECT_NEAR(z / (1.5 / down), 1, kFloatNoise) << x << ", " << y;
                }
            }
        }
    }
}

TEST(Scene, ADistanceToASphereIsTheFormulas) {
    Scene scene = emptyScene();
    const cv::Vec3d centre(0.2, 1.2, 4);
    const double radius = 0.7;
    scene.solids = {sphere(centre, radius)};
    const cv::Size size(41, 53);
    const cv::Mat metric = render(scene, size, kCameraX, 1).metric;
    int hits = 0;
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const cv::Point2d slope = slopes(scene, size, kCameraX, x, y);
            const cv::Vec3d d(slope.x, slope.y, 1);
            const cv::Vec3d toCentre = centre - cv::Vec3d(kCameraX, scene.cameraHeight, 0);
            const double half = d.dot(toCentre) / d.dot(d);
            const double rest = half * half - (toCentre.dot(toCentre) - radius * radius) / d.dot(d);
            const float z = metric.at<float>(y, x);
            EXPECT_EQ(std::isfinite(z), rest > 0) << x << ", " << y;
            if (rest > 0) {
                EXPECT_NEAR(z, half - std::sqrt(rest), kFloatNoise) << x << ", " << y;
                ++hits;
            }
        }
    }
    EXPECT_GT(hits, 100);
}

TEST(Scene, BoxesAndFrustumsStandWhereTheyShould) {
    Scene scene = emptyScene();
    const cv::Size size(200, 200);
    const auto distanceAt = [&](double x, double y, double z) {
        const cv::Point2d at = project(scene, size, 0, {x, y, z});
        const cv::Mat metric = render(scene, size, 0, 1).metric;
        return metric.at<float>(static_cast<int>(at.y), static_cast<int>(at.x));
    };
    scene.solids = {box({0, 1.5, 5}, {1, 0.5, 2})};
    EXPECT_NEAR(distanceAt(0, 1.5, 3), 3, kFloatNoise) << "the front face";
    EXPECT_NEAR(distanceAt(0.9, 1.9, 3), 3, kFloatNoise);
    EXPECT_TRUE(std::isinf(distanceAt(1.1, 1.5, 3))) << "beside it";
    scene.solids = {box({0, 1.5, 5}, {1, 0.5, 1}, 45)};
    EXPECT_NEAR(distanceAt(0, 1.5, 5 - std::sqrt(2.0)), 5 - std::sqrt(2.0), 0.02)
        << "an edge; the pixel's centre is up to half a pixel beside it";

    scene.solids = {frustum({0, 1, 5}, 1, 0.5, 0.5)};
    EXPECT_NEAR(distanceAt(0, 1.5, 4.5), 4.5, 1e-3) << "a cylinder, half a pixel off its middle";
    EXPECT_TRUE(std::isinf(distanceAt(0, 2.1, 4.5))) << "above it";
    EXPECT_TRUE(std::isinf(distanceAt(0, 0.9, 4.5))) << "below it";
    EXPECT_TRUE(std::isinf(distanceAt(0.6, 1.5, 5))) << "beside it";
    scene.solids = {frustum({0, 1, 5}, 1, 0.5, 0)};
    EXPECT_TRUE(std::isfinite(distanceAt(0.2, 1.5, 5))) << "a cone is half as wide halfway up";
    EXPECT_TRUE(std::isinf(distanceAt(0.3, 1.5, 5)));
    scene.solids = {frustum({0, 0, 5}, 1, 0.5, 0.5)};
    const cv::Point2d lid = project(scene, size, 0, {0, 1, 5});
    const int row = static_cast<int>(lid.y);
    const double down = -slopes(scene, size, 0, 100, row).y;
    EXPECT_NEAR(distanceAt(0, 1, 5), 0.5 / down, kFloatNoise) << "the lid, seen from above";
}

TEST(Scene, RelativeInverseDepthIsOneNearAndZeroFar) {
    Scene scene = emptyScene();
    EXPECT_EQ(relativeInverseDepth(scene, 1), 1);
    EXPECT_EQ(relativeInverseDepth(scene, 0.5), 1);
    EXPECT_EQ(relativeInverseDepth(scene, 50), 0);
    EXPECT_EQ(relativeInverseDepth(scene, INFINITY), 0);
    EXPECT_NEAR(relativeInverseDepth(scene, 2), (0.5 - 0.02) / (1 - 0.02), 1e-15);
    scene.solids = {plane(0)};
    const Rendering picture = render(scene, cv::Size(7, 9), kCameraX, 1);
    for (int y = 0; y < 9; ++y) {
        EXPECT_NEAR(
            picture.depth.at<float>(y, 3),
            relativeInverseDepth(scene, static_cast<double>(picture.metric.at<float>(y, 3))), 1e-6);
    }
}

TEST(Scene, ParallaxIsFocalLengthTimesBaselineTimesInverseDepthBeyondTheFocus) {
    const cv::Size size(401, 101);
    const double focal = 1.1 * size.width;
    for (const double z : {1.5, 3.0, 8.0}) {
        Scene scene = emptyScene();
        const cv::Vec3d point(0.02, 1.45, z);
        scene.solids = {sphere(point, 0.02 * z)};
        const double left = -0.04;
        const double right = 0.06;
        const double shift = focal * (right - left) * (1 / z - 1 / scene.focusDistance);
        const double predicted =
            project(scene, size, left, point).x - project(scene, size, right, point).x;
        EXPECT_NEAR(predicted, shift, 1e-9) << z;
        // Nearer than the focus: to the left when the camera goes right; farther: to the right.
        EXPECT_EQ(predicted > 1, z < 3);
        EXPECT_EQ(predicted<-1, z> 3);
        const double seen =
            columnOfNearThing(scene, size, left) - columnOfNearThing(scene, size, right);
        // A ball 17 px wide: its middle of gravity is known to some tenths of a pixel.
        EXPECT_NEAR(seen, shift, 0.3) << z;
    }
}
