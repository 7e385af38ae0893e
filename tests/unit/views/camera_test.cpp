#include "altiro3D/view_options.hpp"

#include "support/files.hpp"

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
    const struct {
        const char* field;
        const char* value;
        const char* problem;
    } cases[] = {{"fx", "0", "is 0, expected a focal length of 0.001..1e9 px"},
                 {"fy", "-1", "is -1, expected a focal length of 0.001..1e9 px"},
                 {"fx", "\"wide\"", "is \"wide\", expected a focal length of 0.001..1e9 px"},
                 {"cx", "1e300", "is 1e+300, expected a principal point of -1e9..1e9 px"},
                 {"cy", "null", "is null, expected a principal point of -1e9..1e9 px"},
                 {"zNear", "0", "is 0, expected a distance of 1e-6..1e9"},
                 {"zNear", "1e-320", "is 9.99989e-321, expected a distance of 1e-6..1e9"},
                 {"zFar", "34.5", "is 34.5, expected more than zNear (34.5)"},
                 {"baseline", "-1.5", "is -1.5, expected a length of 0..1e9"}};
    for (const auto& [field, value, problem] : cases)
        EXPECT_EQ(errorFor(with(field, value)),
                  std::string("street.json: ") + field + " " + problem);
    EXPECT_EQ(errorFor(R"({"fx": 1, "fy": 1, "cx": 1})"),
              "street.json: cy is missing, expected a principal point of -1e9..1e9 px");
}

TEST(Camera, FilesThatAreNoCameraAreRefused) {
    EXPECT_EQ(errorFor("[1, 2]"), "street.json: holds no JSON object, expected a camera's fx, fy, "
                                  "cx, cy, zNear, zFar and baseline");
    for (const std::string& text :
         {std::string(), std::string("{"), std::string("{\"fx\": NaN}"), std::string("\xff\xfe")})
        EXPECT_TRUE(holds(errorFor(text), "street.json: is not valid JSON (")) << text;
    EXPECT_EQ(errorFor(with("fx", "1e999")),
              "street.json: holds a number that is out of range, expected a camera's fx, fy, cx, "
              "cy, zNear, zFar and baseline");
    const std::string deep(100000, '[');
    EXPECT_TRUE(startsWith(errorFor(deep), "street.json: "));
    EXPECT_TRUE(
        startsWith(errorFor(with("fx", deep + std::string(deep.size(), ']'))), "street.json: "));
    const TemporaryDirectory directory;
    EXPECT_TRUE(holds(errorOf([&] { readCamera(directory / "none.json"); }), "none.json"));
}

TEST(Camera, ParallaxFollowsFromBaselineAndRange) {
    Camera camera = aCamera();
    EXPECT_NEAR(parallaxOf(camera), 2 * 1732.5 * 1.5 * (1 / 34.5 - 1 / 2760.0), 1e-9);
    camera.zFar = kInfinity;
    EXPECT_NEAR(parallaxOf(camera), 2 * 1732.5 * 1.5 / 34.5, 1e-9);
    camera.baseline = 0;
    EXPECT_EQ(parallaxOf(camera), 0);
    camera.baseline = kNan;
    EXPECT_TRUE(holds(errorOf([&] { parallaxOf(camera); }), "baseline: is nan"));
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
    EXPECT_TRUE(holds(errorOf([&] { fitted(k, {0, 0, 0, 10}, {10, 10}); }), "part: is 0"));
    EXPECT_EQ(errorOf([&] { fitted(k, part, cv::Size(160, 0)); }),
              "size: is 0, expected 1 px or more a side");
}

TEST(Camera, SingularIntrinsicsAreRefused) {
    for (double bad : {0.0, -5.0, kNan, kInfinity, 1e-9})
        EXPECT_TRUE(holds(errorOf([&] { validate(Camera{{bad, 1, 0, 0}}); }), "fx: is "));
    EXPECT_TRUE(holds(errorOf([] { validate(Camera{{1, 1, kNan, 0}}); }), "cx: is nan"));
}

} // namespace
} // namespace altiro3D::test
