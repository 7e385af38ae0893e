// A show on Qt's offscreen screen: real threads, files and pictures.

#include "viewer/show/slide_presenter.hpp"

#include "altiro3D/qt/image.hpp"
#include "support/slow.hpp"
#include "viewer_scenes.hpp"

#include <QGuiApplication>
#include <QProcess>
#include <QScreen>
#include <QSignalSpy>
#include <QTest>
#include <algorithm>
#include <gtest/gtest.h>
#include <map>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

class SlidePresenterTest : public ::testing::Test {
  protected:
    SlidePresenterTest() : size_(qt::factsOf(screen()).size) {
        display_ = std::make_shared<const Display>(sampleDisplay(size_));
        fs::create_directory(folder_ / "show");
        settings_.each = 0.5;
        settings_.fade = 0.05;
        settings_.loops = true;
    }
    static QScreen& screen() { return *QGuiApplication::primaryScreen(); }
    // A Native of one grey.
    void addNative(const std::string& name, int grey) const {
        writeImage(folder_ / "show" / name, cv::Mat(size_, CV_8UC3, cv::Scalar::all(grey)),
                   ImageMark::Native);
    }
    void begin(const std::vector<fs::path>& names) {
        presenter_ = std::make_unique<SlidePresenter>(
            settings_, ShowFiles(names), display_, size_,
            [this](const std::string& why) { problems_.push_back(why); });
        presenter_->start(screen());
    }
    // The grey in the middle of the screen; -1 before the first picture.
    int grey() const {
        const QImage& image = presenter_->widget().image();
        return image.isNull() ? -1 : qGray(image.pixel(image.width() / 2, image.height() / 2));
    }
    std::string shown() const {
        const Slide* slide = presenter_->show().shown();
        return slide != nullptr ? slide->source.file.filename().string() : "";
    }
    void press(Qt::Key key) {
        QTest::keyClick(const_cast<qt::NativeWidget*>(&presenter_->widget()), key);
    }

    TemporaryDirectory folder_;
    cv::Size size_;
    std::shared_ptr<const Display> display_;
    SlideShow::Settings settings_;
    std::vector<std::string> problems_;
    std::unique_ptr<SlidePresenter> presenter_;
};

TEST_F(SlidePresenterTest, APhotoIsShownAsPhoto2nativeMakesIt) {
    writeImage(folder_ / "photo.png", detailedPhoto({300, 200}));
    writeImage(folder_ / "photo-depth.png", boxDepth({300, 200}));
    begin({folder_ / "photo.png", folder_ / "photo-depth.png"});
    ASSERT_TRUE(waitFor([&] { return grey() >= 0 && !presenter_->show().isFading(); }));
    EXPECT_TRUE(presenter_->widget().isExact());
    std::string text = slurp(sourcePath("calibration/portrait-sample.json"));
    for (const auto& [from, to] : {std::pair<std::string, int>{"1536", size_.width},
                                   std::pair<std::string, int>{"2048", size_.height}})
        text.replace(text.find(from), from.size(), std::to_string(to));
    spill(folder_ / "c.json", text);
    const auto at = [&](const char* name) {
        return QString::fromStdString((folder_ / name).string());
    };
    ASSERT_EQ(
        QProcess::execute(ALTIRO3D_TOOL_PHOTO2NATIVE, {"-c", at("c.json"), "-d", at("photo.png"),
                                                       at("photo-depth.png"), at("native.png")}),
        0);
    const cv::Mat seen = qt::toPicture(presenter_->widget().image());
    const cv::Mat native = readImage(folder_ / "native.png");
    ASSERT_EQ(seen.size(), native.size());
    EXPECT_EQ(cv::norm(seen, native, cv::NORM_INF), 0);
}

TEST_F(SlidePresenterTest, FilesJoinAndLeaveWhileItRuns) {
    ALTIRO3D_TAKES(10);
    addNative("a.png", 50);
    addNative("c.png", 100);
    spill(folder_ / "show/broken.png", "no picture");
    begin({folder_ / "show"});
    ASSERT_TRUE(waitFor([&] { return grey() == 50; }));
    ASSERT_TRUE(waitFor([&] { return grey() == 100; }));
    ASSERT_EQ(problems_.size(), 1U);
    EXPECT_NE(problems_[0].find("broken.png"), std::string::npos);
    addNative("b.png", 200);
    ASSERT_TRUE(waitFor([&] { return grey() == 200; }));
    fs::remove(folder_ / "show/a.png");
    fs::remove(folder_ / "show/b.png");
    QTest::qWait(3000);
    for (int i = 0; i < 30; ++i) {
        QTest::qWait(50);
        EXPECT_EQ(shown(), "c.png");
    }
    EXPECT_EQ(problems_.size(), 1U);
}

TEST_F(SlidePresenterTest, KeysGoOnAndBackAndEnd) {
    settings_.each = 1000;
    for (int i = 1; i <= 3; ++i)
        addNative(std::to_string(i) + ".png", 40 * i);
    begin({folder_ / "show"});
    QSignalSpy ended(presenter_.get(), &SlidePresenter::ended);
    ASSERT_TRUE(waitFor([&] { return grey() == 40; }));
    press(Qt::Key_Right);
    ASSERT_TRUE(waitFor([&] { return grey() == 80; }));
    press(Qt::Key_Space); // stops; keys still work
    press(Qt::Key_PageDown);
    ASSERT_TRUE(waitFor([&] { return grey() == 120; }));
    press(Qt::Key_Left);
    press(Qt::Key_PageUp);
    ASSERT_TRUE(waitFor([&] { return grey() == 40; }));
    EXPECT_EQ(ended.count(), 0);
    press(Qt::Key_Escape);
    EXPECT_EQ(ended.count(), 1);
}

TEST_F(SlidePresenterTest, VideosOfNativesAndOfQuiltsAreShownOnce) {
    settings_.loops = false;
    settings_.each = 0.2;
    writeGreys(folder_ / "show/a_native.mp4", size_, 10);
    addNative("b.png", 240);
    // a video of quilts: each view is of one grey, and so is the Native
    writeGreys(folder_ / "show/c_qs2x2a1.333.mp4", {160, 120}, 10);
    begin({folder_ / "show"});
    QSignalSpy ended(presenter_.get(), &SlidePresenter::ended);
    std::vector<std::string> names;
    std::map<std::string, int> brightest;
    while (ended.count() == 0) {
        QTest::qWait(5);
        if (grey() < 0 || presenter_->show().isFading()) continue;
        if (names.empty() || names.back() != shown()) names.push_back(shown());
        brightest[shown()] = std::max(brightest[shown()], grey());
    }
    EXPECT_EQ(names, (std::vector<std::string>{"a_native.mp4", "b.png", "c_qs2x2a1.333.mp4"}));
    EXPECT_NEAR(brightest["a_native.mp4"], 110, 15); // 20 + 10 * 9, and it may be the last but one
    EXPECT_NEAR(brightest["c_qs2x2a1.333.mp4"], 110, 15);
    EXPECT_GT(presenter_->counts().shown, 10);
    EXPECT_TRUE(problems_.empty());
}

} // namespace
} // namespace altiro3D::test
