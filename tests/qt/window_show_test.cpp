// The display and slide shows, from the window's menu.

#include "altiro3D/qt/native_widget.hpp"
#include "support/compare.hpp"
#include "viewer/window/slide_show_dialog.hpp"
#include "window_actions.hpp"

#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QMenu>
#include <QRadioButton>
#include <QScreen>
#include <QSettings>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

using namespace viewer;

class ViewerWindowShow : public ::testing::Test {
  protected:
    void SetUp() override {
        QSettings().clear();
        begin();
    }
    // A window for a display of the screen's size.
    void begin() {
        const QSize size = QGuiApplication::primaryScreen()->size();
        window_ = std::make_unique<MainWindow>(sampleDisplay({size.width(), size.height()}),
                                               std::vector<std::string>());
        window_->show();
        ASSERT_TRUE(QTest::qWaitForWindowExposed(window_.get()));
    }
    QList<QAction*> screens() {
        auto* menu = window_->findChild<QMenu*>("screens");
        emit menu->aboutToShow();
        return menu->actions();
    }
    static qt::NativeWidget* shown() {
        for (QWidget* widget : QApplication::topLevelWidgets())
            if (auto* native = qobject_cast<qt::NativeWidget*>(widget);
                native != nullptr && native->isVisible())
                return native;
        return nullptr;
    }
    static void leave() {
        ASSERT_TRUE(QTest::qWaitForWindowActive(shown()));
        QTest::keyClick(shown(), Qt::Key_Escape);
        EXPECT_TRUE(waitFor([] { return shown() == nullptr; }));
    }
    // Answers the dialog of the slide show.
    void showSlides(const std::function<void(SlideShowDialog&)>& answer) {
        QTimer::singleShot(0, window_.get(), [&answer] {
            auto* dialog = qobject_cast<SlideShowDialog*>(QApplication::activeModalWidget());
            ASSERT_NE(dialog, nullptr);
            answer(*dialog);
            dialog->accept();
        });
        window_->findChild<QAction*>("slideShowMenu")->trigger();
    }

    TemporaryDirectory folder_;
    std::unique_ptr<MainWindow> window_;
};

TEST_F(ViewerWindowShow, TheScreenMayBeChosenByHandAndStaysChosen) {
    writeImage(folder_ / "photo.png", detailedPhoto({300, 400}));
    dropOn(*window_, {folder_ / "photo.png"});
    ASSERT_TRUE(
        QTest::qWaitFor([this] { return window_->model().files.document() != nullptr; }, 20000))
        << window_->model().stage.problem().toStdString();
    ASSERT_EQ(screens().size(), 1 + QGuiApplication::screens().size());
    EXPECT_TRUE(screens()[0]->isChecked());
    screens()[1]->trigger();
    EXPECT_TRUE(screens()[1]->isChecked());
    EXPECT_FALSE(screens()[0]->isChecked());
    entryOf(*window_, "Show on the display")->trigger();
    ASSERT_NE(shown(), nullptr); // no display is connected
    leave();
    window_->close();
    window_.reset();
    begin();
    EXPECT_TRUE(screens()[1]->isChecked());
    window_->close();
    window_.reset();
    QSettings().setValue("screen", "DP-9");
    begin();
    const QStringList said = answering(
        {}, QMessageBox::Ok, [this] { window_->findChild<QAction*>("testPicture")->trigger(); });
    ASSERT_EQ(said.size(), 1);
    EXPECT_TRUE(said[0].contains("DP-9 is not connected"));
    EXPECT_EQ(shown(), nullptr);
}

// Side by side on the screen of the window, px by px; keys change it there.
TEST_F(ViewerWindowShow, ShowsAPictureForTwoEyes) {
    writeImage(folder_ / "photo.png", detailedPhoto({300, 400}));
    writeImage(folder_ / "photo-depth.png", boxDepth({300, 400}));
    entryOf(*window_, "Show for two eyes")->trigger();
    EXPECT_EQ(shown(), nullptr); // nothing is open
    dropOn(*window_, {folder_ / "photo.png", folder_ / "photo-depth.png"});
    ASSERT_TRUE(waitFor([this] { return window_->model().files.document() != nullptr; }));
    entryOf(*window_, "Side by side, half width")->trigger();
    entryOf(*window_, "Show for two eyes")->trigger();
    ASSERT_NE(shown(), nullptr);
    ASSERT_TRUE(waitFor([] { return !shown()->image().isNull(); }));
    EXPECT_TRUE(shown()->isExact());
    const QImage before = shown()->image().copy();
    ASSERT_TRUE(QTest::qWaitForWindowActive(shown()));
    QTest::keyClick(shown(), Qt::Key_X);
    ASSERT_TRUE(waitFor([&] { return shown()->image() != before; }));
    const int half = before.width() / 2;
    EXPECT_TRUE(shown()->image().copy(0, 0, half, before.height()) ==
                before.copy(half, 0, half, before.height()));
    leave();
}

TEST_F(ViewerWindowShow, ShowsAFolderOrTheOpenFilesFromTheMenu) {
    screens()[1]->trigger();
    const cv::Size panel = window_->model().files.display()->panelSize();
    std::filesystem::create_directory(folder_ / "show");
    const auto write = [&](const char* name, int grey) {
        writeImage(folder_ / name, cv::Mat(panel, CV_8UC3, cv::Scalar::all(grey)),
                   ImageMark::Native);
    };
    write("show/a_native.png", 200);
    write("b_native.png", 100);
    spill(folder_ / "broken.jpg", "no picture");
    const auto shows = [](int grey) {
        return shown() != nullptr && shown()->grab().toImage().pixelColor(9, 9).red() == grey;
    };
    const auto isOver = [] { return shown() == nullptr; };
    QSettings().setValue("showFolder", toName(folder_ / "show"));
    showSlides([](SlideShowDialog& dialog) {
        EXPECT_FALSE(dialog.findChild<QRadioButton*>("ofFiles")->isEnabled()); // none is open
        dialog.findChild<QDoubleSpinBox*>("each")->setValue(1);
    });
    EXPECT_TRUE(waitFor([&] { return shows(200); }));
    EXPECT_TRUE(waitFor(isOver)); // after a second

    dropOn(*window_, {folder_ / "b_native.png", folder_ / "broken.jpg"});
    bool hasShown = false;
    const QStringList said = answering(
        {}, QMessageBox::Ok,
        [&] {
            showSlides([](SlideShowDialog& dialog) {
                EXPECT_TRUE(dialog.findChild<QRadioButton*>("ofFiles")->isChecked());
                EXPECT_EQ(dialog.findChild<QDoubleSpinBox*>("each")->value(), 1); // as before
            });
        },
        [&](const QStringList& all) {
            hasShown = hasShown || shows(100);
            return !all.isEmpty() && isOver();
        });
    EXPECT_TRUE(hasShown);
    ASSERT_EQ(said.size(), 1);
    EXPECT_TRUE(said[0].contains("broken.jpg")) << said[0].toStdString();

    showSlides(
        [](SlideShowDialog& dialog) { dialog.findChild<QCheckBox*>("loops")->setChecked(true); });
    EXPECT_TRUE(waitFor([&] { return shows(100); }));
    leave();
}

} // namespace
} // namespace altiro3D::test
