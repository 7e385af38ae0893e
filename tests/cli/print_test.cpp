#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/print_sheet.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"

#include <csignal>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

// Its picture is 354 x 236 px; with bleed and marks 708 x 661 px.
constexpr const char* kLens = "lpi=37.5,dpi=300,size=30x20mm,thickness=0.5,index=1.5";

} // namespace

/// Prints for a small sheet of lenses.
class Print : public StudioTest {
  protected:
    Print() : StudioTest("photo2native") {
        lens("lens.json", kLens);
        writeImage(studio_ / "p.png", randomPhoto({60, 40}));
        writeImage(studio_ / "d.png", randomPicture({60, 40}, CV_8UC1));
    }
    void lens(const std::string& file, const std::string& numbers) const {
        EXPECT_TRUE(isDone(studio_.run("altiro3Dnative", {"--lens", numbers, file})));
    }
};

TEST_F(Print, APhotoBecomesAPrintOfExactSize) {
    const PrintSheet sheet(readDisplay(studio_ / "lens.json"), {});
    const Outcome made = run("--print -c lens.json -d p.png d.png a.png");
    EXPECT_TRUE(isDone(made));
    EXPECT_TRUE(says(made, "to be cut to 30.0 x 20.0 mm"));
    const cv::Mat print = readBack(studio_ / "a.png");
    EXPECT_EQ(print.size(), sheet.size());
    EXPECT_TRUE(isDone(run("--print -c lens.json -d p.png d.png a.tif")));
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.tif"), print));
    EXPECT_TRUE(isDone(run("--print -c lens.json -d p.png d.png a.pdf")));
    EXPECT_EQ(slurp(studio_ / "a.pdf").substr(0, 5), "%PDF-");
    EXPECT_TRUE(isDone(run("--print --bleed 0 --no-marks -c lens.json -d p.png d.png b.png")));
    EXPECT_EQ(readBack(studio_ / "b.png").size(), cv::Size(354, 236));
}

// A print without anything around it is the Native of its calibration.
TEST_F(Print, ThePictureIsTheNative) {
    EXPECT_TRUE(isDone(run("--print --bleed 0 --no-marks --strength 7 -c lens.json -d p.png d.png "
                           "print.png")));
    EXPECT_TRUE(isDone(run("--strength 7 -c lens.json -d p.png d.png native.png")));
    EXPECT_TRUE(samePicture(readBack(studio_ / "print.png"), readBack(studio_ / "native.png")));
}

TEST_F(Print, StrengthIsWhatTheSheetShowsWithoutBlur) {
    lens("large.json", "lpi=37.5,dpi=300,size=150x100mm,thickness=0.5,index=1.5");
    // 2 * 8 views * .5 mm / 1.5 = 5.3 mm
    const Outcome limited = run("--print -c large.json -d p.png d.png a.png");
    EXPECT_TRUE(says(limited, "strength: at most"));
    EXPECT_TRUE(says(limited, "the 5.3 mm of depth that the sheet shows without blur"));
    EXPECT_FALSE(
        says(run("--print --strength 9 -y -c large.json -d p.png d.png a.png"), "without blur"));
}

TEST_F(Print, AnAutomaticStrengthIsLimitedByTheSheetToo) {
    lens("large.json", "lpi=37.5,dpi=300,size=300x200mm,thickness=0.5,index=1.5");
    cv::Mat slope(40, 60, CV_8UC1);
    for (int y = 0; y < slope.rows; ++y)
        slope.row(y).setTo(6 * y);
    writeImage(studio_ / "slope.png", slope);
    const auto strength = [&](const Arguments& more) {
        EXPECT_TRUE(isDone(run(
            more + "--strength auto --report r.json -y -c large.json -d p.png slope.png a.png")));
        return studio_.json("r.json")["pictures"][0]["strengthPercent"].get<double>();
    };
    const double limit = 200.0 * 8 * 25.4 / 37.5 / 310; // two lenses a view, 310 mm with its bleed
    EXPECT_GT(strength({}), limit + 1);
    EXPECT_NEAR(strength("--print"), limit, 0.01);
}

TEST_F(Print, AFlipShowsOnePictureAfterTheOther) {
    const cv::Size size(30, 20);
    writeImage(studio_ / "red.png", cv::Mat(size, CV_8UC3, cv::Scalar(0, 0, 200)));
    writeImage(studio_ / "blue.png", cv::Mat(cv::Size(60, 40), CV_8UC3, cv::Scalar(200, 0, 0)));
    EXPECT_TRUE(isDone(studio_.run("views2native",
                                   "--print --bleed 0 --no-marks --flip hard -c lens.json red.png "
                                   "blue.png flip.png")));
    EXPECT_TRUE(isDone(studio_.run("native2view", "-c lens.json --view all flip.png seen")));
    for (int view = 0; view < 8; ++view) {
        const cv::Scalar colour = view < 4 ? cv::Scalar(0, 0, 200) : cv::Scalar(200, 0, 0);
        EXPECT_TRUE(
            samePicture(readBack(studio_ / "seen" / ("view_" + std::to_string(view) + ".png")),
                        cv::Mat(236, 354, CV_8UC3, colour)))
            << view;
    }
    EXPECT_TRUE(isDone(studio_.run("views2native",
                                   "--print --bleed 0 --no-marks --flip soft -c lens.json red.png "
                                   "blue.png soft.png")));
    EXPECT_TRUE(isDone(studio_.run("native2view", "-c lens.json --view 3,4 soft.png between")));
    // 3/8 of the way, and 5/8
    EXPECT_NEAR(readBack(studio_ / "between/view_3.png").at<cv::Vec3b>(9, 9)[2], 150, 1);
    EXPECT_NEAR(readBack(studio_ / "between/view_3.png").at<cv::Vec3b>(9, 9)[0], 50, 1);
    EXPECT_NEAR(readBack(studio_ / "between/view_4.png").at<cv::Vec3b>(9, 9)[2], 50, 1);
    EXPECT_TRUE(isDone(
        studio_.run("quilt2native", "--print --fit stretch -c lens.json -q 2x3 quilt.png q.tif")));
    EXPECT_EQ(readBack(studio_ / "q.tif").size(), cv::Size(708, 661));
}

TEST_F(Print, APitchSheetIsMade) {
    EXPECT_TRUE(isDone(studio_.run("altiro3Dnative", {"--lens", kLens, "--pitch-sheet", "a.png",
                                                      "--around", "37.6", "--step", "0.1"})));
    EXPECT_EQ(readBack(studio_ / "a.png").size(), cv::Size(354, 236));
    EXPECT_TRUE(
        fails(studio_.run("altiro3Dnative", "--around 3 small.json"), 2, "expected --lens"));
    EXPECT_TRUE(fails(studio_.run("altiro3Dnative", {"--lens", kLens, "--around", "3", "b.json"}),
                      2, "expected --pitch-sheet"));
    // ten steps of .075 LPI over 30 mm
    EXPECT_TRUE(holds(studio_
                          .run("altiro3Dnative",
                               {"--lens", "lpi=60,dpi=720,size=30x20mm", "--pitch-sheet", "c.png"})
                          .err,
                      "by only 0.89 of a lens over the width"));
}

TEST_F(Print, LyingLensesAreTold) {
    lens("lying.json", "lpi=37.5,dpi=300,size=30x20mm,horizontal=yes");
    EXPECT_TRUE(holds(run("--print -c lying.json -d p.png d.png a.png").err, "has no depth"));
    const Outcome info = studio_.run("altiro3Dnative", "--info lying.json");
    EXPECT_TRUE(holds(info.out, "lens          8 px down; the lenses lie"));
    EXPECT_FALSE(holds(info.out, "one lens"));
}

TEST_F(Print, ASignalEndsAPrintAndKeepsTheOldFile) {
    lens("huge.json", "lpi=37.5,dpi=1440,size=600x600mm"); // seconds of work
    writeFile(studio_ / "a.png", "old");
    const Outcome stopped = studio_.run(
        "photo2native", "--print -y --save-depth depth.png -c huge.json -d p.png d.png a.png",
        SIGINT, [&] { return fs::exists(studio_ / "depth.png"); }); // the print follows it
    EXPECT_EQ(stopped.status, 130) << stopped.text();
    EXPECT_TRUE(slurp(studio_ / "a.png") == "old"); // else it has some 300 MB
}

TEST_F(Print, WhatIsNoPrintIsNamed) {
    EXPECT_TRUE(holds(run("--print -c small.json -d p.png d.png a.png").err,
                      "--print: small.json is the calibration of a display, expected that of a "
                      "print with -c; altiro3Dnative --lens makes it"));
    EXPECT_TRUE(says(run("--strength 7 -c lens.json -d p.png d.png native.png"),
                     "the calibration is that of a print: with --print"));
    EXPECT_TRUE(holds(run({"--print", "--print-text", "für Ü", "-c", "lens.json", "-d", "p.png",
                           "d.png", "a.png"})
                          .err,
                      "text: is too long or has other characters than those of ASCII"));
    EXPECT_TRUE(fails(studio_.run("views2native", "--flip hard -c lens.json p.png f.png"), 2,
                      "--flip shows several pictures"));
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

TEST_F(Print, ScreensInSubpixelsHaveAFileOfNumbers) {
    lens("barrier.json", "panel=64x48,pitch=4.6667,slope=+1,order=3:1:2:0");
    EXPECT_TRUE(holds(studio_.run("altiro3Dnative", "--info barrier.json").out,
                      "lens numbers  pitch 4.6667, slope 1, offset 0 sub-pixels, order 3:1:2:0"));
    EXPECT_EQ(run("-c barrier.json -d p.png d.png screen.png").status, 0);
    spill(studio_ / "c1.json", R"({"lineNumber":19.6138,"obliquity":0.09878,"deviation":-1.95})");
    const Outcome info = studio_.run("altiro3Dnative", "--info c1.json");
    EXPECT_TRUE(holds(info.out, "CubeVi C1"));
    EXPECT_TRUE(holds(info.out, "lineNumber 19.6138, obliquity 0.09878, deviation -1.95"));
}

} // namespace altiro3D::test
