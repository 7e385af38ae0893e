#include "altiro3D/view_options.hpp"

#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/json_reader.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D {

void validate(const ViewOptions& options) {
    checkRange("strength", options.strengthPercent, 0, 10000, " % of the width");
    checkNumber(options.focus >= 0 && options.focus <= 1, "focus", options.focus,
                "a depth of 0 (farthest) .. 1 (nearest)");
    checkRange("refinement", options.refinement, 0, 16, " steps");
    checkRange("inpaintingRadius", options.real.inpaintingRadius, 1, 20, " px");
    checkNumber(options.layered.tearPixels > 0 && options.layered.tearPixels <= 1000, "tear",
                options.layered.tearPixels, "more than 0 and at most 1000 px");
    checkRange("edge dilation", options.layered.edgeDilationPixels, 0, 8, " px");
}

AdjacentParallax adjacentParallax(const ViewOptions& options, const QuiltLayout& quilt,
                                  cv::Size panelSize, cv::Vec2d depthRange) {
    if (quilt.viewCount < 2) return {};
    const double reach =
        std::max(std::abs(depthRange[0] - options.focus), std::abs(depthRange[1] - options.focus));
    const double widths = options.strengthPercent / 100 * reach / (quilt.viewCount - 1);
    return {widths * quilt.tileSize.width, widths * panelSize.width};
}

namespace {

constexpr std::uintmax_t kMaxFileBytes = 1024 * 1024;
constexpr double kLargest = 1e9; // limit of lengths and px; products stay far inside double
constexpr double kMinDistance = 1e-6;
constexpr double kMinFocalLength = 1e-3; // px

const char* const kExpectedFocalLength = "a focal length of 0.001..1e9 px";
const char* const kExpectedPrincipalPoint = "a principal point of -1e9..1e9 px";

// One check for arguments and files; `complain` makes the error.
template <typename Complain>
void check(const Camera& camera, const Complain& complain) {
    const auto focalLength = [&](const char* field, double value) {
        complain(value >= kMinFocalLength && value <= kLargest, field, value, kExpectedFocalLength);
    };
    const auto principalPoint = [&](const char* field, double value) {
        complain(std::abs(value) <= kLargest, field, value, kExpectedPrincipalPoint);
    };
    const CameraIntrinsics& k = camera.intrinsics;
    focalLength("fx", k.fx);
    focalLength("fy", k.fy);
    principalPoint("cx", k.cx);
    principalPoint("cy", k.cy);
    complain(camera.zNear >= kMinDistance && camera.zNear <= kLargest, "zNear", camera.zNear,
             "a distance of 1e-6..1e9");
    complain(camera.zFar > camera.zNear, "zFar", camera.zFar,
             "more than zNear (" + numberText(camera.zNear) + ")");
    complain(camera.baseline >= 0 && camera.baseline <= kLargest, "baseline", camera.baseline,
             "a length of 0..1e9");
}

double inverseRange(double zNear, double zFar) {
    return 1 / zNear - 1 / zFar;
}

} // namespace

void validate(const Camera& camera) {
    check(camera, checkNumber);
}

Camera parseCamera(const std::string& text, const std::string& source) {
    const auto fail = [&source](const std::string& problem) {
        throw Error(ErrorCode::BadFormat, source, problem);
    };
    const Json object = parseJson(
        text, source, "a camera's fx, fy, cx, cy, zNear, zFar and baseline", {8, 1000, false});
    if (!object.is_object()) {
        fail("holds no JSON object, expected a camera's fx, fy, cx, cy, zNear, zFar and baseline");
    }
    const auto read = [&](const char* field, const char* expected) {
        const auto found = object.find(field);
        if (found == object.end()) {
            fail(std::string(field) + " is missing, expected " + expected);
        }
        if (!found->is_number()) {
            fail(std::string(field) + " is " + shownJson(*found) + ", expected " + expected);
        }
        return found->get<double>();
    };
    Camera camera;
    camera.intrinsics.fx = read("fx", kExpectedFocalLength);
    camera.intrinsics.fy = read("fy", kExpectedFocalLength);
    camera.intrinsics.cx = read("cx", kExpectedPrincipalPoint);
    camera.intrinsics.cy = read("cy", kExpectedPrincipalPoint);
    camera.zNear = read("zNear", "a distance of 1e-6..1e9");
    const auto far = object.find("zFar");
    camera.zFar = far != object.end() && far->is_null()
                      ? std::numeric_limits<double>::infinity()
                      : read("zFar", "a distance, more than zNear, or null (infinitely far)");
    camera.baseline = read("baseline", "a length of 0..1e9");
    check(camera, [&](bool good, const char* field, double value, const std::string& expected) {
        if (good) return;
        fail(std::string(field) + " is " + numberText(value) + ", expected " + expected);
    });
    return camera;
}

Camera readCamera(const std::filesystem::path& path) {
    return parseCamera(readFile(path, kMaxFileBytes), path.string());
}

CameraIntrinsics fitted(const CameraIntrinsics& k, const cv::Rect2d& part, cv::Size size) {
    checkNumber(part.width > 0 && part.height > 0, "part", std::min(part.width, part.height),
                "more than 0 px a side");
    checkNumber(size.width >= 1 && size.height >= 1, "size", std::min(size.width, size.height),
                "1 px or more a side");
    const double x = size.width / part.width;
    const double y = size.height / part.height;
    // Areas are scaled, so pixel corners map to corners, 0.5 px from the centres.
    return {k.fx * x, k.fy * y, (k.cx + 0.5 - part.x) * x - 0.5, (k.cy + 0.5 - part.y) * y - 0.5};
}

double parallaxOf(const Camera& camera) {
    validate(camera);
    return 2 * camera.intrinsics.fx * camera.baseline * inverseRange(camera.zNear, camera.zFar);
}

} // namespace altiro3D
