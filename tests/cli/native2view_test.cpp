#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"

#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTool = "native2view";

// A studio with native.png, made of its quilt of 3 columns x 2 rows.
class ViewStudio : public SmallStudio {
  public:
    ViewStudio() { writeImage(*this / "native.png", native()); }
    cv::Mat native() const { return libraryNative(*this, readBack(*this / "quilt.png"), 3, 2); }
    Calibration calibration() const { return readCalibration(*this / "small.json"); }
    Outcome see(const Arguments& arguments) const {
        return run(kTool, Arguments("-c small.json -q 2x3") + arguments);
    }
    cv::Mat seen(const LensEye& eye) const {
        cv::Mat picture;
        simulateView(native(), calibration(), eye, picture);
        return picture;
    }
};

} // namespace

TEST(Native2ViewTool, GivesTheViewOfTheLibrary) {
    const ViewStudio studio;
    EXPECT_TRUE(isDone(studio.see("native.png ahead.png")));
    EXPECT_TRUE(samePicture(readBack(studio / "ahead.png"), studio.seen({0.5, 0})));
    EXPECT_TRUE(isDone(studio.see("--angle -13.5 native.png left.png")));
    EXPECT_TRUE(samePicture(readBack(studio / "left.png"),
                            studio.seen(eyeAtAngle(studio.calibration(), -13.5))));
    EXPECT_TRUE(
        says(studio.see("--view 4 native.png four.png"), "\nfour.png: 1 view, 96 x 128 px\n"));
    EXPECT_TRUE(samePicture(readBack(studio / "four.png"), studio.seen(eyeAtView(4, 6))));
}

TEST(Native2ViewTool, ShowsWhatAnEyeSeesAtADistance) {
    const ViewStudio studio;
    const double pixels = 3 * studio.calibration().DPI / 324; // at 50 cm
    EXPECT_TRUE(isDone(studio.see("--eye native.png eye.png")));
    EXPECT_TRUE(samePicture(readBack(studio / "eye.png"), studio.seen({0.5, 0, pixels})));
    EXPECT_TRUE(isDone(studio.see("--eye --distance 25 --view 4 native.png near.png")));
    EXPECT_TRUE(
        samePicture(readBack(studio / "near.png"), studio.seen({4.5 / 6, 1.0 / 6, pixels / 2})));
    EXPECT_TRUE(fails(studio.see("--distance 25 native.png a.png"), 2, "--eye"));
    EXPECT_TRUE(fails(studio.see("--eye --distance 9 native.png a.png"), 2, "10..1000"));
}

TEST(Native2ViewTool, PutsSeveralViewsIntoADirectory) {
    const ViewStudio studio;
    EXPECT_TRUE(says(studio.see("--view 5,0 -r 64x48 native.png views2"),
                     "\nviews2: 2 views, 48 x 64 px each\n"));
    EXPECT_EQ(readBack(studio / "views2/view_5.png").size(), cv::Size(48, 64));
    EXPECT_TRUE(fs::exists(studio / "views2/view_0.png"));
    EXPECT_FALSE(fs::exists(studio / "views2/view_1.png"));
    EXPECT_TRUE(isDone(studio.see("--view all native.png views3")));
    for (int i = 0; i < 6; ++i) {
        EXPECT_TRUE(samePicture(readBack(studio / ("views3/view_" + std::to_string(i) + ".png")),
                                studio.seen(eyeAtView(i, 6))));
    }
}

// There and back: the quilt of what is seen gives the Native again, where nothing is resized.
TEST(Native2ViewTool, TheQuiltOfViewsAtThePanelsSizeGivesTheNativeBack) {
    const ViewStudio studio;
    EXPECT_TRUE(isDone(studio.see("-r 128x96 --quilt-out native.png seen.png")));
    const fs::path quilt = studio / "seen_qs3x2a0.75.png";
    ASSERT_TRUE(fs::exists(quilt));
    EXPECT_TRUE(isDone(studio.run("quilt2native", "-c small.json seen_qs3x2a0.75.png again.png")));
    EXPECT_TRUE(samePicture(readBack(studio / "again.png"), studio.native()));
}

TEST(Native2ViewTool, WrongCallsAreNamed) {
    const ViewStudio studio;
    EXPECT_TRUE(fails(studio.see("--view 6 native.png a.png"), 2, "expected 0..5"));
    EXPECT_TRUE(fails(studio.see("--view 1,1 native.png a"), 2, "view 1 twice"));
    EXPECT_TRUE(fails(studio.see("--view 1,x native.png a"), 2, "view x"));
    EXPECT_TRUE(fails(studio.see("--view 1,2 native.png a.png"), 2, "a directory"));
    EXPECT_TRUE(fails(studio.see("--angle 91 native.png a.png"), 2, "-90..90"));
    EXPECT_TRUE(fails(studio.see("--angle 1 --view 1 native.png a.png"), 2, "--angle"));
    EXPECT_TRUE(isDone(studio.see("--angle 20 native.png at-the-end.png")));
    EXPECT_TRUE(
        warns(studio.see("--angle -21 native.png behind.png"), "fill 20.0 degrees to each side"));
    EXPECT_TRUE(fails(studio.see("native.png"), 2, "expected NATIVE and OUT"));
    EXPECT_TRUE(fails(studio.see("quilt.png a.png"), 1,
                      "quilt.png: has 90 x 80 px, expected a Native of the panel's 96 x 128 px "
                      "(small.json; -c gives another)"));
    EXPECT_TRUE(fails(studio.see("native.png native.png"), 2, "is also an input"));
    studio.makeMap();
    EXPECT_TRUE(fails(studio.run(kTool, "-m a.map native.png a.png"), 2, "-c"));
    EXPECT_FALSE(fs::exists(studio / "a.png"));
}

} // namespace altiro3D::test
