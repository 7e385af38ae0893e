#include "altiro3D/lens_sheet.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"

#include <opencv2/core.hpp>

/// The shader of `altiro3Dnative --mpv-shader`, run by a software Vulkan and OpenGL of Mesa.
namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTool = "altiro3Dnative";

// The driver of Vulkan in software; empty if there is none.
std::string softwareVulkan() {
    std::error_code error;
    for (const fs::directory_entry& entry :
         fs::directory_iterator("/usr/share/vulkan/icd.d", error))
        if (entry.path().filename().string().rfind("lvp_icd", 0) == 0) return entry.path();
    return {};
}

// Mean and share of what differs: a few sub-pixels may take another view.
void expectAlike(const cv::Mat& shown, const cv::Mat& native, double tolerance) {
    const Difference difference = compare(shown, native, tolerance);
    ASSERT_TRUE(difference.sameShape) << difference.report;
    EXPECT_LT(difference.count, difference.samples / 1000) << difference.report;
}

} // namespace

class QuiltShaderRun : public StudioTest {
  protected:
    QuiltShaderRun() : StudioTest(kTool) {
        studio_.set("VK_ICD_FILENAMES", softwareVulkan());
        studio_.set("PATH", "/usr/bin:/bin");
    }

    bool hasPlacebo() const {
        return !softwareVulkan().empty() && fs::exists("/usr/bin/ffmpeg") &&
               holds(studio_.run("/usr/bin/ffmpeg", "-v error -filters").out, " libplacebo ");
    }

    // Renders quilt.png by the shader with FFmpeg's libplacebo.
    cv::Mat shownByPlacebo(cv::Size panel) {
        const std::string filter =
            "format=rgba,hwupload,libplacebo=w=" + std::to_string(panel.width) +
            ":h=" + std::to_string(panel.height) +
            ":dithering=-1:custom_shader_path=s.glsl,hwdownload,format=rgba";
        const Outcome run =
            studio_.run("/usr/bin/ffmpeg",
                        {"-v", "error", "-y", "-init_hw_device", "vulkan=vk:0", "-filter_hw_device",
                         "vk", "-i", "quilt.png", "-vf", filter, "-frames:v", "1", "-update", "1",
                         "-pix_fmt", "rgb24", "shown.png"});
        EXPECT_EQ(run.status, 0) << run.text();
        return readBack(studio_ / "shown.png");
    }
};

TEST_F(QuiltShaderRun, PlaceboShowsTheNativeOfQuilt2Native) {
    if (!hasPlacebo()) GTEST_SKIP() << "needs ffmpeg with libplacebo, and lavapipe";
    std::vector<Calibration> panels{stripePanel(96, 128)};
    for (double Calibration::*flag : {&Calibration::flipImageX, &Calibration::flipImageY,
                                      &Calibration::flipSubp, &Calibration::invView}) {
        panels.push_back(stripePanel(95, 127));
        panels.back().*flag = flag == &Calibration::invView ? 0 : 1;
    }
    for (int pattern = 0; pattern <= 4; ++pattern) {
        panels.push_back(stripePanel(128, 96));
        panels.back().subpixelCells = deltaCells();
        panels.back().CellPatternMode = pattern;
    }
    const cv::Mat quilt = readBack(studio_ / "quilt.png");
    for (const Calibration& panel : panels) {
        SCOPED_TRACE(std::to_string(&panel - panels.data()));
        spill(studio_ / "small.json", calibrationText(panel));
        const cv::Size size(panel.screenW, panel.screenH);
        ASSERT_EQ(run("-y --mpv-shader s.glsl --sampling nearest -q 2x3 small.json").status, 0);
        expectAlike(
            shownByPlacebo(size),
            libraryNative(studio_, quilt, 3, 2, {ViewFilter::Nearest, TileSampling::Nearest}), 0);
        if (panel.screenW == 95) continue; // for the time that it takes
        ASSERT_EQ(run("-y --mpv-shader s.glsl --view-filter linear -q 2x3 small.json").status, 0);
        // cards blend with eight bits of weight
        expectAlike(shownByPlacebo(size),
                    libraryNative(studio_, quilt, 3, 2, {ViewFilter::Linear, TileSampling::Linear}),
                    2);
    }
}

TEST_F(QuiltShaderRun, PlaceboShowsARealPanelFromAQuiltOfFractionalViews) {
    if (!hasPlacebo()) GTEST_SKIP() << "needs ffmpeg with libplacebo, and lavapipe";
    fs::copy_file(sourcePath("calibration/portrait-sample.json"), studio_ / "small.json",
                  fs::copy_options::overwrite_existing);
    cv::Mat quilt(6 * 84, 8 * 63 + 3, CV_8UC3); // views of 63.4 px
    for (int y = 0; y < quilt.rows; ++y)
        for (int x = 0; x < quilt.cols; ++x)
            quilt.at<cv::Vec3b>(y, x) = cv::Vec3b::all(static_cast<uchar>(x * 8 / quilt.cols * 30));
    writeImage(studio_ / "quilt.png", quilt);
    ASSERT_TRUE(isDone(run("--mpv-shader s.glsl --sampling nearest small.json")));
    expectAlike(shownByPlacebo({1536, 2048}),
                libraryNative(studio_, quilt, 8, 6, {ViewFilter::Nearest, TileSampling::Nearest}),
                0);
}

TEST_F(QuiltShaderRun, MpvShowsTheNativeOfQuilt2Native) {
    for (const char* program : {"/usr/bin/mpv", "/usr/bin/xvfb-run", "/usr/bin/xauth"})
        if (!fs::exists(program)) GTEST_SKIP() << "needs " << program;
    ASSERT_TRUE(isDone(run("--mpv-shader s.glsl --sampling nearest -q 2x3 small.json")));
    spill(studio_ / "shot.lua", "mp.register_event('playback-restart', function()\n"
                                "  mp.add_timeout(0.3, function()\n"
                                "    mp.commandv('screenshot-to-file', 'shown.png', 'window')\n"
                                "    mp.command('quit')\n"
                                "  end)\n"
                                "end)\n");
    const Outcome shown = studio_.run("/usr/bin/xvfb-run", {"-a",
                                                            "-s",
                                                            "-screen 0 400x300x24",
                                                            "/usr/bin/mpv",
                                                            "--no-config",
                                                            "--vo=gpu",
                                                            "--gpu-sw=yes",
                                                            "--gpu-api=opengl",
                                                            "--gpu-context=x11egl",
                                                            "--osc=no",
                                                            "--osd-level=0",
                                                            "--no-border",
                                                            "--geometry=96x128+0+0",
                                                            "--no-keepaspect",
                                                            "--pause",
                                                            "--keep-open=yes",
                                                            "--image-display-duration=inf",
                                                            "--dither-depth=no",
                                                            "--screenshot-format=png",
                                                            "--glsl-shader=s.glsl",
                                                            "--script=shot.lua",
                                                            "--",
                                                            "quilt.png"});
    if (!fs::exists(studio_ / "shown.png") && holds(shown.out + shown.err, "context"))
        GTEST_SKIP() << "needs OpenGL in software: " << shown.text();
    ASSERT_TRUE(fs::exists(studio_ / "shown.png")) << shown.text();
    expectAlike(readBack(studio_ / "shown.png"),
                libraryNative(studio_, readBack(studio_ / "quilt.png"), 3, 2,
                              {ViewFilter::Nearest, TileSampling::Nearest}),
                0);
}

TEST_F(QuiltShaderRun, TheShaderHasNoOtherOutputs) {
    EXPECT_TRUE(fails(run("--mpv-shader s.glsl -m a.map small.json"), 2, "--mpv-shader"));
    EXPECT_TRUE(fails(run("--sampling linear small.json"), 2, "applies to --mpv-shader"));
    EXPECT_TRUE(says(run("--mpv-shader s.glsl -q 2x3 small.json"), "s.glsl: shader"));
    EXPECT_TRUE(fails(run("--mpv-shader s.glsl -q 2x3 small.json"), 1, "exists"));
}

} // namespace altiro3D::test
