#include "altiro3D/display.hpp"
#include "altiro3D/native_lut.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/reference.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <tuple>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTool = "altiro3Dnative";

} // namespace

class Altiro3DNative : public StudioTest {
  protected:
    Altiro3DNative() : StudioTest(kTool) {}
};

TEST_F(Altiro3DNative, WritesTheTableOfTheLibrary) { // its layout: NativeLutFile
    EXPECT_TRUE(isDone(run("-m a.map -q 2x3 -r 40x30 small.json")));
    NativeLut(readCalibration(studio_ / "small.json"), smallLayout()).save(studio_ / "library.map");
    EXPECT_EQ(slurp(studio_ / "a.map"), slurp(studio_ / "library.map"));
}

TEST_F(Altiro3DNative, TheNameComesFromSerialNumberAndQuilt) {
    EXPECT_TRUE(isDone(run("-q 2x3 -r 40x30 small.json")));
    EXPECT_TRUE(fs::exists(studio_ / "TEST-1-2x3.map"));
    writeCalibration(studio_ / "odd.json", {96, 128}, 52.58, "../up/LKG");
    EXPECT_TRUE(isDone(run("-q 2x3 -r 40x30 odd.json")));
    EXPECT_TRUE(fs::exists(studio_ / "_._up_LKG-2x3.map"));
    writeCalibration(studio_ / "order.json", {96, 128}, 52.58, "-x\\u001b[31mY\\nZ$(a)");
    EXPECT_TRUE(isDone(run("-q 2x3 -r 40x30 order.json")));
    EXPECT_TRUE(fs::exists(studio_ / "_x__31mY_Z__a_-2x3.map"));
    const Outcome told = run("--info order.json -q 2x3");
    EXPECT_TRUE(says(told, "serial -x [31mY Z$(a), panel "));
    EXPECT_FALSE(holds(told.out, "\x1b"));
    writeCalibration(studio_ / "nameless.json", {96, 128}, 52.58, "");
    EXPECT_TRUE(isDone(run("-q 2x3 -r 40x30 nameless.json")));
    EXPECT_TRUE(fs::exists(studio_ / "nameless-2x3.map"));
}

TEST_F(Altiro3DNative, InfoTellsWhatTheCalibrationMeansAndWritesNothing) {
    const Outcome outcome = run("--info small.json -q 2x3");
    EXPECT_TRUE(isDone(outcome));
    for (const char* part :
         {"serial TEST-1", "96 x 128 px", "lenses (P)", "tilt (T)", "lens (Px)", "offset (i_off)",
          "3 columns x 2 rows", "default quilt", "fingerprint"}) {
        EXPECT_TRUE(holds(outcome.out, part)) << "\n";
    }
    for (const auto& entry : fs::directory_iterator(studio_.work()))
        EXPECT_NE(entry.path().extension(), ".map");
}

// By the formula of docs/mathematics.md, written once more in the tests.
TEST_F(Altiro3DNative, InfoDrawsOneLens) {
    const Calibration c = readCalibration(studio_ / "small.json");
    std::string drawn = "one lens     ";
    for (int x = 48; x < 48 + 7; ++x) { // 18.7 sub-pixels
        if (x > 48) drawn += " |";
        for (int colour = 0; colour < 3; ++colour)
            drawn += ' ' + std::to_string(referenceView(c, true, 6, x, 64, colour));
    }
    EXPECT_TRUE(says(run("--info small.json -q 2x3"), drawn + "  (views of red"));
}

TEST_F(Altiro3DNative, InfoWarnsOfAFileOfAnotherUnitAndOfOldFirmware) {
    const fs::path folder = studio_ / "LKG-P00655/LKG_calibration";
    fs::create_directories(folder);
    const std::string file = (folder / "visual.json").string();
    for (const char* serial : {"LKG-PORT-00655", "LKG-P00655", "LKG-PORT-", ""}) {
        writeCalibration(file, {96, 128}, 52.58, serial);
        EXPECT_FALSE(holds(run({"--info", "-q", "2x3", file}).err, "another unit's")) << serial;
    }
    writeCalibration(file, {96, 128}, 52.58, "X-00656");
    EXPECT_TRUE(warns(run({"--info", "-q", "2x3", file}),
                      "visual.json: is of X-00656, but lies on the volume LKG-P00655"));
    EXPECT_TRUE(isDone(run({"-q", "2x3", "-r", "40x30", file}))); // tables are made without a word
    std::string text = slurp(studio_ / "small.json");
    const std::string field = R"("invView": {"value": 1}, )";
    text.erase(text.find(field), field.size());
    spill(studio_ / "old.json", text);
    EXPECT_TRUE(
        warns(run("--info old.json -q 2x3"), "old.json: lacks invView, as of old firmware"));
}

TEST_F(Altiro3DNative, JsonStandsAloneAndAgreesWithTheLibrary) {
    const LensGeometry geometry = lensGeometry(readCalibration(studio_ / "small.json"));
    for (const Arguments& more :
         {Arguments{}, Arguments{"-v"}, Arguments("-v -m a.map"), Arguments{"--info"}}) {
        const Outcome outcome = run(Arguments("--json small.json -q 2x3 -r 40x30") + more);
        ASSERT_TRUE(isDone(outcome));
        const auto json = nlohmann::json::parse(outcome.out, nullptr, false);
        ASSERT_FALSE(json.is_discarded()) << outcome.text();
        EXPECT_EQ(json.at("serial"), "TEST-1");
        EXPECT_EQ(json.at("panelWidth"), 96);
        EXPECT_EQ(json.at("P"), geometry.periodsPerWidth);
        EXPECT_EQ(json.at("Px"), geometry.lensPeriodSubpixels);
        EXPECT_EQ(json.at("iOff"), geometry.offsetSubpixels);
        EXPECT_EQ(json.at("quilt").at("columns"), 3);
        EXPECT_EQ(json.at("quilt").at("rows"), 2);
    }
    EXPECT_TRUE(fs::exists(studio_ / "a.map"));
}

TEST_F(Altiro3DNative, InvertChangesTheTable) {
    const Arguments quilt("-q 2x3 -r 40x30 small.json");
    for (const char* mode : {"auto", "on", "off"}) {
        ASSERT_TRUE(
            isDone(run(Arguments{"--invert", mode, "-m", std::string(mode) + ".map"} + quilt)));
    }
    EXPECT_EQ(slurp(studio_ / "auto.map"), slurp(studio_ / "on.map"));
    EXPECT_NE(slurp(studio_ / "on.map"), slurp(studio_ / "off.map"));
}

TEST_F(Altiro3DNative, BadCalibrationsAreNamed) { // all: Calibration
    spill(studio_ / "broken.json", R"({"pitch": {"value": 52.)");
    fs::create_directory(studio_ / "folder.json");
    for (const char* file : {"broken.json", "folder.json"})
        EXPECT_TRUE(fails(run({"--json", "-m", "a.map", file}), 1, file));
    EXPECT_FALSE(fs::exists(studio_ / "a.map"));
}

TEST_F(Altiro3DNative, SerialChoosesAmongSeveral) {
    writeCalibration(studio_ / "a.json", {96, 128}, 52.58, "ONE");
    writeCalibration(studio_ / "b.json", {96, 128}, 50, "TWO");
    spill(studio_ / "both.json",
          "[" + slurp(studio_ / "a.json") + ", " + slurp(studio_ / "b.json") + "]");
    EXPECT_TRUE(warns(run("--json both.json"), "--serial"));
    EXPECT_TRUE(says(run("--json both.json --serial two"), "\"TWO\""));
    EXPECT_TRUE(fails(run("both.json --serial THREE"), 1, "THREE"));
}

TEST_F(Altiro3DNative, ReadUsbTakesOneNameAndNoOptionsOfTables) {
    EXPECT_TRUE(fails(run("--read-usb"), 2, "one file to write"));
    EXPECT_TRUE(fails(run("--read-usb a.json b.json"), 2, "one file to write"));
    EXPECT_TRUE(fails(run("--read-usb --info a.json"), 2, "exclude each other"));
    EXPECT_TRUE(fails(run("--read-usb small.json"), 1, "small.json"));
    if (!findUsbDisplays().empty()) GTEST_SKIP() << "a display is connected here";
    EXPECT_TRUE(fails(run("--read-usb a.json"), 1, "USB"));
    EXPECT_FALSE(fs::exists(studio_ / "a.json"));
}

TEST_F(Altiro3DNative, MakesTheCalibrationOfAPrintFromNumbers) {
    const Outcome made = run("--lens lpi=60,dpi=720x360,size=10x15mm,angle=2,views=7,thickness=0.6,"
                             "index=1.56,distance=400 print.json");
    EXPECT_TRUE(isDone(made));
    EXPECT_TRUE(says(made, "sharp depth"));
    const Calibration c = readCalibration(studio_ / "print.json");
    EXPECT_EQ(cv::Size(c.screenW, c.screenH), cv::Size(283, 213));
    ASSERT_TRUE(c.sheet);
    EXPECT_EQ(c.sheet->views, 7);
    EXPECT_EQ(c.sheet->distance, 400);
    EXPECT_TRUE(isDone(run("-m print.map print.json")));
    EXPECT_EQ(NativeLut::load(studio_ / "print.map").quilt().viewCount, 7);
    EXPECT_TRUE(
        says(run("--info print.json"), "print         10.0 x 15.0 mm, 720 x 360 dpi, 60 LPI"));
    const auto json = nlohmann::json::parse(run("--json print.json").out);
    EXPECT_NEAR(json["lens"]["lpi"], 60, 1e-9);
    EXPECT_TRUE(json["lens"]["print"]);

    EXPECT_TRUE(isDone(run("--lens lpi=60,dpi=720,size=10x15mm plain.json")));
    for (const char* const size : {"1 x 2in", "1x2\"", "2.54cmx50.8mm"}) {
        EXPECT_TRUE(isDone(
            run({"--lens", std::string("lpi=60, dpi = 720, size=") + size, "-y", "in.json"})));
        const Calibration print = readCalibration(studio_ / "in.json");
        EXPECT_EQ(print.screenH, 1440) << size; // 2 inches
        EXPECT_EQ(print.screenW, 720) << size;
    }
    const Outcome plain = run("--info plain.json");
    EXPECT_TRUE(says(plain, "useful views  12 (dpi / LPI)"));
    for (const char* unknown : {"viewing cone", "visual pitch", "sharp depth"})
        EXPECT_FALSE(says(plain, unknown)) << unknown;
    EXPECT_TRUE(isDone(run("--lens lpi=40,dpi=326,size=20x20mm,subpixels=vrgb screen.json")));
    EXPECT_TRUE(says(run("--info screen.json"), "screen        20.0 x 20.0 mm, 326 dpi, 40 LPI"));
}

TEST_F(Altiro3DNative, BadNumbersOfALensAreNamed) {
    const std::tuple<const char*, int, const char*> cases[] = {
        {"lpi=361,dpi=720,size=10x15mm", 1,
         "error: lpi: is 361, expected at most 360, with two px under a lens"},
        {"lpi=60,dpi=720,size=10x15mm,angle=90", 1,
         "error: angle: is 90, expected -45..45 degrees from the vertical; lying lenses are "
         "horizontal=yes"},
        {"lpi=60,dpi=720,size=10x0mm", 1, "height: is 0, expected "},
        {"lpi=60,size=10x15mm", 2, "--lens: dpi is missing"},
        {"lpi=60,dpi=720,size=10x15ft", 2,
         "--lens: size=10x15ft has the unit ft, expected mm, cm or in"},
        {"lpi=60lpi,dpi=720", 2, "has the unit lpi, expected a number"},
        {"lpi=60,dpi=720,size=tenx15mm", 2,
         "size=tenx15mm is not one of its numbers, expected size=100x150mm or 4x6in"},
        {"lpi=60,colour=3", 2, "expected lpi, dpi, size"},
        {"lpi=60,lpi=61", 2, "lpi is given twice"},
        {"lpi=60,dpi=720,size=10x15mm,views=1e9", 2, "views=auto or 2..1024"},
        {"lpi=60,dpi=720,size=30x20mm,order=0:1", 2, "order is in sub-pixels"},
        {"panel=64x48", 2, "pitch is missing"},
        {"panel=64x48,pitch=4,lpi=60", 2, "lpi is of a lens sheet"},
        {"panel=64x48,pitch=4,slope=1,angle=3", 2, "angle and slope are both given"},
        {"panel=64x48,pitch=4,subpixels=vrgb", 2, "expected subpixels=rgb|bgr"},
        {"panel=64.5x48,pitch=4", 2, "panel is not one of its numbers, expected whole px"},
        {"panel=64x48,pitch=4,order=0:x", 2, "order=0:x is not one of its numbers"}};
    for (const auto& [numbers, status, problem] : cases)
        EXPECT_TRUE(fails(run({"--lens", numbers, "print.json"}), status, problem));
    for (const char* other : {"--mpv-shader s.glsl", "--read-usb", "--read-bridge", "--info",
                              "--sampling nearest", "-q 2x3"}) {
        EXPECT_TRUE(fails(run(Arguments("--lens lpi=60,dpi=720,size=10x15mm") + Arguments(other) +
                              Arguments{"print.json"}),
                          2, "is about a calibration that exists"));
    }
    EXPECT_FALSE(fs::exists(studio_ / "print.json"));
}

} // namespace altiro3D::test
