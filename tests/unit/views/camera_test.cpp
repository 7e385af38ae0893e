#include "altiro3D/view_options.hpp"

#include "support/files.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace altiro3D::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

const std::string kStreet = R"({"fx": 1732.5, "fy": 1729.5, "cx": 943.25, "cy": 548.5,
  "zNear": 34.5, "zFar": 2760, "baseline": 1.5, "note": "passed over"})";

// kStreet with one field's value replaced by another text.
std::string with(const std::string& field, const std::string& value) {
    std::string text = kStreet;
    const auto colon = text.find(':', text.find("\"" + field + "\""));
    return text.replace(colon + 1, text.find(',', colon) - colon - 1, " " + value);
}

std::string errorFor(const std::string& text) {
    return errorOf([&] { parseCamera(text, "street.json"); });
}

Camera aCamera() {
    return parseCamera(kStreet, "street.json");
}

TEST(Camera, FileGivesAllSevenNumbers) {
    const TemporaryDirectory directory;
    spill(directory / "street.json", kStreet);
    const Camera camera = readCamera(directory / "street.json");
    EXPECT_EQ(camera.intrinsics.fx, 1732.5);
    EXPECT_EQ(camera.intrinsics.fy, 1729.5);
    EXPECT_EQ(camera.intrinsics.cx, 943.25);
    EXPECT_EQ(camera.intrinsics.cy, 548.5);
    EXPECT_EQ(camera.zNear, 34.5);
    EXPECT_EQ(camera.zFar, 2760);
    EXPECT_EQ(camera.baseline, 1.5);
}

TEST(Camera, NullIsInfinitelyFar) {
    EXPECT_EQ(parseCamera(with("zFar", "null"), "a").zFar, kInfinity);
}

TEST(Camera, ErrorNamesFileFieldValueAndExpectation) {
    EXPECT_EQ(errorFor(with("fx", "0")),
              "street.json: fx is 0, expected a focal length of 0.001..1e9 px");
    EXPECT_EQ(errorFor(with("fy", "-1")),
              "street.json: fy is -1, expected a focal length of 0.001..1e9 px");
    EXPECT_EQ(errorFor(with("fx", "\"wide\"")),
              "street.json: fx is \"wide\", expected a focal length of 0.001..1e9 px");
    EXPECT_EQ(errorFor(with("cx", "1e300")),
              "street.json: cx is 1e+300, expected a principal point of -1e9..1e9 px");
    EXPECT_EQ(errorFor(with("cy", "null")),
              "street.json: cy is null, expected a principal point of -1e9..1e9 px");
    EXPECT_EQ(errorFor(with("zNear", "0")),
              "street.json: zNear is 0, expected a distance of 1e-6..1e9");
    EXPECT_EQ(errorFor(with("zNear", "1e-320")),
              "street.json: zNear is 9.99989e-321, expected a distance of 1e-6..1e9");
    EXPECT_EQ(errorFor(with("zFar", "34.5")),
              "street.json: zFar is 34.5, expected more than zNear (34.5)");
    EXPECT_EQ(errorFor(with("baseline", "-1.5")),
              "street.json: baseline is -1.5, expected a length of 0..1e9");
    EXPECT_EQ(errorFor(R"({"fx": 1, "fy": 1, "cx": 1})"),
              "street.json: cy is missing, expected a principal point of -1e9..1e9 px");
}

TEST(Camera, FilesThatAreNoCameraAreRefused) {
    EXPECT_EQ(errorFor("[1, 2]"), "street.json: holds no JSON object, expected a camera's fx, fy, "
                                  "cx, cy, zNear, zFar and baseline");
    for (const std::string& text :
         {std::string(), std::string("{"), std::string("{\"fx\": NaN}"), std::string("\xff\xfe")}) {
        EXPECT_NE(errorFor(text).find("street.json: is not valid JSON ("), std::string::npos)
            << text;
    }
    EXPECT_EQ(errorFor(with("fx", "1e999")),
              "street.json: holds a number that is out of range, expected a camera's fx, fy, cx, "
              "cy, zNear, zFar and baseline");
    const std::string deep(100000, '[');
    EXPECT_EQ(errorFor(deep).find("street.json: "), 0U);
    EXPECT_EQ(errorFor(with("fx", deep + std::string(deep.size(), ']'))).find("street.json: "), 0U);
    const TemporaryDirectory directory;
    EXPECT_NE(errorOf([&] { readCamera(directory / "none.json"); }).find("none.json"),
              std::string::npos);
}

TEST(Camera, FocalLengthFollowsFromTheFieldOfView) {
    EXPECT_NEAR(focalLengthFromFieldOfView(200, 90), 100, 1e-12);
    EXPECT_NEAR(focalLengthFromFieldOfView(1536, 40), 768 / std::tan(std::acos(-1) / 9), 1e-9);
    // tan(x) = x (1 + x^2 / 3) for the narrowest, 1 / tan(89.5 degrees) = tan(0.5 degrees)
    EXPECT_NEAR(focalLengthFromFieldOfView(1000, 0.1), 1000 / (0.1 * std::acos(-1) / 180), 0.2);
    EXPECT_NEAR(focalLengthFromFieldOfView(1000, 179), 500 * std::tan(std::acos(-1) / 360), 1e-9);
    for (double bad : {0.0, 0.09, 180.0, -40.0, kNan, kInfinity}) {
        EXPECT_NE(errorOf([&] {
                      focalLengthFromFieldOfView(100, bad);
                  }).find("expected 0.1..179 degrees"),
                  std::string::npos)
            << bad;
    }
    EXPECT_NE(errorOf([] { focalLengthFromFieldOfView(0, 40); }).find("columns: is 0"),
              std::string::npos);
}

TEST(Camera, FocalLengthFollowsFromThatOfA35MmCamera) {
    EXPECT_EQ(focalLengthFrom35mm({3600, 2400}, 50), 5000);
    EXPECT_EQ(focalLengthFrom35mm({2400, 3600}, 50), 5000) << "upright: the same lens";
    EXPECT_NE(errorOf([] {
                  focalLengthFrom35mm({10, 10}, 0);
              }).find("expected 1..10000 mm"),
              std::string::npos);
    EXPECT_NE(errorOf([] {
                  focalLengthFrom35mm({0, 10}, 35);
              }).find("size: is 0"),
              std::string::npos);
}

TEST(Camera, ParallaxAndBaselineAreInverse) {
    Camera camera = aCamera();
    const double parallax = parallaxOf(camera);
    EXPECT_NEAR(parallax, 2 * 1732.5 * 1.5 * (1 / 34.5 - 1 / 2760.0), 1e-9);
    EXPECT_NEAR(baselineFor(camera, parallax), 1.5, 1e-12);
    camera.zFar = kInfinity;
    EXPECT_NEAR(parallaxOf(camera), 2 * 1732.5 * 1.5 / 34.5, 1e-9);
    camera.baseline = 0;
    EXPECT_EQ(parallaxOf(camera), 0);
    camera.baseline = kNan;
    EXPECT_NE(errorOf([&] { parallaxOf(camera); }).find("baseline: is nan"), std::string::npos);
    EXPECT_NEAR(baselineFor(camera, 100), 100 / (2 * 1732.5 / 34.5), 1e-12)
        << "its own is not read";
    EXPECT_NE(errorOf([&] { baselineFor(camera, -1); }).find("parallax: is -1"), std::string::npos);
}

TEST(Camera, CroppedAndResizedPicturesKeepTheirRays) {
    const CameraIntrinsics k{1000, 900, 319.5, 239.5};
    const cv::Rect2d part(100, 40, 320, 400);
    const CameraIntrinsics f = fitted(k, part, {160, 100});
    // The part's corners, half a pixel outside the corner pixels' centres, lie on the same rays.
    EXPECT_NEAR((-0.5 - f.cx) / f.fx, (100 - 0.5 - k.cx) / k.fx, 1e-12);
    EXPECT_NEAR((159.5 - f.cx) / f.fx, (420 - 0.5 - k.cx) / k.fx, 1e-12);
    EXPECT_NEAR((-0.5 - f.cy) / f.fy, (40 - 0.5 - k.cy) / k.fy, 1e-12);
    EXPECT_NEAR((99.5 - f.cy) / f.fy, (440 - 0.5 - k.cy) / k.fy, 1e-12);
    const CameraIntrinsics same = fitted(k, {0, 0, 640, 480}, {640, 480});
    EXPECT_EQ(same.cx, k.cx);
    EXPECT_EQ(same.fy, k.fy);
    const CameraIntrinsics centred = centredIntrinsics({640, 480}, 1000);
    EXPECT_EQ(centred.cx, 319.5);
    EXPECT_EQ(centred.cy, 239.5);
    EXPECT_NE(errorOf([&] {
                  fitted(k, {0, 0, 0, 10}, {10, 10});
              }).find("part: is 0"),
              std::string::npos);
    EXPECT_EQ(errorOf([&] {
                  fitted(k, part, {160, 0});
              }),
              "size: is 0, expected 1 px or more a side");
}

TEST(Camera, SingularIntrinsicsAreRefused) {
    for (double bad : {0.0, -5.0, kNan, kInfinity, 1e-9}) {
        EXPECT_NE(errorOf([&] {
                      validate(Camera{{bad, 1, 0, 0}});
                  }).find("fx: is "),
                  std::string::npos);
    }
    EXPECT_NE(errorOf([] {
                  validate(Camera{{1, 1, kNan, 0}});
              }).find("cx: is nan"),
              std::string::npos);
}

} // namespace
} // namespace altiro3D::test
