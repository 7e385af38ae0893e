#include "altiro3D/qt/display_search.hpp"

#include "support/files.hpp"
#include "support/texts.hpp"

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

  private:
    TemporaryDirectory root_;
};

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
    const auto found = mounts.find({kMonitor, screen("LKG", {1537, 2049}, 1.75)});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].screen, 1U);
    EXPECT_EQ(found[0].pairedBy, qt::PairedBy::Size);
    ASSERT_EQ(found[0].problems.size(), 1U);
    EXPECT_EQ(found[0].problems[0].find("the desktop scales this screen"), 0U);
}

TEST(DisplaySearch, PairsBySizeWhereNothingElseCouldBeMeant) {
    Mounts mounts;
    mounts.add("LKG-P00655", "LKG-PORT-00655", kPortrait);
    const auto found = mounts.find({kMonitor, screen("", kPortrait)});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].screen, 1U);
    EXPECT_EQ(found[0].pairedBy, qt::PairedBy::Size);
    EXPECT_TRUE(found[0].problems.empty());

    const auto two = mounts.find({screen("", kPortrait), screen("", kPortrait)});
    ASSERT_EQ(two.size(), 1U);
    EXPECT_FALSE(two[0].screen);
    ASSERT_EQ(two[0].problems.size(), 1U);

    // a screen of a display's name wins over one that only has the size
    const auto named = mounts.find({screen("", kPortrait), screen("LKG01Do12HjQE", kPortrait)});
    ASSERT_EQ(named.size(), 1U);
    EXPECT_EQ(named[0].screen, 1U);
}

TEST(DisplaySearch, ACubeViIsFoundByItsNameAndByItsSize) {
    TemporaryDirectory folder;
    spill(folder / "c1.json", R"({"lineNumber":19.6,"obliquity":0.1,"deviation":1})");
    qt::ScreenFacts named;
    named.model = "CubeVi";
    named.size = {1440, 2560};
    qt::ScreenFacts other;
    other.size = {1920, 1080};
    const auto alone = qt::findDisplays({other, named}, {});
    ASSERT_EQ(alone.size(), 1U);
    EXPECT_EQ(alone[0].screen, 1U);
    EXPECT_NE(alone[0].problems.at(0).find("give its visual.json"), std::string::npos);
    named.model.clear();
    const auto bySize = qt::findDisplays({other, named}, {{folder / "c1.json", "cubevi-c1"}});
    ASSERT_EQ(bySize.size(), 1U);
    EXPECT_EQ(bySize[0].screen, 1U);
    EXPECT_TRUE(bySize[0].problems.empty());
}

TEST(DisplaySearch, SaysWhichPartIsMissing) {
    Mounts mounts;
    const auto screenOnly = mounts.find({screen("LKG-P00655", kPortrait)});
    ASSERT_EQ(screenOnly.size(), 1U);
    EXPECT_EQ(screenOnly[0].name, "LKG-P00655");
    EXPECT_FALSE(screenOnly[0].calibration);
    ASSERT_EQ(screenOnly[0].problems.size(), 1U);
    EXPECT_TRUE(holds(screenOnly[0].problems[0], "visual.json"));

    mounts.add("LKG-E05304", "LKG-E05304", kGo);
    const auto volumeOnly = mounts.find({kMonitor});
    ASSERT_EQ(volumeOnly.size(), 1U);
    ASSERT_EQ(volumeOnly[0].problems.size(), 1U);
    EXPECT_TRUE(holds(volumeOnly[0].problems[0], "1440 x 2560"));
}

TEST(DisplaySearch, BrokenCalibrationsAreProblemsNotErrors) {
    Mounts mounts;
    mounts.write("LKG-P00655", "{}");
    const auto found = mounts.find({screen("LKG-P00655", kPortrait)});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].screen, 0U);
    EXPECT_FALSE(found[0].calibration);
    ASSERT_EQ(found[0].problems.size(), 1U);
    EXPECT_TRUE(holds(found[0].problems[0], "visual.json"));
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
    const auto found = mounts.find({screen("LKG-P00655", {1920, 1080}, 2)});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].problems.size(), 2U);
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
