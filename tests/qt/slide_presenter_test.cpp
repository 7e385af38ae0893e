// A show on Qt's offscreen screen: real threads, files and pictures.

#include "viewer/show/slide_presenter.hpp"

#include "altiro3D/qt/image.hpp"
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
            settings_, ShowFiles(names), display_, qt::factsOf(screen()),
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
    ASSERT_EQ(QProcess::execute(ALTIRO3D_TOOL_PHOTO2NATIVE,
                                {"-c", writeSample(folder_ / "c.json", size_), "-d",
                                 toName(folder_ / "photo.png"), toName(folder_ / "photo-depth.png"),
                                 toName(folder_ / "native.png")}),
              0);
    const cv::Mat seen = qt::toPicture(presenter_->widget().image());
    const cv::Mat native = readImage(folder_ / "native.png");
    ASSERT_EQ(seen.size(), native.size());
    EXPECT_EQ(cv::norm(seen, native, cv::NORM_INF), 0);
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
    EXPECT_TRUE(waitFor([&] {
        if (grey() < 0 || presenter_->show().isFading()) return ended.count() > 0;
        if (names.empty() || names.back() != shown()) names.push_back(shown());
        brightest[shown()] = std::max(brightest[shown()], grey());
        return ended.count() > 0;
    }));
    EXPECT_EQ(names, (std::vector<std::string>{"a_native.mp4", "b.png", "c_qs2x2a1.333.mp4"}));
    for (const char* video : {"a_native.mp4", "c_qs2x2a1.333.mp4"}) { // 20 to 110
        EXPECT_GT(brightest[video], 60) << "a busy machine may drop the last ones";
        EXPECT_LT(brightest[video], 115);
    }
    EXPECT_GE(presenter_->counts().shown, 6);
    EXPECT_TRUE(problems_.empty());
}

} // namespace
} // namespace altiro3D::test
