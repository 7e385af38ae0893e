// Videos with sound in the window and in a show: the bar, the keys, and pictures in step.

#include "recorded_sound.hpp"
#include "support/slow.hpp"
#include "viewer/show/slide_presenter.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/video_bar.hpp"
#include "viewer_scenes.hpp"
#include "window_actions.hpp"

#include <QComboBox>
#include <QGuiApplication>
#include <QLabel>
#include <QScreen>
#include <QSettings>
#include <QSlider>
#include <QToolButton>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;
using Clock = Recording::Clock;

// Times at which a picture turns from dark to bright.
class Flashes {
  public:
    void note(int grey) {
        if (grey > 128 && before_ <= 128) times_.push_back(Clock::now());
        before_ = grey;
    }
    std::size_t count() const { return times_.size(); }
    // The largest distance of a flash from its click, s.
    double largestOffset(const Recording& recording) const {
        const std::vector<double> clicks = clicksOf(recording.samples());
        double worst = 0;
        for (const Clock::time_point time : times_) {
            double nearest = 1e9;
            for (const double click : clicks)
                nearest = std::min(nearest, std::abs(recording.sampleAt(time) - click));
            worst = std::max(worst, nearest / Recording::kRate);
        }
        return worst;
    }

  private:
    int before_ = 0;
    std::vector<Clock::time_point> times_;
};

class ViewerVideoBar : public ::testing::Test {
  protected:
    void SetUp() override {
        ALTIRO3D_REQUIRE_FFMPEG();
        if (!soundProblem().empty()) GTEST_SKIP() << soundProblem();
        QSettings().clear();
    }
    // A Native video of the panel's size, with two sound tracks.
    fs::path clicks(int seconds, cv::Size size = {150, 200}) {
        const std::string scale =
            "-vf scale=" + std::to_string(size.width) + ":" + std::to_string(size.height);
        return makeClicks(folder_ / "native.mkv", seconds, scale + " -map 0 -map 1 -map 1");
    }
    void open(const fs::path& file) {
        window_ = shownWindow();
        EXPECT_FALSE(bar().isVisible());
        model().files.open(std::vector<fs::path>{file});
        ASSERT_TRUE(waitFor([this] { return bar().isVisible() && state().sounds; }));
    }
    Model& model() { return window_->model(); }
    VideoPlayer::State state() { return model().files.videoState(); }
    VideoBar& bar() { return *window_->findChild<VideoBar*>(); }
    template <class Widget>
    Widget& part(const char* name) {
        return *window_->findChild<Widget*>(name);
    }
    void press(Qt::Key key, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
        QTest::keyClick(window_.get(), key, modifiers);
    }

    TemporaryDirectory folder_;
    std::unique_ptr<MainWindow> window_;
};

TEST_F(ViewerVideoBar, ShowsAndSetsHowTheVideoPlays) {
    ALTIRO3D_TAKES(8);
    open(clicks(30));
    ASSERT_TRUE(waitFor([&] { return state().position > 0.3; }));
    ASSERT_TRUE(waitFor([&] { return part<QLabel>("videoTime").text() == "0:01 / 0:30"; }));
    for (const QWidget* control : bar().findChildren<QWidget*>()) {
        if (control->objectName().startsWith("qt_") || control->objectName().isEmpty()) continue;
        EXPECT_FALSE(control->accessibleName().isEmpty()) << control->objectName().toStdString();
    }

    part<QToolButton>("playVideo").click();
    EXPECT_FALSE(model().files.isPlaying());
    part<QSlider>("videoPosition").setValue(205); // 20.5 s
    ASSERT_TRUE(waitFor([&] { return std::abs(state().position - 20.5) < 0.05; }));
    EXPECT_TRUE(state().paused);
    ASSERT_TRUE(waitFor([&] { return part<QLabel>("videoTime").text() == "0:20 / 0:30"; }));
    part<QToolButton>("playVideo").click();
    EXPECT_TRUE(model().files.isPlaying());

    part<QSlider>("videoVolume").setValue(40);
    EXPECT_EQ(model().files.playSettings().volume, 40);
    part<QToolButton>("muteVideo").click();
    EXPECT_TRUE(model().files.playSettings().muted);
    part<QToolButton>("loopVideo").click();
    EXPECT_EQ(model().files.playSettings().atEnd, AtEnd::Stop);
    auto& tracks = part<QComboBox>("soundTrack");
    ASSERT_TRUE(tracks.isVisible());
    ASSERT_EQ(tracks.count(), 2);
    tracks.setCurrentIndex(1);
    emit tracks.activated(1);
    EXPECT_EQ(model().files.playSettings().track, state().tracks[1].index);
    auto& speeds = part<QComboBox>("videoSpeed");
    EXPECT_EQ(speeds.currentText(), "1x");
    emit speeds.activated(speeds.findText("2x"));
    EXPECT_EQ(model().files.playSettings().speed, 2);
    EXPECT_EQ(speeds.currentText(), "2x");
    // to the end, where it stops and the window knows
    ASSERT_TRUE(waitFor([&] { return !model().files.isPlaying(); }));
    EXPECT_GT(state().position, 29);
    model().files.close(0);
    EXPECT_TRUE(waitFor([&] { return !bar().isVisible(); }));
}

TEST_F(ViewerVideoBar, KeysSeekMuteAndChangeTheVolume) {
    open(clicks(30));
    ASSERT_TRUE(waitFor([&] { return state().position > 0.3; }));
    press(Qt::Key_P);
    ASSERT_TRUE(state().paused);
    const double at = state().position;
    press(Qt::Key_Right, Qt::ShiftModifier);
    ASSERT_TRUE(waitFor([&] { return std::abs(state().position - at - 5) < 0.1; }));
    press(Qt::Key_Right, Qt::ShiftModifier);
    press(Qt::Key_Left, Qt::ShiftModifier);
    press(Qt::Key_Left, Qt::ShiftModifier);
    ASSERT_TRUE(waitFor([&] { return std::abs(state().position - at) < 0.1; }));
    press(Qt::Key_Minus);
    EXPECT_EQ(model().files.playSettings().volume, 90);
    press(Qt::Key_Plus);
    press(Qt::Key_Plus);
    EXPECT_EQ(model().files.playSettings().volume, 100);
    press(Qt::Key_M, Qt::ShiftModifier);
    EXPECT_TRUE(model().files.playSettings().muted);
    press(Qt::Key_M, Qt::ShiftModifier);
    EXPECT_FALSE(model().files.playSettings().muted);
}

TEST_F(ViewerVideoBar, TheWindowIsInStep) {
    const fs::path file = clicks(20); // it is not played to its end
    Recording recording(folder_ / "played.raw");
    Flashes flashes;
    QObject watcher;
    open(file);
    model().stage.setMode(Mode::Native);
    QObject::connect(&model().stage, &Stage::frameReady, &watcher, [&] {
        const cv::Mat& picture = model().stage.frame().picture;
        if (!picture.empty())
            flashes.note(picture.at<cv::Vec3b>(picture.rows / 2, picture.cols / 2)[1]);
    });
    EXPECT_TRUE(waitFor([&] { return flashes.count() >= 4; }));
    EXPECT_TRUE(recording.goesOnFor(0.1)); // with the last click
    window_.reset();
    recording.stop();
    const double worst = flashes.largestOffset(recording);
    std::printf("window: at most %.1f ms\n", worst * 1000);
    EXPECT_LT(worst, inStep());
}

TEST_F(ViewerVideoBar, AShowIsInStepAndHasItsKeys) {
    QScreen& screen = *QGuiApplication::primaryScreen();
    const cv::Size size = qt::factsOf(screen).size;
    const fs::path file = clicks(20, size);
    Recording recording(folder_ / "played.raw");
    Flashes flashes;
    {
        SlideShow::Settings settings;
        settings.loops = true;
        SlidePresenter presenter(
            settings, ShowFiles({file}), std::make_shared<const Display>(sampleDisplay(size)),
            qt::factsOf(screen), [](const std::string& why) { ADD_FAILURE() << why; });
        presenter.start(screen);
        QTimer look;
        QObject::connect(&look, &QTimer::timeout, &look, [&] {
            const QImage& image = presenter.widget().image();
            if (!image.isNull() && !presenter.show().isFading())
                flashes.note(qGray(image.pixel(image.width() / 2, image.height() / 2)));
        });
        look.start(1);
        EXPECT_TRUE(waitFor([&] { return flashes.count() >= 4; }));
        EXPECT_TRUE(recording.goesOnFor(0.1));
        auto* const widget = const_cast<qt::NativeWidget*>(&presenter.widget());
        for (const Qt::Key key : {Qt::Key_Minus, Qt::Key_Minus, Qt::Key_M, Qt::Key_Plus})
            QTest::keyClick(widget, key);
        EXPECT_EQ(presenter.playSettings().volume, 90);
        EXPECT_TRUE(presenter.playSettings().muted);
        QTest::keyClick(widget, Qt::Key_Left, Qt::ShiftModifier);
        EXPECT_EQ(presenter.show().changes(), 1); // not the file before
    }
    recording.stop();
    const double worst = flashes.largestOffset(recording);
    std::printf("show: at most %.1f ms\n", worst * 1000);
    EXPECT_LT(worst, inStep());
}

TEST(VideoBarWords, TimesAreForPeople) {
    EXPECT_EQ(timeText(0), "0:00");
    EXPECT_EQ(timeText(65.9), "1:05");
    EXPECT_EQ(timeText(3723), "1:02:03");
    EXPECT_EQ(timeText(-1), "0:00");
}

} // namespace
} // namespace altiro3D::test
