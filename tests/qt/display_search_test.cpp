#include "altiro3D/qt/display_search.hpp"

#include "support/files.hpp"

#include <QGuiApplication>
#include <QScreen>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

qt::ScreenFacts screen(const std::string& model, cv::Size size, double scale = 1) {
    qt::ScreenFacts facts;
    facts.name = "HDMI-1";
    facts.model = model;
    facts.size = size;
    facts.scale = scale;
    return facts;
}

const cv::Size kPortrait(1536, 2048);
const cv::Size kGo(1440, 2560);
const qt::ScreenFacts kMonitor = screen("U2720Q", {3840, 2160});

// A file system with volumes of displays.
class Mounts {
  public:
    void add(const std::string& volume, const std::string& serial, cv::Size panel,
             double center = 0.5) {
        write(volume, R"({"serial": ")" + serial +
                          R"(", "pitch": 52.58, "slope": -7.17, "center": )" +
                          std::to_string(center) + R"(, "DPI": 324, "screenW": )" +
                          std::to_string(panel.width) + R"(, "screenH": )" +
                          std::to_string(panel.height) + "}");
    }
    void write(const std::string& volume, const std::string& text) {
        const fs::path folder = root_ / ("media/user/" + volume + "/LKG_calibration");
        fs::create_directories(folder);
        spill(folder / "visual.json", text);
    }
    std::vector<qt::FoundDisplay> find(const std::vector<qt::ScreenFacts>& screens) const {
        return qt::findDisplays(screens, qt::findVolumes(root_.path()));
    }
    qt::FoundDisplay findOne(const std::vector<qt::ScreenFacts>& screens) const {
        const auto found = find(screens);
        EXPECT_EQ(found.size(), 1U);
        return found.empty() ? qt::FoundDisplay() : found[0];
    }

  private:
    TemporaryDirectory root_;
};

// The problem of a display that has one.
std::string problemOf(const qt::FoundDisplay& display) {
    EXPECT_EQ(display.problems.size(), 1U);
    return display.problems.empty() ? "" : display.problems[0];
}

TEST(DisplaySearch, NothingIsFoundWhereThereIsNothing) {
    EXPECT_TRUE(Mounts().find({}).empty());
    EXPECT_TRUE(Mounts().find({kMonitor, screen("", kPortrait)}).empty());
}

TEST(DisplaySearch, PairsSeveralDisplaysBySerialNumberNotBySize) {
    Mounts mounts;
    mounts.add("LKG-P00655", "LKG-PORT-", kPortrait, 0.1); // cut short, as some are
    mounts.add("LKG-P11063", "LKG-P11063", kPortrait, 0.2);
    mounts.add("LKG-E05304", "LKG-E05304", kGo);
    qt::ScreenFacts byName = screen("", kPortrait);
    byName.name = "Looking Glass lkg-p00655"; // as Windows and macOS name screens
    const auto found =
        mounts.find({screen("LKG-E05304", kGo), kMonitor, screen("LKG-P11063", kPortrait), byName});
    ASSERT_EQ(found.size(), 3U);
    const char* expected[] = {"LKG-E05304", "LKG-P11063", "LKG-P00655"};
    const std::size_t screens[] = {0, 2, 3};
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(found[i].name, expected[i]);
        EXPECT_EQ(found[i].screen, screens[i]);
        EXPECT_EQ(found[i].pairedBy, qt::PairedBy::Serial);
        EXPECT_TRUE(found[i].problems.empty()) << found[i].problems.front();
    }
    EXPECT_EQ(found[2].calibration->center, 0.1);
}

TEST(DisplaySearch, PairsAScreenByTheSizeThatItsScaleHasRounded) {
    Mounts mounts;
    mounts.add("LKG-P00655", "LKG-PORT-00655", kPortrait);
    const auto found = mounts.findOne({kMonitor, screen("LKG", {1537, 2049}, 1.75)});
    EXPECT_EQ(found.screen, 1U);
    EXPECT_EQ(found.pairedBy, qt::PairedBy::Size);
    EXPECT_EQ(problemOf(found).find("the desktop scales this screen"), 0U);
}

TEST(DisplaySearch, PairsBySizeWhereNothingElseCouldBeMeant) {
    Mounts mounts;
    mounts.add("LKG-P00655", "LKG-PORT-00655", kPortrait);
    const auto found = mounts.findOne({kMonitor, screen("", kPortrait)});
    EXPECT_EQ(found.screen, 1U);
    EXPECT_EQ(found.pairedBy, qt::PairedBy::Size);
    EXPECT_TRUE(found.problems.empty());
    const auto two = mounts.findOne({screen("", kPortrait), screen("", kPortrait)});
    EXPECT_FALSE(two.screen);
    EXPECT_EQ(two.problems.size(), 1U);
    // a screen of a display's name wins over one that only has the size
    EXPECT_EQ(mounts.findOne({screen("", kPortrait), screen("LKG01Do12HjQE", kPortrait)}).screen,
              1U);
}

TEST(DisplaySearch, ACubeViIsFoundByItsNameAndByItsSize) {
    Mounts mounts;
    const auto named = mounts.findOne({kMonitor, screen("CubeVi", kGo)});
    EXPECT_EQ(named.screen, 1U);
    EXPECT_TRUE(holds(problemOf(named), "give its visual.json"));
    mounts.write("LKG-C1", R"({"lineNumber":19.6,"obliquity":0.1,"deviation":1})");
    const auto bySize = mounts.findOne({kMonitor, screen("", kGo)});
    EXPECT_EQ(bySize.screen, 1U);
    EXPECT_TRUE(bySize.problems.empty());
}

TEST(DisplaySearch, SaysWhichPartIsMissing) {
    Mounts mounts;
    const auto screenOnly = mounts.findOne({screen("LKG-P00655", kPortrait)});
    EXPECT_EQ(screenOnly.name, "LKG-P00655");
    EXPECT_FALSE(screenOnly.calibration);
    EXPECT_TRUE(holds(problemOf(screenOnly), "visual.json"));
    mounts.add("LKG-E05304", "LKG-E05304", kGo);
    EXPECT_TRUE(holds(problemOf(mounts.findOne({kMonitor})), "1440 x 2560"));
}

TEST(DisplaySearch, BrokenCalibrationsAreProblemsNotErrors) {
    Mounts mounts;
    mounts.write("LKG-P00655", "{}");
    const auto found = mounts.findOne({screen("LKG-P00655", kPortrait)});
    EXPECT_EQ(found.screen, 0U);
    EXPECT_FALSE(found.calibration);
    EXPECT_TRUE(holds(problemOf(found), "visual.json"));
}

TEST(DisplaySearch, ReportsDesktopSettingsThatChangePixels) {
    EXPECT_TRUE(qt::problemsOf(screen("", kPortrait), kPortrait).empty());
    // 1536 px are 877 or 878 of a desktop at 175 %, and those times 1.75 are 1535 or 1537.
    for (const cv::Size rounded : {cv::Size(1535, 2048), cv::Size(1537, 2049)}) {
        EXPECT_EQ(qt::problemsOf(screen("", rounded, 1.75), kPortrait).size(), 1U);
        EXPECT_EQ(qt::problemsOf(screen("", rounded), kPortrait).size(), 1U); // another mode
    }
    EXPECT_EQ(qt::problemsOf(screen("", {1539, 2048}, 1.75), kPortrait).size(), 2U);
    const auto one = [](const qt::ScreenFacts& facts) {
        const auto problems = qt::problemsOf(facts, kPortrait);
        return problems.size() == 1 ? problems[0] : std::to_string(problems.size());
    };
    EXPECT_TRUE(holds(one(screen("", kPortrait, 1.5)), "150 %"));
    EXPECT_TRUE(holds(one(screen("", {2048, 1536})), "rotation"));
    EXPECT_TRUE(
        holds(one(screen("", {1920, 1080})), "1920 x 1080 px, but the panel has 1536 x 2048"));
    for (const cv::Size shown : {cv::Size(3072, 4096), cv::Size(1152, 1536), cv::Size(1921, 2560)})
        EXPECT_TRUE(holds(one(screen("", shown)), "the scale of the main screen counts for all"));
    Mounts mounts;
    mounts.add("LKG-P00655", "LKG-P00655", kPortrait);
    EXPECT_EQ(mounts.findOne({screen("LKG-P00655", {1920, 1080}, 2)}).problems.size(), 2U);
}

TEST(DisplaySearch, ChoosesTheDisplayThatANativeIsFor) {
    Mounts mounts;
    mounts.add("LKG-P00655", "LKG-P00655", kPortrait, 0.1);
    mounts.add("LKG-P11063", "LKG-P11063", kPortrait, 0.2);
    mounts.add("LKG-E05304", "LKG-E05304", kGo);
    const std::vector<qt::ScreenFacts> screens{kMonitor, screen("LKG-P00655", kPortrait),
                                               screen("LKG-P11063", kPortrait),
                                               screen("LKG-E05304", kGo)};
    const auto found = mounts.find(screens);
    ASSERT_EQ(found.size(), 3U);
    EXPECT_EQ(qt::chooseDisplay(found, screens, found[1].calibration, kPortrait), 1U);
    EXPECT_EQ(qt::chooseDisplay(found, screens, std::nullopt, kGo), 2U);
    EXPECT_FALSE(qt::chooseDisplay(found, screens, std::nullopt, kPortrait));
    EXPECT_FALSE(qt::chooseDisplay(found, screens, std::nullopt, {640, 480}));
    const std::vector<qt::ScreenFacts> alone{screens[1]};
    EXPECT_EQ(qt::chooseDisplay(mounts.find(alone), alone, std::nullopt, {640, 480}), 0U);
    EXPECT_FALSE(qt::chooseDisplay({}, {}, std::nullopt, kPortrait));
}

TEST(DisplaySearch, ReadsTheFactsOfRealScreens) {
    const QScreen* primary = QGuiApplication::primaryScreen();
    const qt::ScreenFacts facts = qt::factsOf(*primary);
    EXPECT_EQ(facts.name, primary->name().toStdString());
    EXPECT_EQ(facts.size.width, qRound(primary->size().width() * primary->devicePixelRatio()));
    EXPECT_EQ(facts.scale, primary->devicePixelRatio());
}

} // namespace
} // namespace altiro3D::test
