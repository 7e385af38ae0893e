// Parts of the viewer that need no desktop. tests/qt tests the window.

#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"

#include <nlohmann/json.hpp>

namespace altiro3D::test {

namespace {

constexpr const char* kTool = "altiro3Dview";

// Under sanitizers: memory that Qt keeps until the end is not reported as a leak.
class ViewerStudio : public SmallStudio {
  public:
    ViewerStudio() {
        set("LSAN_OPTIONS",
            "print_suppressions=0:suppressions=" + sourcePath("tests/qt/qt_leaks.supp").string());
    }
};

} // namespace

TEST(ViewTool, HelpAndVersionNeedNoDesktop) {
    const ViewerStudio studio;
    const Outcome help = studio.run(kTool, {"--help"});
    EXPECT_TRUE(isDone(help));
    EXPECT_NE(help.out.find("--list-displays"), std::string::npos);
    EXPECT_TRUE(isDone(studio.run(kTool, {"--version"})));
}

TEST(ViewTool, SaysThatThereIsNoDesktop) {
    ViewerStudio studio;
    EXPECT_TRUE(fails(studio.run(kTool, {"photo.png"}), 1, "expected $DISPLAY"));
    EXPECT_TRUE(fails(studio.run(kTool, {"--show", "photo.png"}), 1, "expected $DISPLAY"));
    studio.set("QT_QPA_PLATFORM", "xcb"); // the environment claims a desktop
    studio.set("DISPLAY", ":31415");
    EXPECT_TRUE(fails(studio.run(kTool, {"photo.png"}), 1, "no desktop: "));
}

TEST(ViewTool, WrongUsageIsSaidBeforeAnyWindow) {
    ViewerStudio studio;
    studio.set("QT_QPA_PLATFORM", "offscreen");
    EXPECT_TRUE(fails(studio.run(kTool, {"--unknown"}), 2, "--help"));
    EXPECT_TRUE(fails(studio.run(kTool, {"-d", "photo.png"}), 2, "PHOTO DEPTH"));
    EXPECT_TRUE(fails(studio.run(kTool, {"--show", "photo.png", "quilt.png"}), 2, "one Native"));
    EXPECT_TRUE(fails(studio.run(kTool, {"--screen", "0", "photo.png"}), 2, "expected --show"));
    EXPECT_TRUE(fails(studio.run(kTool, {"--json"}), 2, "expected --list-displays"));
    EXPECT_TRUE(fails(studio.run(kTool, {"--list-displays", "photo.png"}), 2, "takes no names"));
    EXPECT_TRUE(fails(studio.run(kTool, {"--list-displays", "--show", "photo.png"}), 2,
                      "exclude each other"));
    for (const char* option : {"-m", "-q", "-r", "--invert"})
        EXPECT_TRUE(fails(studio.run(kTool, {"--show", "photo.png", option, "off"}), 2,
                          std::string(option) + " and --show exclude each other"));
    EXPECT_TRUE(fails(studio.run(kTool, {"-c", "none.json"}), 1, "none.json"));
    EXPECT_TRUE(
        fails(studio.run(kTool, {"--show", "photo.png", "--screen", "7"}), 2, "--screen is 7"));
}

TEST(ViewTool, AcceptsTheFolderOfACalibration) {
    ViewerStudio studio;
    studio.set("QT_QPA_PLATFORM", "offscreen");
    std::filesystem::create_directory(studio / "volume");
    std::filesystem::copy(studio / "small.json", studio / "volume/visual.json");
    const Arguments show{"--show", "photo.png", "-c"};
    const Outcome folder = studio.run(kTool, show + Arguments{"volume"});
    EXPECT_EQ(folder.err, studio.run(kTool, show + Arguments{"small.json"}).err);
    EXPECT_EQ(folder.err.find("volume"), std::string::npos) << folder.text();
}

TEST(ViewTool, ShowsNothingOnAScreenOfAnotherSizeOrWithoutADisplay) {
    ViewerStudio studio;
    studio.set("QT_QPA_PLATFORM", "offscreen");
    EXPECT_TRUE(fails(studio.run(kTool, {"--show", "photo.png", "--screen", "0"}), 1,
                      "photo.png: has 90 x 120 px, but the screen shows 800 x 600 px"));
    EXPECT_TRUE(fails(studio.run(kTool, {"--show", "photo.png"}), 1, "no light-field display"));
    EXPECT_TRUE(fails(studio.run(kTool, {"--show", "none.png"}), 1, "none.png"));
}

TEST(ViewTool, ListsDisplaysForPeopleAndPrograms) {
    ViewerStudio studio;
    EXPECT_TRUE(warns(studio.run(kTool, {"--list-displays"}), "no desktop"));
    studio.set("QT_QPA_PLATFORM", "offscreen");
    const Outcome people = studio.run(kTool, {"--list-displays"});
    EXPECT_TRUE(isDone(people));
    EXPECT_NE(people.out.find("screen 0: "), std::string::npos) << people.out;
    EXPECT_NE(people.out.find("800 x 600 px"), std::string::npos) << people.out;
    const Outcome programs = studio.run(kTool, {"--list-displays", "--json"});
    EXPECT_TRUE(isDone(programs));
    const auto json = nlohmann::json::parse(programs.out);
    ASSERT_EQ(json.at("screens").size(), 1U);
    EXPECT_EQ(json["screens"][0]["width"], 800);
    EXPECT_TRUE(json.at("displays").is_array());
}

} // namespace altiro3D::test
