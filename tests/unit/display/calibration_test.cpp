#include "altiro3D/display.hpp"

#include "support/files.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/imgcodecs.hpp>

namespace altiro3D::test {
namespace {

const std::string kPortrait = R"({"configVersion":"1.0","serial":"LKG-PORT-00001",
  "pitch":{"value":52.5},"slope":{"value":-7.2},"center":{"value":0.4},"DPI":{"value":324},
  "screenW":{"value":1536.0},"screenH":{"value":2048}})";

// kPortrait with one field's value replaced by another text.
std::string with(const std::string& field, const std::string& value) {
    std::string text = kPortrait;
    const auto at = text.find("\"" + field + "\"");
    const auto colon = text.find(':', at);
    const auto end = text.find('}', colon) + 1;
    return text.replace(colon + 1, end - colon - 1, value);
}

Calibration parseCalibration(const std::string& text, const std::string& source) {
    return parseCalibrations(text, source).front();
}

TEST(Calibration, WrappedAndBareNumbersIntsFloatsAndNumericStringsAreEqual) {
    const Calibration wrapped = parseCalibration(kPortrait, "a");
    const Calibration bare = parseCalibration(
        R"({"pitch":52.5,"slope":"-7.2","center":0.4,"DPI":324.0,"screenW":1536,"screenH":2048.0})",
        "b");
    EXPECT_EQ(fingerprint(wrapped), fingerprint(bare));
    EXPECT_EQ(wrapped.serial, "LKG-PORT-00001");
    EXPECT_EQ(bare.serial, "");
    EXPECT_EQ(wrapped.screenW, 1536);
}

TEST(Calibration, MissingOptionalFieldsTakeTheirDefaults) {
    const Calibration c = parseCalibration(kPortrait, "a");
    EXPECT_EQ(c.invView, 1);
    EXPECT_EQ(c.flipImageX, 0);
    EXPECT_EQ(c.flipSubp, 0);
    EXPECT_EQ(c.CellPatternMode, 0);
    EXPECT_TRUE(c.subpixelCells.empty());
    EXPECT_EQ(c.missing, (std::vector<std::string>{"viewCone", "invView"}));
    std::string text = kPortrait;
    text.insert(1, R"("viewCone":40,)");
    EXPECT_EQ(parseCalibration(text, "a").missing, std::vector<std::string>{"invView"});
}

TEST(Calibration, ByteOrderMarkContainersAndTextInTextAreUnderstood) {
    const std::uint64_t plain = fingerprint(parseCalibration(kPortrait, "a"));
    const std::string service = R"({"devices":[{"defaultQuilt":{"quiltX":1},"calibration":)" +
                                kPortrait + R"(}],"version":3})";
    std::string quoted;
    for (char c : kPortrait) {
        if (c == '"') quoted += '\\';
        if (c != '\n') quoted += c;
    }
    EXPECT_EQ(fingerprint(parseCalibration("\xEF\xBB\xBF" + kPortrait, "a")), plain);
    EXPECT_EQ(fingerprint(parseCalibration(service, "a")), plain);
    EXPECT_EQ(fingerprint(parseCalibration("{\"configValue\":" + kPortrait + "}", "a")), plain);
    EXPECT_EQ(fingerprint(parseCalibration("{\"value\":\"" + quoted + "\"}", "a")), plain);
    EXPECT_EQ(parseCalibrations("[" + kPortrait + "," + kPortrait + "]", "a").size(), 2U);
}

TEST(Calibration, ErrorNamesFileFieldValueAndExpectation) {
    const auto error = [](const std::string& text) {
        return errorOf([&] { parseCalibration(text, "visual.json"); });
    };
    EXPECT_EQ(error(with("pitch", "{\"value\":-1}")),
              "visual.json: pitch is -1, expected lenses per inch, a number > 0");
    EXPECT_EQ(error(with("slope", "0")), "visual.json: slope is 0, expected a number other than 0");
    EXPECT_EQ(error(with("DPI", "\"many\"")),
              "visual.json: DPI is \"many\", expected px per inch, a number > 0");
    EXPECT_EQ(error(with("screenW", "1536.5")),
              "visual.json: screenW is 1536.5, expected whole px, 16..16384");
    EXPECT_EQ(error(with("screenH", "20000")),
              "visual.json: screenH is 20000, expected whole px, 16..16384");
    EXPECT_EQ(error(with("center", "null")),
              "visual.json: center is missing, expected a finite number");
    EXPECT_EQ(error(with("center", "[1]")),
              "visual.json: center is a list, expected a finite number");
    EXPECT_EQ(error(R"({"pitch":50,"screenW":1536})"),
              "visual.json: slope is missing, expected a number other than 0");
    EXPECT_EQ(error("{}"),
              "visual.json: holds no calibration, expected an object with pitch, slope "
              "and center");
    EXPECT_TRUE(holds(error("{\"pitch\":"), "is not valid JSON (line 1, column 10)"));
    EXPECT_TRUE(holds(error(""), "visual.json: is not valid JSON"));
}

TEST(Calibration, CellsAreCheckedOneByOne) {
    const std::string cell = R"({"ROffsetX":-0.3,"ROffsetY":0.25,"GOffsetX":0.3,"GOffsetY":0.25,)"
                             R"("BOffsetX":0,"BOffsetY":-0.25})";
    std::string text = kPortrait;
    text.insert(1, "\"CellPatternMode\":{\"value\":2.0},\"subpixelCells\":[" + cell + "," + cell +
                       "],");
    const Calibration c = parseCalibration(text, "a");
    ASSERT_EQ(c.subpixelCells.size(), 2U);
    EXPECT_EQ(c.CellPatternMode, 2);
    EXPECT_EQ(c.subpixelCells[0].x[1], 0.3);
    EXPECT_EQ(c.subpixelCells[1].y[2], -0.25);
    const auto replaced = [&](const std::string& from, const std::string& to) {
        std::string broken = text;
        broken.replace(broken.find(from), from.size(), to);
        return errorOf([&] { parseCalibration(broken, "a"); });
    };
    EXPECT_EQ(replaced("\"BOffsetY\":-0.25", "\"BOffsetZ\":1"),
              "a: subpixelCells[0]: BOffsetY is missing, expected px, -1..1");
    EXPECT_EQ(replaced("\"BOffsetY\":-0.25", "\"BOffsetY\":1.5"),
              "a: subpixelCells[0] offset is 1.5, expected px, -1..1");
    EXPECT_EQ(replaced("{\"value\":2.0}", "7"),
              "a: CellPatternMode is 7, expected a whole number, 0..4");
}

TEST(Calibration, TheErrorForAPictureSaysThatItIsOne) {
    std::vector<uchar> png;
    cv::imencode(".png", cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(0)), png);
    EXPECT_EQ(errorOf([&] { parseCalibration(std::string(png.begin(), png.end()), "a.png"); }),
              "a.png: is a picture, expected a display's visual.json");
}

TEST(Calibration, DeepNestingIsRefusedWithoutRunningOutOfStack) {
    const std::string bomb(100000, '[');
    EXPECT_TRUE(holds(errorOf([&] { parseCalibration(bomb, "a"); }), "nests deeper"));
}

TEST(Calibration, ObjectsOfManyMembersAreRefusedBeforeTheyTakeTime) {
    std::string bomb = "{\"a\": 0";
    for (int i = 0; i < 300000; ++i)
        bomb += ",\"" + std::to_string(i) + "\":0";
    EXPECT_TRUE(
        holds(errorOf([&] { parseCalibration(bomb + "}", "a"); }), "more than 1000 members"));
}

// Text in text is parsed as JSON, where each member is compared with all before it: here for
// minutes.
TEST(Calibration, AFieldsTextIsReadAsANumberAndNothingElse) {
    std::string members = "{\\\"a\\\":0";
    for (int i = 0; i < 300000; ++i)
        members += ",\\\"" + std::to_string(i) + "\\\":0";
    EXPECT_TRUE(holds(errorOf([&] { parseCalibration(with("DPI", '"' + members + "}\""), "a"); }),
                      "a: DPI is \"{"));
    EXPECT_TRUE(holds(errorOf([&] { parseCalibration(with("DPI", "\"[324]\""), "a"); }), "DPI is"));
    EXPECT_EQ(parseCalibration(with("DPI", "\" 3.24e2 \""), "a").DPI, 324);
}

TEST(Calibration, LimitsOfDoublesAreRefusedByField) {
    const double bad[] = {std::numeric_limits<double>::infinity(), std::nan(""), 0.0};
    for (double value : bad) {
        Calibration c = parseCalibration(kPortrait, "a");
        c.pitch = value;
        EXPECT_TRUE(holds(errorOf([&] { validate(c); }), "calibration: pitch is"));
        c = parseCalibration(kPortrait, "a");
        c.DPI = value;
        EXPECT_TRUE(holds(errorOf([&] { lensGeometry(c); }), ": DPI is"));
    }
    Calibration c = parseCalibration(kPortrait, "a");
    c.slope = 1e-300; // each field is valid, but together they are not a lens array
    EXPECT_TRUE(holds(errorOf([&] { validate(c); }), "describe no lens array"));
    c = parseCalibration(kPortrait, "a");
    c.center = 1e300;
    EXPECT_EQ(errorOf([&] { validate(c); }),
              "calibration: center is 1e+300, expected lens periods, -1e6..1e6");
    c.center = std::nan("");
    EXPECT_TRUE(holds(errorOf([&] { validate(c); }), "center is nan"));
}

TEST(Calibration, LensesMayBeVertical) {
    Calibration c = parseCalibration(kPortrait, "a");
    for (const double slope : {1e9, -1e9, 1e200, std::numeric_limits<double>::max()}) {
        c.slope = slope;
        const LensGeometry g = lensGeometry(c);
        const double period = 3 * c.DPI / c.pitch; // of an untilted lens, sub-pixels
        EXPECT_NEAR(g.lensPeriodSubpixels, period, 1e-9) << slope;
        EXPECT_NEAR(g.offsetSubpixels, c.center * period - 1.5, 1e-4) << slope;
        EXPECT_NEAR(g.phase(700, 0, 1), g.phase(700, c.screenH - 1, 1), 1e-6) << slope;
    }
}

TEST(Calibration, FingerprintSeesWhatChangesThePictureAndNothingElse) {
    const Calibration base = parseCalibration(kPortrait, "a");
    Calibration other = base;
    other.serial = "LKG-PORT-99999";
    other.viewCone = 50;
    EXPECT_EQ(fingerprint(other), fingerprint(base));
    other = base;
    other.center += 1e-9;
    EXPECT_NE(fingerprint(other), fingerprint(base));
    other = base;
    other.invView = 0;
    EXPECT_NE(fingerprint(other), fingerprint(base));
    EXPECT_EQ(fingerprintText(0x0123456789abcdefULL), "0123456789abcdef");
}

TEST(Calibration, EveryRealFileIsRead) {
    ALTIRO3D_REQUIRE_DATA("calibrations");
    for (const std::filesystem::path& file : realCalibrations()) {
        EXPECT_EQ(errorOf([&] { lensGeometry(readCalibration(file)); }), "(no error)") << file;
    }
    const std::vector<Calibration> templates =
        readCalibrations(dataPath("calibrations/templates_LKG-Toolkit_nominal.json"));
    EXPECT_EQ(templates.size(), 14U);
    for (const Calibration& calibration : templates) {
        EXPECT_EQ(errorOf([&] { lensGeometry(calibration); }), "(no error)") << calibration.serial;
    }
}

// P, T and Px of known units, computed elsewhere from the published formula.
TEST(LensGeometry, EqualsTheTableOfDerivedConstants) {
    ALTIRO3D_REQUIRE_DATA("calibrations");
    const struct {
        const char* file;
        double P, T, Px;
    } kTable[] = {
        {"portrait_altiro3D-manual_LKG-PORT-19930", 246.9047532689, -0.185722724168, 18.66306719},
        {"portrait_stepit-holo_LKG-PORT-00000", 246.9100175182, -0.186183410235, 18.66266928},
        {"portrait_Rezmason-matrix_P11063", 246.8628039017, -0.186606350113, 18.66623860},
        {"gen1-8.9in_LKG-2K-04409", 354.3958591525, -0.114051094494, 21.67068210},
        {"gen1-8.9in_serial-00112_positive-slope", 370.6246938616, 0.119822872920, 20.72177091},
        {"gen2-16in_LKG-APW92011", 673.4608856975, -0.074780801514, 17.10567049},
        {"gen3-16in-landscape_LKG-J00133", 600.8171185510, -0.082055756691, 19.17388777},
        {"gen3-go_bare-numbers_owner", 234.1813507834, -0.266982640080, 18.44724179}};
    for (const auto& row : kTable) {
        const LensGeometry g = lensGeometry(
            readCalibration(dataPath(std::string("calibrations/") + row.file + ".json")));
        EXPECT_NEAR(g.periodsPerWidth / row.P, 1, 1e-9) << row.file;
        EXPECT_NEAR(g.tilt / row.T, 1, 1e-9) << row.file;
        EXPECT_NEAR(g.lensPeriodSubpixels / row.Px, 1, 1e-9) << row.file;
    }
    const LensGeometry manual = lensGeometry(
        readCalibration(dataPath("calibrations/portrait_altiro3D-manual_LKG-PORT-19930.json")));
    EXPECT_NEAR(manual.offsetSubpixels, 862.7345095353363, 1e-8);
    EXPECT_NEAR(manual.lensPeriodSubpixels, 18.663067190857234, 1e-12);
}

// The published Eq. (1): frac((i - i_off - 3 j tan a) / Px), i the sub-pixel column.
TEST(LensGeometry, PhaseEqualsThePublishedEquation) {
    const Calibration c = parseCalibration(kPortrait, "a");
    const LensGeometry g = lensGeometry(c, InvertViews::Off);
    for (int y = 0; y < c.screenH; y += 37) {
        for (int x = 0; x < c.screenW; x += 11) {
            for (int k = 0; k < 3; ++k) {
                const double turns =
                    (3 * x + k - g.offsetSubpixels - 3 * y / c.slope) / g.lensPeriodSubpixels;
                const double published = turns - std::floor(turns);
                const double difference = std::abs(g.phase(x, y, k) - published);
                EXPECT_LT(std::min(difference, 1 - difference), 1e-9); // circular
            }
        }
    }
}

TEST(LensGeometry, InversionIsAsTheFileSaysOnStripesAndAlwaysOnCells) {
    Calibration c = parseCalibration(kPortrait, "a");
    EXPECT_TRUE(lensGeometry(c).inverted);
    c.invView = 0;
    EXPECT_FALSE(lensGeometry(c).inverted);
    EXPECT_TRUE(lensGeometry(c, InvertViews::On).inverted);
    c.subpixelCells.resize(1);
    EXPECT_TRUE(lensGeometry(c).inverted);
    EXPECT_FALSE(lensGeometry(c, InvertViews::Off).inverted);
}

TEST(LensGeometry, CellsRepeatAsTheirPatternSays) {
    Calibration c = parseCalibration(kPortrait, "a");
    c.subpixelCells.resize(4);
    const int bottom = c.screenH - 1;
    const auto cell = [&](int mode, int x, int fromBottom) {
        c.CellPatternMode = mode;
        return lensGeometry(c).cellIndex(x, bottom - fromBottom);
    };
    EXPECT_EQ(cell(0, 3, 3), 0);
    EXPECT_EQ(cell(1, 3, 2), 1);
    EXPECT_EQ(cell(2, 3, 0), 1);
    EXPECT_EQ(cell(3, 3, 3), 1); // (3 + 2) mod 4
    EXPECT_EQ(cell(3, 2, 3), 3);
    EXPECT_EQ(cell(4, 2, 3), 1);
    c.subpixelCells.resize(2); // fewer cells than the pattern knows
    EXPECT_EQ(cell(3, 2, 3), 1);
}

} // namespace
} // namespace altiro3D::test
