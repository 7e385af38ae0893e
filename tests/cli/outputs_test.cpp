// When outputs are written or refused, and which files remain if a run fails.

#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

class OutputsOf : public ToolTest {
  protected:
    // One of the files that goodCall() reads.
    std::string anInput() const {
        if (tool() == "altiro3Dnative") return "small.json";
        if (tool() == "photo2native") return "depth.png";
        if (tool() == "views2native") return "views/view3.png";
        const Arguments call = studio_.goodCall(tool(), "a");
        return call[call.size() - 2];
    }
};

INSTANTIATE_TEST_SUITE_P(Tools, OutputsOf, ::testing::ValuesIn(allTools()),
                         [](const auto& tool) { return tool.param; });

TEST_P(OutputsOf, ExistingFilesAreReplacedOnlyWithY) {
    spill(studio_ / output("a"), "precious");
    EXPECT_TRUE(fails(good(output("a")), 1, output("a") + ": exists"));
    EXPECT_EQ(slurp(studio_ / output("a")), "precious");
    EXPECT_TRUE(isDone(good(output("a"), "-y")));
    EXPECT_TRUE(isDone(good(output("b"))));
    EXPECT_EQ(slurp(studio_ / output("a")), slurp(studio_ / output("b")));
}

// Names in the wrong order: the message is about the missing input, not the existing output.
TEST_P(OutputsOf, AMissingInputIsNamedBeforeAnOutputThatExists) {
    const std::string input = tool() == "views2native" ? "views" : anInput();
    fs::rename(studio_ / input, studio_ / "away");
    spill(studio_ / output("a"), "precious");
    EXPECT_TRUE(fails(good(output("a")), 1, input + ": does not exist"));
    EXPECT_EQ(slurp(studio_ / output("a")), "precious");
}

TEST_P(OutputsOf, AnInputIsNeverReplaced) {
    const std::string input = anInput();
    const std::string before = slurp(studio_ / input);
    fs::create_symlink(input, studio_ / output("symlink"));
    fs::create_hard_link(studio_ / input, studio_ / output("hardlink"));
    fs::create_directory_symlink(".", studio_ / "here");
    std::vector<std::string> names{output("symlink"), output("hardlink")};
    // whose input is a picture, and whose output is one, too
    if (tool() != "quilt2video" && tool() != "slide2native" && tool() != "splat2native") {
        names.push_back("here/./" + input);
        names.push_back((studio_ / input).string());
    }
    for (const std::string& name : names) {
        EXPECT_TRUE(fails(good(name, "-y"), 2, "is also an input"));
        EXPECT_EQ(slurp(studio_ / input), before);
    }
    // nor one that is a link
    const fs::path target = studio_ / output("target");
    fs::rename(studio_ / input, target);
    fs::create_symlink(target, studio_ / input);
    EXPECT_TRUE(fails(good(output("target"), "-y"), 2, "is also an input"));
    EXPECT_EQ(slurp(target), before);
}

TEST_P(OutputsOf, ALinkIsFollowedAndStays) {
    fs::create_directory(studio_ / "store");
    spill(studio_ / output("store/real"), "old");
    fs::create_symlink(output("store/real"), studio_ / output("link"));
    EXPECT_TRUE(fails(good(output("link")), 1, "exists"));
    EXPECT_TRUE(isDone(good(output("link"), "-y")));
    EXPECT_TRUE(fs::is_symlink(studio_ / output("link")));
    EXPECT_TRUE(isDone(good(output("plain"))));
    EXPECT_EQ(slurp(studio_ / output("store/real")), slurp(studio_ / output("plain")));
}

TEST_P(OutputsOf, MissingDirectoriesAreNamed) {
    EXPECT_TRUE(fails(good(output("missing/a")), 1, "there is no directory"));
    EXPECT_FALSE(fs::exists(studio_ / "missing"));
    EXPECT_TRUE(fails(good(output("small.json/a")), 1, output("small.json/a")));
}

TEST_P(OutputsOf, AFullDiskIsAnErrorAndTheDeviceStays) {
    if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "needs /dev/full";
    fs::create_symlink("/dev/full", studio_ / output("full"));
    const bool video = tool() == "quilt2video" || tool() == "video2native";
    const char* const problem = video ? ": is a device or pipe" : ": cannot be written";
    EXPECT_TRUE(fails(good(output("full")), 1, output("full") + problem));
    EXPECT_TRUE(fails(good(output("full"), "-y"), 1, video ? problem : "No space left"));
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_P(OutputsOf, AFileThatMayNotGrowIsAnErrorAndLeavesNothing) {
    studio_.limitFiles(2048);
    // a video is written in parts
    const std::string file = output("a") + (tool() == "video2native" ? ".parts/000001.mkv" : "");
    EXPECT_TRUE(fails(good(output("a")), 1, file + ": cannot be written"));
    EXPECT_FALSE(fs::exists(studio_ / output("a")));
}

TEST_P(OutputsOf, NamesThatAreTooLongAreNamed) {
    const std::string name = output(std::string(300, 'a'));
    EXPECT_TRUE(fails(good(name), 1, name + ": cannot be written"));
    Arguments call = studio_.goodCall(tool(), output("b"));
    // the last of the inputs
    (tool() == "altiro3Dnative" ? call.back() : call[call.size() - 2]) = name;
    EXPECT_TRUE(fails(studio_.run(tool(), call), 1, name + ": "));
    constexpr std::size_t kLongest = 255;
    const std::string longest = output(std::string(kLongest - output("").size(), 'a'));
    EXPECT_EQ(good(longest).status, 0);
    EXPECT_TRUE(fs::exists(studio_ / longest));
}

TEST_P(OutputsOf, AFailedRunLeavesWhatWasThere) {
    spill(studio_ / output("a"), "precious");
    const std::string input = tool() == "views2native" ? "views/view0.png" : anInput();
    for (const char* bytes : {"broken", ""}) {
        spill(studio_ / input, bytes);
        EXPECT_TRUE(fails(good(output("a"), "-y"), 1, input));
        EXPECT_EQ(slurp(studio_ / output("a")), "precious");
        EXPECT_TRUE(fails(good(output("b")), 1, input));
        EXPECT_FALSE(fs::exists(studio_ / output("b")));
    }
    fs::remove_all(studio_ / input);
    if (tool() == "views2native") fs::remove_all(studio_ / "views");
    EXPECT_TRUE(fails(good(output("a"), "-y"), 1, "does not exist"));
    EXPECT_EQ(slurp(studio_ / output("a")), "precious");
}

TEST_P(OutputsOf, ExtensionsAreKnownAndLossyNativesAreWarnedOf) { // others: Words
    if (!writesPictures()) GTEST_SKIP() << "writes no picture";
    EXPECT_TRUE(fails(good("a.gif"), 2, "a.gif: "));
    EXPECT_FALSE(fs::exists(studio_ / "a.gif"));
    if (tool() == "native2view") return; // writes no Native
    EXPECT_TRUE(isDone(good("a.png")));
    const cv::Mat expected = readBack(studio_ / "a.png");
    EXPECT_TRUE(warns(good("b.jpg"), "b.jpg: this format mixes"));
    EXPECT_TRUE(isDone(good("b.tif")));
    EXPECT_EQ(cv::norm(readBack(studio_ / "b.tif"), expected, cv::NORM_INF), 0);
}

class Outputs : public StudioTest {
  protected:
    Outputs() : StudioTest("photo2native") {}
};

TEST_F(Outputs, ADirectoryIsNoOutputFile) {
    studio_.makeClip();
    studio_.makeSlide();
    studio_.makeScan();
    for (const std::string& tool : allTools()) {
        if (tool == "photo2native") continue; // uses it as the directory for outputs
        const std::string name = outputName(tool, "dir");
        fs::create_directories(studio_ / name);
        for (const Arguments& more : {Arguments{}, Arguments{"-y"}})
            EXPECT_TRUE(fails(studio_.run(tool, more + studio_.goodCall(tool, name)), 1, name));
    }
}

TEST_F(Outputs, CalibrationAndMapAreInputsHoweverTheyWereFound) {
    fs::rename(studio_ / "small.json", studio_ / "visual.json");
    const std::string before = slurp(studio_ / "visual.json");
    const Arguments photo("-q 2x3 -r 40x30 -y -d photo.png depth.png a.png");
    EXPECT_TRUE(fails(run(Arguments("--report visual.json") + photo), 2, "is also an input"));
    studio_.set("LKG_CALIBRATION", (studio_ / "visual.json").string());
    EXPECT_TRUE(fails(run(Arguments("--report ./visual.json") + photo), 2, "is also an input"));
    EXPECT_EQ(slurp(studio_ / "visual.json"), before);
    fs::create_hard_link(studio_ / "visual.json", studio_ / "calibration.png");
    EXPECT_TRUE(fails(studio_.run("quilt2native", "-q 2x3 -y quilt.png calibration.png"), 2,
                      "is also an input"));
    EXPECT_TRUE(fails(studio_.run("views2native", "-q 2x3 -y views calibration.png"), 2,
                      "is also an input"));
    EXPECT_EQ(slurp(studio_ / "visual.json"), before);
}

TEST_F(Outputs, AReportOfAnEarlierRunDoesNotPassForThatOfOneThatFails) {
    studio_.makeClip();
    const std::string clip = slurp(studio_ / "clip.mp4");
    spill(studio_ / "cut.mp4", clip.substr(0, clip.find("mdat") + 100));
    const auto ends = [&](const std::string& tool, const Arguments& call) {
        const std::string old = R"({"tool": ")" + tool + R"(", "state": "done"})";
        spill(studio_ / "r.json", old);
        EXPECT_EQ(studio_.convert(tool, call).status, 1); // no -y
        EXPECT_EQ(slurp(studio_ / "r.json"), old);
        EXPECT_EQ(studio_.convert(tool, Arguments("-y") + call).status, 1);
        EXPECT_EQ(studio_.json("r.json")["state"], "failed") << tool;
        EXPECT_TRUE(studio_.json("r.json").contains("error"));
    };
    ends("photo2native", "--report r.json missing.png a.png");
    ends("video2native", "--report r.json cut.mp4 a.mp4");
    ends("quilt2native", "--report r.json missing.mp4 a.mp4");
    spill(studio_ / "r.json", "{\"tool\": \"another\"}");
    EXPECT_EQ(convert("-y --report r.json missing.png a.png").status, 1);
    EXPECT_EQ(slurp(studio_ / "r.json"), "{\"tool\": \"another\"}");
}

TEST_F(Outputs, WrongUsageMakesNoDirectories) { // the messages: Jobs
    for (const auto& [call, status] : {std::pair("photo.png photo.png out", 2),
                                       std::pair("--rgbd up photo.png quilt.png out", 2),
                                       std::pair("-n nothere.onnx photo.png quilt.png out", 1)}) {
        EXPECT_TRUE(fails(convert(call), status, ""));
        EXPECT_FALSE(fs::exists(studio_ / "out"));
    }
}

TEST_F(Outputs, AllExistingOutputsAreChecked) { // of photo2native: Jobs
    spill(studio_ / "c_qs3x2a0.75.png", "precious");
    EXPECT_TRUE(
        fails(studio_.convert("views2native", "--save-quilt c.png views a.png"), 1, "exists"));
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

} // namespace altiro3D::test
