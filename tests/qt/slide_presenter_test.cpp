// A show on Qt's offscreen screen: real threads, files and pictures. The places of its viewer.

#include "viewer/show/slide_presenter.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/qt/image.hpp"
#include "cli/command_line.hpp"
#include "viewer/show/eye_source.hpp"
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
    void begin(const std::vector<fs::path>& names, const std::optional<Request>& eyes = {}) {
        presenter_ = std::make_unique<SlidePresenter>(
            settings_, ShowFiles(names), display_, qt::factsOf(screen()),
            [this](const std::string& why) { problems_.push_back(why); }, eyes);
        presenter_->start(screen());
    }
    // The grey in the middle of the screen; -1 before the first picture.
    // @param aside px to the right
    int grey(int aside = 0) const {
        const QImage& image = presenter_->widget().image();
        const int x = image.width() / 2 + aside;
        return image.isNull() ? -1 : qGray(image.pixel(x, image.height() / 2));
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

// A quilt of nine greys in columns; the px in the middle is the left eye's.
TEST_F(SlidePresenterTest, TwoEyesSeeTheViewsOfTheirPlace) {
    ASSERT_EQ(size_.width / 2 % 2, 0);
    const QuiltLayout layout{3, 3, size_ / 4, 9};
    cv::Mat quilt(layout.size(), CV_8UC3);
    for (int view = 0; view < 9; ++view)
        quilt(layout.tile(view)).setTo(cv::Scalar::all(20 * view));
    for (const char* name : {"a_qs3x3a1.333.png", "b_qs3x3a1.333.png"})
        writeImage(folder_ / "show" / name, quilt);
    Request eyes;
    eyes.mode = Mode::Stereo;
    eyes.eyes.picture = EyesPicture::Columns;
    eyes.fills = eyes.follows = true;
    begin({folder_ / "show"}, eyes);
    const auto see = [&](int left, int right) {
        return waitFor([&] { return grey() == 20 * left && grey(1) == 20 * right; });
    };
    EXPECT_TRUE(see(3, 5));
    presenter_->moveEyes(1); // both eyes stay in the cone
    EXPECT_TRUE(see(6, 8));
    const std::string before = shown(); // the next one was made before the move
    EXPECT_TRUE(waitFor([&] { return shown() != before && !presenter_->show().isFading(); }));
    EXPECT_TRUE(see(6, 8));
    presenter_->moveEyes(-.5);
    EXPECT_TRUE(see(1, 3));
    EXPECT_EQ(problems_, std::vector<std::string>());
}

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

TEST(EyeSource, ReadsNumbersAndNothingElse) {
    const std::pair<const char*, std::optional<double>> lines[] = {
        {"0.25", .25}, {" -0.5\t0.1\r", -.5}, {"1e3", 1},    {"-7 0", -1},
        {"0 nan", {}}, {"nan", {}},           {"inf", {}},   {"1e999", {}},
        {"", {}},      {"0.1,0.2", {}},       {"0.1 x", {}}, {"1 2 3", {}}};
    for (const auto& [line, position] : lines)
        EXPECT_EQ(EyeSource::positionOf(line), position) << line;
    EXPECT_FALSE(EyeSource::positionOf(QByteArray(300, ' ') + "0"));
}

TEST(EyeSource, PortsAreNumbers) {
    EXPECT_EQ(eyePort("stdin"), 0);
    EXPECT_EQ(eyePort("udp:65535"), 65535);
    for (const char* text : {"udp:0", "udp:65536", "udp:", "udp:1x", "tcp:1", "4242", "udp:-1"})
        EXPECT_THROW(eyePort(text), tools::UsageError) << text;
}

TEST(EyeSource, OfAFloodOnlyTheNewestIsShown) {
    constexpr quint16 kPort = 47311;
    EyeSource source(kPort);
    EXPECT_THROW(EyeSource second(kPort), Error) << "the port is taken";
    int moves = 0;
    double last = 9;
    QObject::connect(&source, &EyeSource::moved, [&](double x) {
        ++moves;
        last = x;
    });
    QUdpSocket sender;
    for (int i = 0; i < 100; ++i)
        sender.writeDatagram(QByteArray::number(i / 200.0) + "\nno number\n",
                             QHostAddress::LocalHost, kPort);
    sender.writeDatagram("-0.75 0.5\n", QHostAddress::LocalHost, kPort);
    EXPECT_TRUE(waitFor([&] { return last == -0.75; }));
    EXPECT_LT(moves, 10);
    EXPECT_EQ(source.ignoredLines(), 100);
}

} // namespace
} // namespace altiro3D::test
