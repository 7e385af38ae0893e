// A session with real mouse and keys: xdotool sends them through an X server (session_test.sh).
// $SESSION_PICTURES: where pictures of the screen go, to be looked at.

#include "altiro3D/qt/image.hpp"
#include "home.hpp"
#include "support/compare.hpp"
#include "viewer/window/knob_panel.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/picture_view.hpp"
#include "viewer_scenes.hpp"

#include <QApplication>
#include <QFileDialog>
#include <QLineEdit>
#include <QPointer>
#include <QProcess>
#include <QScreen>
#include <QSettings>
#include <QSlider>
#include <QStyle>
#include <QStyleOptionSlider>
#include <QTimer>
#include <clocale>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

// Real input; handles the events of this process while xdotool runs. False if xdotool fails.
bool send(const QStringList& arguments) {
    QProcess xdotool;
    xdotool.start("xdotool", arguments);
    EXPECT_TRUE(waitFor([&xdotool] { return xdotool.state() == QProcess::NotRunning; }));
    return xdotool.exitStatus() == QProcess::NormalExit && xdotool.exitCode() == 0;
}

void input(const QStringList& arguments) {
    EXPECT_TRUE(send(arguments)) << arguments.join(' ').toStdString();
}

void key(const QString& name) {
    input({"key", name});
}

void moveTo(const QPoint& place) {
    input({"mousemove", QString::number(place.x()), QString::number(place.y())});
}

QImage screenPicture() {
    return QGuiApplication::primaryScreen()->grabWindow(0).toImage();
}

void keepPicture(const QString& name) {
    const QString folder = qEnvironmentVariable("SESSION_PICTURES");
    if (folder.isEmpty()) return;
    EXPECT_TRUE(screenPicture().save(folder + "/" + name + ".png"));
}

// Gives the keyboard focus to a window, because no window manager does. Without --sync, which waits
// forever if the X server refuses.
void focusOn(QWidget& window) {
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, 60000));
    const auto has = [&window] {
        return send({"windowfocus", QString::number(window.winId())}) && window.isActiveWindow();
    };
    EXPECT_TRUE(QTest::qWaitFor(has, 20000));
}

// Types a file's name into the dialog that opens next. A timer finds the dialog from inside the
// dialog's own event loop, because the code that opens it waits until that loop ends. Keys may be
// lost on a busy machine, so they are sent again until the dialog has closed.
class NameTyper {
  public:
    explicit NameTyper(const fs::path& file) : name_(QString::fromStdString(file.string())) {
        QObject::connect(&timer_, &QTimer::timeout, &timer_, [this] { type(); });
        timer_.start(50);
    }
    ~NameTyper() { EXPECT_GT(tries_, 0) << "no dialog has opened"; }
    NameTyper(const NameTyper&) = delete;
    NameTyper& operator=(const NameTyper&) = delete;

  private:
    void type() {
        const QPointer<QWidget> modal = QApplication::activeModalWidget();
        if (!modal || !modal->isVisible()) {
            if (tries_ > 0) timer_.stop(); // it has gone
            return;
        }
        if (++tries_ > 10) {
            ADD_FAILURE() << "the dialog does not take " << name_.toStdString();
            modal->close();
            return;
        }
        focusOn(*modal);
        if (!modal) return;
        if (qobject_cast<QFileDialog*>(modal) != nullptr) {
            key("ctrl+a");
            input({"type", "--delay", "2", name_});
            const auto isThere = [&] {
                return !modal || modal->findChild<QLineEdit*>("fileNameEdit")->text() == name_;
            };
            if (!QTest::qWaitFor(isThere) || !modal) return;
        } // else it is a message about a name of which a part was lost
        key("Return");
        static_cast<void>(QTest::qWaitFor([&] { return !modal || !modal->isVisible(); }));
    }

    QString name_;
    QTimer timer_;
    int tries_ = 0;
};

QPoint handleOf(const QSlider& slider) {
    QStyleOptionSlider option;
    option.initFrom(&slider);
    option.orientation = Qt::Horizontal;
    option.minimum = slider.minimum();
    option.maximum = slider.maximum();
    option.sliderPosition = option.sliderValue = slider.value();
    const QRect handle = slider.style()->subControlRect(QStyle::CC_Slider, &option,
                                                        QStyle::SC_SliderHandle, &slider);
    return slider.mapToGlobal(handle.center());
}

// The number of the window of another program; empty while there is none.
QString windowOf(const QProcess& program) {
    QProcess search;
    search.start("xdotool",
                 {"search", "--onlyvisible", "--pid", QString::number(program.processId())});
    search.waitForFinished();
    return QString(search.readAllStandardOutput()).split('\n').front();
}

TEST(Session, OpensDragsFocusesLooksAndExports) {
    const TemporaryDirectory folder;
    fs::copy(sourcePath("docs/examples/sample.jpg"), folder / "terrace.jpg");
    fs::copy(sourcePath("docs/examples/sample-depth.png"), folder / "terrace-depth.png");
    spill(folder / "broken.jpg", "no picture");
    MainWindow window(sampleDisplay(), {});
    window.setGeometry(QGuiApplication::primaryScreen()->geometry());
    window.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window));
    Model& model = window.model();
    auto& picture = *window.findChild<PictureView*>();
    auto& panel = *window.findChild<KnobPanel*>();
    const auto settled = [&] {
        return waitFor([&] {
            return !model.stage.isBusy() && model.stage.frame().knobs == model.settings.knobs() &&
                   model.stage.frame().setup.mode == model.stage.mode();
        });
    };
    focusOn(window);
    keepPicture("empty");

    {
        const NameTyper typer(folder / "broken.jpg");
        key("ctrl+o");
        ASSERT_TRUE(waitFor(
            [&] { return !picture.headline().isEmpty() && !model.stage.problem().isEmpty(); }));
    }
    keepPicture("broken");

    model.files.open(std::vector<fs::path>{folder / "terrace.jpg", folder / "terrace-depth.png"});
    ASSERT_TRUE(waitFor([&] { return !picture.picture().isNull(); }));
    focusOn(window);
    key("space"); // stands still
    ASSERT_TRUE(waitFor([&] { return !model.stage.isSwinging(); }) && settled());
    keepPicture("photo");

    // drag the strength up
    QSlider& slider = panel.findChild<KnobSlider*>("strength")->slider();
    const QPoint handle = handleOf(slider);
    moveTo(handle);
    input({"mousedown", "1"});
    for (int dx = 4; dx <= 24; dx += 4)
        moveTo(handle + QPoint(dx, 0));
    input({"mouseup", "1"});
    const Knobs& knobs = model.settings.knobs();
    EXPECT_TRUE(
        waitFor([&] { return knobs.views.strengthPercent > 12 && !slider.isSliderDown(); }));
    EXPECT_EQ(model.settings.undoStack().count(), 1);
    ASSERT_TRUE(settled());

    // focus on the ball in the middle below, and on the sky
    const auto clickAt = [&](double x, double y) {
        const cv::Size target = model.stage.frame().target;
        const QPoint middle = picture.rect().center();
        moveTo(picture.mapToGlobal(middle + QPoint(static_cast<int>((x - 0.5) * target.width),
                                                   static_cast<int>((y - 0.5) * target.height))));
        const int steps = model.settings.undoStack().count();
        input({"click", "1"});
        ASSERT_TRUE(waitFor([&] { return model.settings.undoStack().count() > steps; }) &&
                    settled());
        EXPECT_EQ(model.settings.undoStack().count(), steps + 1);
    };
    clickAt(0.55, 0.7);
    const double ball = knobs.views.focus;
    clickAt(0.5, 0.3);
    EXPECT_LT(knobs.views.focus, ball);
    key("ctrl+z");
    ASSERT_TRUE(waitFor([&] { return knobs.views.focus == ball; }) && settled());

    // a double click resets the slider
    moveTo(handleOf(slider));
    input({"click", "--repeat", "2", "--delay", "40", "1"});
    EXPECT_TRUE(waitFor([&] { return knobs.views.strengthPercent == 10; }));

    for (const int mode : {2, 3, 4, 5, 1}) {
        key(QString::number(mode));
        ASSERT_TRUE(waitFor([&] { return int(model.stage.mode()) == mode - 1; }) && settled());
        keepPicture("mode-" + QString::number(mode));
    }

    // the camera follows the mouse
    key("m");
    moveTo(picture.mapToGlobal({5, 300}));
    EXPECT_TRUE(waitFor([&] { return model.stage.position() < -0.9; }));
    key("m");

    {
        const NameTyper typer(folder / "exported.png");
        key("ctrl+s");
        ASSERT_TRUE(waitFor(
            [&] { return fs::exists(folder / "exported.png") && !model.exports.areRunning(); }));
    }
    EXPECT_EQ(readPhoto(folder / "exported.png").size(), cv::Size(1536, 2048));
    keepPicture("exported");

    focusOn(window);
    key("ctrl+q");
    EXPECT_TRUE(waitFor([&] { return !window.isVisible(); }));
}

TEST(Session, ShowsANativePxByPxUntilEscape) {
    const TemporaryDirectory folder;
    const QSize size = QGuiApplication::primaryScreen()->size();
    cv::Mat native(size.height(), size.width(), CV_8UC3);
    cv::RNG(9).fill(native, cv::RNG::UNIFORM, 0, 256);
    writeImage(folder / "native.png", native);
    const QString file = QString::fromStdString((folder / "native.png").string());
    QProcess viewer;
    viewer.start(ALTIRO3D_TOOL_ALTIRO3DVIEW, {"--show", file, "--screen", "0"});
    moveTo({0, 0});
    cv::Mat shown;
    EXPECT_TRUE(waitFor([&] {
        shown = qt::toPicture(screenPicture());
        return compare(shown, native).count == 0;
    })) << compare(shown, native).report;
    QString number;
    EXPECT_TRUE(waitFor([&] { return !(number = windowOf(viewer)).isEmpty(); }));
    // again, as the keyboard may come late; the window goes with the first that arrives
    EXPECT_TRUE(waitFor([&] {
        if (viewer.state() == QProcess::Running && send({"windowfocus", number})) key("Escape");
        return viewer.state() == QProcess::NotRunning;
    }));
    EXPECT_EQ(viewer.exitCode(), 0);
    EXPECT_EQ(viewer.readAllStandardError().toStdString(), "");
}

// A folder of a photo, a quilt, Natives and a file that cannot be read, on a display of the
// screen's size, with the keys of the show.
TEST(Session, ShowsAFolderByTimeAndByKeys) {
    const TemporaryDirectory folder;
    const QSize screen = QGuiApplication::primaryScreen()->size();
    const cv::Size size(screen.width(), screen.height());
    const QString display = writeSample(folder / "visual.json", size);
    const auto native = [&](const char* name, int grey) {
        writeImage(folder / name, cv::Mat(size, CV_8UC3, cv::Scalar::all(grey)), ImageMark::Native);
    };
    fs::create_directory(folder / "in");
    native("in/1.png", 60);
    fs::copy(sourcePath("docs/examples/sample.jpg"), folder / "in/2.jpg");
    fs::copy(sourcePath("docs/examples/sample-depth.png"), folder / "in/2-depth.png");
    spill(folder / "in/3.jpg", "no picture");
    native("in/4.png", 180);
    QProcess viewer;
    viewer.start(ALTIRO3D_TOOL_ALTIRO3DVIEW, {"-c", display, "--screen", "0", "--each", "3600",
                                              "--show", toName(folder / "in")});
    const auto greyOf = [] { return qGray(screenPicture().pixel(640, 400)); };
    EXPECT_TRUE(waitFor([&] { return greyOf() == 60; }));
    EXPECT_TRUE(waitFor([&] {
        const QString number = windowOf(viewer);
        return !number.isEmpty() && send({"windowfocus", number});
    }));
    keepPicture("show-native");
    key("Right");
    // the photo fades in when it is made
    EXPECT_TRUE(waitFor([&] {
        const QImage now = screenPicture();
        return now.pixel(640, 400) != now.pixel(600, 300) && now.pixel(5, 5) != qRgb(60, 60, 60);
    }));
    keepPicture("show-photo");
    key("Page_Down"); // the unreadable one is left out
    EXPECT_TRUE(waitFor([&] { return greyOf() == 180; }));
    key("Left");
    EXPECT_TRUE(waitFor([&] { return greyOf() != 180; }));
    key("Left");
    EXPECT_TRUE(waitFor([&] { return greyOf() == 60; }));
    key("Escape");
    EXPECT_TRUE(waitFor([&] { return viewer.state() == QProcess::NotRunning; }));
    EXPECT_EQ(viewer.exitCode(), 0);
    const QByteArray said = viewer.readAllStandardError();
    EXPECT_EQ(said.count('\n'), 1) << said.toStdString();
    EXPECT_TRUE(said.contains("3.jpg: is not a picture that can be read")) << said.toStdString();
}

} // namespace
} // namespace altiro3D::test

int main(int argc, char** argv) {
    const altiro3D::test::Home home;
    qputenv("QT_QPA_PLATFORM", "xcb");
    ::testing::InitGoogleTest(&argc, argv);
    if (::testing::GTEST_FLAG(list_tests)) return RUN_ALL_TESTS(); // takes no desktop
    const QApplication application(argc, argv);
    std::setlocale(LC_NUMERIC, "C");
    QApplication::setQuitOnLastWindowClosed(false);
    QCoreApplication::setOrganizationName("altiro3D");
    QCoreApplication::setApplicationName("session");
    return RUN_ALL_TESTS();
}
