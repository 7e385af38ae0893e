#include "altiro3D/splats.hpp"

#include "altiro3D/quilt2native.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

class Splat2Native : public StudioTest {
  protected:
    Splat2Native() : StudioTest("splat2native") { studio_.makeScan(); }
    Outcome convert(const Arguments& arguments) const { return run(studio_.display() + arguments); }
};

} // namespace

TEST_F(Splat2Native, MakesWhatTheLibraryMakes) {
    EXPECT_TRUE(isDone(
        convert("--save-quilt quilt.png --save-views v --save-depth d.png --view-filter nearest "
                "--sampling nearest scan.ply n.png")));
    const SplatScene scene = readSplats(studio_ / "scan.ply");
    const QuiltLayout layout = smallLayout();
    const SplatCamera camera = chooseSplatCamera(scene, layout.tileSize, 0.75).camera;
    const SplatRenderer renderer(scene, camera);
    const SplatPlacement placed = placeSplats(renderer.render(), camera, layout);
    cv::Mat quilt;
    renderQuilt(renderer, placed, layout, quilt);
    EXPECT_TRUE(samePicture(readBack(studio_ / "quilt_qs3x2a0.75.png"), quilt));
    EXPECT_TRUE(samePicture(readBack(studio_ / "v/view_4.png"), quilt(layout.tile(4))));
    const Calibration calibration = readCalibration(studio_ / "small.json");
    cv::Mat native;
    Quilt2Native(calibration, layout, {}).render(filterForLens(quilt, layout, calibration), native);
    EXPECT_TRUE(samePicture(readBack(studio_ / "n.png"), native));
    EXPECT_EQ(readBack(studio_ / "d.png").type(), CV_16UC1);
}

TEST_F(Splat2Native, OptionsMoveTheCamera) {
    const auto viewsOf = [&](const Arguments& options) {
        EXPECT_TRUE(isDone(convert(options + Arguments("-y --save-views v scan.ply n.png"))));
        return std::pair(readBack(studio_ / "v/view_0.png"), readBack(studio_ / "v/view_5.png"));
    };
    const auto [left, right] = viewsOf("");
    EXPECT_FALSE(samePicture(left, right));
    const auto [flatLeft, flatRight] = viewsOf("--strength 0");
    EXPECT_TRUE(samePicture(flatLeft, flatRight)); // all views are the middle one
    for (const char* const option : {"--yaw 90", "--tilt 30", "--view-angle 40", "--splat-axes rub",
                                     "--camera-position 1,2,-9", "--up 1,0,0", "--look-at 1,0,0"})
        EXPECT_FALSE(
            samePicture(viewsOf(Arguments(option) + Arguments("--strength 0")).first, flatLeft))
            << option;
    EXPECT_FALSE(samePicture(viewsOf("--focus 0").first, left));
}

TEST_F(Splat2Native, AGoGetsOneSceneToo) {
    EXPECT_TRUE(isDone(studio_.run("splat2native", "--go go scan.ply")));
    EXPECT_FALSE(fs::is_empty(studio_ / "go/LKG/Content/1"));
    EXPECT_TRUE(fails(convert("scan.ply -"), 2, "expected the name of a file"));
}

TEST_F(Splat2Native, ASceneWhoseNativeExistsIsSkipped) {
    spill(studio_ / "n.png", "an older one");
    EXPECT_TRUE(holds(convert("--skip-existing scan.ply n.png").out, "skipped, as n.png exists"));
    EXPECT_EQ(slurp(studio_ / "n.png"), "an older one");
}

TEST_F(Splat2Native, FoldersAreConvertedAndReported) {
    fs::create_directory(studio_ / "scans");
    fs::copy(studio_ / "scan.ply", studio_ / "scans/b.ply");
    fs::copy(studio_ / "photo.png", studio_ / "scans/photo.png");
    spill(studio_ / "scans/a.spz", "broken");
    const Outcome outcome = convert("--report r.json scans out");
    EXPECT_EQ(outcome.status, 1);
    EXPECT_TRUE(holds(outcome.err, "a.spz: is not a scene of splats"));
    EXPECT_TRUE(fs::exists(studio_ / "out/b_native.png"));
    EXPECT_TRUE(fails(convert("--save-quilt q.png scans out2"), 2,
                      "names one file, expected a directory for the outputs of several scenes"));
    const auto report = nlohmann::json::parse(slurp(studio_ / "r.json"));
    EXPECT_EQ(report["scenes"].size(), 2U);
    EXPECT_EQ(report["scenes"][1]["splats"], 64);
    // other tools name the scenes of a folder
    EXPECT_TRUE(
        holds(studio_.run("photo2native", studio_.display() + Arguments("scans more")).text(),
              "scene of splats"));
}

TEST_F(Splat2Native, ASheetAVideoAndPicturesForEyesAreMade) {
    EXPECT_TRUE(isDone(convert("--yaw sheet scan.ply sheet.png")));
    EXPECT_EQ(readBack(studio_ / "sheet.png").size(), cv::Size(4 * 30, 2 * 40));
    EXPECT_TRUE(fails(convert("--yaw sheet scan.ply sheet.png"), 1, "exists, expected a new name"));
    EXPECT_TRUE(isDone(convert("--lg o.mp4 --orbit 40 --seconds 0.2 --turns 1 scan.ply")));
    EXPECT_TRUE(isDone(convert("--save-stereo e_LRF.png scan.ply")));
    EXPECT_TRUE(fails(convert("--yaw sheet --save-quilt q.png scan.ply"), 2, "--save-quilt"));
    EXPECT_TRUE(fails(convert("--orbit 40 scan.ply n.png"), 2, "--orbit is a motion of the video"));
    EXPECT_TRUE(
        fails(convert("--yaw sheet scan.ply scan.ply out"), 2, "--yaw sheet shows one scene"));
    EXPECT_TRUE(
        fails(convert("--up 1,2 scan.ply n.png"), 2, "--up is \"1,2\", expected three numbers"));
}

TEST_F(Splat2Native, PhotosBecomeSplatsAndComeBack) {
    const Outcome outcome =
        studio_.run("photo2native",
                    "-d --save-splats s.ply --splat-camera --splat-side 90 photo.png depth.png");
    EXPECT_TRUE(says(outcome, "; focal length not known, taken as 35 mm on 36 x 24"));
    const SplatScene scene = readSplats(studio_ / "s.ply");
    ASSERT_TRUE(scene.camera);
    EXPECT_EQ(scene.camera->size, cv::Size(68, 90)); // in the photo's own shape
    EXPECT_TRUE(says(convert("s.ply n.png"), "camera: that of the file"));
    EXPECT_TRUE(isDone(studio_.run("photo2native", "-d --save-splats s.spz photo.png depth.png")));
    EXPECT_TRUE(says(convert("-y s.spz n.png"), "camera: at the origin"));
    EXPECT_TRUE(fails(studio_.run("photo2native", "-d --save-splats s.obj photo.png depth.png"), 2,
                      "s.obj: is not the name of splats, expected .ply or .spz"));
    EXPECT_TRUE(fails(studio_.run("photo2native", "-d --splat-side 90 photo.png depth.png n.png"),
                      2, "--splat-side describes saved splats"));
}

} // namespace altiro3D::test
