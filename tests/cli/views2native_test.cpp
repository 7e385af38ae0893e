#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/photo_files.hpp"
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

class Views2Native : public StudioTest {
  protected:
    Views2Native() : StudioTest(kTool) {}
};

TEST_F(Views2Native, GivesTheNativeOfTheQuilt) {
    EXPECT_TRUE(isDone(convert("--save-quilt q.png views a.png")));
    EXPECT_TRUE(
        samePicture(readBack(studio_ / "q_qs3x2a0.75.png"), readBack(studio_ / "quilt.png")));
    EXPECT_TRUE(isDone(studio_.run("quilt2native", "-c small.json -q 2x3 quilt.png b.png")));
    EXPECT_EQ(slurp(studio_ / "a.png"), slurp(studio_ / "b.png"));
}

TEST_F(Views2Native, SortsNumbersByValue) {
    writeGreys(studio_ / "grey", 12);
    spill(studio_ / "grey/notes.txt", "no view");
    spill(studio_ / "grey/.hidden.png", "no view");
    const Arguments call("-c small.json -q 3x4 -r 40x30 -y --save-quilt q.png grey a.png");
    EXPECT_TRUE(isDone(run(call)));
    std::vector<int> expected;
    for (int i = 0; i < 12; ++i)
        expected.push_back(10 + 10 * i);
    EXPECT_EQ(greys(studio_ / "q_qs4x3a0.75.png", 4, 3), expected);
    EXPECT_TRUE(isDone(run(Arguments{"--reverse"} + call)));
    std::reverse(expected.begin(), expected.end());
    EXPECT_EQ(greys(studio_ / "q_qs4x3a0.75.png", 4, 3), expected);
}

// A camera counts on with IMG_0001 after IMG_9999.
TEST_F(Views2Native, NumbersThatBeginAgainGoOn) {
    fs::create_directory(studio_ / "grey");
    std::vector<int> expected;
    const auto nameOf = [](int i) { // 9995 to 9999, 1 to 7
        const std::string number = std::to_string(i < 5 ? 9995 + i : i - 4);
        return "grey/IMG_" + std::string(4 - number.size(), '0') + number + ".jpg";
    };
    for (int i = 0; i < 12; ++i) {
        expected.push_back(10 + 10 * i);
        writeImage(studio_ / nameOf(i), cv::Mat(40, 30, CV_8UC3, cv::Scalar::all(10 + 10 * i)));
    }
    const Arguments call("-c small.json -q 3x4 -r 40x30 -y --save-quilt q.png grey a.png");
    EXPECT_TRUE(warns(run(call), "the first picture is IMG_9995.jpg, as the camera's numbers begin "
                                 "again after IMG_9999.jpg"));
    EXPECT_EQ(greys(studio_ / "q_qs4x3a0.75.png", 4, 3), expected);
    // unless the photos were taken in the order of their names
    const auto takeAt = [&](int i, const std::string& time) {
        const std::string exif("Exif\0\0II*\0\10\0\0\0\1\0\x32\1\2\0\x14\0\0\0\x1a\0\0\0\0\0\0\0",
                               32);
        writeImage(studio_ / nameOf(i), cv::Mat(40, 30, CV_8UC3, cv::Scalar::all(10 + 10 * i)));
        spill(studio_ / nameOf(i),
              withSegments(slurp(studio_ / nameOf(i)), jpegSegment(0xe1, exif + time + '\0')));
    };
    takeAt(5, "2024:05:31 12:00:07");
    takeAt(4, "2024:05:31 12:00:05");
    EXPECT_TRUE(warns(run(call), "the first picture is IMG_9995.jpg"));
    takeAt(4, "2024:05:31 12:00:09");
    EXPECT_TRUE(fails(run(call), 1, "misses numbers between IMG_0007.jpg and IMG_9995.jpg"));
}

TEST_F(Views2Native, OtherCountsAreSpreadOverTheViewsWithAWarning) {
    const auto viewsOf = [&](int pictures, const Arguments& views) {
        EXPECT_TRUE(warns(convert(Arguments("-y --save-quilt q.png") + views + Arguments{"a.png"}),
                          "are " + std::to_string(pictures) + " pictures for 6 views"));
        return greys(studio_ / "q_qs3x2a0.75.png", 3, 2);
    };
    writeGreys(studio_ / "grey", 11);
    EXPECT_EQ(viewsOf(11, "grey"), (std::vector<int>{10, 30, 50, 70, 90, 110}));
    EXPECT_EQ(viewsOf(2, "grey/view5.png grey/view2.png"),
              (std::vector<int>{50, 50, 50, 20, 20, 20}));
}

TEST_F(Views2Native, ViewsOfDifferentSizesAreRefused) {
    writeImage(studio_ / "views/view3.png", madePhoto(31, 40));
    EXPECT_TRUE(fails(convert("views a.png"), 1,
                      "views: holds pictures of different sizes, expected at least 6 views"));
    Arguments named = studio_.display();
    for (int i = 0; i < 6; ++i)
        named.push_back("views/view" + std::to_string(i) + ".png");
    EXPECT_TRUE(fails(run(named + Arguments{"a.png"}), 1,
                      "views/view3.png: has 31 x 40 px, expected 30 x 40 px"));
}

TEST_F(Views2Native, ViewsOfAnotherShapeAreCutWithAWarningUnlessFitIsGiven) {
    writeGreys(studio_ / "wide", 6, {80, 40});
    const auto run = [&](const Arguments& more) {
        return convert(more + Arguments("-y --save-quilt q.png wide a.png"));
    };
    EXPECT_TRUE(warns(run({}), "are cut to it; --fit contain keeps all"));
    EXPECT_TRUE(isDone(run("--fit contain")));
    EXPECT_EQ(readBack(studio_ / "q_qs3x2a0.75.png").at<cv::Vec3b>(0, 15), cv::Vec3b(0, 0, 0));
    EXPECT_TRUE(isDone(run("--fit stretch")));
}

// Pictures of `photo`, seen through a window that moves by `step(i)` px.
template <class Step>
void writeWindows(const fs::path& directory, int count, Step step) {
    fs::create_directory(directory);
    const cv::Mat photo = scenery({220, 200}, 20);
    for (int i = 0; i < count; ++i) {
        const cv::Point at = step(i);
        writeImage(directory / ("IMG_" + std::to_string(100 + i) + ".png"),
                   photo(cv::Rect(30 + at.x, 30 + at.y, 105, 140)).clone());
    }
}

TEST_F(Views2Native, AFolderOfOtherPicturesIsNoFolderOfViews) {
    const auto refusal = [&](const char* folder, const std::string& reason) {
        return fails(convert({folder, "a.png"}), 1, folder + (": " + reason));
    };
    fs::create_directory(studio_ / "photos");
    fs::create_directory(studio_ / "mixed");
    fs::create_directory(studio_ / "grid");
    for (int i = 0; i < 6; ++i) {
        writeImage(studio_ / ("photos/IMG_" + std::to_string(i) + ".png"),
                   scenery({120, 160}, 20 + i));
        writeImage(studio_ / ("mixed/v" + std::to_string(i) + ".png"), scenery({120, 160}, 20),
                   i == 4 ? ImageMark::Native : ImageMark::None);
        writeImage(studio_ / ("grid/view_0" + std::to_string(i / 3) + "_0" + std::to_string(i % 3) +
                              ".png"),
                   scenery({120, 160}, 20));
    }
    EXPECT_TRUE(refusal("photos", "holds pictures that do not resemble each other, expected at "
                                  "least 6 views of one scene"));
    EXPECT_TRUE(
        fails(convert("mixed a.png"), 1, "mixed/v4.png: is a Native already, expected views"));
    EXPECT_TRUE(refusal("grid", "holds names with two numbers that count, such as view_01_00.png"));
    fs::rename(studio_ / "views/view3.png", studio_ / "views/depth.png");
    EXPECT_TRUE(refusal("views", "holds depth.png and view0.png, which are not numbered"));
    fs::rename(studio_ / "views/depth.png", studio_ / "views/view7.png");
    EXPECT_TRUE(refusal("views", "misses numbers between view2.png and view4.png"));
    fs::remove(studio_ / "views/view7.png");
    EXPECT_TRUE(refusal("views", "holds 5 pictures, expected at least 6 views"));
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

TEST_F(Views2Native, TheCameraOfViewsMovesInOneDirection) {
    const auto run = [&](const char* folder) { return convert({"-y", folder, "a.png"}); };
    writeWindows(studio_ / "row", 8, [](int i) { return cv::Point(2 * i, 0); });
    writeWindows(studio_ / "still", 8, [](int) { return cv::Point(0, 0); });
    writeWindows(studio_ / "up", 8, [](int i) { return cv::Point(0, -2 * i); });
    constexpr int kHand[8][2] = {{0, 0}, {3, -2}, {-1, 2}, {1, -1},
                                 {4, 3}, {0, 0},  {-2, 2}, {1, 1}};
    writeWindows(studio_ / "hand", 8, [&](int i) { return cv::Point(kHand[i][0], kHand[i][1]); });
    EXPECT_TRUE(warns(run("row"), "there are 8 pictures for 6 views"));
    EXPECT_TRUE(warns(run("still"), "there are 8 pictures for 6 views"));
    EXPECT_TRUE(fails(run("up"), 1, "up: holds pictures of a camera that moves up or down"));
    EXPECT_TRUE(fails(run("hand"), 1, "hand: holds pictures of a camera that moves to and fro"));
}

TEST_F(Views2Native, RealLightFieldsAreViewsUnlessTheyAreGrids) {
    ALTIRO3D_REQUIRE_DATA("lightfields");
    SmallStudio studio;
    const auto run = [&](const fs::path& folder) {
        return studio.convert(kTool, {"-y", "--fit", "cover", folder.string(), "a.png"});
    };
    const fs::path cards = dataPath("lightfields/stanford_cards");
    EXPECT_TRUE(warns(run(dataPath("lightfields/greenbuddha_33")), "33 pictures for 6 views"));
    const fs::path numbers = dataPath("lightfields/numbers_64");
    EXPECT_TRUE(fails(run(numbers), 1, "do not resemble each other"));
    Arguments named = studio.display() + Arguments("--fit cover");
    for (int i = 10; i < 16; ++i)
        named.push_back((numbers / (std::to_string(i) + ".png")).string());
    EXPECT_TRUE(isDone(studio.run(kTool, named + Arguments{"named.png"})));
    EXPECT_TRUE(fails(run(cards), 1, "which are not numbered as one sequence"));
    fs::create_directory(studio / "grid");
    fs::create_directory(studio / "line");
    for (const fs::path& file : listImages(cards)) {
        const std::string name = file.filename().string();
        if (name[0] != 'r') continue; // the depth map
        fs::create_symlink(file, studio / "grid" / name);
        if (name.rfind("r08", 0) == 0) fs::create_symlink(file, studio / "line" / name);
    }
    EXPECT_TRUE(fails(run("grid"), 1, "holds names with two numbers that count"));
    EXPECT_TRUE(warns(run("line"), "9 pictures for 6 views"));
}

TEST_F(Views2Native, PlacesWithoutViewsAreNamed) {
    fs::create_directory(studio_ / "empty");
    for (const char* name : {"empty", "nothere", "photo.png"}) {
        EXPECT_TRUE(fails(convert({name, "a.png"}), 1, name));
    }
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

} // namespace altiro3D::test
