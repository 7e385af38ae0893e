#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "scene/framing.hpp"
#include "splats/splat_collector.hpp"

#include <algorithm>
#include <functional>

namespace altiro3D {

namespace {

constexpr double kOpaque = 0.1;       // fainter splats do not count for the choice of a camera
constexpr double kTail = 0.05;        // share of the splats on each side that may be cut off
constexpr double kUsualDegrees = 14;  // angle of view that makers of displays recommend
constexpr double kWidestDegrees = 90; // of a chosen camera
constexpr double kMargin = 1.2;       // around the middle of an object, for its tails

// The places below which given shares of the opacity lie.
std::vector<double> quantilesOf(const SplatScene& scene, const std::vector<double>& shares,
                                const std::function<double(const cv::Vec3d&)>& coordinate) {
    constexpr std::size_t kEnough = 50'000; // splats; all would not move a camera by what is seen
    const std::size_t step = 1 + scene.splats.size() / kEnough;
    std::vector<std::pair<double, double>> places; // and their weights
    double sum = 0;
    for (std::size_t i = 0; i < scene.splats.size(); i += step) {
        const Splat& splat = scene.splats[i];
        const auto opacity = static_cast<double>(splat.opacity);
        if (opacity < kOpaque) continue;
        places.emplace_back(coordinate(splat.centre), opacity);
        sum += opacity;
    }
    if (places.empty())
        throw Error(ErrorCode::BadFormat, "splats",
                    "are all nearly transparent, expected some of opacity 0.1 or more");
    std::sort(places.begin(), places.end());
    std::vector<double> result;
    double before = 0;
    auto place = places.begin();
    for (const double share : shares) {
        while (place + 1 != places.end() && before + place->second < share * sum)
            before += (place++)->second;
        result.push_back(place->first);
    }
    return result;
}

double tangent(double degrees) {
    return std::tan(degrees * CV_PI / 360);
}

double degreesOf(double tangent) {
    return std::atan(tangent) * 360 / CV_PI;
}

// Rows right, down, forward of a camera that looks in a direction.
cv::Matx33d axesOf(const cv::Vec3d& forward, const cv::Vec3d& up) {
    const cv::Vec3d f = forward / cv::norm(forward);
    const cv::Vec3d across = (-up).cross(f);
    check(cv::norm(forward) > 0 && cv::norm(across) > 1e-9 * cv::norm(up), "up",
          "is the direction of the view, expected another one");
    const cv::Vec3d right = across / cv::norm(across);
    const cv::Vec3d down = f.cross(right);
    return {right[0], right[1], right[2], down[0], down[1], down[2], f[0], f[1], f[2]};
}

// Turns a camera around a point before it: to its right, then upwards.
cv::Matx33d turned(const cv::Matx33d& axes, double yaw, double tilt) {
    const double y = yaw * CV_PI / 180;
    const double t = tilt * CV_PI / 180;
    const cv::Matx33d toRight(std::cos(y), 0, std::sin(y), 0, 1, 0, -std::sin(y), 0, std::cos(y));
    const cv::Matx33d upwards(1, 0, 0, 0, std::cos(t), -std::sin(t), 0, std::sin(t), std::cos(t));
    return upwards * toRight * axes;
}

// A camera without its size: where it stands, what it looks at, and how much it sees.
struct Pose {
    cv::Matx33d axes = cv::Matx33d::eye();
    cv::Vec3d eye;
    cv::Vec3d pivot;        // in the middle of the picture
    double viewTangent = 0; // of half the vertical angle of view
    cv::Vec2d offset;       // of the principal point from the middle, in heights of the picture
    std::string how;
};

cv::Vec3d row(const cv::Matx33d& axes, int i) {
    return {axes(i, 0), axes(i, 1), axes(i, 2)};
}

Pose poseOfFile(const SplatScene& scene, double aspect) {
    const SplatCamera& camera = *scene.camera;
    Pose pose;
    pose.axes = camera.axes;
    pose.eye = camera.eye;
    const cv::Vec3d forward = row(pose.axes, 2);
    double distance = scene.focusDistance;
    if (distance <= 0)
        distance = quantilesOf(scene, {0.5}, [&](const cv::Vec3d& p) {
            return std::max((p - pose.eye).dot(forward), 0.0);
        })[0];
    pose.pivot = pose.eye + std::max(distance, 1e-6) * forward;
    const CameraIntrinsics& lens = camera.intrinsics;
    const double width = camera.size.width / lens.fx; // at distance 1
    const double height = camera.size.height / lens.fy;
    const double seen = std::min(height, width / aspect); // it fills the panel
    pose.viewTangent = seen / 2;
    pose.offset = {(lens.cx - (camera.size.width - 1) / 2.0) / lens.fx / seen,
                   (lens.cy - (camera.size.height - 1) / 2.0) / lens.fy / seen};
    pose.how = "that of the file";
    return pose;
}

// Scenes that a network made of one photo lie before the origin.
std::optional<Pose> poseAtOrigin(const SplatScene& scene, double aspect) {
    constexpr double kWidest = 1.5; // tangent of the angle to the view
    const auto z = quantilesOf(scene, {0.02, 0.5}, [](const cv::Vec3d& p) { return p[2]; });
    if (!(z[0] > 0)) return std::nullopt;
    double sides[2];
    for (int i = 0; i < 2; ++i) {
        const auto ends = quantilesOf(scene, {kTail, 1 - kTail}, [i](const cv::Vec3d& p) {
            return p[2] > 0 ? p[i] / p[2] : 0;
        });
        if (std::max(-ends[0], ends[1]) > kWidest || ends[0] > 0 || ends[1] < 0)
            return std::nullopt;
        sides[i] = std::max(std::min(-ends[0], ends[1]), (ends[1] - ends[0]) / 4);
    }
    Pose pose;
    pose.pivot = {0, 0, z[1]};
    pose.viewTangent =
        std::clamp(std::min(sides[1], sides[0] / aspect), tangent(1), tangent(kWidestDegrees));
    pose.how = "at the origin, in front of which the scene lies";
    return pose;
}

// A camera in front of the middle of the opaque part, which fills the panel.
Pose poseBefore(const SplatScene& scene, double aspect, const SplatCameraOptions& options) {
    Pose pose;
    for (int i = 0; i < 3; ++i) {
        const auto ends =
            quantilesOf(scene, {kTail, 1 - kTail}, [i](const cv::Vec3d& p) { return p[i]; });
        pose.pivot[i] = (ends[0] + ends[1]) / 2;
    }
    pose.pivot = options.lookAt.value_or(pose.pivot);
    const cv::Vec3d up = options.up.value_or(cv::Vec3d(0, -1, 0));
    cv::Vec3d forward(0, 0, 1);
    if (cv::norm(forward.cross(up)) < 1e-6 * cv::norm(up)) forward = {0, 1, 0};
    forward -= up * (forward.dot(up) / up.dot(up));
    pose.axes = turned(axesOf(forward, up), options.yaw, options.tilt);
    double reach[3]; // from the middle
    for (int i = 0; i < 3; ++i) {
        const cv::Vec3d axis = row(pose.axes, i);
        const auto ends = quantilesOf(scene, {kTail, 1 - kTail}, [&](const cv::Vec3d& p) {
            return (p - pose.pivot).dot(axis);
        });
        reach[i] = std::max(-ends[0], ends[1]);
    }
    pose.viewTangent = tangent(options.viewDegrees.value_or(kUsualDegrees));
    const double distance =
        kMargin * std::max(reach[1], reach[0] / aspect) / pose.viewTangent + reach[2];
    pose.eye = pose.pivot - std::max(distance, 1e-6) * row(pose.axes, 2);
    pose.how = "in front of the middle of the opaque part";
    return pose;
}

void validate(const SplatCameraOptions& options) {
    checkRange("yaw", options.yaw, -360, 360, " degrees");
    checkRange("tilt", options.tilt, -90, 90, " degrees");
    if (options.viewDegrees) checkRange("viewDegrees", *options.viewDegrees, 1, 150, " degrees");
    for (const auto& place : {options.position, options.lookAt, options.up})
        if (place) check(cv::norm(*place) < 1e9, "position", "is not a place in the scene");
    if (options.up) check(cv::norm(*options.up) > 1e-9, "up", "is no direction, expected one");
}

} // namespace

ChosenSplatCamera chooseSplatCamera(const SplatScene& scene, cv::Size size, double aspect,
                                    const SplatCameraOptions& options) {
    checkRange("aspect", aspect, 0.01, 100);
    validate(options);
    std::optional<Pose> pose;
    if (scene.camera) pose = poseOfFile(scene, aspect);
    if (!pose && !options.position) pose = poseAtOrigin(scene, aspect);
    const bool isPhoto = pose.has_value(); // taken from where the camera is
    if (!pose) pose = poseBefore(scene, aspect, options);
    if (options.position || (isPhoto && (options.lookAt || options.up))) {
        pose->pivot = options.lookAt.value_or(pose->pivot);
        pose->eye = options.position.value_or(pose->eye);
        pose->axes = axesOf(pose->pivot - pose->eye, options.up.value_or(-row(pose->axes, 1)));
        pose->offset = {};
        pose->how = "as given";
    }
    if ((isPhoto || options.position) && (options.yaw != 0 || options.tilt != 0)) {
        const double distance = cv::norm(pose->pivot - pose->eye);
        pose->axes = turned(pose->axes, options.yaw, options.tilt);
        pose->eye = pose->pivot - distance * row(pose->axes, 2);
    }
    if (options.viewDegrees) pose->viewTangent = tangent(*options.viewDegrees);
    ChosenSplatCamera chosen;
    SplatCamera& camera = chosen.camera;
    camera.size = size;
    camera.axes = pose->axes;
    camera.eye = pose->eye;
    const double height = 2 * pose->viewTangent; // seen at distance 1
    camera.intrinsics.fy = size.height / height;
    camera.intrinsics.fx = size.width / (height * aspect);
    camera.intrinsics.cx = (size.width - 1) / 2.0 + pose->offset[0] * size.width / aspect;
    camera.intrinsics.cy = (size.height - 1) / 2.0 + pose->offset[1] * size.height;
    requireCamera(camera);
    chosen.how = pose->how + ", view angle " + fixed(degreesOf(pose->viewTangent), 0) + " degrees";
    return chosen;
}

SplatPlacement placeSplats(const SplatView& view, const SplatCamera& camera,
                           const QuiltLayout& quilt, std::optional<double> focus,
                           std::optional<double> strengthPercent) try {
    if (focus) checkRange("focus", *focus, 0, 1);
    if (strengthPercent) checkRange("strength", *strengthPercent, 0, 10000, " %");
    checkType(view.distance, {CV_32FC1}, "distance", "CV_32FC1");
    requireCamera(camera);
    validate(quilt);
    const auto closenessIn = [&](const cv::Rect& part) {
        std::vector<double> values;
        for (const float distance : cv::Mat1f(view.distance(part)))
            if (distance > 0) values.push_back(1 / static_cast<double>(distance));
        std::sort(values.begin(), values.end());
        return values;
    };
    const cv::Size size = view.distance.size();
    const std::vector<double> all = closenessIn({{}, size});
    check(!all.empty(), "view", "shows nothing, expected splats before the camera");
    std::vector<double> middle =
        closenessIn({size.width / 3, size.height / 3, std::max(size.width / 3, 1),
                     std::max(size.height / 3, 1)});
    if (middle.empty()) middle = all;
    const auto at = [&](double share) {
        return all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))];
    };
    constexpr double kOutside = 0.02;
    const double low = at(kOutside);
    const double high = at(1 - kOutside);
    SplatPlacement placement;
    placement.zNear = 1 / high;
    placement.zFar = 1 / low;
    const double range = high - low;
    const bool isFlat = range <= 1e-6 * high;
    const double median = middle[middle.size() / 2];
    placement.focus = focus.value_or(isFlat ? 0.5 : std::clamp((median - low) / range, 0.0, 1.0));
    placement.strengthPercent =
        strengthPercent.value_or(strengthOfRange(placement.focus, quilt, {0, 1}));
    placement.focusDistance = 1 / (low + placement.focus * range);
    if (!isFlat) // (9.5)
        placement.baseline = placement.strengthPercent / 100 * camera.size.width /
                             (2 * camera.intrinsics.fx * range);
    return placement;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Mat depthOf(const SplatView& view, const SplatPlacement& placement) try {
    checkType(view.distance, {CV_32FC1}, "distance", "CV_32FC1");
    check(placement.zNear > 0 && placement.zFar >= placement.zNear, "placement",
          "lies at " + numberText(placement.zNear) + ".." + numberText(placement.zFar) +
              ", expected a near distance above 0 and a far one");
    const double low = 1 / placement.zFar;
    const double range = std::max(1 / placement.zNear - low, 1e-12);
    return mapped<float, float>(view.distance, [&](float distance) {
        const double value = (1 / static_cast<double>(distance) - low) / range;
        return distance > 0 ? static_cast<float>(std::clamp(value, 0.0, 1.0)) : 0;
    });
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
