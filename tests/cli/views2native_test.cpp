#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/random_pictures.hpp"

#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTool = "views2native";

// Pictures of one grey each, numbered without leading zeros: view1.png .. viewN.png.
void writeGreys(const fs::path& directory, int count, cv::Size size = {30, 40}) {
    fs::create_directory(directory);
    for (int i = 0; i < count; ++i) {
        writeImage(directory / ("view" + std::to_string(i + 1) + ".png"),
                   cv::Mat(size, CV_8UC3, cv::Scalar::all(10 + 10 * i)));
    }
}

// The greys of a quilt's tiles from view 0 on.
std::vector<int> greys(const fs::path& quilt, int columns, int rows) {
    const cv::Mat picture = readBack(quilt);
    std::vector<int> result;
    for (int i = 0; i < columns * rows; ++i) {
        const int x = (2 * (i % columns) + 1) * picture.cols / (2 * columns);
        const int y = (2 * (rows - 1 - i / columns) + 1) * picture.rows / (2 * rows);
        result.push_back(picture.at<cv::Vec3b>(y, x)[0]);
    }
    return result;
}

} // namespace

TEST(Views2Native, GivesTheNativeOfTheQuilt) {
    SmallStudio studio;
    EXPECT_TRUE(isDone(studio.run(
        kTool, studio.display() + Arguments{"--save-quilt", "q.png", "views", "a.png"})));
    EXPECT_TRUE(samePicture(readBack(studio / "q_qs3x2a0.75.png"), readBack(studio / "quilt.png")));
    EXPECT_TRUE(isDone(
        studio.run("quilt2native", {"-c", "small.json", "-q", "2x3", "quilt.png", "b.png"})));
    EXPECT_EQ(slurp(studio / "a.png"), slurp(studio / "b.png"));
}

TEST(Views2Native, SortsNumbersByValue) {
    SmallStudio studio;
    writeGreys(studio / "grey", 12);
    spill(studio / "grey/notes.txt", "no view");
    spill(studio / "grey/.hidden.png", "no view");
    const Arguments call{"-c", "small.json",   "-q",    "3x4",  "-r",   "40x30",
                         "-y", "--save-quilt", "q.png", "grey", "a.png"};
    EXPECT_TRUE(isDone(studio.run(kTool, call)));
    std::vector<int> expected;
    for (int i = 0; i < 12; ++i)
        expected.push_back(10 + 10 * i);
    EXPECT_EQ(greys(studio / "q_qs4x3a0.75.png", 4, 3), expected);
    EXPECT_TRUE(isDone(studio.run(kTool, Arguments{"--reverse"} + call)));
    std::reverse(expected.begin(), expected.end());
    EXPECT_EQ(greys(studio / "q_qs4x3a0.75.png", 4, 3), expected);
}

TEST(Views2Native, OtherCountsAreSpreadOverTheViewsWithAWarning) {
    SmallStudio studio;
    const auto viewsOf = [&](int pictures) {
        writeGreys(studio / "grey", pictures);
        EXPECT_TRUE(warns(studio.run(kTool, studio.display() + Arguments{"-y", "--save-quilt",
                                                                         "q.png", "grey", "a.png"}),
                          "holds " + std::to_string(pictures) +
                              (pictures == 1 ? " picture" : " pictures") + " for 6 views"));
        fs::remove_all(studio / "grey");
        return greys(studio / "q_qs3x2a0.75.png", 3, 2);
    };
    EXPECT_EQ(viewsOf(1), (std::vector<int>{10, 10, 10, 10, 10, 10}));
    EXPECT_EQ(viewsOf(2), (std::vector<int>{10, 10, 10, 20, 20, 20}));
    EXPECT_EQ(viewsOf(11), (std::vector<int>{10, 30, 50, 70, 90, 110}));
}

TEST(Views2Native, ViewsOfDifferentSizesAreRefused) {
    SmallStudio studio;
    writeImage(studio / "views/view3.png", madePhoto(31, 40));
    EXPECT_TRUE(fails(studio.run(kTool, studio.display() + Arguments{"views", "a.png"}), 1,
                      "views/view3.png: has 31 x 40 px, expected 30 x 40 px"));
}

TEST(Views2Native, ViewsOfAnotherShapeAreCutWithAWarningUnlessFitIsGiven) {
    SmallStudio studio;
    writeGreys(studio / "wide", 6, {80, 40});
    const auto run = [&](const Arguments& more) {
        return studio.run(kTool, more + studio.display() +
                                     Arguments{"-y", "--save-quilt", "q.png", "wide", "a.png"});
    };
    EXPECT_TRUE(warns(run({}), "are cut to it; --fit contain keeps all"));
    EXPECT_TRUE(isDone(run({"--fit", "contain"})));
    EXPECT_EQ(readBack(studio / "q_qs3x2a0.75.png").at<cv::Vec3b>(0, 15), cv::Vec3b(0, 0, 0));
    EXPECT_TRUE(isDone(run({"--fit", "stretch"})));
}

TEST(Views2Native, AFolderOfPhotosOrNativesIsNoFolderOfViews) {
    SmallStudio studio;
    fs::create_directory(studio / "photos");
    fs::create_directory(studio / "mixed");
    for (int i = 0; i < 6; ++i) {
        writeImage(studio / ("photos/IMG_" + std::to_string(i) + ".png"),
                   scenery({120, 160}, 20 + i));
        writeImage(studio / ("mixed/v" + std::to_string(i) + ".png"), scenery({120, 160}, 20),
                   i == 4 ? ImageMark::Native : ImageMark::None);
    }
    EXPECT_TRUE(fails(studio.run(kTool, studio.display() + Arguments{"photos", "a.png"}), 1,
                      "photos: holds pictures that do not resemble each other, expected views"));
    EXPECT_TRUE(fails(studio.run(kTool, studio.display() + Arguments{"mixed", "a.png"}), 1,
                      "mixed/v4.png: is a Native already, expected views"));
    EXPECT_FALSE(fs::exists(studio / "a.png"));
}

TEST(Views2Native, PlacesWithoutViewsAreNamed) {
    SmallStudio studio;
    fs::create_directory(studio / "empty");
    for (const char* name : {"empty", "nothere", "photo.png"}) {
        EXPECT_TRUE(fails(studio.run(kTool, studio.display() + Arguments{name, "a.png"}), 1, name));
    }
    EXPECT_FALSE(fs::exists(studio / "a.png"));
}

} // namespace altiro3D::test
