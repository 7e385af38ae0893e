#include "support/splat_reference.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace {

// Spherical harmonics as 3DGS has them, by name of their axis terms.
cv::Vec3d slowColour(const SplatScene& scene, std::size_t i, const cv::Vec3d& d) {
    const double x = d[0];
    const double y = d[1];
    const double z = d[2];
    const double c1 = std::sqrt(3 / (4 * CV_PI));
    const double c2 = std::sqrt(15 / (4 * CV_PI));
    const double c20 = std::sqrt(5 / (16 * CV_PI));
    const double c33 = std::sqrt(35 / (32 * CV_PI));
    const double c32 = std::sqrt(105 / (4 * CV_PI));
    const double c31 = std::sqrt(21 / (32 * CV_PI));
    const double c30 = std::sqrt(7 / (16 * CV_PI));
    const double values[15] = {-c1 * y,
                               c1 * z,
                               -c1 * x,
                               c2 * x * y,
                               -c2 * y * z,
                               c20 * (2 * z * z - x * x - y * y),
                               -c2 * x * z,
                               c2 / 2 * (x * x - y * y),
                               -c33 * y * (3 * x * x - y * y),
                               c32 * x * y * z,
                               -c31 * y * (4 * z * z - x * x - y * y),
                               c30 * z * (2 * z * z - 3 * x * x - 3 * y * y),
                               -c31 * x * (4 * z * z - x * x - y * y),
                               c32 / 2 * z * (x * x - y * y),
                               -c33 * x * (x * x - 3 * y * y)};
    const auto count = static_cast<std::size_t>((scene.degree + 1) * (scene.degree + 1) - 1);
    cv::Vec3d colour = scene.splats[i].colour;
    for (std::size_t k = 0; k < count; ++k)
        for (int c = 0; c < 3; ++c)
            colour[c] +=
                values[k] * static_cast<double>(
                                scene.harmonics[3 * (i * count + k) + static_cast<std::size_t>(c)]);
    for (double& value : colour.val)
        value = std::max(value, 0.0);
    return colour;
}

// Turns a vector by a quaternion: q v q*.
cv::Vec3d turnedBy(const cv::Vec4d& q, const cv::Vec3d& v) {
    const cv::Vec3d axis(q[1], q[2], q[3]);
    return v + 2 * axis.cross(axis.cross(v) + q[0] * v);
}

} // namespace

SplatScene randomSplats(int count, int degree) {
    cv::RNG random(7);
    const auto number = [&](double low, double high) {
        return static_cast<float>(random.uniform(low, high));
    };
    SplatScene scene;
    scene.degree = degree;
    for (int i = 0; i < count; ++i) {
        const float z = number(-1, 8);
        cv::Vec4f q(number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1));
        q /= cv::norm(q);
        Splat splat{{z * number(-0.6, 0.6), z * number(-0.6, 0.6), z},
                    {},
                    q,
                    {number(-0.2, 1.2), number(0, 1), number(0, 1)},
                    number(0, 1)};
        for (float& radius : splat.radii.val)
            radius = std::exp(number(-7, -1));
        scene.splats.push_back(splat);
        for (int k = 0; k < 3 * ((degree + 1) * (degree + 1) - 1); ++k)
            scene.harmonics.push_back(number(-0.2, 0.2));
    }
    return scene;
}

cv::Mat slowSplats(const SplatScene& scene, const SplatCamera& camera, double shift,
                   double focusDistance, double nearest, cv::Mat* alpha) {
    const CameraIntrinsics& lens = camera.intrinsics;
    const cv::Vec3d eye = camera.eye + camera.axes.t() * cv::Vec3d(shift, 0, 0);
    const double cx = lens.cx + lens.fx * shift / focusDistance;
    const std::size_t count = scene.splats.size();
    std::vector<cv::Vec3d> places(count);
    for (std::size_t i = 0; i < count; ++i)
        places[i] = camera.axes * (cv::Vec3d(scene.splats[i].centre) - eye);
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return static_cast<float>(places[a][2]) < static_cast<float>(places[b][2]);
    });
    cv::Mat picture(camera.size, CV_64FC3, cv::Scalar::all(0));
    cv::Mat clear(camera.size, CV_64FC1, cv::Scalar::all(1));
    cv::Mat ended(camera.size, CV_8UC1, cv::Scalar::all(0));
    const double farX = 1.3 * camera.size.width / (2 * lens.fx) + std::abs(shift) / focusDistance;
    const double farY = 1.3 * camera.size.height / (2 * lens.fy);
    for (const std::size_t i : order) {
        const Splat& splat = scene.splats[i];
        const cv::Vec3d& p = places[i];
        const double z = p[2];
        if (z <= nearest) continue;
        // columns: the three radii, in the picture
        cv::Matx23d spread;
        const double sx = std::clamp(p[0] / z, -farX, farX);
        const double sy = std::clamp(p[1] / z, -farY, farY);
        for (int k = 0; k < 3; ++k) {
            cv::Vec3d radius;
            radius[k] = static_cast<double>(splat.radii[k]);
            const cv::Vec3d r = camera.axes * turnedBy(splat.rotation, radius);
            spread(0, k) = lens.fx / z * (r[0] - sx * r[2]);
            spread(1, k) = lens.fy / z * (r[1] - sy * r[2]);
        }
        const cv::Matx22d plain = spread * spread.t();
        const cv::Matx22d covariance = plain + 0.3 * cv::Matx22d::eye();
        const cv::Matx22d inverse = covariance.inv();
        auto opacity = static_cast<double>(splat.opacity);
        if (scene.isAntialiased)
            opacity *=
                std::sqrt(std::max(cv::determinant(plain), 0.0) / cv::determinant(covariance));
        const double middle = (covariance(0, 0) + covariance(1, 1)) / 2;
        const double reach = std::ceil(
            3 * std::sqrt(middle +
                          std::sqrt(std::max(0.1, middle * middle - cv::determinant(covariance)))));
        const double u = lens.fx * p[0] / z + cx;
        const double v = lens.fy * p[1] / z + lens.cy;
        const cv::Vec3d way = cv::Vec3d(splat.centre) - eye;
        const cv::Vec3d colour = slowColour(scene, i, way / cv::norm(way));
        const auto limit = [](double value, int most) {
            return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(most)));
        };
        for (int y = limit(std::ceil(v - reach), camera.size.height);
             y < limit(std::floor(v + reach) + 1, camera.size.height); ++y)
            for (int x = limit(std::ceil(u - reach), camera.size.width);
                 x < limit(std::floor(u + reach) + 1, camera.size.width); ++x) {
                const cv::Vec2d d(x - u, y - v);
                const double power = -0.5 * d.dot(inverse * d);
                const double a = std::min(0.99, opacity * std::exp(std::min(power, 0.0)));
                double& t = clear.at<double>(y, x);
                if (a < 1.0 / 255 || ended.at<uchar>(y, x) != 0) continue;
                if (t * (1 - a) < 1e-4) {
                    ended.at<uchar>(y, x) = 1;
                    continue;
                }
                auto& to = picture.at<cv::Vec3d>(y, x);
                for (int c = 0; c < 3; ++c)
                    to[2 - c] += 255 * a * t * colour[c];
                t *= 1 - a;
            }
    }
    if (alpha != nullptr) *alpha = 1 - clear;
    return cv::min(picture, 255);
}

double psnrOf(const cv::Mat& picture, const cv::Mat& expected, double* largest) {
    cv::Mat a;
    cv::Mat b;
    picture.convertTo(a, CV_64F);
    expected.convertTo(b, CV_64F);
    if (largest != nullptr) *largest = cv::norm(a, b, cv::NORM_INF);
    const double samples = static_cast<double>(a.total()) * a.channels();
    const double error = cv::norm(a, b, cv::NORM_L2SQR) / samples;
    return 10 * std::log10(255 * 255 / std::max(error, 1e-9));
}

} // namespace altiro3D::test
