#include "altiro3D/display.hpp"
#include "altiro3D/native_lut.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"

#include <cstring>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTool = "altiro3Dnative";

std::uint32_t word(const std::string& bytes, std::size_t offset) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;)
        value = value << 8 | static_cast<unsigned char>(bytes.at(offset + i));
    return value;
}

NativeLut libraryLut(const Sandbox& sandbox) {
    QuiltLayout layout;
    layout.columns = 3;
    layout.rows = 2;
    layout.tileSize = {30, 40};
    layout.viewCount = 6;
    return {readCalibration(sandbox / "small.json"), layout};
}

} // namespace

TEST(Altiro3DNative, WritesTheTableOfTheLibrary) {
    SmallStudio studio;
    EXPECT_TRUE(
        isDone(studio.run(kTool, {"-m", "a.map", "-q", "2x3", "-r", "40x30", "small.json"})));
    libraryLut(studio).save(studio / "library.map");
    EXPECT_EQ(slurp(studio / "a.map"), slurp(studio / "library.map"));
}

TEST(Altiro3DNative, TheFileIsAsDocumented) {
    SmallStudio studio;
    ASSERT_TRUE(
        isDone(studio.run(kTool, {"-m", "a.map", "-q", "2x3", "-r", "40x30", "small.json"})));
    const std::string bytes = slurp(studio / "a.map");
    EXPECT_EQ(bytes.substr(0, 8), "ALTIRO3D");
    EXPECT_EQ(word(bytes, 8), 1U);
    const std::size_t headerBytes = word(bytes, 12);
    const std::vector<std::uint32_t> expected{96, 128, 90, 80, 3, 2, 6};
    for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_EQ(word(bytes, 16 + 4 * i), expected[i]) << "field " << i;
    constexpr std::size_t kMatrixBytes = std::size_t{96} * 128 * 4;
    ASSERT_EQ(bytes.size(), headerBytes + 3 * kMatrixBytes);
    const NativeLut lut = libraryLut(studio);
    for (int channel = 0; channel < 3; ++channel) {
        cv::Mat matrix(128, 96, CV_16UC2);
        const std::size_t start = headerBytes + static_cast<std::size_t>(channel) * kMatrixBytes;
        std::memcpy(matrix.data, bytes.data() + start, kMatrixBytes);
        EXPECT_TRUE(samePicture(matrix, lut.channel(channel))) << "channel " << channel;
    }
}

TEST(Altiro3DNative, TheNameComesFromSerialNumberAndQuilt) {
    SmallStudio studio;
    EXPECT_TRUE(isDone(studio.run(kTool, {"-q", "2x3", "-r", "40x30", "small.json"})));
    EXPECT_TRUE(fs::exists(studio / "TEST-1-2x3.map"));
    writeCalibration(studio / "odd.json", {96, 128}, 52.58, "../up/LKG");
    EXPECT_TRUE(isDone(studio.run(kTool, {"-q", "2x3", "-r", "40x30", "odd.json"})));
    EXPECT_TRUE(fs::exists(studio / "_._up_LKG-2x3.map"));
    writeCalibration(studio / "order.json", {96, 128}, 52.58, "-x\\u001b[31mY\\nZ$(a)");
    EXPECT_TRUE(isDone(studio.run(kTool, {"-q", "2x3", "-r", "40x30", "order.json"})));
    EXPECT_TRUE(fs::exists(studio / "_x__31mY_Z__a_-2x3.map"));
    const Outcome told = studio.run(kTool, {"--info", "order.json", "-q", "2x3"});
    EXPECT_TRUE(isDone(told));
    EXPECT_NE(told.out.find("serial -x [31mY Z$(a), panel "), std::string::npos) << told.out;
    EXPECT_EQ(told.out.find('\x1b'), std::string::npos);
    writeCalibration(studio / "nameless.json", {96, 128}, 52.58, "");
    EXPECT_TRUE(isDone(studio.run(kTool, {"-q", "2x3", "-r", "40x30", "nameless.json"})));
    EXPECT_TRUE(fs::exists(studio / "nameless-2x3.map"));
}

TEST(Altiro3DNative, InfoTellsWhatTheCalibrationMeansAndWritesNothing) {
    SmallStudio studio;
    const Outcome outcome = studio.run(kTool, {"--info", "small.json", "-q", "2x3"});
    EXPECT_TRUE(isDone(outcome));
    for (const char* part :
         {"serial TEST-1", "96 x 128 px", "lenses (P)", "tilt (T)", "lens (Px)", "offset (i_off)",
          "3 columns x 2 rows", "default quilt", "fingerprint"}) {
        EXPECT_NE(outcome.out.find(part), std::string::npos) << part << "\n" << outcome.out;
    }
    for (const auto& entry : fs::directory_iterator(studio.work()))
        EXPECT_NE(entry.path().extension(), ".map");
}

TEST(Altiro3DNative, JsonStandsAloneAndAgreesWithTheLibrary) {
    SmallStudio studio;
    const LensGeometry geometry = lensGeometry(readCalibration(studio / "small.json"));
    for (const Arguments& more :
         {Arguments{}, Arguments{"-v"}, Arguments{"-v", "-m", "a.map"}, Arguments{"--info"}}) {
        const Outcome outcome =
            studio.run(kTool, Arguments{"--json", "small.json", "-q", "2x3", "-r", "40x30"} + more);
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
    EXPECT_TRUE(fs::exists(studio / "a.map"));
}

TEST(Altiro3DNative, InvertChangesTheTable) {
    SmallStudio studio;
    const Arguments quilt{"-q", "2x3", "-r", "40x30", "small.json"};
    for (const char* mode : {"auto", "on", "off"}) {
        ASSERT_TRUE(isDone(studio.run(
            kTool, Arguments{"--invert", mode, "-m", std::string(mode) + ".map"} + quilt)));
    }
    EXPECT_EQ(slurp(studio / "auto.map"), slurp(studio / "on.map"));
    EXPECT_NE(slurp(studio / "on.map"), slurp(studio / "off.map"));
}

TEST(Altiro3DNative, BadCalibrationsAreNamed) {
    SmallStudio studio;
    spill(studio / "empty.json", "");
    spill(studio / "broken.json", R"({"pitch": {"value": 52.)");
    spill(studio / "array.json", "[1, 2, 3]");
    spill(studio / "words.json", R"({"pitch": "much", "slope": -7, "center": 0, "DPI": 324,
                                     "screenW": 96, "screenH": 128})");
    writeCalibration(studio / "huge.json", {100000, 128});
    writeCalibration(studio / "zero.json", {96, 128}, 0);
    fs::create_directory(studio / "folder.json");
    for (const char* file : {"empty.json", "broken.json", "array.json", "words.json", "huge.json",
                             "zero.json", "folder.json", "nothere.json"}) {
        EXPECT_TRUE(fails(studio.run(kTool, {"--json", "-m", "a.map", file}), 1, file));
    }
    EXPECT_FALSE(fs::exists(studio / "a.map"));
}

TEST(Altiro3DNative, SerialChoosesAmongSeveral) {
    SmallStudio studio;
    writeCalibration(studio / "a.json", {96, 128}, 52.58, "ONE");
    writeCalibration(studio / "b.json", {96, 128}, 50, "TWO");
    spill(studio / "both.json",
          "[" + slurp(studio / "a.json") + ", " + slurp(studio / "b.json") + "]");
    EXPECT_TRUE(warns(studio.run(kTool, {"--json", "both.json"}), "--serial"));
    const Outcome second = studio.run(kTool, {"--json", "both.json", "--serial", "two"});
    EXPECT_TRUE(isDone(second));
    EXPECT_NE(second.out.find("\"TWO\""), std::string::npos) << second.out;
    EXPECT_TRUE(fails(studio.run(kTool, {"both.json", "--serial", "THREE"}), 1, "THREE"));
}

TEST(Altiro3DNative, WarnsOfTheSwappedReading) {
    SmallStudio studio;
    EXPECT_TRUE(warns(studio.run(kTool, {"--info", "small.json", "-q", "6x8", "-r", "30x40"}),
                      "swapped reading"));
}

} // namespace altiro3D::test
