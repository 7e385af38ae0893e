#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

/// The folder that a Looking Glass Go plays alone, as its maker documents it.
namespace altiro3D::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

const QuiltLayout kGo{11, 6, {372, 682}, 66};

} // namespace

class GoFolderTest : public StudioTest {
  protected:
    GoFolderTest() : StudioTest("photo2native") {
        const std::pair<const char*, const char*> names[] = {{"photo.png", "photos/b 10.png"},
                                                             {"photo.png", "photos/b 9.png"}};
        fs::create_directory(studio_ / "photos");
        for (const auto& [from, to] : names)
            fs::copy(studio_ / from, studio_ / to);
    }
};

TEST_F(GoFolderTest, HoldsTheDocumentedTree) {
    const Outcome outcome = run("--go go --each 7.5 photos");
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    const std::set<std::string> expected{"currentlyPlaying.json",
                                         "LKG/Content/1/playlist.m3u",
                                         "LKG/Content/1/001_b_9_qs11x6a0.5625.jpg",
                                         "LKG/Content/1/001_b_9_qs11x6a0.5625.jpg.json",
                                         "LKG/Content/1/002_b_10_qs11x6a0.5625.jpg",
                                         "LKG/Content/1/002_b_10_qs11x6a0.5625.jpg.json"};
    EXPECT_EQ(filesBelow(studio_ / "go"), expected);
    EXPECT_EQ(studio_.json("go/currentlyPlaying.json"), Json::parse(R"({
        "model": "toolkit", "schema": "0.1",
        "playlists": [{"title": "altiro3D 1", "path": "/LKG/Content/1/playlist.m3u"}]})"));
    EXPECT_EQ(studio_.json("go/LKG/Content/1/001_b_9_qs11x6a0.5625.jpg.json"), Json::parse(R"({
        "mediaType": "quilt",
        "quilt_settings": {"viewX": 11, "viewY": 6, "viewTotal": 66, "aspect": 0.5625,
                           "invertViews": false},
        "focus": 0.0, "zoom": 1, "duration": 7.5})"));
    EXPECT_EQ(slurp(studio_ / "go/LKG/Content/1/playlist.m3u"),
              "#EXTM3U\n"
              "#EXTINF:7.5,001_b_9_qs11x6a0.5625\n001_b_9_qs11x6a0.5625.jpg\n"
              "#EXTINF:7.5,002_b_10_qs11x6a0.5625\n002_b_10_qs11x6a0.5625.jpg\n");
    EXPECT_EQ(readBack(studio_ / "go/LKG/Content/1/001_b_9_qs11x6a0.5625.jpg").size(), kGo.size());
}

TEST_F(GoFolderTest, WhatTheStorageHoldsStays) {
    const std::string old = R"({"model": "m", "other": [1],
        "playlists": [{"title": "mine", "path": "/LKG/Content/608/playlist.m3u"}]})";
    fs::create_directories(studio_ / "go/LKG/Content/608");
    spill(studio_ / "go/LKG/Content/608/playlist.m3u", "mine");
    spill(studio_ / "go/currentlyPlaying.json", old);
    ASSERT_EQ(run("--go go photo.png").status, 0);
    EXPECT_EQ(slurp(studio_ / "go/LKG/Content/608/playlist.m3u"), "mine");
    EXPECT_EQ(slurp(studio_ / "go/currentlyPlaying.json.bak"), old);
    Json expected = Json::parse(old);
    expected["playlists"].push_back(
        {{"title", "altiro3D 609"}, {"path", "/LKG/Content/609/playlist.m3u"}});
    EXPECT_EQ(studio_.json("go/currentlyPlaying.json"), expected);
    EXPECT_EQ(filesBelow(studio_ / "go/LKG/Content/609").size(), 3U);
}

TEST_F(GoFolderTest, ChangesNothingWithoutAQuilt) {
    fs::create_directory(studio_ / "bad");
    spill(studio_ / "bad/bad.jpg", "no picture");
    EXPECT_EQ(run("--go go bad").status, 1);
    EXPECT_FALSE(fs::exists(studio_ / "go/currentlyPlaying.json"));
    for (const char* list : {"{}", "[", R"({"playlists": 3})", "[[[[1]]]]"}) {
        spill(studio_ / "go/currentlyPlaying.json", list);
        EXPECT_TRUE(fails(run("--go go photo.png"), 1, "currentlyPlaying.json")) << list;
    }
    spill(studio_ / "go/currentlyPlaying.json", std::string(500000, '['));
    EXPECT_TRUE(fails(run("--go go photo.png"), 1, "nests too deep"));
    EXPECT_EQ(filesBelow(studio_ / "go"), std::set<std::string>{"currentlyPlaying.json"});
}

TEST_F(GoFolderTest, RequiresSpaceBeforeAnyWork) {
    if (fs::space("/proc").available != 0) GTEST_SKIP() << "needs a /proc without space";
    EXPECT_TRUE(
        fails(run("--go /proc photo.png"), 1, "/proc: has 0 MB free, expected 16 MB for 1 quilt"));
}

TEST_F(GoFolderTest, QuiltsOfAGoStayAndOthersAreLaidOutAnew) {
    fs::create_directory(studio_ / "quilts");
    cv::Mat quilt(kGo.size(), CV_8UC3);
    for (int i = 0; i < 66; ++i)
        quilt(kGo.tile(i)).setTo(cv::Scalar::all(3 * i + 20));
    writeImage(studio_ / "quilts/a_qs11x6a0.5625.png", quilt);
    const QuiltLayout portrait{8, 6, {42, 56}, 48};
    cv::Mat other(portrait.size(), CV_8UC3);
    for (int i = 0; i < 48; ++i)
        other(portrait.tile(i)).setTo(cv::Scalar::all(4 * i + 20));
    writeImage(studio_ / "quilts/b_QS8x6a0.75.png", other);
    const Outcome outcome = studio_.run("quilt2native", "--go go quilts");
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.out, "its 48 views become the 66 of a Go"));
    const fs::path content = studio_ / "go/LKG/Content/1";
    // JPEG: a few levels
    EXPECT_TRUE(samePicture(readBack(content / "001_a_qs11x6a0.5625.jpg"), quilt, 3));
    const cv::Mat laidOut = readBack(content / "002_b_qs11x6a0.5625.jpg");
    ASSERT_EQ(laidOut.size(), kGo.size());
    for (const int view : {0, 30, 65}) {
        const cv::Rect tile = kGo.tile(view);
        const int expected = 4 * static_cast<int>(std::lround(view * 47 / 65.0)) + 20;
        const cv::Point centre(tile.x + tile.width / 2, tile.y + tile.height / 2);
        EXPECT_NEAR(laidOut.at<cv::Vec3b>(centre)[1], expected, 3) << view;
        // a view of 3 : 4 on a panel of 9 : 16 has black bars above and below
        EXPECT_LT(laidOut.at<cv::Vec3b>(tile.y + 20, centre.x)[1], 20) << view;
    }
    EXPECT_TRUE(fails(studio_.run("quilt2native", "--go go -c small.json quilts"), 2, "--go"));
}

} // namespace altiro3D::test
