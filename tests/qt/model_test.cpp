#include "viewer/model/model.hpp"

#include "altiro3D/depth_source.hpp"
#include "altiro3D/splats.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"
#include "support/video.hpp"
#include "viewer/model/depth_maker.hpp"
#include "viewer_scenes.hpp"

#include <QElapsedTimer>
#include <QProcess>
#include <QSignalSpy>
#include <atomic>
#include <chrono>
#include <fcntl.h>
#include <functional>
#include <future>
#include <gtest/gtest.h>
#include <mutex>
#include <set>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

// Whether the first frames of two videos are equal.
bool beginAlike(const fs::path& one, const fs::path& other) {
    VideoReader ours(one);
    VideoReader theirs(other);
    VideoFrame a;
    VideoFrame b;
    for (int i = 0; i < 3; ++i) {
        if (!ours.read(a) || !theirs.read(b) || !samePicture(a.picture, b.picture)) return false;
    }
    return true;
}

class ViewerModel : public ::testing::Test {
  protected:
    void SetUp() override {
        writeImage(folder_ / "photo.png", detailedPhoto({300, 400}));
        writeImage(folder_ / "photo-depth.png", boxDepth({300, 400}));
        model_.stage.setArea({300, 400});
        model_.settings.restore(ofVideo(Knobs())); // nothing is chosen by the photo
    }
    // Opens files and waits for a frame of the first one.
    void open(const std::vector<std::string>& names) {
        std::vector<fs::path> files;
        for (const std::string& name : names)
            files.push_back(folder_ / name);
        model_.files.open(files);
        ASSERT_TRUE(settled());
    }
    void openPhoto() { open({"photo.png", "photo-depth.png"}); }
    bool settled() {
        return waitFor([this] { return !model_.stage.isBusy() && shown(); });
    }
    // The last frame belongs to the current document and settings.
    bool shown() const {
        const Frame& frame = model_.stage.frame();
        return frame.setup.document && frame.setup.document == model_.files.document() &&
               frame.knobs == model_.settings.knobs() && frame.setup.mode == model_.stage.mode() &&
               frame.setup.position == model_.stage.position();
    }
    bool waitForFrame() {
        return waitFor([this] { return shown(); });
    }
    const cv::Mat& picture() const { return model_.stage.frame().picture; }
    void turn(const std::function<void(Knobs&)>& change, const QString& name = "a knob",
              int gesture = 0) {
        Knobs knobs = model_.settings.knobs();
        change(knobs);
        model_.settings.turn(knobs, name, gesture);
    }
    void focus(double value) {
        turn([=](Knobs& knobs) { knobs.views.focus = value; });
    }
    QString exportTo(Product product, const fs::path& file) {
        QSignalSpy ended(&model_.exports, &Exports::ended);
        EXPECT_TRUE(model_.exports.start(product, file));
        EXPECT_TRUE(waitFor([&ended] { return ended.count() > 0; }));
        if (ended.isEmpty()) return "no end";
        said_ = ended.at(0).at(0).toString();
        return ended.at(0).at(1).toString();
    }
    // Exports until the first sign of progress.
    void cancelExportTo(Product product, const fs::path& file) {
        const auto connection =
            QObject::connect(&model_.exports, &Exports::progress, &model_.exports,
                             [this] { model_.exports.cancel(); });
        EXPECT_EQ(exportTo(product, file), "");
        EXPECT_EQ(said_, "");
        QObject::disconnect(connection);
    }

    QString at(const char* name) const { return toName(folder_ / name); }
    // What photo2native then chooses by the photo is given.
    static QStringList fixedWay(QStringList options) {
        if (!options.contains("--focus"))
            options << "--focus"
                    << "0.5";
        return options << "--fit"
                       << "cover";
    }
    // Runs the tool on the photo and its depth image, for the model's display.
    void photo2native(const QStringList& options, const char* output) const {
        const QStringList call{"-y", "-c", writeSample(folder_ / "c.json", {150, 200}), "-d"};
        ASSERT_EQ(
            QProcess::execute(ALTIRO3D_TOOL_PHOTO2NATIVE,
                              call + (options.contains("auto") ? options : fixedWay(options)) +
                                  QStringList{at("photo.png"), at("photo-depth.png"), at(output)}),
            0);
    }

    TemporaryDirectory folder_;
    Model model_{sampleDisplay({150, 200})};
    QString said_; // by the last export
};

TEST(ViewerWorker, TheLatestOfEachKindWins) {
    std::promise<void> go;
    std::vector<int> done;
    {
        Worker worker;
        std::promise<void> running;
        worker.post(1, [&] {
            running.set_value();
            go.get_future().wait();
            done.push_back(0);
        });
        running.get_future().wait();
        for (int i = 1; i <= 5; ++i)
            worker.post(1, [&done, i] { done.push_back(i); });
        worker.post(0, [&done] { done.push_back(100); });
        std::promise<void> last;
        worker.post(2, [&last] { last.set_value(); });
        go.set_value();
        last.get_future().wait();
    }
    EXPECT_EQ(done, (std::vector<int>{0, 100, 5}));
}

// A swing asks for frames faster than a slow computer makes them.
TEST(ViewerWorker, WorkWithoutEndLeavesTurnsToTheOthers) {
    std::promise<void> shown;
    std::atomic<bool> ends = false;
    std::function<void()> frame;
    Worker worker;
    frame = [&] {
        if (!ends) worker.post(1, frame);
    };
    worker.post(1, frame);
    worker.post(2, [&] { shown.set_value(); });
    EXPECT_EQ(shown.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
    ends = true;
}

TEST_F(ViewerModel, ShowsAPhotoFromTheMiddleAndFromTheSide) {
    openPhoto();
    ASSERT_EQ(picture().size(), cv::Size(300, 400));
    EXPECT_TRUE(samePicture(picture(), detailedPhoto({300, 400})));
    model_.stage.setPosition(1);
    ASSERT_TRUE(waitForFrame());
    cv::Mat expected;
    cv::Mat depth;
    boxDepth({300, 400}).convertTo(depth, CV_32F, 1 / 255.0);
    Depth2Quilt({1, 1, {300, 400}, 1}).renderView({detailedPhoto({300, 400}), depth}, 1, expected);
    EXPECT_TRUE(samePicture(picture(), expected));
}

TEST_F(ViewerModel, EveryModeShowsItsPicture) {
    openPhoto();
    for (const Mode mode : modesOf(nullptr)) {
        model_.stage.setMode(mode);
        ASSERT_TRUE(waitForFrame()) << int(mode);
        EXPECT_FALSE(picture().empty());
    }
    model_.stage.setMode(Mode::Native);
    ASSERT_TRUE(waitForFrame());
    EXPECT_EQ(picture().size(), cv::Size(150, 200)); // px by px, not enlarged
    EXPECT_EQ(model_.stage.frame().target, picture().size());
    const cv::Mat native = picture().clone();
    model_.stage.setMode(Mode::Lens);
    ASSERT_TRUE(waitForFrame());
    cv::Mat seen;
    const Calibration calibration = sampleDisplay({150, 200}).calibration;
    simulateView(native, calibration, eyeAtAngle(calibration, 0), seen);
    cv::resize(seen, seen, {300, 400}, 0, 0, cv::INTER_LINEAR);
    EXPECT_TRUE(samePicture(picture(), seen));
    model_.stage.setArea({75, 100}); // zoomed out: light is averaged, as an eye does
    ASSERT_TRUE(waitFor([this] { return picture().size() == cv::Size(75, 100); }));
    LensEye eye = eyeAtAngle(calibration, 0);
    eye.blur = eyeBlur(calibration);
    simulateView(native, calibration, eye, seen);
    cv::resize(seen, seen, {75, 100}, 0, 0, cv::INTER_AREA);
    EXPECT_TRUE(samePicture(picture(), seen));
}

// The box (depth 1) stands 3 % of the width apart, the wall behind it lies at the focus.
TEST_F(ViewerModel, TwoEyesSeeTheWholePhotoFromBothSides) {
    openPhoto();
    focus(0);
    turn([](Knobs& knobs) { // of no effect
        knobs.framing = {{0.5, 0.5}, 2};
        knobs.views.strengthPercent = 20;
    });
    tools::EyesOptions eyes;
    eyes.strengthPercent = 4;
    model_.stage.setEyes(eyes);
    model_.stage.setArea({600, 1000});
    model_.stage.setMode(Mode::Stereo);
    const auto isShown = [&](const cv::Size& size) {
        return waitFor([&] { return shown() && picture().size() == size; });
    };
    ASSERT_TRUE(isShown({600, 400}));
    const cv::Mat photo = detailedPhoto({300, 400});
    const cv::Rect wall(20, 20, 260, 60);
    const cv::Rect box(100, 120, 100, 160); // moves by 4 % of 300 px: 6 px to each side
    const cv::Mat left = picture()(cv::Rect(0, 0, 300, 400)).clone();
    const cv::Mat right = picture()(cv::Rect(300, 0, 300, 400)).clone();
    EXPECT_TRUE(samePicture(left(wall), photo(wall)));
    EXPECT_TRUE(samePicture(right(wall), photo(wall)));
    EXPECT_TRUE(samePicture(left(box + cv::Point(6, 0)), photo(box)));
    EXPECT_TRUE(samePicture(right(box - cv::Point(6, 0)), photo(box)));

    EXPECT_EQ(exportTo(Product::Eyes, folder_ / "eyes.png"), "");
    EXPECT_TRUE(samePicture(readPhoto(folder_ / "eyes.png"), picture()));

    eyes.swapped = true;
    model_.stage.setEyes(eyes);
    ASSERT_TRUE(waitFor([&] { return model_.stage.frame().setup.eyes.swapped; }));
    EXPECT_TRUE(samePicture(picture()(cv::Rect(300, 0, 300, 400)), left));
    eyes = {EyesPicture::Rows};
    eyes.strengthPercent = 4;
    model_.stage.setEyes(eyes);
    model_.stage.setArea({300, 400});
    ASSERT_TRUE(isShown({300, 400}));
    for (int y = 0; y < 400; ++y)
        ASSERT_TRUE(samePicture(picture().row(y), (y % 2 == 0 ? left : right).row(y))) << y;

    // on a screen each eye's picture has its own bars
    eyes.picture = EyesPicture::SideBySideHalf;
    model_.stage.setEyes(eyes);
    cv::Mat onScreen;
    QObject::connect(&model_.stage, &Stage::nativeReady, &model_.stage,
                     [&](const cv::Mat& native) { onScreen = native; });
    model_.stage.setPresenting(true, {800, 400});
    ASSERT_TRUE(waitFor([&] { return !onScreen.empty(); }));
    ASSERT_EQ(onScreen.size(), cv::Size(800, 400));
    cv::Mat squeezed;
    cv::resize(left, squeezed, {150, 400}, 0, 0, cv::INTER_AREA);
    EXPECT_LE(cv::norm(onScreen(cv::Rect(125, 0, 150, 400)), squeezed, cv::NORM_INF), 1);
    EXPECT_EQ(cv::norm(onScreen(cv::Rect(0, 0, 125, 400))), 0);
    EXPECT_EQ(cv::norm(onScreen(cv::Rect(275, 0, 250, 400))), 0);
    EXPECT_EQ(cv::norm(onScreen(cv::Rect(675, 0, 125, 400))), 0);
}

TEST_F(ViewerModel, ThePageIsThatOfTheTool) {
    openPhoto();
    focus(0.25);
    ASSERT_TRUE(waitForFrame());
    EXPECT_EQ(exportTo(Product::Page, folder_ / "viewer.html"), "");
    photo2native({"--focus", "0.25", "--save-page", at("tool.html")}, "n.png");
    EXPECT_TRUE(slurp(folder_ / "viewer.html") == slurp(folder_ / "tool.html"));
}

TEST_F(ViewerModel, ThePictureForTwoEyesIsThatOfTheTool) {
    openPhoto();
    focus(0.25);
    ASSERT_TRUE(waitForFrame());
    for (const auto& [layout, picture] : {std::pair("anaglyph", EyesPicture::Anaglyph),
                                          std::pair("tb-half", EyesPicture::TopBottomHalf)}) {
        model_.stage.setEyes({picture});
        EXPECT_EQ(exportTo(Product::Eyes, folder_ / "plain.png"), "");
        EXPECT_TRUE(said_.contains("only by its name, as plain_")) << said_.toStdString();
        photo2native(
            {"--focus", "0.25", "--save-stereo", at("tool.png"), "--stereo-layout", layout},
            "n.png");
        EXPECT_TRUE(slurp(folder_ / "plain.png") == slurp(folder_ / "tool.png")) << layout;
    }
}

TEST_F(ViewerModel, TheDepthCurveBendsTheDepthOnce) {
    cv::Mat depth = boxDepth({300, 400});
    depth.rowRange(320, 400) = 128;
    writeImage(folder_ / "photo-depth.png", depth);
    openPhoto();
    model_.stage.setMode(Mode::Depth);
    const auto shownAt = [this](int x, int y) {
        EXPECT_TRUE(waitForFrame());
        return int(picture().at<cv::Vec3b>(y, x)[0]);
    };
    EXPECT_NEAR(shownAt(150, 370), 128, 1);
    turn([](Knobs& knobs) { knobs.depthCurve = 2; });
    EXPECT_NEAR(shownAt(150, 370), 128.0 * 128 / 255, 1);
    EXPECT_EQ(shownAt(150, 200), 255);
    EXPECT_EQ(shownAt(20, 20), 0);
    for (const double curve : {1.0, 2.0}) {
        turn([=](Knobs& knobs) { knobs.depthCurve = curve; }, "depth curve", 1);
        ASSERT_TRUE(waitForFrame());
        EXPECT_EQ(exportTo(Product::SwayVideo, folder_ / (curve > 1 ? "bent.mkv" : "sway.mkv")),
                  "");
    }
    EXPECT_FALSE(beginAlike(folder_ / "bent.mkv", folder_ / "sway.mkv"));
    model_.stage.focusAt(0.5, 370.0 / 400); // a depth after the curve
    EXPECT_NEAR(model_.settings.knobs().views.focus, 0.25, 0.011);
    for (int i = 0; i < 3; ++i)
        model_.settings.undoStack().undo();
    EXPECT_NEAR(shownAt(150, 370), 128, 1);
}

TEST_F(ViewerModel, ANativeInASmallWindowIsPanned) {
    openPhoto();
    model_.stage.setMode(Mode::Native);
    ASSERT_TRUE(waitForFrame());
    const cv::Mat native = picture().clone();
    model_.stage.setArea({100, 100});
    ASSERT_TRUE(waitFor([this] { return picture().size() == cv::Size(100, 100); }));
    EXPECT_TRUE(samePicture(picture(), native(cv::Rect(25, 50, 100, 100))));
    QSignalSpy frames(&model_.stage, &Stage::frameReady);
    model_.stage.panBy({1000, -1000}); // to the left lower corner, no further
    ASSERT_TRUE(waitFor([&frames] { return frames.count() > 0; }));
    EXPECT_TRUE(samePicture(picture(), native(cv::Rect(0, 100, 100, 100))));
}

TEST_F(ViewerModel, AClickFocusesOnWhatIsSeenThere) {
    openPhoto();
    model_.stage.focusAt(0.5, 0.5);
    EXPECT_EQ(model_.settings.knobs().views.focus, 1);
    model_.stage.focusAt(0.1, 0.1);
    EXPECT_EQ(model_.settings.knobs().views.focus, 0);
    EXPECT_EQ(model_.settings.undoStack().count(), 2);
    // from the side the near box is seen beside its place: 5 % of the width to the left
    focus(0);
    model_.stage.setPosition(1);
    ASSERT_TRUE(waitForFrame());
    model_.stage.focusAt(0.22, 0.5);
    EXPECT_EQ(model_.settings.knobs().views.focus, 1);
}

TEST_F(ViewerModel, KnobsAreUndoneGestureByGesture) {
    const Knobs first = model_.settings.knobs();
    Knobs knobs = first;
    for (int i = 1; i <= 5; ++i) {
        knobs.views.strengthPercent = 10 + i;
        model_.settings.turn(knobs, "strength", 7);
    }
    focus(0.9);
    EXPECT_EQ(model_.settings.undoStack().count(), 2);
    model_.settings.undoStack().undo();
    EXPECT_EQ(model_.settings.knobs(), knobs);
    model_.settings.undoStack().undo();
    EXPECT_EQ(model_.settings.knobs(), first);
    model_.settings.undoStack().redo();
    EXPECT_EQ(model_.settings.knobs(), knobs);
    model_.settings.reset();
    EXPECT_EQ(model_.settings.knobs(), Knobs());
    model_.settings.undoStack().undo();
    EXPECT_EQ(model_.settings.knobs(), knobs);
}

TEST_F(ViewerModel, WhileAKnobMovesTheNativeIsADraft) {
    openPhoto();
    model_.stage.setArea({150, 200});
    model_.stage.setMode(Mode::Native);
    ASSERT_TRUE(waitForFrame());
    for (const double strength : {11.0, 12.0})
        turn([=](Knobs& knobs) { knobs.views.strengthPercent = strength; }, "strength", 7);
    ASSERT_TRUE(waitForFrame());
    const cv::Mat draft = picture().clone();
    EXPECT_TRUE(model_.stage.frame().setup.isDraft);
    ASSERT_TRUE(waitFor([this] { return shown() && !model_.stage.frame().setup.isDraft; }));
    EXPECT_FALSE(samePicture(picture(), draft)); // the filter is on again
    model_.settings.undoStack().undo();
    ASSERT_TRUE(waitForFrame());
    EXPECT_FALSE(model_.stage.frame().setup.isDraft);
}

TEST_F(ViewerModel, ABrokenFileIsNamedAndTheNextOneOpens) {
    spill(folder_ / "broken.png", "\x89PNG\r\n\x1a\nand nothing more");
    model_.files.open(std::vector<fs::path>{folder_ / "broken.png"});
    ASSERT_TRUE(waitFor([this] { return !model_.stage.isBusy(); }));
    EXPECT_TRUE(model_.stage.problem().contains("broken.png: "))
        << model_.stage.problem().toStdString();
    EXPECT_EQ(model_.files.document(), nullptr);
    openPhoto();
    EXPECT_TRUE(model_.stage.problem().isEmpty());
    EXPECT_EQ(model_.files.sources().size(), 2U);
    model_.files.close(0);
    EXPECT_EQ(model_.files.current(), 0);
    EXPECT_TRUE(model_.files.document() != nullptr);
    model_.files.close(0);
    EXPECT_EQ(model_.files.current(), -1);
    EXPECT_EQ(model_.files.document(), nullptr);
}

TEST_F(ViewerModel, AFolderOfPhotosIsReplacedByItsFiles) {
    fs::create_directory(folder_ / "in");
    for (int i = 0; i < 3; ++i)
        writeImage(folder_ / ("in/p" + std::to_string(i) + ".png"), scenery({90, 60}, 7 * i + 1));
    spill(folder_ / "in/notes.txt", "x");
    open({"photo.png", "in"});
    ASSERT_EQ(model_.files.sources().size(), 2U);
    model_.files.select(1);
    ASSERT_TRUE(settled());
    ASSERT_EQ(model_.files.sources().size(), 4U);
    EXPECT_EQ(model_.files.current(), 1);
    EXPECT_EQ(model_.files.document()->source.file, folder_ / "in/p0.png");
    EXPECT_EQ(model_.files.document()->kind, Kind::Scene);
    ASSERT_EQ(model_.files.document()->notes.size(), 1U);
    EXPECT_TRUE(holds(model_.files.document()->notes[0].text, "not opened: 1 .txt file"));
    EXPECT_EQ(model_.files.sources()[3].file, folder_ / "in/p2.png");
    model_.files.select(2); // said once
    ASSERT_TRUE(settled());
    EXPECT_TRUE(model_.files.document()->notes.empty());

    fs::create_directory(folder_ / "empty");
    model_.files.open(std::vector<fs::path>{folder_ / "empty"});
    ASSERT_TRUE(waitFor([this] { return !model_.stage.isBusy(); }));
    EXPECT_NE(model_.stage.problem().indexOf("holds no pictures and no videos"), -1);
}

TEST_F(ViewerModel, ClosingAnotherFileLeavesTheCurrentOneAsItIs) {
    openPhoto();
    for (int i = 0; i < 2; ++i)
        model_.files.open(std::vector<fs::path>{folder_ / "photo.png"});
    model_.files.select(1);
    ASSERT_TRUE(settled());
    const auto document = model_.files.document();
    for (const int other : {0, 1}) {
        model_.files.close(other);
        EXPECT_EQ(model_.files.current(), 0);
        EXPECT_FALSE(model_.stage.isBusy());
    }
    EXPECT_EQ(model_.files.document(), document);
}

TEST_F(ViewerModel, ANativeForAnotherPanelIsSaidWhenItIsLookedAt) {
    writeImage(folder_ / "n.png", detailedPhoto({64, 64}));
    model_.files.open(std::vector<Source>{Source{folder_ / "n.png", {}, Reading::Native}});
    ASSERT_TRUE(waitFor([this] { return !model_.stage.problem().isEmpty(); }));
    EXPECT_TRUE(model_.stage.problem().contains("expected the panel's 150 x 200 px"));
    model_.stage.setMode(Mode::Native);
    ASSERT_TRUE(waitFor([this] { return model_.stage.problem().isEmpty(); }));
    EXPECT_EQ(picture().size(), cv::Size(64, 64));
}

TEST_F(ViewerModel, ViewsOfAQuiltKeepTheShapeThatItsNameTells) {
    const cv::Mat quilt = detailedPhoto({90, 80});
    writeImage(folder_ / "q_qs3x2a1.5.png", quilt);
    model_.stage.setMode(Mode::Native);
    model_.files.open(
        std::vector<Source>{Source{folder_ / "q_qs3x2a1.5.png", {}, Reading::Automatic}});
    ASSERT_TRUE(waitForFrame());
    const QuiltLayout layout{3, 2, {30, 40}, 6};
    cv::Mat native;
    const Display display = sampleDisplay({150, 200});
    const QuiltShape shape("q_qs3x2a1.5.png", layout, display, FitMode::Contain);
    Quilt2Native(display.calibration, layout, {ViewFilter::Nearest, TileSampling::Linear})
        .render(shape.apply(quilt), native);
    EXPECT_TRUE(samePicture(picture(), native));
}

// Every product of the viewer, as photo2native makes it with the same settings.
TEST_F(ViewerModel, ExportsWhatTheToolsWrite) {
    ALTIRO3D_TAKES(3);
    cv::Mat photo = detailedPhoto({320, 200});
    cv::GaussianBlur(photo, photo, {15, 15}, 4); // sharp is only the subject, on the right
    const cv::Rect subject(215, 60, 60, 130);
    detailedPhoto({320, 200})(subject).copyTo(photo(subject));
    cv::Mat depth(200, 320, CV_8UC1, cv::Scalar(30));
    depth(subject) = 200;
    writeImage(folder_ / "photo.png", photo);
    writeImage(folder_ / "photo-depth.png", depth);
    Display display = sampleDisplay({150, 200});
    display.quilt = {3, 2, {60, 80}, 6};
    model_.files.setDisplay(display);
    openPhoto();
    const auto expectSame = [&](QStringList options, bool hasQuilt = true) {
        SCOPED_TRACE(options.join(' ').toStdString());
        ASSERT_TRUE(waitForFrame());
        EXPECT_EQ(exportTo(Product::Native, folder_ / "n.png"), "");
        EXPECT_EQ(exportTo(Product::Depth, folder_ / "d.png"), "");
        EXPECT_EQ(exportTo(Product::SwayVideo, folder_ / "sway.mkv"), "");
        options << "-q"
                << "2x3"
                << "-r"
                << "80x60"
                << "--save-depth" << at("tool-d.png") << "--lg" << at("tool.mkv");
        if (hasQuilt) {
            EXPECT_EQ(exportTo(Product::Quilt, folder_ / "q.png"), "");
            fs::remove_all(folder_ / "views");
            EXPECT_EQ(exportTo(Product::Views, folder_ / "views"), "");
            options << "--save-quilt" << at("tool.png") << "--save-views" << at("tool-views");
        }
        photo2native(options, "tool-n.png");
        std::vector<std::pair<const char*, const char*>> files{{"n.png", "tool-n.png"},
                                                               {"d.png", "tool-d.png"}};
        if (hasQuilt) {
            files.emplace_back("q_qs3x2a0.75.png", "tool_qs3x2a0.75.png");
            files.emplace_back("views/view_5.png", "tool-views/view_5.png");
        }
        for (const auto& [ours, theirs] : files)
            EXPECT_TRUE(slurp(folder_ / ours) == slurp(folder_ / theirs)) << ours;
        EXPECT_TRUE(beginAlike(folder_ / "sway.mkv", folder_ / "tool.mkv"));
    };
    Knobs knobs = model_.settings.knobs();
    knobs.views.strengthPercent = 7.5;
    knobs.views.focus = 0.25;
    model_.settings.turn(knobs, "strength");
    expectSame({"--strength", "7.5", "--focus", "0.25"});
    model_.stage.moveFrame({0.3, 0}, 1); // the left part comes in
    model_.stage.zoomFrame({0.2, 0.9}, 1.7, 2);
    const Framing framing = model_.settings.knobs().framing;
    EXPECT_LT(framing.centre.x, 0.5);
    EXPECT_DOUBLE_EQ(framing.zoom, 1.7);
    const auto text = [](double value) { return QString::number(value, 'g', 17); };
    expectSame({"--strength", "7.5", "--focus", "0.25", "--zoom", text(framing.zoom), "--center",
                text(framing.centre.x) + "," + text(framing.centre.y)});
    turn([](Knobs& bent) { bent.depthCurve = 1.7; });
    expectSame({"--strength", "7.5", "--focus", "0.25", "--depth-curve", "1.7", "--zoom",
                text(framing.zoom), "--center",
                text(framing.centre.x) + "," + text(framing.centre.y)});
    model_.settings.undoStack().undo();
    knobs.choices = {true, true, true};
    model_.settings.turn(knobs, "all");
    ASSERT_TRUE(waitForFrame());
    const Knobs chosen = model_.stage.frame().setup.knobs;
    EXPECT_GT(chosen.framing.centre.x, 0.6);
    EXPECT_GT(chosen.views.focus, 0.8);
    EXPECT_NE(chosen.views.strengthPercent, 7.5);
    expectSame({"--fit", "auto", "--focus", "auto", "--strength", "auto"});
    // the user takes over from what is shown
    const Framing shownFrame = model_.stage.frame().setup.knobs.framing;
    model_.stage.moveFrame({0.1, 0}, 1);
    EXPECT_FALSE(model_.settings.knobs().choices.framing);
    EXPECT_LT(model_.settings.knobs().framing.centre.x, shownFrame.centre.x);
    EXPECT_GT(model_.settings.knobs().framing.centre.x, 0.5);
    ASSERT_TRUE(waitForFrame());
    model_.stage.focusAt(0.05, 0.05);
    EXPECT_FALSE(model_.settings.knobs().choices.focus);
    EXPECT_TRUE(model_.settings.knobs().choices.strength);
    model_.settings.undoStack().undo();
    EXPECT_TRUE(model_.settings.knobs().choices.focus);
}

TEST(ViewerStudio, AVideoKeepsWhatWasChosenForItsFirstPicture) {
    const auto display = std::make_shared<const Display>(sampleDisplay({150, 200}));
    const auto framesOf = [&](bool video) {
        Studio studio(std::make_shared<DepthMaker>());
        std::vector<double> centres;
        for (const int left : {40, 430, 430}) { // the subject moves, and a scene begins
            const auto document = std::make_shared<Document>();
            document->source.file = "v.mp4";
            document->video = video;
            document->scene = centres.size() < 2 ? 4 : 5;
            document->picture = detailedPhoto({640, 400});
            document->depth = cv::Mat(400, 640, CV_32FC1, cv::Scalar(0.1));
            document->depth(cv::Rect(left, 120, 120, 260)) = 0.9;
            Request request;
            request.document = document;
            request.display = display;
            request.area = {150, 200};
            request.knobs.choices = {true, true, true};
            centres.push_back(studio.render(request).setup.knobs.framing.centre.x);
        }
        return centres;
    };
    const std::vector<double> photos = framesOf(false);
    const std::vector<double> video = framesOf(true);
    EXPECT_LT(photos[0], 0.4);
    EXPECT_GT(photos[1], 0.6);
    EXPECT_NEAR(video[0], photos[0], 0.02); // the photo's frame keeps away from the sides
    EXPECT_EQ(video[1], video[0]);
    EXPECT_NEAR(video[2], photos[2], 0.02);
}

TEST(ViewerStudio, APhotoAFrameAndTheViewerGiveOneNative) {
    const auto display = std::make_shared<const Display>(sampleDisplay({150, 200}));
    const cv::Size size(360, 480); // of enlarged frames, soft depth hardly differs
    TemporaryDirectory folder;
    std::vector<altiro3D::Scene> scenes;
    VideoWriterOptions lossless;
    lossless.size = size;
    lossless.codec = VideoCodec::Ffv1;
    VideoWriter clip(folder / "clip.mkv", lossless);
    VideoWriter depths(folder / "depth.mkv", lossless);
    for (int i = 0; i < 3; ++i) {
        cv::Mat depth = boxDepth(size);
        if (i == 0) cv::GaussianBlur(depth, depth, {0, 0}, 4); // only its flaws are measured
        cv::Mat photo(size, CV_8UC3, cv::Scalar(60 * i, 90, 150));
        detailedPhoto(size).copyTo(photo, boxDepth(size));
        cv::Mat grey;
        cv::cvtColor(depth, grey, cv::COLOR_GRAY2BGR);
        clip.write({photo, 40 * i, 40});
        depths.write({grey, 40 * i, 40});
        scenes.push_back({photo, {}});
        depth.convertTo(scenes.back().depth, CV_32F, 1 / 255.0);
    }
    clip.finish();
    depths.finish();
    VideoConversion conversion;
    conversion.input = folder / "clip.mkv";
    conversion.given.emplace().source = folder / "depth.mkv";
    conversion.output = folder / "native.mkv";
    conversion.encoding.codec = VideoCodec::Ffv1;
    conversion.display = *display;
    VideoConverter(std::move(conversion)).run();
    std::vector<cv::Mat> written;
    for (const VideoFrame& frame : allFrames(folder / "native.mkv"))
        written.push_back(frame.picture);
    ASSERT_EQ(written.size(), scenes.size());
    cv::Mat native;
    NativeMaker(*display).makeNative(scenes.front(), native);
    EXPECT_TRUE(samePicture(written.front(), native));
    NativeMaker(*display).makeNative(scenes.back(), native); // which has no flaws
    EXPECT_FALSE(samePicture(written.back(), native));
    Studio studio(std::make_shared<DepthMaker>());
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        const auto document = std::make_shared<Document>();
        document->source.file = folder / "clip.mkv";
        document->video = true;
        document->picture = scenes[i].photo;
        scenes[i].depth.convertTo(document->rawDepth, CV_8U, 255); // as of RGB-D frames
        Request request;
        request.document = document;
        request.display = display;
        request.mode = Mode::Native;
        request.area = display->panelSize();
        request.knobs = ofVideo({});
        EXPECT_TRUE(samePicture(studio.render(request).picture, written[i])) << i;
    }
}

TEST_F(ViewerModel, ContentFollowsTheMouse) {
    // 600 x 400 on 3 : 4: half of the width is seen, px by px
    const cv::Mat photo = detailedPhoto({600, 400});
    writeImage(folder_ / "photo.png", photo);
    writeImage(folder_ / "photo-depth.png", cv::Mat(400, 600, CV_8UC1, cv::Scalar(90)));
    openPhoto();
    EXPECT_TRUE(samePicture(picture(), photo(cv::Rect(150, 0, 300, 400))));
    model_.stage.moveFrame({40 / 300.0, 0.2}, 1); // only along the axis that is cut
    ASSERT_TRUE(waitForFrame());
    EXPECT_TRUE(samePicture(picture(), photo(cv::Rect(110, 0, 300, 400))));
    model_.stage.moveFrame({-9, 0}, 1); // to the photo's end, and back from there
    model_.stage.moveFrame({10 / 300.0, 0}, 1);
    ASSERT_TRUE(waitForFrame());
    EXPECT_TRUE(samePicture(picture(), photo(cv::Rect(290, 0, 300, 400))));
    model_.stage.zoomFrame({1, 0}, 2, 2); // the right upper corner stays
    ASSERT_TRUE(waitForFrame());
    const PhotoFit fit = fitPhoto({600, 400}, 0.75, {300, 400}, FitMode::Cover,
                                  framingOf(model_.stage.frame().setup));
    EXPECT_EQ(fit.source, cv::Rect(440, 0, 150, 200));
    model_.stage.resetFrame();
    ASSERT_TRUE(waitForFrame());
    EXPECT_TRUE(samePicture(picture(), photo(cv::Rect(150, 0, 300, 400))));
    EXPECT_EQ(model_.settings.undoStack().count(), 3); // a drag, a zoom, a reset
}

TEST_F(ViewerModel, ASmallPhotoIsShownWithTheZoomOfALargeOne) {
    openPhoto();
    for (int i = 0; i < 20; ++i)
        model_.stage.zoomFrame({0.3, 0.4}, 2, 1);
    EXPECT_NEAR(model_.settings.knobs().framing.zoom, 300 / 16.0, 0.01); // 16 columns are left
    ASSERT_TRUE(waitForFrame());
    EXPECT_EQ(model_.stage.problem(), "");
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(15, 400), cv::Size(40, 30)}) {
        writeImage(folder_ / "small.png", detailedPhoto(size));
        open({"small.png"});
        EXPECT_EQ(model_.stage.problem(), "") << size;
        model_.stage.moveFrame({0.1, 0.1}, 2);
        ASSERT_TRUE(waitForFrame());
        EXPECT_EQ(model_.stage.problem(), "") << size;
    }
}

TEST_F(ViewerModel, TheNativeByMethodRealIsThatOfTheTool) {
    openPhoto();
    model_.stage.setMode(Mode::Native);
    ASSERT_TRUE(waitForFrame());
    const cv::Mat usual = picture().clone();
    turn([](Knobs& knobs) { knobs.views.method = ViewMethod::Real; }); // makes whole views only
    EXPECT_EQ(exportTo(Product::Native, folder_ / "r.png"), "");
    photo2native({"-g"}, "tool-r.png");
    EXPECT_EQ(slurp(folder_ / "r.png"), slurp(folder_ / "tool-r.png"));
    model_.settings.undoStack().undo();
    ASSERT_TRUE(waitForFrame());
    EXPECT_TRUE(samePicture(picture(), usual));
}

TEST_F(ViewerModel, FlatDepthLiesAtTheFocusAsTheToolsHaveIt) {
    writeImage(folder_ / "photo-depth.png", cv::Mat(400, 300, CV_8UC1, cv::Scalar(90)));
    openPhoto();
    for (const auto& [value, text] : {std::pair{0.25, "0.25"}, std::pair{0.75, "0.75"}}) {
        focus(value);
        EXPECT_EQ(exportTo(Product::Native, folder_ / "n.png"), ""); // before its frame is there
        EXPECT_EQ(exportTo(Product::Depth, folder_ / "d.png"), "");
        photo2native({"--focus", text, "--save-depth", at("tool-d.png")}, "tool-n.png");
        EXPECT_EQ(slurp(folder_ / "n.png"), slurp(folder_ / "tool-n.png")) << text;
        EXPECT_EQ(slurp(folder_ / "d.png"), slurp(folder_ / "tool-d.png")) << text;
        model_.stage.setPosition(1);
        ASSERT_TRUE(waitForFrame());
        EXPECT_TRUE(samePicture(picture(), detailedPhoto({300, 400}))) << text; // nothing moves
    }
}

TEST_F(ViewerModel, ASwayVideoIsThereWholeOrNotAtAll) {
    openPhoto();
    EXPECT_EQ(exportTo(Product::SwayVideo, folder_ / "sway.mp4"), "");
    VideoReader reader(folder_ / "sway.mp4");
    int frames = 0;
    while (reader.next())
        ++frames;
    EXPECT_EQ(frames, 240); // two turns of four seconds, as the tools

    cancelExportTo(Product::SwayVideo, folder_ / "cancelled.mp4");
    for (const auto& entry : fs::directory_iterator(folder_.path()))
        EXPECT_FALSE(holds(entry.path().string(), "cancelled")) << entry.path();
}

TEST_F(ViewerModel, ViewsDoNotMixWithThoseOfAnotherPicture) {
    openPhoto();
    fs::create_directory(folder_ / "views");
    const cv::Mat mine(3, 4, CV_8UC3, cv::Scalar(1, 2, 3));
    writeImage(folder_ / "views/view_03.png", mine);
    const QString problem = exportTo(Product::Views, folder_ / "views");
    EXPECT_TRUE(problem.contains("views: holds view_03.png already")) << problem.toStdString();
    EXPECT_TRUE(samePicture(readPhoto(folder_ / "views/view_03.png"), mine));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "views"), {}), 1);
    cancelExportTo(Product::Views, folder_ / "cancelled");
    EXPECT_FALSE(fs::exists(folder_ / "cancelled"));
}

TEST_F(ViewerModel, SaysWhyNothingCanBeExportedYet) {
    EXPECT_TRUE(model_.exports.obstacle().contains("Nothing is open"));
    openPhoto();
    EXPECT_EQ(model_.exports.obstacle(), "");
    turn([](Knobs& knobs) { knobs.depth = "tiny"; });
    EXPECT_TRUE(model_.exports.obstacle().contains("still being estimated"));
    EXPECT_FALSE(model_.exports.start(Product::Native, folder_ / "n.png"));
    ASSERT_TRUE(waitForFrame());
    EXPECT_TRUE(model_.exports.start(Product::Native, folder_ / "n.png"));
    EXPECT_TRUE(model_.exports.obstacle().contains("Another export"));
    EXPECT_FALSE(model_.exports.start(Product::Native, folder_ / "second.png"));
    ASSERT_TRUE(waitFor([this] { return !model_.exports.areRunning(); }));
    EXPECT_EQ(model_.exports.obstacle(), "");
    // and what cannot be written is named
    EXPECT_TRUE(exportTo(Product::Native, folder_ / "none/n.png").contains("none/n.png"));
    EXPECT_FALSE(model_.exports.areRunning());
}

// When each picture of a video was shown, ms, and its grey; at least so many.
std::vector<std::pair<qint64, int>> played(const fs::path& file, std::size_t count, int seeks = 0) {
    std::mutex mutex;
    std::vector<std::pair<qint64, int>> shown;
    QElapsedTimer timer;
    timer.start();
    VideoPlayer player(
        file,
        [&](const cv::Mat& picture, double) {
            const std::lock_guard<std::mutex> lock(mutex);
            shown.emplace_back(timer.elapsed(), picture.at<cv::Vec3b>(20, 20)[1]);
            return true;
        },
        [](const std::string& problem) { ADD_FAILURE() << problem; });
    EXPECT_TRUE(waitFor([&] {
        const std::lock_guard<std::mutex> lock(mutex);
        return shown.size() >= count;
    }));
    const auto total = [&] { return player.counts().shown + player.counts().dropped; };
    for (; seeks > 0; --seeks) {
        const auto before = total();
        player.seek(0);
        EXPECT_TRUE(waitFor([&] { return total() > before; }));
    }
    player.end();
    EXPECT_EQ(player.counts().shown, static_cast<std::int64_t>(shown.size()));
    return shown;
}

TEST(ViewerVideo, PlaysAtItsRateAgainAndAgain) {
    const TemporaryDirectory folder;
    writeGreys(folder / "v.mkv", {64, 48}, 10);
    const auto shown = played(folder / "v.mkv", 15);
    // busy machines are late and drop some, but nothing is early, out of order, or the end
    bool again = false;
    for (std::size_t i = 1; i < shown.size(); ++i) {
        const int number = qRound((shown[i].second - 20) / 10.0);
        const int before = qRound((shown[i - 1].second - 20) / 10.0);
        if (number < before) {
            again = true;
            break;
        }
        EXPECT_GT(number, before);
        EXPECT_GE(shown[i].first, 40 * number); // the clock ran before the video did
    }
    EXPECT_TRUE(again);
}

TEST(ViewerVideo, TheLastPictureHasItsTimeToo) {
    const TemporaryDirectory folder;
    writeGreys(folder / "v.mkv", {64, 48}, 2, 4);
    const auto shown = played(folder / "v.mkv", 3);
    ASSERT_GE(shown.size(), 3U);
    for (std::size_t i = 1; i < shown.size(); ++i)
        EXPECT_NE(shown[i].second, shown[i - 1].second);
    EXPECT_GE(shown[2].first, 480); // two of 250 ms; the clock here began before the player's
}

// Times that a clock of 64 bits in ns cannot count.
TEST(ViewerVideo, APictureOfTheFarFutureIsNotShownNow) {
    const TemporaryDirectory folder;
    VideoWriterOptions options;
    options.size = {64, 48};
    options.timeBase = {1, 1};
    VideoWriter writer(folder / "v.mkv", options);
    for (int i = 0; i < 2; ++i)
        writer.write(
            {cv::Mat(options.size, CV_8UC3, cv::Scalar::all(20 + 90 * i)), i * 20'000'000'000, 1});
    writer.finish();
    for (const auto& [time, grey] : played(folder / "v.mkv", 1, 5))
        EXPECT_LT(grey, 60) << time;
}

TEST(ViewerVideo, ASinglePictureIsNotReadAllTheTime) {
    const TemporaryDirectory folder;
    writeGreys(folder / "v.mkv", {64, 48}, 1, 1000);
    const auto shown = played(folder / "v.mkv", 5);
    EXPECT_GE(shown.back().first, 40 * static_cast<qint64>(shown.size() - 1));
}

TEST(ViewerVideo, SaysWhyAVideoCannotBeRead) {
    const TemporaryDirectory folder;
    spill(folder / "v.mp4", "no video");
    std::promise<std::string> problem;
    VideoPlayer player(
        folder / "v.mp4", [](const cv::Mat&, double) { return true; },
        [&](const std::string& text) { problem.set_value(text); });
    EXPECT_TRUE(holds(problem.get_future().get(), "v.mp4"));
}

TEST_F(ViewerModel, VideosOfAllKindsPlay) {
    writeGreys(folder_ / "n.mkv", {150, 200}, 10);
    writeGreys(folder_ / "q_qs2x2a0.75.mkv", {150, 200}, 10);
    writeGreys(folder_ / "flat.mkv", {90, 120}, 10);
    const std::pair<const char*, Kind> videos[] = {
        {"n.mkv", Kind::Native}, {"q_qs2x2a0.75.mkv", Kind::Quilt}, {"flat.mkv", Kind::Scene}};
    for (const auto& [name, kind] : videos) {
        model_.files.open(std::vector<fs::path>{folder_ / name});
        ASSERT_TRUE(waitFor([&] { return !model_.stage.isBusy(); }));
        ASSERT_NE(model_.files.document(), nullptr) << model_.stage.problem().toStdString();
        EXPECT_EQ(model_.files.document()->kind, kind) << name;
        std::set<int> greys;
        QObject watcher;
        QObject::connect(&model_.stage, &Stage::frameReady, &watcher, [&] {
            if (!picture().empty())
                greys.insert(picture().at<cv::Vec3b>(picture().rows / 2, 70)[1]);
        });
        EXPECT_TRUE(waitFor([&] { return greys.size() >= 4; })) << name;
        model_.files.setPlaying(false);
        const auto standsStill = [this] { // while 20 frames are made of its last picture
            const auto before = model_.files.videoCounts().shown;
            for (int width = 280; width < 300; ++width) {
                QSignalSpy frames(&model_.stage, &Stage::frameReady);
                model_.stage.setArea({width, 400});
                if (!waitFor([&] { return frames.count() > 0; })) return false;
            }
            return model_.files.videoCounts().shown == before;
        };
        ASSERT_TRUE(waitFor(standsStill)) << name; // a picture was on its way
        const auto counts = model_.files.videoCounts();
        model_.files.setPlaying(true);
        EXPECT_TRUE(waitFor([&] { return model_.files.videoCounts().shown > counts.shown; }));
    }
    model_.files.close(model_.files.current());
}

// A directory of networks, while it lives.
class Networks {
  public:
    explicit Networks(const fs::path& directory) : before_(qgetenv("ALTIRO3D_MODELS")) {
        qputenv("ALTIRO3D_MODELS", directory.c_str());
    }
    ~Networks() { qputenv("ALTIRO3D_MODELS", before_); }
    Networks(const Networks&) = delete;
    Networks& operator=(const Networks&) = delete;

  private:
    QByteArray before_;
};

TEST_F(ViewerModel, ANetworkMakesTheDepthOfPhotosAndVideos) {
    ALTIRO3D_REQUIRE_DATA("models/fastdepth/fastdepth_224_op10.onnx");
    const fs::path file = dataPath("models/fastdepth/fastdepth_224_op10.onnx");
    const Networks networks(file.parent_path());
    const InstalledNetwork* known = nullptr;
    const std::vector<InstalledNetwork> ready = installedNetworks();
    for (const InstalledNetwork& network : ready)
        if (network.profile.name == "fastdepth") known = &network;
    ASSERT_NE(known, nullptr);
    const cv::Mat photo = detailedPhoto({300, 400});
    cv::Mat expected;
    altiro3D::Scene scene;
    depthFromNetworkFile(known->file, known->profile)->readScene(photo, 0.5, scene);
    expected = scene.depth;

    fs::remove(folder_ / "photo-depth.png");
    Model model(sampleDisplay({150, 200}));
    model.stage.setArea({300, 400});
    Knobs knobs;
    knobs.depth = "fastdepth";
    model.settings.restore(knobs);
    model.files.open(std::vector<fs::path>{folder_ / "photo.png"});
    const auto isFrom = [&model](const std::string& source) {
        return waitFor([&] { return model.stage.frame().setup.depthSource == source; });
    };
    EXPECT_TRUE(isFrom("fastdepth")) << model.stage.problem().toStdString();
    EXPECT_TRUE(samePicture(model.stage.frame().setup.depth, expected));

    writeGreys(folder_ / "flat.mkv", {90, 120}, 25);
    model.files.open(std::vector<fs::path>{folder_ / "flat.mkv"});
    EXPECT_TRUE(isFrom("fastdepth, as often as the video needs it"));
    knobs.depth = "altiro3d"; // while it plays
    model.settings.turn(knobs, "depth");
    EXPECT_TRUE(isFrom("altiro3d, as often as the video needs it"));
}

TEST(ViewerDepth, TheStandardNetworkIsUsedByItself) {
    EXPECT_EQ(DepthMaker().choose(kBestDepth, false), "tiny");
    const TemporaryDirectory models;
    const Networks networks(models.path());
    if (fs::exists(sourcePath("models/model-small.onnx"))) GTEST_SKIP() << "it is there";
    spill(models / "fastdepth_224_op10.onnx", "no network");
    EXPECT_EQ(DepthMaker().choose(kBestDepth, false), "altiro3d"); // of the source tree
    EXPECT_EQ(DepthMaker().choose("fastdepth", false), "fastdepth");
    spill(models / "model-small.onnx", "no network");
    EXPECT_EQ(DepthMaker().choose(kBestDepth, false), "midas-small");
    EXPECT_EQ(DepthMaker().choose(kBestDepth, true), kGivenDepth);
    spill(models / "catalog.json", R"({"networks": [
        {"name": "other", "file": "model-small.onnx", "inputWidth": 64, "inputHeight": 64,
         "engine": "onnxruntime"}]})");
    EXPECT_EQ(DepthMaker().choose(kBestDepth, false), hasOnnxRuntime() ? "other" : kBestDepth);
}

TEST_F(ViewerModel, ANetworkThatIsNoneIsAMessage) {
    const TemporaryDirectory models;
    spill(models / "model-small.onnx", "no network");
    const Networks networks(models.path());
    fs::remove(folder_ / "photo-depth.png");
    writeGreys(folder_ / "flat.mkv", {90, 120}, 25);
    Model model(sampleDisplay({150, 200}));
    model.stage.setArea({300, 400});
    for (const char* name : {"photo.png", "flat.mkv"}) {
        model.files.open(std::vector<fs::path>{folder_ / name});
        EXPECT_TRUE(waitFor([&] { return model.stage.problem().contains("model-small.onnx"); }))
            << model.stage.problem().toStdString();
        EXPECT_FALSE(model.stage.canFrame()) << "no picture is shown";
    }
    spill(models / "catalog.json", R"({"networks": []})");
    Model other(sampleDisplay({150, 200}));
    other.stage.setArea({300, 400});
    other.files.open(std::vector<fs::path>{folder_ / "photo.png"});
    EXPECT_TRUE(waitFor([&] { return other.stage.problem().contains("no network is installed"); }))
        << other.stage.problem().toStdString();
}

TEST_F(ViewerModel, WhyAVideoStoppedIsSaidUntilItPlaysAgain) {
    writeGreys(folder_ / "flat.mkv", {90, 120}, 10);
    model_.files.open(std::vector<fs::path>{folder_ / "flat.mkv"});
    ASSERT_TRUE(waitFor([this] { return !model_.stage.isBusy() && model_.files.document(); }));
    fs::rename(folder_ / "flat.mkv", folder_ / "away.mkv"); // as if its USB drive were removed
    model_.stage.setSwinging(true);
    ASSERT_TRUE(waitFor([this] { return model_.stage.problem().contains("flat.mkv"); }));
    QSignalSpy frames(&model_.stage, &Stage::frameReady);
    ASSERT_TRUE(waitFor([&frames] { return frames.count() >= 3; })); // of the last picture
    EXPECT_TRUE(model_.stage.problem().contains("flat.mkv"));
    fs::rename(folder_ / "away.mkv", folder_ / "flat.mkv");
    turn([](Knobs& knobs) { knobs.depth = "tiny"; });
    EXPECT_TRUE(waitFor([this] { return model_.files.videoCounts().shown >= 3; }));
    EXPECT_EQ(model_.stage.problem(), "");
}

// A network that is a named pipe: it takes as long as the pipe is open for writing.
TEST_F(ViewerModel, OtherFilesAreChosenWhileAVideoWaitsForItsDepth) {
    const TemporaryDirectory models;
    ASSERT_EQ(mkfifo((models / "model-small.onnx").c_str(), 0600), 0);
    const Networks networks(models.path());
    writeGreys(folder_ / "flat.mkv", {90, 120}, 25);
    Model model(sampleDisplay({150, 200}));
    Knobs knobs;
    knobs.depth = "midas-small";
    model.settings.restore(knobs);
    model.stage.setArea({300, 400});
    model.files.open(std::vector<fs::path>{folder_ / "flat.mkv"});
    ASSERT_TRUE(waitFor([&] { return model.files.document() != nullptr; }));
    int pipe = -1;
    ASSERT_TRUE(waitFor([&] { // a thread reads it
        pipe = ::open((models / "model-small.onnx").c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
        return pipe >= 0;
    }));
    for (int i = 0; i < 3; ++i) // does not wait for that thread, which waits for this one
        model.files.open(std::vector<fs::path>{folder_ / "photo.png", folder_ / "photo-depth.png"});
    knobs.depth = kBestDepth;
    model.settings.turn(knobs, "depth");
    EXPECT_TRUE(model.stage.isBusy());
    EXPECT_TRUE(waitFor([&] {
        close(std::exchange(pipe, -1)); // nothing was in it; others may have begun to read it
        pipe = ::open((models / "model-small.onnx").c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
        return !model.stage.isBusy() && model.files.document() && !model.files.document()->video;
    }));
    close(pipe);
}

TEST_F(ViewerModel, LateFramesOfTheFileBeforeTakeNoMessageAway) {
    spill(folder_ / "broken.jpg", "no picture");
    model_.files.open(std::vector<fs::path>{folder_ / "broken.jpg"});
    openPhoto();
    model_.stage.setSwinging(true); // requests frames continuously
    QObject watcher;
    QObject::connect(&model_.stage, &Stage::stateChanged, &watcher, [this] {
        EXPECT_FALSE(!model_.files.document() && model_.stage.problem().isEmpty());
    });
    for (int i = 0; i < 10; ++i) {
        model_.files.select(0);
        model_.stage.setPosition(0.1 * i); // while the file is being read
        ASSERT_TRUE(waitFor([this] { return !model_.stage.isBusy(); }));
        EXPECT_FALSE(model_.stage.problem().isEmpty()) << i;
        EXPECT_EQ(model_.files.document(), nullptr);
        model_.files.select(1);
        ASSERT_TRUE(waitFor([this] { return !model_.stage.isBusy() && model_.files.document(); }));
    }
}

TEST_F(ViewerModel, EndsCleanlyInTheMiddleOfItsWork) {
    writeImage(folder_ / "large.png", detailedPhoto({2000, 1500}));
    for (int frames = 0; frames < 4; ++frames) {
        Model model(sampleDisplay());
        QSignalSpy made(&model.stage, &Stage::frameReady);
        model.stage.setArea({600, 800});
        model.files.open(std::vector<fs::path>{folder_ / "large.png"});
        model.stage.setSwinging(true);
        EXPECT_TRUE(waitFor([&] { return made.count() >= frames; }));
    }
    fs::create_directory(folder_ / "exports");
    for (int steps = 0; steps < 4; ++steps) {
        Model model(sampleDisplay());
        QSignalSpy progress(&model.exports, &Exports::progress);
        model.stage.setArea({600, 800});
        model.files.open(std::vector<fs::path>{folder_ / "large.png"});
        ASSERT_TRUE(waitFor([&] { return model.exports.obstacle().isEmpty(); }));
        model.stage.setSwinging(true);
        EXPECT_TRUE(model.exports.start(Product::SwayVideo, folder_ / "exports/e.mp4"));
        EXPECT_TRUE(waitFor([&] { return progress.count() >= steps; }));
        EXPECT_TRUE(model.exports.areRunning());
    }
    EXPECT_TRUE(fs::is_empty(folder_ / "exports"));
}

// A change of a setting is visible at once because it costs one frame of bounded size and nothing
// is read or estimated again.
TEST_F(ViewerModel, AKnobOnALargePhotoCostsOneSmallFrame) {
    writeImage(folder_ / "mega.png", detailedPhoto({1734, 2312}));
    writeImage(folder_ / "mega-depth.png", boxDepth({1734, 2312}));
    model_.stage.setArea({867, 1156});
    open({"mega.png", "mega-depth.png"});
    model_.stage.setPosition(0.7);
    ASSERT_TRUE(waitForFrame());
    const auto document = model_.files.document();
    QSignalSpy frames(&model_.stage, &Stage::frameReady);
    for (int i = 1; i <= 4; ++i) {
        focus(model_.settings.knobs().views.focus + 0.01);
        ASSERT_TRUE(waitForFrame());
        EXPECT_EQ(frames.count(), i);
        EXPECT_GT(picture().total(), 600000U);
        EXPECT_LE(picture().total(), 867U * 1156);
        EXPECT_EQ(model_.files.document(), document);
    }
}

TEST_F(ViewerModel, SplatsAreTurnedByTheMouse) {
    Scene scene;
    scene.photo = detailedPhoto({40, 30});
    scene.depth = cv::Mat(30, 40, CV_32FC1, cv::Scalar(0.2));
    scene.depth(cv::Rect(12, 8, 16, 14)) = 0.9;
    writeSplats(folder_ / "a.ply", splatsOf(scene));
    model_.settings.restore(Knobs());
    open({"a.ply"});
    const cv::Mat before = picture().clone();
    EXPECT_FALSE(model_.stage.frame().depth.empty());
    EXPECT_TRUE(model_.stage.canFrame());
    const auto isTurned = [&](int views) {
        return waitFor([&] {
            const Frame& frame = model_.stage.frame();
            return frame.knobs == model_.settings.knobs() && !frame.setup.isDraft &&
                   frame.setup.document->layout.viewCount == views;
        });
    };
    model_.stage.setMode(Mode::Depth);
    ASSERT_TRUE(waitForFrame());
    EXPECT_GT(picture().at<cv::Vec3b>(picture().rows / 2, picture().cols / 2)[0], 200); // the box
    model_.stage.setMode(Mode::Sway);
    model_.stage.moveFrame({-0.05, 0.02}, 7); // the camera goes to the right and up
    EXPECT_NEAR(model_.settings.knobs().framing.centre.x, 0.525, 1e-9);
    model_.stage.zoomFrame({0.5, 0.5}, 1.5, 8);
    ASSERT_TRUE(isTurned(model_.files.display()->quilt.viewCount)); // when it rests
    EXPECT_FALSE(samePicture(picture(), before));
    model_.stage.focusAt(0.5, 0.5);
    EXPECT_FALSE(model_.settings.knobs().choices.focus);
    EXPECT_GT(model_.settings.knobs().views.focus, 0.5); // the near box
    for (int i = 0; i < 3; ++i)
        model_.settings.undoStack().undo();
    ASSERT_TRUE(waitForFrame());
    EXPECT_TRUE(samePicture(picture(), before));
}

} // namespace
} // namespace altiro3D::test
