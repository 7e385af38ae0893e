#include "support/compare.hpp"
#include "support/slow.hpp"
#include "support/stereo_scene.hpp"
#include "support/video.hpp"
#include "viewer/window/video_export_dialog.hpp"
#include "viewer_scenes.hpp"
#include "window_actions.hpp"

#include <QLabel>
#include <QProcess>
#include <QPushButton>
#include <QSettings>
#include <QStatusBar>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

void writeMovingClip(const fs::path& file, cv::Size size, int frames) {
    VideoWriterOptions options = smallOptions();
    options.size = size;
    writeClip(file, options, frames);
}

class ViewerVideoExport : public ::testing::Test {
  protected:
    void SetUp() override {
        QSettings().clear();
        window_ = shownWindow();
        model().files.setPlaying(false);
    }
    Model& model() { return window_->model(); }
    void open(const char* name) {
        dropOn(*window_, {folder_ / name});
        ASSERT_TRUE(waitFor([this] {
            const auto& document = model().files.document();
            return document && document->video && !model().stage.isBusy();
        }));
    }
    // Exports through the menu. @return what was asked
    QStringList startExport(const char* name, QMessageBox::StandardButton answer) {
        return answering(folder_ / name, answer,
                         [this] { window_->findChild<QAction*>("exportVideo")->trigger(); });
    }
    void waitForEnd() {
        ASSERT_TRUE(waitFor([this] { return !model().exports.areRunning(); }));
    }
    QString said() {
        QStringList tips;
        for (const QLabel* label : window_->statusBar()->findChildren<QLabel*>())
            tips << label->toolTip();
        return tips.join(' ');
    }
    std::string bytesOf(const char* name) const { return slurp(folder_ / name); }
    // What the tool makes for the window's display.
    void video2native(const QStringList& options, const char* input, const char* output) const {
        const QStringList call{"-y", "-c", writeSample(folder_ / "c.json", {150, 200})};
        ASSERT_EQ(
            QProcess::execute(ALTIRO3D_TOOL_VIDEO2NATIVE,
                              call + options +
                                  QStringList{toName(folder_ / input), toName(folder_ / output)}),
            0);
    }
    // The window writes the bytes of the tool.
    void expectSame(const QStringList& options, const char* input, const char* output) {
        startExport(output, QMessageBox::No);
        waitForEnd();
        video2native(options, input, "tool.mkv");
        EXPECT_EQ(bytesOf(output), bytesOf("tool.mkv")) << output;
    }
    bool isPartLeft(const char* name) const {
        return fs::exists(unfinishedVideoDirectory(folder_ / name));
    }

    TemporaryDirectory folder_;
    std::unique_ptr<MainWindow> window_;
};

TEST_F(ViewerVideoExport, WritesTheBytesOfTheToolWithTheSameSettings) {
    writeMovingClip(folder_ / "clip.mkv", {96, 128}, 20);
    open("clip.mkv");
    EXPECT_EQ(startExport("plain", QMessageBox::No), QStringList{"clip_native.mp4"});
    waitForEnd();
    video2native({}, "clip.mkv", "tool.mp4");
    EXPECT_EQ(bytesOf("plain.mp4"), bytesOf("tool.mp4")); // the suffix was added
    EXPECT_TRUE(said().contains("Written: ")) << said().toStdString();

    Knobs knobs = model().settings.knobs();
    knobs.views.method = ViewMethod::Fast;
    knobs.views.strengthPercent = 7;
    knobs.views.focus = 0.25;
    knobs.depthCurve = 1.5;
    knobs.fit = FitMode::Contain;
    knobs.columns = 5;
    knobs.rows = 4;
    model().settings.turn(knobs, "all");
    expectSame({"--method", "fast", "--strength", "7", "--focus", "0.25", "--fit", "contain", "-q",
                "4x5", "--depth-curve", "1.5"},
               "clip.mkv", "other.mkv");

    knobs = Knobs();
    knobs.choices = {true, true, false, false};
    model().settings.turn(knobs, "all");
    expectSame({"--fit", "auto", "--focus", "auto"}, "clip.mkv", "auto.mkv");
}

TEST_F(ViewerVideoExport, TakesDepthAndQuiltsInThePicturesOfTheVideo) {
    writeMovingClip(folder_ / "clip_rgbd.mkv", {192, 128}, 12);
    writeMovingClip(folder_ / "clip_qs4x3a0.75.mkv", {240, 240}, 12);
    open("clip_rgbd.mkv");
    expectSame({"--rgbd", "right"}, "clip_rgbd.mkv", "rgbd.mkv");
    // a network cannot see half of a picture
    Knobs knobs = model().settings.knobs();
    knobs.depth = "tiny";
    model().settings.turn(knobs, "depth");
    EXPECT_TRUE(model().exports.videoObstacle().contains("its own depth"));
    EXPECT_FALSE(model().exports.startVideo(folder_ / "no.mkv", false));

    model().files.close(0);
    open("clip_qs4x3a0.75.mkv");
    expectSame({"--from-quilt"}, "clip_qs4x3a0.75.mkv", "quilts.mkv");

    // a depth stream is replaced by a network if one is chosen
    writeMovingClip(folder_ / "clip.mkv", {96, 128}, 12);
    ffmpeg("-i " + arg(folder_ / "clip.mkv") +
           " -map 0 -map 0 -c:v ffv1 -pix_fmt:v:0 bgr0 -pix_fmt:v:1 gray "
           "-metadata:s:v:1 title=depth " +
           arg(folder_ / "track.mkv"));
    model().files.close(0);
    open("track.mkv");
    expectSame({}, "track.mkv", "own.mkv");
    EXPECT_EQ(model().files.document()->facts(),
              "Video, 96 x 128 px; depth in the video, white as near");
    model().settings.turn(knobs, "depth");
    expectSame({"-n", "tiny"}, "track.mkv", "estimated.mkv");
}

// A thing before a wall, side by side, then a title that both eyes see alike.
TEST_F(ViewerVideoExport, PlaysAndExportsVideosOfBothEyes) {
    ALTIRO3D_TAKES(3);
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat film;
    cv::hconcat(eyes.left, eyes.right, film);
    cv::Mat title;
    cv::hconcat(detailedPhoto(eyes.left.size()), detailedPhoto(eyes.left.size()), title);
    std::vector<cv::Mat> pictures(20, film);
    pictures.resize(30, title);
    writeClip(folder_ / "film_LRF.mkv", pictures, 25);
    model().stage.setMode(Mode::Depth);
    open("film_LRF.mkv");
    EXPECT_EQ(model().files.document()->facts().find(
                  "Video, 400 x 300 px; both eyes, as its name says it (LRF)"),
              0U)
        << model().files.document()->facts();
    model().files.setPlaying(true);
    int things = 0;
    QObject::connect(&model().stage, &Stage::frameReady, window_.get(), [&] {
        const Frame& frame = model().stage.frame();
        if (frame.setup.depthSource.find("both eyes, as often") != 0) return; // not played yet
        const bool isFilm = cv::norm(frame.setup.document->picture, eyes.left, cv::NORM_L1) <
                            10.0 * static_cast<double>(eyes.left.total() * 3);
        if (!isFilm) return; // the title's depth is estimated, in the network's size
        const cv::Mat& depth = frame.setup.depth;
        const double thing = cv::mean(depth(cv::Rect(180, 130, 40, 40)))[0];
        const double wall = cv::mean(depth(cv::Rect(330, 30, 40, 40)))[0];
        ++things;
        EXPECT_GT(thing, 0.9);
        EXPECT_LT(wall, 0.1);
    });
    EXPECT_TRUE(waitFor([&] { return things >= 5; })) << model().stage.problem().toStdString();
    EXPECT_EQ(model().stage.problem(), "");
    model().files.setPlaying(false);

    expectSame({}, "film_LRF.mkv", "eyes.mkv");
    const auto readAs = [this](Reading reading) {
        model().files.reopen(reading, {});
        ASSERT_TRUE(
            waitFor([this] { return model().files.document() && !model().stage.isBusy(); }));
    };
    readAs(Reading::Photo);
    EXPECT_EQ(model().files.document()->facts(), "Video, 800 x 300 px");
    expectSame({"--stereo", "off"}, "film_LRF.mkv", "flat.mkv");
    readAs(Reading::EyesRightLeft);
    EXPECT_TRUE(model().files.document()->facts().find("you have chosen it") != std::string::npos);
    expectSame({"--stereo", "right-left"}, "film_LRF.mkv", "swapped.mkv");
}

TEST_F(ViewerVideoExport, ACancelledOneKeepsItsPartsAndGoesOnToTheSameBytes) {
    writeMovingClip(folder_ / "clip.mkv", {48, 64}, 400); // of 16 s
    open("clip.mkv");
    spill(folder_ / "out.mkv", "mine");
    QString size;
    QObject::connect(&model().exports, &Exports::videoProgress, window_.get(),
                     [&](const VideoExportState& state) {
                         auto* dialog = window_->findChild<VideoExportDialog*>();
                         ASSERT_NE(dialog, nullptr);
                         EXPECT_FALSE(dialog->isModal()); // the window can be used
                         if (state.end < 8 || size.size() > 0) return;
                         EXPECT_NEAR(state.share, state.end / 16, 1e-6);
                         size = dialog->findChild<QLabel*>("videoSize")->text();
                         dialog->findChild<QPushButton*>("cancelVideo")->click();
                     });
    EXPECT_EQ(startExport("out.mkv", QMessageBox::Yes).size(), 2); // it exists already
    entryOf(*window_, "Depth")->trigger();
    EXPECT_EQ(model().stage.mode(), Mode::Depth);
    EXPECT_FALSE(window_->findChild<QAction*>("exportVideo")->isEnabled());
    waitForEnd();
    EXPECT_TRUE(size.startsWith("about ")) << size.toStdString();
    EXPECT_EQ(bytesOf("out.mkv"), "mine");
    EXPECT_TRUE(isPartLeft("out.mkv"));
    EXPECT_TRUE(said().contains("export to the same name to go on")) << said().toStdString();
    EXPECT_EQ(window_->findChild<VideoExportDialog*>(), nullptr);

    fs::remove(folder_ / "out.mkv");
    const QStringList asked = startExport("out.mkv", QMessageBox::Yes);
    ASSERT_EQ(asked.size(), 2);
    EXPECT_TRUE(asked[1].contains("was not finished")) << asked[1].toStdString();
    waitForEnd();
    EXPECT_FALSE(isPartLeft("out.mkv"));
    video2native({}, "clip.mkv", "tool.mkv");
    EXPECT_EQ(bytesOf("out.mkv"), bytesOf("tool.mkv"));
}

TEST_F(ViewerVideoExport, SaysInOneSentenceWhatIsWrong) {
    writeMovingClip(folder_ / "clip.mkv", {48, 64}, 5);
    open("clip.mkv");
    EXPECT_TRUE(startExport("clip.avi", QMessageBox::Ok)[1].contains("no video format"));
    const QStringList asked = answering(
        folder_ / "clip.mkv", QMessageBox::Yes,
        [this] { window_->findChild<QAction*>("exportVideo")->trigger(); },
        [](const QStringList& all) { return all.size() == 3; }); // its name, "replace?", the error
    EXPECT_TRUE(asked[2].contains("clip.mkv: ")) << asked[2].toStdString();
    EXPECT_FALSE(asked[2].contains(" -")) << asked[2].toStdString();
    EXPECT_FALSE(model().exports.areRunning());
    VideoReader reader(folder_ / "clip.mkv");
    EXPECT_EQ(allFrames(reader).size(), 5U);

    writeImage(folder_ / "photo.png", detailedPhoto({300, 400}));
    dropOn(*window_, {folder_ / "photo.png"});
    ASSERT_TRUE(waitFor([this] {
        return model().files.document() && !model().stage.isBusy() &&
               !model().files.document()->video;
    }));
    EXPECT_FALSE(window_->findChild<QAction*>("exportVideo")->isEnabled());
}

} // namespace
} // namespace altiro3D::test
