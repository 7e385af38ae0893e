// The files of a show, the slides made of them, and the show in its window.

#include "altiro3D/altiro3D.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/slow.hpp"
#include "viewer/show/presentation.hpp"
#include "viewer/show/slide_presenter.hpp"
#include "viewer/show/slide_show.hpp"
#include "viewer_scenes.hpp"

#include <QGuiApplication>
#include <QSignalSpy>
#include <gtest/gtest.h>
#include <set>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

std::string namesOf(const ShowFiles& files) {
    std::string text;
    for (const Source& source : files.files())
        text += source.file.filename().string() + " ";
    return text;
}

TEST(SteadyFiles, AreThoseThatHaveNotChangedForTwoSeconds) {
    SteadyFiles files;
    using Names = std::set<fs::path>;
    EXPECT_EQ(files.look({{"old", "1"}}, 0), (Names{"old"}));
    EXPECT_FALSE(files.isWaiting());
    EXPECT_EQ(files.look({{"old", "1"}, {"new", "1"}}, 0.5), (Names{"old"}));
    EXPECT_TRUE(files.isWaiting());
    EXPECT_EQ(files.look({{"old", "1"}, {"new", "2"}}, 2.4), (Names{"old"})); // still growing
    EXPECT_EQ(files.look({{"old", "1"}, {"new", "2"}}, 4.3), (Names{"old"}));
    EXPECT_EQ(files.look({{"old", "2"}, {"new", "2"}}, 4.4), (Names{"new"})); // written again
    EXPECT_TRUE(files.isWaiting());
    EXPECT_EQ(files.look({{"new", "2"}}, 5), (Names{"new"}));
    EXPECT_FALSE(files.isWaiting());
}

TEST(ShowFiles, TakesOfAFolderWhatTheToolsTake) {
    const TemporaryDirectory folder;
    const cv::Mat picture = detailedPhoto({48, 64});
    for (const char* name :
         {"b.png", "b2.png", "a.jpg", ".hidden.png", "a-depth.png", "q_qs4x4a0.75.png"})
        writeImage(folder / name, picture); // equal pictures, but no views of one scene
    writeImage(folder / "n.png", picture, ImageMark::Native);
    writeGreys(folder / "clip.mkv", {32, 32}, 2);
    writeGreys(folder / "clip-depth.mkv", {32, 32}, 2);
    writeGreys(folder / "a.mov", {32, 32}, 2); // the clip of a Live Photo
    spill(folder / "notes.txt", "text");
    fs::create_directory(folder / "more");
    ShowFiles files({folder.path(), folder / "gone.png"});
    EXPECT_EQ(namesOf(files), "a.jpg b.png b2.png clip.mkv n.png q_qs4x4a0.75.png ");
    EXPECT_EQ(files.files()[0].depth.filename(), "a-depth.png");
    ASSERT_EQ(files.notes().size(), 2U);
    EXPECT_TRUE(holds(files.notes()[0].text, "1 .txt file"));
    EXPECT_TRUE(holds(files.notes()[1].text, "gone.png: does not exist"));
    EXPECT_TRUE(holds(errorOf([&] { const ShowFiles none({folder / "gone.png"}); }),
                      "gone.png: does not exist"));
    EXPECT_TRUE(holds(errorOf([&] { const ShowFiles none({folder / "more"}); }),
                      "more: holds no pictures"));
}

TEST(ShowFiles, JoinWhenTheyAreWhole) {
    const TemporaryDirectory folder;
    const cv::Mat picture = detailedPhoto({48, 64});
    writeImage(folder / "b.png", picture);
    ShowFiles files({folder.path()});
    EXPECT_EQ(namesOf(files), "b.png ");
    EXPECT_TRUE(files.refresh(1));
    const std::string whole = slurp(folder / "b.png");
    spill(folder / "a.png", whole.substr(0, whole.size() / 2)); // is being copied
    EXPECT_FALSE(files.refresh(2));
    EXPECT_FALSE(files.refresh(3.9));
    EXPECT_EQ(namesOf(files), "b.png ");
    spill(folder / "a.png", whole);
    EXPECT_FALSE(files.refresh(5)); // 3 s old, but it has grown
    EXPECT_FALSE(files.refresh(6.9));
    EXPECT_EQ(namesOf(files), "b.png ");
    EXPECT_TRUE(files.refresh(7));
    EXPECT_EQ(namesOf(files), "a.png b.png ");
    spill(folder / "a.png", whole + "x"); // written again: it leaves and comes back
    EXPECT_FALSE(files.refresh(8));
    EXPECT_EQ(namesOf(files), "b.png ");
    EXPECT_TRUE(files.refresh(10));
    EXPECT_EQ(namesOf(files), "a.png b.png ");
    fs::remove(folder / "b.png");
    EXPECT_TRUE(files.refresh(11));
    EXPECT_EQ(namesOf(files), "a.png ");
    fs::remove_all(folder.path());
    EXPECT_TRUE(files.refresh(12));
    EXPECT_EQ(namesOf(files), "");
}

std::shared_ptr<const Display> smallDisplay() {
    return std::make_shared<const Display>(sampleDisplay({96, 128}));
}

// 98 px are 78 or 79 of a desktop at 125 %, and those times 1.25 are 98 or 99.
TEST(SlideMaker, TakesNativesOfTheSizeThatAScaledDesktopRounds) {
    const TemporaryDirectory folder;
    writeImage(folder / "a.png", cv::Mat(128, 98, CV_8UC3, cv::Scalar::all(9)), ImageMark::Native);
    qt::ScreenFacts screen;
    screen.size = {99, 128};
    const Source source{folder / "a.png", {}, {}};
    EXPECT_TRUE(holds(SlideMaker(nullptr, screen).make(source).problem, "98 x 128 px"));
    screen.scale = 1.25;
    EXPECT_EQ(SlideMaker(nullptr, screen).make(source).problem, "");
}

TEST(Screens, AWindowLeavesTheDisplayIfThereIsAnotherScreen) {
    const auto on = [](std::size_t screen) {
        qt::FoundDisplay display;
        display.screen = screen;
        return display;
    };
    EXPECT_EQ(screenBeside({on(0), on(1), {}}, 1, 3), 2U);
    EXPECT_EQ(screenBeside({on(2)}, 2, 3), 0U);
    EXPECT_FALSE(screenBeside({on(2)}, 0, 3)); // it is beside already
    EXPECT_FALSE(screenBeside({on(0), on(1)}, 0, 2));
    EXPECT_FALSE(screenBeside({}, 0, 1));
}

TEST(SlideMaker, MakesNativesOfFlatVideos) {
    const TemporaryDirectory folder;
    writeGreys(folder / "flat.mkv", {60, 80}, 3);
    const Slide slide = SlideMaker(smallDisplay(), {}).make({folder / "flat.mkv", {}, {}});
    ASSERT_EQ(slide.problem, "");
    ASSERT_TRUE(slide.isVideo());
    EXPECT_EQ(slide.native.size(), cv::Size(96, 128));
    // a grey picture has the same grey in all views, whatever its depth
    for (const int grey : {20, 130, 240}) {
        const cv::Mat native =
            slide.nativeOfFrame(cv::Mat(80, 60, CV_8UC3, cv::Scalar::all(grey)), 0);
        ASSERT_EQ(native.size(), cv::Size(96, 128));
        double low = 0;
        double high = 0;
        cv::minMaxLoc(native.reshape(1), &low, &high);
        EXPECT_NEAR(low, grey, 1);
        EXPECT_NEAR(high, grey, 1);
    }
}

// All kinds of files in a window, with the keys of a show.
TEST(SlidePresenter, GoesThroughAMixedFolderByItsKeys) {
    ALTIRO3D_TAKES(7);
    const TemporaryDirectory folder;
    const auto display = smallDisplay();
    fs::create_directory(folder / "in");
    const auto native = [&](const char* name, int grey) {
        writeImage(folder / name, cv::Mat(128, 96, CV_8UC3, cv::Scalar::all(grey)),
                   ImageMark::Native);
    };
    native("in/1.png", 40);
    writeImage(folder / "in/2.jpg", detailedPhoto({90, 120}));
    spill(folder / "in/3.png", "no picture");
    writeImage(folder / "in/4_qs4x4a0.75.png", detailedPhoto({96, 128}));
    writeGreys(folder / "in/5.mkv", {96, 128}, 4);
    writeGreys(folder / "in/6.mkv", {60, 80}, 4);
    native("in/7.png", 200);
    SlideShow::Settings settings;
    settings.each = 3600;
    settings.fade = 0.1;
    settings.loops = true;
    std::vector<std::string> told;
    SlidePresenter presenter(settings, ShowFiles({folder / "in"}), display, {},
                             [&](const std::string& why) { told.push_back(why); });
    presenter.start(*QGuiApplication::primaryScreen());
    auto& widget = const_cast<qt::NativeWidget&>(presenter.widget()); // the keys go there
    std::size_t most = 0;
    const auto shows = [&](const std::string& name) {
        return waitFor([&] {
            most = std::max(most, presenter.show().slidesKept());
            const Slide* const shown = presenter.show().shown();
            return shown != nullptr && shown->source.file.filename() == name &&
                   !presenter.show().isFading();
        });
    };
    const auto grey = [&] { return qGray(widget.image().pixel(48, 64)); };
    ASSERT_TRUE(shows("1.png"));
    EXPECT_TRUE(waitFor([&] { return grey() == 40; }));
    QTest::keyClick(&widget, Qt::Key_Right);
    ASSERT_TRUE(shows("2.jpg"));
    QTest::keyClick(&widget, Qt::Key_PageDown);
    ASSERT_TRUE(shows("4_qs4x4a0.75.png"));
    QTest::keyClick(&widget, Qt::Key_Right);
    ASSERT_TRUE(shows("7.png")); // after both videos, which end by themselves
    EXPECT_TRUE(waitFor([&] { return grey() == 200; }));
    EXPECT_GT(presenter.counts().shown, 0);
    QTest::keyClick(&widget, Qt::Key_Right);
    ASSERT_TRUE(shows("1.png"));
    QTest::keyClick(&widget, Qt::Key_Left);
    ASSERT_TRUE(shows("7.png"));
    EXPECT_LE(most, 4U);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(holds(told[0], "3.png: "));

    // a new file joins
    native("in/8.png", 90);
    int changes = -1;
    ASSERT_TRUE(waitFor([&] {
        if (presenter.show().shown()->source.file.filename() == "8.png") return true;
        if (presenter.show().changes() != changes) QTest::keyClick(&widget, Qt::Key_Right);
        changes = presenter.show().changes();
        return false;
    }));
    EXPECT_TRUE(waitFor([&] { return grey() == 90; }));
    QTest::keyClick(&widget, Qt::Key_Space);
    EXPECT_TRUE(presenter.show().isPaused());
    QSignalSpy ended(&presenter, &SlidePresenter::ended);
    QTest::keyClick(&widget, Qt::Key_PageUp); // keys still work
    EXPECT_TRUE(shows("7.png"));
    EXPECT_EQ(ended.count(), 0);
    QTest::keyClick(&widget, Qt::Key_Escape);
    EXPECT_EQ(ended.count(), 1);
}

} // namespace
} // namespace altiro3D::test
