#include "altiro3D/calibration.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/quilt2native.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"

#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTool = "quilt2native";

} // namespace

TEST(Quilt2NativeTool, GivesTheNativeOfTheLibrary) {
    SmallStudio studio;
    const cv::Mat quilt = readBack(studio / "quilt.png");
    const std::pair<Arguments, QuiltSampling> cases[] = {
        {{}, {}},
        {{"--view-filter", "linear"}, {ViewFilter::Linear, TileSampling::Nearest}},
        {{"--sampling", "linear"}, {ViewFilter::Nearest, TileSampling::Linear}},
        {{"--sampling", "linear", "--view-filter", "linear", "-j", "1"},
         {ViewFilter::Linear, TileSampling::Linear}}};
    for (const auto& [arguments, sampling] : cases) {
        EXPECT_TRUE(isDone(studio.run(kTool, arguments + Arguments{"-y", "-c", "small.json", "-q",
                                                                   "2x3", "quilt.png", "a.png"})));
        EXPECT_TRUE(
            samePicture(readBack(studio / "a.png"), libraryNative(studio, quilt, 3, 2, sampling)));
    }
}

TEST(Quilt2NativeTool, AQuiltOfOneColourPerViewShowsEachViewWhereTheLensSendsIt) {
    SmallStudio studio;
    cv::Mat quilt(80, 90, CV_8UC3);
    for (int i = 0; i < 6; ++i)
        quilt(cv::Rect(i % 3 * 30, (1 - i / 3) * 40, 30, 40)) = cv::Scalar::all(10 + 40 * i);
    writePicture(studio / "views.png", quilt);
    ASSERT_TRUE(isDone(studio.run(kTool, {"-c", "small.json", "-q", "2x3", "views.png", "a.png"})));
    const cv::Mat native = readBack(studio / "a.png");
    const LensGeometry geometry = lensGeometry(readCalibration(studio / "small.json"));
    for (int y = 0; y < native.rows; y += 5) {
        for (int x = 0; x < native.cols; ++x) {
            for (int channel = 0; channel < 3; ++channel) {
                const int view = LensGeometry::viewOfPhase(geometry.phase(x, y, channel), 6);
                ASSERT_EQ(native.at<cv::Vec3b>(y, x)[2 - channel], 10 + 40 * view)
                    << x << " " << y << " " << channel;
            }
        }
    }
}

TEST(Quilt2NativeTool, TheFileNameTellsTheLayout) {
    SmallStudio studio;
    fs::copy(studio / "quilt.png", studio / "q_qs3x2a0.75.png");
    const Outcome outcome = studio.run(kTool, {"-c", "small.json", "q_qs3x2a0.75.png", "a.png"});
    EXPECT_TRUE(isDone(outcome));
    EXPECT_NE(outcome.out.find("3 columns x 2 rows, each view 30 x 40 px"), std::string::npos);
    EXPECT_TRUE(samePicture(readBack(studio / "a.png"),
                            libraryNative(studio, readBack(studio / "quilt.png"), 3, 2)));
    // 2x3 is rows x columns for -q, and 3x2 columns x rows in the name
    EXPECT_TRUE(isDone(
        studio.run(kTool, {"-y", "-c", "small.json", "-q", "2x3", "q_qs3x2a0.75.png", "a.png"})));
    EXPECT_TRUE(fails(
        studio.run(kTool, {"-y", "-c", "small.json", "-q", "3x2", "q_qs3x2a0.75.png", "a.png"}), 1,
        "2 columns x 3 rows"));
    fs::copy(studio / "quilt.png", studio / "q_qs0x2.png");
    EXPECT_TRUE(
        fails(studio.run(kTool, {"-y", "-c", "small.json", "q_qs0x2.png", "a.png"}), 1, "q_qs0x2"));
}

TEST(Quilt2NativeTool, ARestOfPixelsIsCutOffWithANote) {
    SmallStudio studio;
    // as 4096 x 4096 px of 5 columns x 9 rows: tiles of 8 x 5 px in 44 x 50 px
    const cv::Mat quilt = madePhoto(44, 50);
    writePicture(studio / "rest.png", quilt);
    ASSERT_TRUE(isDone(
        studio.run("altiro3Dnative", {"-m", "a.map", "-q", "9x5", "-r", "5x8", "small.json"})));
    EXPECT_TRUE(warns(studio.run(kTool, {"-m", "a.map", "rest.png", "a.png"}), "44 x 50"));
    EXPECT_TRUE(samePicture(readBack(studio / "a.png"), libraryNative(studio, quilt, 5, 9)));
    EXPECT_TRUE(warns(studio.run(kTool, {"-c", "small.json", "-q", "9x5", "rest.png", "b.png"}),
                      "44 x 50"));
    EXPECT_EQ(slurp(studio / "a.png"), slurp(studio / "b.png"));
}

TEST(Quilt2NativeTool, ContradictionsAreErrors) {
    SmallStudio studio;
    EXPECT_TRUE(
        fails(studio.run(kTool, studio.display() + Arguments{"-r", "10x10", "quilt.png", "a.png"}),
              1, "30 x 40"));
    EXPECT_TRUE(
        fails(studio.run(kTool, {"-c", "small.json", "-q", "100x100", "quilt.png", "a.png"}), 1,
              "do not fit"));
}

TEST(Quilt2NativeTool, ViewsOfAnotherShapeAreFittedIfAsked) {
    SmallStudio studio;
    writePicture(studio / "q_qs3x2a1.5.png", cv::Mat(80, 90, CV_8UC3, cv::Scalar::all(200)));
    const auto run = [&](const Arguments& more) {
        return studio.run(kTool,
                          more + Arguments{"-y", "-c", "small.json", "q_qs3x2a1.5.png", "a.png"});
    };
    EXPECT_TRUE(warns(run({}), "another shape"));
    EXPECT_TRUE(isDone(run({"--fit", "cover"})));
    EXPECT_EQ(cv::countNonZero(readBack(studio / "a.png").reshape(1) != 200), 0);
    EXPECT_TRUE(isDone(run({"--fit", "contain"})));
    const cv::Mat bars = readBack(studio / "a.png");
    EXPECT_EQ(bars.at<cv::Vec3b>(2, 48), cv::Vec3b(0, 0, 0));
    EXPECT_EQ(bars.at<cv::Vec3b>(64, 48), cv::Vec3b(200, 200, 200));
    EXPECT_EQ(bars.at<cv::Vec3b>(125, 48), cv::Vec3b(0, 0, 0));
}

} // namespace altiro3D::test
