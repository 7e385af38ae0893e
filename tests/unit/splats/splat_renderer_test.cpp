#include "altiro3D/splats.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/placement.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"
#include "support/splat_reference.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

SplatCamera cameraOf(cv::Size size, double focal) {
    SplatCamera camera;
    camera.size = size;
    camera.intrinsics = {focal, focal, (size.width - 1) / 2.0, (size.height - 1) / 2.0};
    return camera;
}

Splat splatAt(const cv::Vec3f& centre, float radius, const cv::Vec3f& colour, float opacity) {
    return {centre, {radius, radius, radius}, {1, 0, 0, 0}, colour, opacity};
}

// A camera that stands and looks somewhere.
SplatCamera turnedCamera(cv::Size size, double focal) {
    SplatCamera camera = cameraOf(size, focal);
    const double a = 0.3;
    camera.axes = cv::Matx33d(std::cos(a), 0, -std::sin(a), 0, 1, 0, std::sin(a), 0, std::cos(a));
    camera.eye = {0.2, -0.1, 0.4};
    return camera;
}

} // namespace

TEST(SplatRenderer, ASplatIsAGaussianOfItsSizeWithTheLowPass) {
    SplatScene scene;
    scene.splats = {splatAt({0.5F, 0.25F, 4}, 0.2F, {1, 0.5F, 0.25F}, 0.8F)};
    const SplatCamera camera = cameraOf({101, 81}, 100);
    const SplatView view = SplatRenderer(scene, camera).render();
    const double x = 50 + 100 * 0.5 / 4;
    const double y = 40 + 100 * 0.25 / 4;
    // across: 100 / 4 * 0.2 px, lengthened as the splat is seen from the side
    const double across = 25 + 0.3 + 25 * 0.125 * 0.125;
    const double down = 25 + 0.3 + 25 * 0.0625 * 0.0625;
    const double mixed = 25 * 0.125 * 0.0625;
    const double determinant = across * down - mixed * mixed;
    for (const cv::Point p : {cv::Point(62, 46), cv::Point(66, 49), cv::Point(58, 40)}) {
        const double dx = p.x - x;
        const double dy = p.y - y;
        const double power =
            (down * dx * dx + across * dy * dy - 2 * mixed * dx * dy) / determinant;
        const double alpha = 0.8 * std::exp(-power / 2);
        EXPECT_NEAR(static_cast<double>(view.alpha.at<float>(p)), alpha, 1e-4);
        EXPECT_NEAR(view.picture.at<cv::Vec3b>(p)[2], 255 * alpha, 1);
        EXPECT_NEAR(view.picture.at<cv::Vec3b>(p)[0], 255 * alpha / 4, 1);
    }
    EXPECT_NEAR(static_cast<double>(view.distance.at<float>(46, 62)), 4, 1e-5);
    EXPECT_TRUE(std::isnan(view.distance.at<float>(0, 0)));
}

TEST(SplatRenderer, ViewsOfParallelCamerasCrossAtTheFocus) {
    SplatScene scene;
    scene.splats = {splatAt({0, 0, 2}, 0.01F, {1, 1, 1}, 0.9F),
                    splatAt({0, 0.5F, 4}, 0.02F, {1, 1, 1}, 0.9F)};
    const SplatRenderer renderer(scene, cameraOf({101, 101}, 100));
    const auto centreIn = [&](double shift, const cv::Range& rows) {
        cv::Mat picture;
        renderer.render(shift, 2, picture);
        double sum = 0;
        double weighted = 0;
        for (int y = rows.start; y < rows.end; ++y)
            for (int x = 0; x < picture.cols; ++x) {
                sum += picture.at<cv::Vec3b>(y, x)[1];
                weighted += x * picture.at<cv::Vec3b>(y, x)[1];
            }
        return weighted / sum;
    };
    for (const double shift : {-0.4, 0.0, 0.4}) {
        EXPECT_NEAR(centreIn(shift, {44, 56}), 50, 0.02); // at the focus
        EXPECT_NEAR(centreIn(shift, {57, 70}), 50 - 100 * shift * (0.25 - 0.5), 0.05); // (9.2)
    }
}

TEST(SplatRenderer, EqualsTheFormulaInDoublePrecision) {
    const SplatCamera camera = turnedCamera({150, 110}, 90);
    for (const int degree : {0, 1, 3})
        for (const bool isAntialiased : {false, true}) {
            SplatScene scene = randomSplats(400, degree);
            scene.isAntialiased = isAntialiased;
            const SplatRenderer renderer(scene, camera);
            for (const double shift : {-0.3, 0.0, 0.3}) {
                cv::Mat picture;
                renderer.render(shift, 3, picture);
                double largest = 0;
                const cv::Mat slow = slowSplats(scene, camera, shift, 3, renderer.nearest());
                EXPECT_GE(psnrOf(picture, slow, &largest), 55)
                    << "degree " << degree << ", shift " << shift;
                EXPECT_LE(largest, 8);
            }
        }
}

TEST(SplatRenderer, GivesTheSameBytesForAnyNumberOfThreads) {
    const SplatScene scene = randomSplats(2000, 2);
    const SplatCamera camera = turnedCamera({333, 222}, 200);
    const int threads = cv::getNumThreads();
    cv::setNumThreads(1);
    cv::Mat one;
    SplatRenderer(scene, camera).render(0.2, 3, one);
    cv::setNumThreads(3);
    cv::Mat three;
    SplatRenderer(scene, camera).render(0.2, 3, three);
    cv::setNumThreads(threads);
    EXPECT_TRUE(samePicture(three, one));
}

TEST(SplatRenderer, DrawsNothingOfWhatIsBehindOrAtTheCamera) {
    SplatScene scene;
    for (const float z : {-5.0F, -0.01F, 0.0F, 0.01F, 0.1F})
        scene.splats.push_back(splatAt({0, 0, z}, 1, {1, 0, 0}, 1));
    for (int i = 0; i < 9; ++i) // most are far
        scene.splats.push_back(splatAt({0, 0, 10}, 0.1F, {0, 1, 0}, 0.9F));
    const SplatView view = SplatRenderer(scene, cameraOf({51, 51}, 50)).render();
    EXPECT_EQ(view.picture.at<cv::Vec3b>(25, 25)[2], 0);
    EXPECT_GT(view.picture.at<cv::Vec3b>(25, 25)[1], 200);
    EXPECT_NEAR(static_cast<double>(view.distance.at<float>(25, 25)), 10, 1e-4);
}

TEST(SplatRenderer, WithstandsExtremeSplats) {
    SplatScene scene;
    constexpr float kHuge = 4e8F;
    Splat needle = splatAt({0, 0, 3}, 0, {1, 1, 1}, 1);
    needle.radii = {kHuge, 0, 0};
    needle.rotation = {0.9238795F, 0, 0, 0.3826834F}; // 45 degrees
    scene.splats = {needle,
                    splatAt({0, 0, 5}, kHuge, {0, 1, 0}, 1),
                    splatAt({1e14F, -1e14F, 4}, 1, {1, 1, 1}, 1),
                    splatAt({0, 0, 1e14F}, 0, {1, 1, 1}, 1),
                    splatAt({0, 0, 2}, 0, {1, 1, 1}, 0),
                    splatAt({0.1F, 0, 2}, 0.1F, {1e6F, -1e6F, 0}, 1)};
    const SplatCamera camera = cameraOf({64, 64}, 60);
    cv::Mat picture;
    SplatRenderer(scene, camera).render(0.1, kInfinity, picture);
    EXPECT_EQ(picture.size(), camera.size);
    scene.splats = {splatAt({1e14F, 0, 1e-14F}, 0.1F, {1, 1, 1}, 1), // beyond all numbers of px
                    splatAt({0, 0, 1e-20F}, 0.1F, {1, 1, 1}, 1)};
    SplatRenderer(scene, camera).render(1e14, 1e-14, picture);
    scene.splats = {needle}; // on its own: a line of the low-pass's width, nothing beside it
    SplatRenderer(scene, camera).render(0, 3, picture);
    EXPECT_LE(picture.at<cv::Vec3b>(10, 50)[1], 1);
}

TEST(SplatRenderer, QuiltsHoldTheViewsFromTheLeftmostCameraOn) {
    const SplatScene scene = randomSplats(300, 0);
    const SplatRenderer renderer(scene, turnedCamera({40, 30}, 30));
    QuiltLayout layout{2, 2, {40, 30}, 3};
    SplatPlacement placement;
    placement.baseline = 0.4;
    placement.focusDistance = 3;
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(77));
    EXPECT_TRUE(renderQuilt(renderer, placement, layout, quilt));
    for (const int view : {0, 1, 2}) {
        cv::Mat expected;
        renderer.render(0.4 * (view - 1), 3, expected);
        EXPECT_TRUE(samePicture(quilt(layout.tile(view)), expected));
    }
    EXPECT_EQ(cv::norm(quilt(cv::Rect(40, 0, 40, 30))), 0); // no view is there
    EXPECT_FALSE(
        renderQuilt(renderer, placement, layout, quilt, [](int view) { return view < 1; }));
    layout.tileSize = {41, 30};
    EXPECT_EQ(codeOf([&] { renderQuilt(renderer, placement, layout, quilt); }),
              ErrorCode::Mismatch);
}

TEST(SplatRenderer, RefusesWhatMakesNoSense) {
    SplatScene scene = randomSplats(3, 1);
    const SplatCamera good = cameraOf({10, 10}, 10);
    const auto code = [&](const SplatScene& of, const SplatCamera& camera, double shift,
                          double focus) {
        cv::Mat picture;
        return codeOf([&] { SplatRenderer(of, camera).render(shift, focus, picture); });
    };
    constexpr ErrorCode kRefused = ErrorCode::InvalidArgument;
    EXPECT_EQ(code(SplatScene(), good, 0, 1), kRefused);
    EXPECT_EQ(code(scene, cameraOf({0, 10}, 10), 0, 1), kRefused);
    EXPECT_EQ(code(scene, cameraOf({10, 10}, std::nan("")), 0, 1), kRefused);
    EXPECT_EQ(code(scene, good, std::nan(""), 1), kRefused);
    EXPECT_EQ(code(scene, good, 0, 0), kRefused);
    scene.harmonics.pop_back();
    EXPECT_EQ(code(scene, good, 0, 1), kRefused);
    const SplatView view{{}, cv::Mat(10, 10, CV_8UC1, cv::Scalar(1)), {}};
    EXPECT_EQ(codeOf([&] { (void)depthOf(view, {0, 0, 0, 0, 1, 2}); }), kRefused);
    const SplatView far{{}, cv::Mat(10, 10, CV_32FC1, cv::Scalar(1)), {}};
    EXPECT_EQ(codeOf([&] { (void)depthOf(far, {}); }), kRefused);
    const QuiltLayout quilt{8, 6, {10, 10}, 48};
    EXPECT_EQ(codeOf([&] { (void)placeSplats(far, cameraOf({10, 10}, 0), quilt); }), kRefused);
    EXPECT_EQ(codeOf([&] { (void)placeSplats(far, good, {8, 6, {-5, -5}, 48}); }), kRefused);
}

// Pictures that another program made of real scenes, with a formula of its own in float64.
TEST(SplatRenderer, AgreesWithAnIndependentReference) {
    ALTIRO3D_REQUIRE_DATA("splats/oracle");
    const std::filesystem::path oracle = dataPath("splats/oracle");
    const std::pair<const char*, const char*> scenes[] = {{"playbot", "playbot_lod4_sh2.ply"},
                                                          {"plant", "lastchance.splat"}};
    for (const auto& [name, file] : scenes) {
        const SplatScene scene = readSplats(dataPath("splats") / file);
        const auto facts =
            nlohmann::json::parse(readFile(oracle / (std::string(name) + ".json"), 1 << 20));
        for (const nlohmann::json& one : facts.at("views")) {
            const auto number = [&](const char* key) { return one.at(key).get<double>(); };
            SplatCamera camera = cameraOf({one.at("W").get<int>(), one.at("H").get<int>()}, 1);
            camera.intrinsics = {number("fx"), number("fy"), number("cx"), number("cy")};
            for (int r = 0; r < 3; ++r) {
                const auto row = static_cast<std::size_t>(r);
                camera.eye[r] = one.at("C").at(row).get<double>();
                for (int c = 0; c < 3; ++c)
                    camera.axes(r, c) =
                        one.at("R").at(row).at(static_cast<std::size_t>(c)).get<double>();
            }
            cv::Mat picture;
            SplatRenderer(scene, camera).render(number("shift"), number("zf"), picture);
            double largest = 0;
            const auto expected = oracle / one.at("file").get<std::string>();
            EXPECT_GE(psnrOf(picture, readImage(expected), &largest), 45) << expected;
            EXPECT_LE(largest, 32) << expected;
        }
    }
}

TEST(SplatPlacement, MovesNearAndFarByTheStrength) {
    SplatView view;
    view.distance = cv::Mat(30, 30, CV_32FC1, cv::Scalar(4));
    view.distance.rowRange(0, 6) = 2;
    view.distance.rowRange(24, 30) = 8;
    const SplatCamera camera = cameraOf({300, 300}, 400);
    QuiltLayout quilt{8, 6, {300, 300}, 48};
    const SplatPlacement placed = placeSplats(view, camera, quilt, std::nullopt, 10);
    EXPECT_NEAR(placed.zNear, 2, 1e-9);
    EXPECT_NEAR(placed.zFar, 8, 1e-9);
    EXPECT_NEAR(placed.focusDistance, 4, 1e-9); // the middle third
    EXPECT_NEAR(placed.focus, (1 / 4.0 - 1 / 8.0) / (1 / 2.0 - 1 / 8.0), 1e-9);
    // parallax of near against far between the outermost views, % of the width
    EXPECT_NEAR(2 * 400 * placed.baseline * (1 / 2.0 - 1 / 8.0) / 300, 0.10, 1e-9);
    EXPECT_EQ(placeSplats(view, camera, quilt, 0.5, 0).baseline, 0);
    EXPECT_NEAR(placeSplats(view, camera, quilt, 0.5).strengthPercent, 10, 1e-9); // as for photos
    EXPECT_NEAR(static_cast<double>(depthOf(view, placed).at<float>(0, 0)), 1, 1e-6);
    EXPECT_NEAR(static_cast<double>(depthOf(view, placed).at<float>(29, 0)), 0, 1e-6);
    view.distance = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(codeOf([&] { (void)placeSplats(view, camera, quilt); }), ErrorCode::InvalidArgument);
    view.distance = 3;
    EXPECT_EQ(placeSplats(view, camera, quilt).baseline, 0); // flat
}

namespace {

// A photo with fine texture whose middle stands in front.
Scene steppedScene(cv::Size size) {
    Scene scene;
    scene.photo = (randomPhoto(size, 5, 2) - cv::Scalar::all(100)) * 4;
    scene.depth = cv::Mat(size, CV_32FC1, cv::Scalar(0.2));
    scene.depth(cv::Rect(size.width / 3, size.height / 4, size.width / 3, size.height / 2)) = 0.8;
    for (int y = size.height - 20; y < size.height; ++y) // a slope
        scene.depth.row(y) = 0.2 + 0.03 * (y - size.height + 20);
    return scene;
}

// How the views of photos, made of their splats, compare with those of Layered: the mean of the
// PSNR in the middle and at the outermost views, and the least opacity.
struct Loop {
    double middle = 0;
    double outer = 0;
    double alpha = 1;
};
Loop loopOf(const Scene& fitted, const ViewOptions& options) {
    PhotoSplatOptions how;
    how.focus = options.focus;
    const SplatScene scene = splatsOf(fitted, how);
    const SplatCamera& camera = *scene.camera;
    // cameras that move depth 0 and 1 as the views do: depth is 100 (1 / z - 1 / 100) / 9
    const double perDepth = camera.intrinsics.fx * 0.09;
    const double width = shownColumns(fitted).size();
    const double baseline = options.strengthPercent / 100 * width / 2 / perDepth;
    const SplatRenderer renderer(scene, camera);
    QuiltLayout layout{3, 1, {shownColumns(fitted).size(), fitted.photo.rows}, 3};
    const Depth2Quilt layered(layout, options);
    Loop loop;
    for (const int position : {-1, 0, 1}) {
        cv::Mat expected;
        cv::Mat picture;
        layered.renderView(fitted, position, expected);
        renderer.render(position * baseline, scene.focusDistance, picture);
        expected.convertTo(expected, CV_32F);
        const double footprint = std::sqrt(how.radius * how.radius + 0.3); // with the low-pass
        cv::GaussianBlur(expected, expected, {0, 0}, footprint);
        const double psnr = psnrOf(picture.colRange(shownColumns(fitted)), expected);
        (position == 0 ? loop.middle : loop.outer) += position == 0 ? psnr : psnr / 2;
        SplatCamera moved = camera; // which tells the opacity of this view
        moved.eye[0] += position * baseline;
        moved.intrinsics.cx += camera.intrinsics.fx * position * baseline / scene.focusDistance;
        double least = 0;
        cv::minMaxLoc(SplatRenderer(scene, moved).render().alpha.colRange(shownColumns(fitted)),
                      &least);
        loop.alpha = std::min(loop.alpha, least);
    }
    return loop;
}

} // namespace

TEST(SplatsOfPhotos, ShowWhatTheViewsOfLayeredShow) {
    const Loop loop = loopOf(steppedScene({160, 120}), ViewOptions());
    EXPECT_GE(loop.middle, 28); // finer texture than photos have
    EXPECT_GE(loop.outer, 26);
    EXPECT_GE(loop.alpha, 0.98);
}

TEST(SplatsOfPhotos, ShowPhotosAsLayeredDoes) {
    ALTIRO3D_TAKES(5);
    ALTIRO3D_REQUIRE_DATA("photos");
    const auto source = estimatedDepth();
    PlacementOptions options;
    Loop mean;
    const char* const photos[] = {"skimage/astronaut.png", "skimage/chelsea.png",
                                  "skimage/coffee.png",    "kodak/kodim04.png",
                                  "kodak/kodim19.png",     "kodak/kodim23.png"};
    for (const char* const photo : photos) {
        Scene scene;
        source->readScene(readPhoto(dataPath("photos") / photo), 0.5, scene);
        const Loop loop = loopOf(placeScene(scene, 0.75, {420, 560}, options).scene, options.views);
        mean.middle += loop.middle / std::size(photos);
        mean.outer += loop.outer / std::size(photos);
        EXPECT_GE(loop.alpha, 0.979) << photo; // of 2.8 million px one has less than 0.98
    }
    EXPECT_GE(mean.middle, 31);
    EXPECT_GE(mean.outer, 27);
}

TEST(SplatsOfPhotos, PhotosOfOneDepthAreFlatAndRowsOfPxAreTheirColours) {
    Scene scene = steppedScene({40, 30});
    scene.depth = 0.5;
    const SplatScene splats = splatsOf(scene);
    ASSERT_EQ(splats.splats.size(), 1280U) << "one for each px, and the outermost rows once more";
    for (const Splat& splat : splats.splats) {
        EXPECT_NEAR(splat.centre[2], splats.focusDistance, 1e-4);
        EXPECT_NEAR(splat.radii[0], splat.radii[1], 1e-5F);
        EXPECT_LT(splat.radii[2], splat.radii[1]);
    }
    EXPECT_NEAR(splats.splats[81].colour[0], scene.photo.at<cv::Vec3b>(1, 1)[2] / 255.0, 1e-6);
    scene.depth = std::nanf("");
    EXPECT_FALSE(splatsOf(scene).splats.empty()); // NaN counts as 0
    EXPECT_EQ(codeOf([] { (void)splatsOf(Scene()); }), ErrorCode::InvalidArgument);
    EXPECT_EQ(codeOf([&] {
                  (void)splatsOf(scene, {0, 0.4, 0.5, 20});
              }),
              ErrorCode::InvalidArgument);
    scene.depth = 0.5;
    scene.mixedPixels = 8;
    EXPECT_EQ(codeOf([&] { (void)splatsOf(scene); }), ErrorCode::InvalidArgument);
    scene.mixedPixels = 0;
    scene.hidden.photo = scene.photo;
    EXPECT_EQ(codeOf([&] { (void)splatsOf(scene); }), ErrorCode::InvalidArgument);
    scene.hidden = {scene.photo.rowRange(0, 20), scene.depth.rowRange(0, 20)};
    EXPECT_EQ(codeOf([&] { (void)splatsOf(scene); }), ErrorCode::Mismatch);
}

} // namespace altiro3D::test
