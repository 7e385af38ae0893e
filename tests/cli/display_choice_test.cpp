// How a run finds its display: -m, -c, the search without them.

#include "altiro3D/display.hpp"
#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"

#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

const Arguments kQuilt("-q 2x3 -r 40x30");

// The panel's width by the Native that comes out.
int nativeWidth(const Sandbox& sandbox, const Arguments& more = {}) {
    const Outcome outcome = sandbox.run("views2native", more + Arguments{"-y"} + kQuilt +
                                                            Arguments("views native.png"));
    return outcome.status == 0 ? readBack(sandbox / "native.png").cols : -1;
}

} // namespace

class DisplayChoice : public StudioTest {
  protected:
    DisplayChoice() : StudioTest("quilt2native") {}
    // altiro3Dnative in a mount namespace of its own, where others can be mounted.
    Outcome runMounted(const std::string& mounts, const Arguments& arguments) const {
        std::string call = mounts + "exec '" + toolPath("altiro3Dnative").string() + "'";
        for (const std::string& argument : arguments)
            call += " '" + argument + "'";
        Outcome outcome = studio_.run("/usr/bin/unshare", {"-rm", "sh", "-c", call});
        outcome.tool = "altiro3Dnative";
        return outcome;
    }
    // A volume in media/; why it cannot be mounted, or nothing.
    std::string makeVolume() const {
        fs::create_directories(studio_ / "media/LKG-T1/LKG_calibration");
        writeCalibration(studio_ / "media/LKG-T1/LKG_calibration/visual.json", {104, 120}, 50,
                         "T1");
        if (studio_.run("/usr/bin/unshare", "-rm true").status != 0)
            return "needs unshare(1) and user namespaces";
        return findMountedCalibrations().empty() ? "" : "a display is mounted here";
    }
};

const char* const kMountMedia = "mount --bind media /media && ";

TEST_F(DisplayChoice, TheFirstOneFoundIsUsed) {
    writeCalibration(studio_ / "visual.json", {100, 120});
    EXPECT_EQ(nativeWidth(studio_), 100);
    writeCalibration(studio_ / "variable.json", {104, 120});
    studio_.set("LKG_CALIBRATION", (studio_ / "variable.json").string());
    EXPECT_EQ(nativeWidth(studio_), 104);
    EXPECT_EQ(nativeWidth(studio_, "-c small.json"), 96);
    ASSERT_EQ(
        studio_.run("altiro3Dnative", Arguments("-m a.map") + kQuilt + Arguments{"visual.json"})
            .status,
        0);
    EXPECT_EQ(nativeWidth(studio_, "-m a.map"), 100);
}

// The first line of each tool, in order: model, serial number, panel, file.
TEST_F(DisplayChoice, TheFirstLineSaysWhichDisplayItIs) {
    studio_.makeClip();
    studio_.makeSlide();
    studio_.makeScan();
    for (const std::string& tool : allTools()) {
        const Outcome outcome =
            studio_.run(tool, studio_.goodCall(tool, outputName(tool, tool + "-first")));
        EXPECT_TRUE(isDone(outcome));
        const std::string line = outcome.out.substr(0, outcome.out.find('\n'));
        if (tool == "quilt2video") { // without -c it needs none
            EXPECT_FALSE(holds(line, "display"));
            continue;
        }
        EXPECT_EQ(line, std::string("display: unknown model, serial TEST-1, panel 96 x 128 px, ") +
                            (tool == "native2view" ? "simulated from" : "from") + " small.json");
    }
    writeCalibration(studio_ / "portrait.json", {1536, 2048}, 52.58, "LKG-P00655");
    const auto firstLine = [&](const std::string& tool, const Arguments& arguments) {
        const std::string out = studio_.run(tool, arguments).out;
        return out.substr(0, out.find('\n'));
    };
    const std::string portrait =
        "display: Looking Glass Portrait, serial LKG-P00655, panel 1536 x 2048 px, from ";
    EXPECT_EQ(firstLine("altiro3Dnative", "--info portrait.json"), portrait + "portrait.json");
    EXPECT_EQ(firstLine("quilt2video", "-c portrait.json quilt.png a.mp4"),
              portrait + "portrait.json");
    ASSERT_TRUE(isDone(studio_.run("altiro3Dnative", "-m a.map portrait.json")));
    EXPECT_EQ(firstLine("views2native", "-m a.map views a.png"), portrait + "a.map");
    studio_.set("LKG_CALIBRATION", "portrait.json");
    EXPECT_EQ(firstLine("altiro3Dnative", "--info"), portrait + "portrait.json ($LKG_CALIBRATION)");
    const Outcome json = studio_.run("altiro3Dnative", "--json");
    EXPECT_TRUE(isDone(json));
    EXPECT_EQ(json.out.rfind('{', 0), 0U) << json.out;
}

// The warning about the sample depends on what is made with it.
TEST_F(DisplayChoice, TheSampleIsWarnedOfByWhatItIsUsedFor) {
    if (!findMountedCalibrations().empty()) GTEST_SKIP() << "a display is mounted here";
    SmallStudio studio;
    studio.makeClip();
    const std::string sample =
        "display: none was given or found; the sample calibration of a Portrait, panel "
        "1536 x 2048 px\n";
    const auto warnsOf = [&](const Outcome& outcome, const char* part) {
        EXPECT_TRUE(warns(outcome, part));
        EXPECT_EQ(outcome.out.rfind(sample, 0), 0U) << outcome.out;
        return outcome;
    };
    warnsOf(studio.run("quilt2native", "-q 2x3 quilt.png native.png"),
            "a real display will show the picture doubled and blurred");
    EXPECT_EQ(readBack(studio / "native.png").size(), cv::Size(1536, 2048));
    const Outcome seen = warnsOf(studio.run("native2view", "native.png seen.png"),
                                 "the sample one of a Portrait is simulated");
    EXPECT_FALSE(holds(seen.err, "a real display will show"));
    warnsOf(studio.run("altiro3Dnative", "--info"), "give your display's visual.json");
    warnsOf(studio.run("video2native", "--quilt-out -q 2x3 -r 40x30 clip.mp4 quilt.mp4"),
            "the quilt has the shape and the layout of a Portrait's");
    const Outcome rgbd = studio.run("video2native", "--rgbd-out clip.mp4 rgbd.mp4");
    EXPECT_TRUE(isDone(rgbd)); // which is for no display
    EXPECT_FALSE(holds(rgbd.out, "display"));
}

TEST_F(DisplayChoice, AFileFoundBesideAMountedDisplayOfAnotherCalibrationIsWarnedOf) {
    if (const std::string problem = makeVolume(); !problem.empty()) GTEST_SKIP() << problem;
    const auto run = [&](const Arguments& arguments) {
        return runMounted(kMountMedia, Arguments("--info -q 2x3 -r 40x30") + arguments);
    };
    const Outcome mounted = run({});
    EXPECT_TRUE(isDone(mounted));
    EXPECT_EQ(mounted.out.rfind("display: unknown model, serial T1, panel 104 x 120 px, from "
                                "/media/LKG-T1/LKG_calibration/visual.json\n",
                                0),
              0U)
        << mounted.text();
    writeCalibration(studio_ / "visual.json");
    const Outcome other = run({});
    EXPECT_TRUE(warns(other, "visual.json: is used, but a display with another calibration is "
                             "connected: LKG-T1 (/media/LKG-T1/LKG_calibration/visual.json)"));
    EXPECT_TRUE(holds(other.out, "serial TEST-1, panel 96 x 128 px, from visual.json\n"));
    EXPECT_TRUE(warns(run("small.json"), "small.json: is used, but a display with another"));
    studio_.set("LKG_CALIBRATION", "small.json");
    EXPECT_TRUE(warns(run({}), "small.json ($LKG_CALIBRATION): is used, but"));
    studio_.set("LKG_CALIBRATION", std::nullopt);
    fs::copy_file(studio_ / "media/LKG-T1/LKG_calibration/visual.json", studio_ / "visual.json",
                  fs::copy_options::overwrite_existing);
    EXPECT_TRUE(isDone(run({}))); // a copy of the display's own
}

// A display that the system lists, but whose device is missing.
TEST_F(DisplayChoice, AUsbDisplayThatCannotBeReadIsAnErrorWithoutAVolume) {
    if (const std::string problem = makeVolume(); !problem.empty()) GTEST_SKIP() << problem;
    if (!fs::exists("/sys/class/hidraw")) GTEST_SKIP() << "the system lists no hidraw devices";
    fs::create_directories(studio_ / "list/hidraw77/device");
    spill(studio_ / "list/hidraw77/device/uevent",
          "HID_ID=0003:000004D8:0000EF7E\nHID_NAME=Looking Glass HoloPlay\n");
    const std::string list = "mount --bind list /sys/class/hidraw && ";
    for (const char* call : {"--info", "--read-usb a.json"})
        EXPECT_TRUE(fails(runMounted(list, call), 1, "/dev/hidraw77"));
    const Outcome mounted = runMounted(list + kMountMedia, "--info -q 2x3 -r 40x30");
    EXPECT_TRUE(isDone(mounted));
    EXPECT_TRUE(holds(mounted.out, "serial T1"));
}

TEST_F(DisplayChoice, AnUnusableVariableIsAnError) {
    writeCalibration(studio_ / "visual.json");
    spill(studio_ / "broken.json", "{");
    for (const char* value : {"broken.json", "nothere.json", "views"}) {
        studio_.set("LKG_CALIBRATION", value);
        const Outcome outcome = run("-q 2x3 quilt.png native.png");
        EXPECT_TRUE(fails(outcome, 1, value));
        EXPECT_TRUE(holds(outcome.err, "LKG_CALIBRATION"));
    }
    studio_.set("LKG_CALIBRATION", ""); // as if it were not set
    EXPECT_TRUE(isDone(run("-q 2x3 quilt.png native.png")));
}

TEST_F(DisplayChoice, ABrokenCalibrationInTheWorkingDirectoryIsAnError) {
    spill(studio_ / "visual.json", "{}");
    EXPECT_TRUE(fails(run("quilt.png native.png"), 1, "visual.json"));
}

TEST_F(DisplayChoice, MapAndCalibrationGiveTheSameNative) {
    studio_.makeMap();
    const Arguments inputs("--quick -d photo.png depth.png");
    EXPECT_TRUE(isDone(studio_.convert("photo2native", inputs + Arguments{"c.png"})));
    EXPECT_TRUE(
        isDone(studio_.run("photo2native", Arguments("-m a.map") + inputs + Arguments{"m.png"})));
    EXPECT_TRUE(isDone(
        studio_.convert("photo2native", Arguments("-m a.map") + inputs + Arguments{"mc.png"})));
    const std::string expected = slurp(studio_ / "c.png");
    EXPECT_EQ(slurp(studio_ / "m.png"), expected);
    EXPECT_EQ(slurp(studio_ / "mc.png"), expected);
}

TEST_F(DisplayChoice, AMapOfAnotherDisplayOrQuiltIsRefused) {
    studio_.makeClip();
    studio_.makeSlide();
    studio_.makeScan();
    writeCalibration(studio_ / "other.json", {96, 128}, 50);
    ASSERT_TRUE(isDone(
        studio_.run("altiro3Dnative", Arguments("-m a.map") + kQuilt + Arguments{"other.json"})));
    ASSERT_TRUE(isDone(studio_.run("altiro3Dnative", "-m q.map -q 2x3 -r 30x20 small.json")));
    for (const std::string& tool : allTools()) {
        if (tool == "altiro3Dnative" || tool == "quilt2video") continue; // make or need no map
        Arguments call = studio_.goodCall(tool, outputName(tool, "native"));
        const Outcome display = studio_.run(tool, Arguments("-m a.map") + call);
        EXPECT_TRUE(fails(display, 1, "a.map"));
        EXPECT_TRUE(holds(display.err, "small.json"));
        if (tool == "native2view") continue;        // to which a map alone does not tell enough
        call.erase(call.begin(), call.begin() + 2); // no -c
        const Outcome quilt = studio_.run(tool, Arguments("-m q.map") + call);
        EXPECT_TRUE(fails(quilt, 1, "60 x 60 px"));
        EXPECT_TRUE(holds(quilt.err, "90 x 80 px"));
    }
    EXPECT_TRUE(fails(run("-m q.map quilt.png native.png"), 1, "90 x 80 px"));
}

TEST_F(DisplayChoice, DamagedMapsAreRefused) { // each kind of damage: the library's tests
    studio_.makeMap();
    std::string bytes = slurp(studio_ / "a.map");
    bytes[200] = static_cast<char>(bytes[200] ^ 0x10);
    spill(studio_ / "flipped.map", bytes);
    spill(studio_ / "empty.map", "");
    for (const auto& [name, problem] :
         {std::pair("flipped.map",
                    ": is corrupt: its checksum does not match, expected a table that is built "
                    "anew; altiro3Dnative makes tables"),
          std::pair("photo.png", ": is not a look-up table, expected a .map file; altiro3Dnative"),
          std::pair("empty.map", ": "), std::pair("views", ": ")})
        EXPECT_TRUE(
            fails(run({"-m", name, "quilt.png", "native.png"}), 1, std::string(name) + problem));
}

} // namespace altiro3D::test
