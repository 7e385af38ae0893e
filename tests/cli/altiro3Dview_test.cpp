// Parts of the viewer that need no desktop. tests/qt tests the window.

#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"

#include <algorithm>
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
    EXPECT_TRUE(says(studio.run(kTool, "--help"), "--list-displays"));
    EXPECT_TRUE(isDone(studio.run(kTool, "--version")));
}

TEST(ViewTool, SaysThatThereIsNoDesktop) {
    ViewerStudio studio;
    EXPECT_TRUE(fails(studio.run(kTool, "photo.png"), 1, "expected $DISPLAY"));
    EXPECT_TRUE(fails(studio.run(kTool, "--show photo.png"), 1, "expected $DISPLAY"));
    studio.set("QT_QPA_PLATFORM", "xcb"); // the environment claims a desktop
    studio.set("DISPLAY", ":31415");
    EXPECT_TRUE(fails(studio.run(kTool, "photo.png"), 1, "no desktop: "));
}

TEST(ViewTool, WrongUsageIsSaidBeforeAnyWindow) {
    ViewerStudio studio;
    studio.set("QT_QPA_PLATFORM", "offscreen");
    const std::pair<const char*, const char*> wrong[] = {
        {"--unknown", "--help"},
        {"-d photo.png", "PHOTO DEPTH"},
        {"--show - quilt.png", "no further names"},
        {"--screen 1 photo.png", "applies to --show"},
        {"--each 1 photo.png", "applies to --show"},
        {"--loop photo.png", "applies to --show"},
        {"--shuffle photo.png", "applies to --show"},
        {"--view-from stdin photo.png", "applies to --show"},
        {"--show - --view-from stdin", "needs the viewer and files"},
        {"--show a --player mpv --stereo-layout rows", "needs the viewer and files"},
        {"--show a --view-from udp:99999", "expected udp:PORT (1..65535) or stdin"},
        {"--show a --stereo-layout files", "stereo-layout"},
        {"--json", "expected --list-displays"},
        {"--list-displays photo.png", "takes no names"},
        {"--list-displays --show photo.png", "exclude each other"}};
    for (const auto& [arguments, problem] : wrong)
        EXPECT_TRUE(fails(studio.run(kTool, arguments), 2, problem)) << arguments;
    for (const char* seconds : {"0", "-1", "nan", "1e9", "x"})
        EXPECT_TRUE(
            fails(studio.run(kTool, {"--show", "photo.png", "--each", seconds}), 2, "--each"));
    for (const char* option : {"-m", "-q", "-r", "--invert"})
        EXPECT_TRUE(fails(studio.run(kTool, {"--show", "photo.png", option, "off"}), 2,
                          std::string(option) + " and --show exclude each other"));
    EXPECT_TRUE(fails(studio.run(kTool, "-c none.json"), 1, "none.json"));
    EXPECT_TRUE(fails(studio.run(kTool, "--show photo.png --screen 7"), 2, "--screen is 7"));
}

TEST(ViewTool, StartsMpvWithAShaderOfTheDisplay) {
    ViewerStudio studio;
    studio.set("QT_QPA_PLATFORM", "offscreen");
    writeCalibration(studio / "screen.json", {800, 600}); // of the offscreen platform
    const std::string quilt = "--no &'_qs3x2a1.333.png";
    std::filesystem::copy(studio / "quilt.png", studio / quilt);
    std::filesystem::copy(studio / "quilt.png", studio / "tall_qs3x2a0.75.png");
    const Arguments show("--player mpv -c screen.json --screen 0 --volume 50 --show");
    std::filesystem::create_directory(studio / "bin");
    studio.set("PATH", (studio / "bin").string());
    EXPECT_TRUE(fails(studio.run(kTool, show + Arguments{"./" + quilt}), 1,
                      "expected the program mpv to be installed"));
    spill(studio / "bin/mpv", "#!/bin/sh\nfor word; do echo \"$word\"; done\n");
    std::filesystem::permissions(studio / "bin/mpv", std::filesystem::perms::owner_all);
    const Outcome outcome = studio.run(kTool, show + Arguments{"./" + quilt});
    EXPECT_TRUE(isDone(outcome));
    EXPECT_TRUE(warns(studio.run(kTool, show + Arguments{"tall_qs3x2a0.75.png"}), "is stretched"));
    EXPECT_TRUE(holds(outcome.out, "\n--no-config\n")) << outcome.out;
    EXPECT_TRUE(holds(outcome.out, "\n--volume=79.4\n")) << outcome.out;
    EXPECT_TRUE(holds(outcome.out, "\n--\n/")) << outcome.out;
    EXPECT_TRUE(holds(outcome.out, "/" + quilt + "\n")) << outcome.out;
    const std::string option = "--glsl-shader=";
    const std::size_t begin = outcome.out.find(option) + option.size();
    const std::string shader = outcome.out.substr(begin, outcome.out.find('\n', begin) - begin);
    EXPECT_TRUE(holds(slurp(shader), "//!WIDTH 800\n//!HEIGHT 600\n"));
    EXPECT_TRUE(fails(studio.run(kTool, show + Arguments{"photo.png"}), 1,
                      "photo.png: is not named as a quilt"));
    std::filesystem::copy(studio / "quilt.png", studio / "b_qs2x3.png");
    EXPECT_TRUE(fails(studio.run(kTool, show + Arguments{"./" + quilt, "b_qs2x3.png"}), 1,
                      "b_qs2x3.png: has another layout"));
    EXPECT_TRUE(fails(studio.run(kTool, "--player mpv photo.png"), 2, "applies to --show"));
    EXPECT_TRUE(fails(studio.run(kTool, "--player mpv --show -"), 2, "plays files"));
}

TEST(ViewTool, AcceptsTheFolderOfACalibration) {
    ViewerStudio studio;
    studio.set("QT_QPA_PLATFORM", "offscreen");
    std::filesystem::create_directory(studio / "volume");
    std::filesystem::copy(studio / "small.json", studio / "volume/visual.json");
    const Arguments show("--show photo.png -c");
    const Outcome folder = studio.run(kTool, show + Arguments{"volume"});
    EXPECT_EQ(folder.err, studio.run(kTool, show + Arguments{"small.json"}).err);
    EXPECT_FALSE(holds(folder.err, "volume"));
}

TEST(ViewTool, ShowsNothingOnAScreenOfAnotherSizeOrWithoutADisplay) {
    ViewerStudio studio;
    studio.set("QT_QPA_PLATFORM", "offscreen");
    EXPECT_TRUE(fails(studio.run(kTool, "--show photo.png --screen 0"), 1,
                      "photo.png: has 90 x 120 px, but the screen shows 800 x 600 px"));
    EXPECT_TRUE(fails(studio.run(kTool, "--show photo.png"), 1, "no light-field display"));
    EXPECT_TRUE(fails(studio.run(kTool, "--show none.png"), 1, "none.png"));
    EXPECT_TRUE(fails(studio.run(kTool, "--show photo.png -c small.json --screen 0"), 1,
                      "small.json: has 96 x 128 px, but the screen shows 800 x 600 px"));
}

// A display of the size of Qt's offscreen screen.
class ShowStudio : public ViewerStudio {
  public:
    ShowStudio() {
        set("QT_QPA_PLATFORM", "offscreen");
        writeCalibration(*this / "wide.json", {800, 600});
        std::filesystem::create_directory(*this / "show");
    }
    Outcome show(const Arguments& arguments) const {
        return run(kTool, Arguments("-c wide.json --screen 0 -v") + arguments);
    }
};

TEST(ViewTool, ShowsAllOfAFolderAndEnds) {
    const ShowStudio studio;
    for (const char* name : {"a.png", "b.png", "c.png"})
        std::filesystem::copy(studio / "photo.png", studio / "show" / name);
    spill(studio / "show/broken.jpg", "no picture");
    spill(studio / "show/notes.txt", "left out");
    const Outcome outcome = studio.show("--show show --each 0.2 quilt.png");
    EXPECT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.err, "broken.jpg: "));
    EXPECT_TRUE(holds(outcome.err, "not opened: 1 .txt file"));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 2) << outcome.text();
    // nothing that can be shown
    std::filesystem::create_directory(studio / "bad");
    spill(studio / "bad/1.jpg", "no picture");
    spill(studio / "bad/2.jpg", "neither");
    const Outcome none = studio.show("--show bad --loop");
    EXPECT_EQ(none.status, 1);
    EXPECT_TRUE(holds(none.err, "bad: holds nothing that can be shown"));
    std::filesystem::create_directory(studio / "empty");
    EXPECT_TRUE(fails(studio.show("--show empty"), 1, "empty: holds no pictures"));
}

TEST(ViewTool, TwoEyesAreShownAndAnEndOfThePlacesIsNone) {
    const ShowStudio studio;
    for (const char* name : {"show/a.png", "show/b.png"})
        std::filesystem::copy(studio / "photo.png", studio / name);
    const Outcome outcome =
        studio.run(kTool, "--show show --stereo-layout checkerboard --view-from stdin --each 0.2");
    EXPECT_EQ(outcome.status, 0) << outcome.text();
}

TEST(ViewTool, OptionsAfterTheFileOfShowWorkAsBeforeIt) {
    const ViewerStudio studio;
    const auto differs = [&](const Arguments& option, const std::string& problem) {
        EXPECT_TRUE(fails(studio.run(kTool, option + Arguments("--show photo.png")), 2, problem));
        EXPECT_TRUE(fails(studio.run(kTool, Arguments("--show photo.png") + option), 2, problem));
    };
    differs("--volume 300", "--volume is \"300\"");
    differs("--each 0", "--each is \"0\"");
    differs("--json", "applies to --list-displays");
    EXPECT_TRUE(fails(studio.run(kTool, "--show --loop photo.png"), 2,
                      "--show takes a value, but --loop follows"));
}

TEST(ViewTool, ListsDisplaysForPeopleAndPrograms) {
    ViewerStudio studio;
    EXPECT_TRUE(warns(studio.run(kTool, "--list-displays"), "no desktop"));
    studio.set("QT_QPA_PLATFORM", "offscreen");
    const Outcome people = studio.run(kTool, "--list-displays");
    EXPECT_TRUE(says(people, "screen 0: "));
    EXPECT_TRUE(holds(people.out, "800 x 600 px"));
    const Outcome programs = studio.run(kTool, "--list-displays --json");
    EXPECT_TRUE(isDone(programs));
    const auto json = nlohmann::json::parse(programs.out);
    ASSERT_EQ(json.at("screens").size(), 1U);
    EXPECT_EQ(json["screens"][0]["width"], 800);
    EXPECT_TRUE(json.at("displays").is_array());
}

} // namespace altiro3D::test
