// Method Real for any two cameras.

#include "altiro3D/camera.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "views/views_real_cells.hpp"
#include "views/views_real_holes.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace altiro3D {

namespace {

struct Point {
    int x;
    int y;
    float nearness;
};

// Calls use(column, row, weight of the pixel, whether the point falls onto it) for up to four px
// around a point.
template <typename Use>
void spread(const Point& point, cv::Size size, const Use& use) {
    const Split u(point.x);
    const Split v(point.y);
    for (int j = 0; j < 2; ++j) {
        const int y = v.first + j;
        const int wy = j == 0 ? kOne - v.secondWeight : v.secondWeight;
        if (wy == 0 || y < 0 || y >= size.height) continue;
        for (int i = 0; i < 2; ++i) {
            const int x = u.first + i;
            const int wx = i == 0 ? kOne - u.secondWeight : u.secondWeight;
            if (wx == 0 || x < 0 || x >= size.width) continue;
            use(x, y, (wx * wy + kOne / 2) / kOne, wx >= kCovered && wy >= kCovered);
        }
    }
}

} // namespace

void renderReal(const cv::Mat& photo, const cv::Mat& distance, const CameraIntrinsics& photoCamera,
                const CameraIntrinsics& viewCamera, const CameraPose& pose,
                const RealOptions& options, cv::Mat& view) {
    checkPhotoAndDepth(photo, distance, "distance", "CV_32FC1");
    validate(photoCamera);
    validate(viewCamera);
    validate(pose);
    validate(options);
    const cv::Size size = photo.size();
    const cv::Vec3d& t = pose.translation;
    // movement in px of things at distance 1; gives nearness in px of parallax, as for cameras side
    // by side
    const double parallax = viewCamera.fx * std::abs(t[0]) + viewCamera.fy * std::abs(t[1]) +
                            std::max(size.width, size.height) / 2.0 * std::abs(t[2]);
    const auto pointOf = [&](int x, int y) -> Point {
        const auto z = static_cast<double>(distance.ptr<float>(y)[x]);
        if (!(z > 0)) return {kOutside, kOutside, 0};
        // Divided by Z, so infinite distances need no special case.
        const cv::Vec3d ray((x - photoCamera.cx) / photoCamera.fx,
                            (y - photoCamera.cy) / photoCamera.fy, 1);
        const cv::Vec3d m = pose.rotation * ray + t * (1 / z);
        if (!(m[2] > 0)) return {kOutside, kOutside, 0}; // behind the camera
        return {placeOf(viewCamera.fx * m[0] / m[2] + viewCamera.cx, size.width),
                placeOf(viewCamera.fy * m[1] / m[2] + viewCamera.cy, size.height),
                static_cast<float>(std::min(parallax / (z * m[2]), kNearest))};
    };
    std::vector<Cell> cells(static_cast<std::size_t>(size.width) *
                            static_cast<std::size_t>(size.height));
    const auto cellAt = [&](int x, int y) -> Cell& {
        return cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) +
                     static_cast<std::size_t>(x)];
    };
    const auto forEachPoint = [&](const auto& use) {
        for (int y = 0; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) {
                const Point point = pointOf(x, y);
                if (point.x != kOutside && point.y != kOutside) use(point, x, y);
            }
        }
    };
    forEachPoint([&](const Point& point, int, int) {
        spread(point, size, [&](int x, int y, int, bool onto) {
            if (onto) offer(cellAt(x, y), point.nearness);
        });
    });
    forEachPoint([&](const Point& point, int fromX, int fromY) {
        const uchar* pixel = photo.ptr(fromY) + 3 * fromX;
        spread(point, size, [&](int x, int y, int weight, bool) {
            if (weight > 0) collect(cellAt(x, y), point.nearness, pixel, weight);
        });
    });
    cv::Mat result = view.datastart == photo.datastart ? cv::Mat() : view;
    result.create(size, CV_8UC3);
    Warped warped{cv::Mat(size, CV_8UC1), cv::Mat(size, CV_32FC1)};
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const bool seen =
                resolve(cellAt(x, y), result.ptr(y) + 3 * x, warped.nearness.ptr<float>(y) + x);
            warped.holes.ptr(y)[x] = seen ? uchar{0} : uchar{255};
        }
    }
    if (cv::countNonZero(warped.holes) < size.width * size.height)
        fillHoles(result, warped, options);
    view = result;
}

} // namespace altiro3D
