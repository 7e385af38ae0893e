// Positions of a viewer, and the pictures that follow them.

#include "viewer/show/eye_source.hpp"

#include "altiro3D/qt/image.hpp"
#include "cli/run_tool.hpp"
#include "viewer/show/presentation.hpp"
#include "viewer/show/slide_presenter.hpp"
#include "viewer_scenes.hpp"

#include <QGuiApplication>
#include <QScreen>
#include <gtest/gtest.h>
#include <optional>

namespace altiro3D::test {
namespace {

using namespace viewer;

constexpr quint16 kPort = 47311;

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

// The greys of the first two px of a quilt of nine greys, for a viewer at a place.
TEST(EyeSource, TheTwoViewsOfThePlaceAreInTheColumns) {
    TemporaryDirectory folder;
    QScreen& screen = *QGuiApplication::primaryScreen();
    const cv::Size size = qt::factsOf(screen).size;
    const QuiltLayout layout{3, 3, {size.width / 4, size.height / 4}, 9};
    cv::Mat quilt(layout.size(), CV_8UC3);
    for (int view = 0; view < 9; ++view)
        quilt(layout.tile(view)).setTo(cv::Scalar::all(20 * view));
    writeImage(folder / "a_qs3x3a1.333.png", quilt);
    auto eyes = std::make_shared<EyesShow>();
    eyes->layout = tools::EyesOptions{EyesPicture::Columns};
    SlideShow::Settings settings;
    settings.loops = true;
    SlidePresenter presenter(
        settings, ShowFiles({folder / "a_qs3x3a1.333.png"}),
        std::make_shared<const Display>(sampleDisplay(size)), qt::factsOf(screen),
        [](const std::string& why) { ADD_FAILURE() << why; }, eyes);
    presenter.start(screen);
    const auto shows = [&](int left, int right) {
        const QImage& image = presenter.widget().image();
        if (image.isNull()) return false;
        const int y = image.height() / 2;
        const int x = image.width() / 2 & ~1;
        return qGray(image.pixel(x, y)) == 20 * left && qGray(image.pixel(x + 1, y)) == 20 * right;
    };
    EXPECT_TRUE(waitFor([&] { return shows(3, 5); }));
    presenter.moveEyes(1); // both eyes stay in the cone
    EXPECT_TRUE(waitFor([&] { return shows(6, 8); }));
    presenter.moveEyes(-.5);
    EXPECT_TRUE(waitFor([&] { return shows(1, 3); }));
}

} // namespace
} // namespace altiro3D::test
