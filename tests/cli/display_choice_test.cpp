// Which display a run is for: -m, -c, what is found without them, and the cache of tables.

#include "altiro3D/display.hpp"
#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"

#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

const Arguments kQuilt{"-q", "2x3", "-r", "40x30"};

// The panel's width by the Native that comes out.
int nativeWidth(const Sandbox& sandbox, const Arguments& more = {}) {
    const Outcome outcome = sandbox.run("views2native", more + Arguments{"-y"} + kQuilt +
                                                            Arguments{"views", "native.png"});
    return outcome.status == 0 ? readBack(sandbox / "native.png").cols : -1;
}

fs::path onlyCacheFile(const fs::path& directory) {
    fs::path found;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(directory, error)) {
        EXPECT_TRUE(found.empty()) << "a second file: " << entry.path();
        found = entry.path();
    }
    return found;
}

Outcome verboseViews(const Sandbox& sandbox) {
    return sandbox.run("views2native", Arguments{"-v", "-y", "-c", "small.json"} + kQuilt +
                                           Arguments{"views", "native.png"});
}

} // namespace

TEST(DisplayChoice, TheFirstThatIsThereCounts) {
    SmallStudio studio;
    writeCalibration(studio / "visual.json", {100, 120});
    EXPECT_EQ(nativeWidth(studio), 100);
    writeCalibration(studio / "variable.json", {104, 120});
    studio.set("LKG_CALIBRATION", (studio / "variable.json").string());
    EXPECT_EQ(nativeWidth(studio), 104);
    EXPECT_EQ(nativeWidth(studio, {"-c", "small.json"}), 96);
    ASSERT_EQ(
        studio.run("altiro3Dnative", Arguments{"-m", "a.map"} + kQuilt + Arguments{"visual.json"})
            .status,
        0);
    EXPECT_EQ(nativeWidth(studio, {"-m", "a.map"}), 100);
}

TEST(DisplayChoice, AnUnusableVariableIsAnError) {
    SmallStudio studio;
    writeCalibration(studio / "visual.json");
    spill(studio / "broken.json", "{");
    for (const char* value : {"broken.json", "nothere.json", "views"}) {
        studio.set("LKG_CALIBRATION", value);
        const Outcome outcome =
            studio.run("quilt2native", {"-q", "2x3", "quilt.png", "native.png"});
        EXPECT_TRUE(fails(outcome, 1, value));
        EXPECT_NE(outcome.err.find("LKG_CALIBRATION"), std::string::npos) << outcome.err;
    }
    studio.set("LKG_CALIBRATION", ""); // as if it were not set
    EXPECT_TRUE(isDone(studio.run("quilt2native", {"-q", "2x3", "quilt.png", "native.png"})));
}

TEST(DisplayChoice, TheSampleComesLastWithAWarning) {
    if (!findMountedCalibrations().empty()) GTEST_SKIP() << "a display is mounted here";
    SmallStudio studio;
    const Outcome outcome = studio.run("quilt2native", {"-q", "2x3", "quilt.png", "native.png"});
    EXPECT_TRUE(warns(outcome, "doubled and blurred"));
    EXPECT_EQ(readBack(studio / "native.png").size(), cv::Size(1536, 2048));
}

TEST(DisplayChoice, ABrokenCalibrationInTheWorkingDirectoryIsAnError) {
    SmallStudio studio;
    spill(studio / "visual.json", "{}");
    EXPECT_TRUE(fails(studio.run("quilt2native", {"quilt.png", "native.png"}), 1, "visual.json"));
}

TEST(DisplayChoice, MapAndCalibrationGiveTheSameNative) {
    SmallStudio studio;
    ASSERT_TRUE(isDone(
        studio.run("altiro3Dnative", Arguments{"-m", "a.map"} + kQuilt + Arguments{"small.json"})));
    const Arguments inputs{"-d", "photo.png", "depth.png"};
    EXPECT_TRUE(isDone(studio.run("photo2native", studio.display() + inputs + Arguments{"c.png"})));
    EXPECT_TRUE(
        isDone(studio.run("photo2native", Arguments{"-m", "a.map"} + inputs + Arguments{"m.png"})));
    EXPECT_TRUE(isDone(studio.run("photo2native", Arguments{"-m", "a.map"} + studio.display() +
                                                      inputs + Arguments{"mc.png"})));
    const std::string expected = slurp(studio / "c.png");
    EXPECT_EQ(slurp(studio / "m.png"), expected);
    EXPECT_EQ(slurp(studio / "mc.png"), expected);
}

TEST(DisplayChoice, AMapOfAnotherDisplayIsRefused) {
    SmallStudio studio;
    studio.makeClip();
    writeCalibration(studio / "other.json", {96, 128}, 50);
    ASSERT_TRUE(isDone(
        studio.run("altiro3Dnative", Arguments{"-m", "a.map"} + kQuilt + Arguments{"other.json"})));
    for (const std::string& tool : allTools()) {
        if (tool == "altiro3Dnative" || tool == "quilt2video") continue; // make or need no map
        const Outcome outcome = studio.run(
            tool, Arguments{"-m", "a.map"} + studio.goodCall(tool, outputName(tool, "native")));
        EXPECT_TRUE(fails(outcome, 1, "a.map"));
        EXPECT_NE(outcome.err.find("small.json"), std::string::npos) << outcome.err;
    }
}

TEST(DisplayChoice, AMapForAnotherQuiltIsRefusedWithBothSizes) {
    SmallStudio studio;
    studio.makeClip();
    ASSERT_TRUE(isDone(
        studio.run("altiro3Dnative", {"-m", "a.map", "-q", "2x3", "-r", "30x20", "small.json"})));
    for (const std::string& tool : allTools()) {
        if (tool == "altiro3Dnative" || tool == "quilt2video") continue; // make or need no map
        if (tool == "native2view") continue; // to which a map alone does not tell enough
        Arguments call = studio.goodCall(tool, outputName(tool, "native"));
        call.erase(call.begin(), call.begin() + 2); // no -c
        const Outcome outcome = studio.run(tool, Arguments{"-m", "a.map"} + call);
        EXPECT_TRUE(fails(outcome, 1, "60 x 60 px"));
        EXPECT_NE(outcome.err.find("90 x 80 px"), std::string::npos) << outcome.err;
    }
    EXPECT_TRUE(fails(studio.run("quilt2native", {"-m", "a.map", "quilt.png", "native.png"}), 1,
                      "90 x 80 px"));
}

TEST(DisplayChoice, DamagedMapsAreRefused) {
    SmallStudio studio;
    ASSERT_TRUE(isDone(
        studio.run("altiro3Dnative", Arguments{"-m", "a.map"} + kQuilt + Arguments{"small.json"})));
    const std::string good = slurp(studio / "a.map");
    std::string flipped = good;
    flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 0xff);
    std::string longer = good + "x";
    const std::pair<const char*, std::string> bad[] = {
        {"short.map", good.substr(0, good.size() - 1)},
        {"head.map", good.substr(0, 20)},
        {"empty.map", ""},
        {"flipped.map", flipped},
        {"longer.map", longer},
        {"foreign.map", slurp(studio / "photo.png")}};
    for (const auto& [name, bytes] : bad) {
        spill(studio / name, bytes);
        EXPECT_TRUE(
            fails(studio.run("quilt2native", {"-m", name, "quilt.png", "native.png"}), 1, name));
    }
    EXPECT_TRUE(
        fails(studio.run("quilt2native", {"-m", "views", "quilt.png", "native.png"}), 1, "views"));
}

TEST(DisplayChoice, OptionsThatAMapCannotTakeAreWrongUsage) {
    SmallStudio studio;
    ASSERT_TRUE(isDone(
        studio.run("altiro3Dnative", Arguments{"-m", "a.map"} + kQuilt + Arguments{"small.json"})));
    for (const Arguments& more :
         {Arguments{"--invert", "off"}, Arguments{"--view-filter", "linear"},
          Arguments{"--sampling", "linear"}}) {
        EXPECT_TRUE(fails(
            studio.run("quilt2native", more + Arguments{"-m", "a.map", "quilt.png", "native.png"}),
            2, "exclude each other"));
    }
}

TEST(LutCache, IsKeptAndUsedAgain) {
    SmallStudio studio;
    const Outcome first = verboseViews(studio);
    EXPECT_TRUE(isDone(first));
    EXPECT_NE(first.out.find("built and kept"), std::string::npos) << first.out;
    const std::string expected = slurp(studio / "native.png");
    const fs::path cached = onlyCacheFile(studio.home() / ".cache/altiro3D");
    ASSERT_FALSE(cached.empty());
    const Outcome second = verboseViews(studio);
    EXPECT_TRUE(isDone(second));
    EXPECT_NE(second.out.find("from the cache"), std::string::npos) << second.out;
    EXPECT_EQ(slurp(studio / "native.png"), expected);
}

TEST(LutCache, ADamagedTableIsBuiltAnew) {
    SmallStudio studio;
    ASSERT_TRUE(isDone(verboseViews(studio)));
    const std::string expected = slurp(studio / "native.png");
    const fs::path cached = onlyCacheFile(studio.home() / ".cache/altiro3D");
    const std::string good = slurp(cached);
    std::string flipped = good;
    flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 0xff);
    for (const std::string& bytes : {std::string(), good.substr(0, 100), flipped}) {
        spill(cached, bytes);
        const Outcome outcome = verboseViews(studio);
        EXPECT_TRUE(isDone(outcome));
        EXPECT_NE(outcome.out.find("built and kept"), std::string::npos) << outcome.out;
        EXPECT_EQ(slurp(studio / "native.png"), expected);
        EXPECT_EQ(slurp(cached), good);
    }
}

TEST(LutCache, DisplaysAndOrdersOfViewsDoNotMix) {
    SmallStudio studio;
    writeCalibration(studio / "other.json", {96, 128}, 50);
    const auto native = [&](const Arguments& arguments) {
        EXPECT_TRUE(isDone(studio.run(
            "quilt2native", arguments + Arguments{"-y", "-q", "2x3", "quilt.png", "native.png"})));
        return slurp(studio / "native.png");
    };
    const std::string plain = native({"-c", "small.json"});
    EXPECT_NE(native({"-c", "small.json", "--invert", "off"}), plain);
    EXPECT_NE(native({"-c", "other.json"}), plain);
    EXPECT_EQ(native({"-c", "small.json"}), plain);
}

TEST(LutCache, XdgCacheHomeComesFirst) {
    SmallStudio studio;
    studio.set("XDG_CACHE_HOME", (studio.home() / "elsewhere").string());
    EXPECT_TRUE(isDone(verboseViews(studio)));
    EXPECT_FALSE(onlyCacheFile(studio.home() / "elsewhere/altiro3D").empty());
    EXPECT_FALSE(fs::exists(studio.home() / ".cache"));
    studio.set("XDG_CACHE_HOME", "relative"); // to be ignored, says the standard
    EXPECT_TRUE(isDone(verboseViews(studio)));
    EXPECT_FALSE(fs::exists(studio / "relative"));
    EXPECT_FALSE(onlyCacheFile(studio.home() / ".cache/altiro3D").empty());
}

TEST(LutCache, AHomeThatCannotBeWrittenIsNoError) {
    SmallStudio studio;
    ASSERT_TRUE(isDone(verboseViews(studio)));
    const std::string expected = slurp(studio / "native.png");
    for (const std::optional<std::string>& home :
         {std::optional<std::string>("/proc"), std::optional<std::string>("/dev/null"),
          // below a file, where not even root can make directories
          std::optional<std::string>((studio / "small.json").string() + "/at/all/\xff"),
          std::optional<std::string>("")}) {
        studio.set("HOME", home);
        EXPECT_TRUE(isDone(verboseViews(studio)));
        EXPECT_EQ(slurp(studio / "native.png"), expected);
    }
    studio.set("HOME", std::nullopt);
    EXPECT_TRUE(isDone(verboseViews(studio)));
}

} // namespace altiro3D::test
