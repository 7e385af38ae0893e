#include "altiro3D/qt/image.hpp"
#include "support/compare.hpp"
#include "viewer/window/knob_panel.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/paint_bar.hpp"
#include "viewer/window/photo_strip.hpp"
#include "viewer/window/picture_view.hpp"
#include "viewer/window/window_words.hpp"
#include "viewer_scenes.hpp"
#include "window_actions.hpp"

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QInputDialog>
#include <QLabel>
#include <QMenu>
#include <QRegularExpression>
#include <QScrollBar>
#include <QSettings>
#include <QSignalSpy>
#include <QSlider>
#include <QStatusBar>
#include <QTextDocument>
#include <fstream>
#include <gtest/gtest.h>
#include <regex>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

class ViewerWindow : public ::testing::Test {
  protected:
    void SetUp() override {
        QSettings().clear();
        writeImage(folder_ / "photo.png", detailedPhoto({300, 400}));
        writeImage(folder_ / "photo-depth.png", boxDepth({300, 400}));
        begin();
    }
    void begin() { window_ = shownWindow(warnings_); }
    void beginAgain() {
        window_->close();
        window_.reset();
        begin();
    }
    bool isSaid(const char* words) {
        for (const QLabel* label : window_->statusBar()->findChildren<QLabel*>())
            if (label->toolTip().contains(words)) return true;
        return false;
    }
    template <class Widget>
    Widget* setting(const char* name) {
        return panel().findChild<Widget*>(name);
    }
    // The camera stands in the middle.
    void standStill() {
        window_->model().stage.setSwinging(false);
        ASSERT_TRUE(waitFor([this] { return window_->model().stage.frame().setup.position == 0; }));
    }
    void drop(const std::vector<std::string>& names) {
        std::vector<fs::path> paths;
        for (const std::string& name : names)
            paths.push_back(folder_ / name);
        dropOn(*window_, paths);
    }
    void openPhoto() {
        drop({"photo.png", "photo-depth.png"});
        ASSERT_TRUE(waitFor([this] { return !picture().picture().isNull() && !busy(); }));
    }
    bool busy() { return window_->model().stage.isBusy(); }
    PictureView& picture() { return *window_->findChild<PictureView*>(); }
    KnobPanel& panel() { return *window_->findChild<KnobPanel*>(); }
    PhotoStrip& files() { return *window_->findChild<PhotoStrip*>(); }
    const Knobs& knobs() { return window_->model().settings.knobs(); }
    QAction* entry(const QString& text) { return entryOf(*window_, text); }
    QStringList answering(const char* name, QMessageBox::StandardButton answer,
                          const std::function<void()>& act) {
        return test::answering(folder_ / name, answer, act);
    }
    // Waits until the work that was started is done.
    void endExport() {
        ASSERT_TRUE(waitFor([this] { return !window_->model().exports.areRunning(); }));
    }

    TemporaryDirectory folder_;
    std::vector<std::string> warnings_;
    std::unique_ptr<MainWindow> window_;
};

TEST_F(ViewerWindow, TellsWhatToDoWhileItIsEmpty) {
    EXPECT_EQ(picture().headline(), "Drop a photo here");
    EXPECT_FALSE(entry("Export Native")->isEnabled());
    EXPECT_FALSE(setting<KnobSlider>("strength")->isEnabled());
    EXPECT_EQ(files().model()->rowCount(), 0);
}

TEST_F(ViewerWindow, ShowsAllWarningsAboutTheDisplay) {
    warnings_ = {"the first sentence", "a second one"};
    beginAgain();
    EXPECT_TRUE(isSaid("the first sentence") && isSaid("a second one"));
    bool isShown = false;
    for (const QLabel* label : window_->statusBar()->findChildren<QLabel*>())
        isShown = isShown || label->text().contains("the first sentence; a second one");
    EXPECT_TRUE(isShown);
}

TEST_F(ViewerWindow, OpensWhatIsDroppedAndPaintsIt) {
    openPhoto();
    EXPECT_EQ(files().model()->rowCount(), 1);
    EXPECT_TRUE(window_->windowTitle().startsWith("photo.png"));
    EXPECT_TRUE(setting<KnobSlider>("strength")->isEnabled());
    standStill();
    // what is seen in the window is the frame, px by px
    const cv::Mat painted = qt::toPicture(picture().grab().toImage());
    const cv::Mat& frame = window_->model().stage.frame().picture;
    const cv::Rect middle((painted.cols - frame.cols) / 2, (painted.rows - frame.rows) / 2,
                          frame.cols, frame.rows);
    EXPECT_TRUE(samePicture(painted(middle), frame));
}

TEST_F(ViewerWindow, KeysChooseModesAndSwing) {
    openPhoto();
    for (const auto& [key, mode] :
         {std::pair{Qt::Key_2, Mode::Depth}, std::pair{Qt::Key_3, Mode::Quilt},
          std::pair{Qt::Key_4, Mode::Native}, std::pair{Qt::Key_5, Mode::Lens},
          std::pair{Qt::Key_6, Mode::Stereo}, std::pair{Qt::Key_1, Mode::Sway}}) {
        QTest::keyClick(window_.get(), key);
        EXPECT_EQ(window_->model().stage.mode(), mode);
    }
    const bool swings = window_->model().stage.isSwinging();
    QTest::keyClick(&picture(), Qt::Key_Space);
    EXPECT_NE(window_->model().stage.isSwinging(), swings);
    EXPECT_EQ(entry("Undo")->shortcut(), QKeySequence(QKeySequence::Undo));
}

TEST_F(ViewerWindow, BothEyesHaveAKindAStrengthAndASwapThatAreKept) {
    openPhoto();
    const auto& eyes = [this]() -> const tools::EyesOptions& {
        return window_->model().stage.eyes();
    };
    auto* slider = setting<KnobSlider>("eyesStrength");
    EXPECT_FALSE(slider->isVisible());
    EXPECT_TRUE(setting<KnobSlider>("strength")->isEnabled());
    QTest::keyClick(window_.get(), Qt::Key_6);
    EXPECT_TRUE(slider->isVisible());
    EXPECT_FALSE(setting<KnobSlider>("strength")->isEnabled()); // has no effect
    EXPECT_EQ(slider->value(), kEyesStrength);
    for (const auto key : {Qt::Key_Up, Qt::Key_Up, Qt::Key_Down})
        QTest::keyClick(window_.get(), key, Qt::ShiftModifier);
    EXPECT_EQ(slider->value(), kEyesStrength + 0.25);
    slider->slider().setValue(400);
    EXPECT_EQ(eyes().strengthPercent, 4);
    QTest::keyClick(window_.get(), Qt::Key_X);
    EXPECT_TRUE(eyes().swapped);
    entry("Top and bottom")->trigger();
    EXPECT_EQ(eyes().picture, EyesPicture::TopBottom);
    beginAgain();
    EXPECT_EQ(window_->model().stage.mode(), Mode::Sway); // every start begins with it
    EXPECT_EQ(eyes().picture, EyesPicture::TopBottom);
    EXPECT_TRUE(entry("Top and bottom")->isChecked());
    EXPECT_TRUE(eyes().swapped);
    EXPECT_EQ(eyes().strengthPercent, 4);
}

TEST_F(ViewerWindow, TheHelpNamesItsKeys) {
    QStringList named;
    for (const KeyWords& key : kKeys)
        named << QString(key.keys).split(", ");
    int count = 0;
    for (const QAction* action : window_->findChildren<QAction*>()) {
        if (action->shortcut().isEmpty()) continue;
        ++count;
        EXPECT_TRUE(named.contains(action->shortcut().toString(QKeySequence::PortableText)))
            << action->text().toStdString();
    }
    EXPECT_GE(count, 15);
}

// Settings say what they do, without words of a terminal.
TEST_F(ViewerWindow, EverySettingHasATip) {
    int count = 0;
    const auto expectTip = [&](const QWidget* widget) {
        ++count;
        QTextDocument tip;
        tip.setHtml(widget->toolTip());
        EXPECT_GE(tip.toPlainText().split(' ').size(), 7) << widget->objectName().toStdString();
        EXPECT_FALSE(tip.toPlainText().contains(QRegularExpression("(^| )-\\w|--|2native")))
            << tip.toPlainText().toStdString();
    };
    for (const char* name :
         {"reading", "fit", "depth", "depthImage", "strength", "auto-strength", "focus",
          "auto-focus", "betterDepth", "depth-curve", "eyesStrength", "method", "fill", "refine",
          "parallax", "calibration", "columns", "rows", "reset"})
        expectTip(setting<QWidget>(name));
    for (const QWidget* widget : panel().findChildren<QWidget*>()) {
        const auto* const label = qobject_cast<const QLabel*>(widget);
        const bool isSetting = qobject_cast<const QAbstractButton*>(widget) != nullptr ||
                               qobject_cast<const QComboBox*>(widget) != nullptr;
        if (isSetting ||
            (label != nullptr && label->objectName().isEmpty() && label->text() != "×"))
            expectTip(widget);
    }
    EXPECT_GE(count, 30);
}

// What the window says is in its own words: no options and no names of tools.
TEST_F(ViewerWindow, ItsTextsHaveNoWordsOfATerminal) {
    const std::regex option(R"re("(?:[^"]* )?(?:--?[a-z][a-z-]+|-[a-z]|\w+2native)[ ,.;)"])re");
    int lines = 0;
    for (const char* folder : {"window", "model", "player"}) {
        for (const auto& file :
             fs::directory_iterator(sourcePath(std::string("tools/viewer/") + folder))) {
            std::ifstream text(file.path());
            for (std::string line; std::getline(text, line); ++lines) {
                const bool isCode = line.find("kTryNetwork") != std::string::npos;
                EXPECT_TRUE(isCode || !std::regex_search(line, option)) << line;
            }
        }
    }
    EXPECT_GT(lines, 3000);
}

TEST_F(ViewerWindow, SwingsOnAfterPainting) {
    openPhoto();
    window_->model().stage.setSwinging(true);
    const auto paint = [this] { window_->findChild<QAction*>("paintDepth")->trigger(); };
    paint();
    ASSERT_TRUE(waitFor([this] { return !window_->model().stage.isSwinging(); }));
    window_->findChild<PaintBar*>()->choose(PaintTool::Lasso);
    EXPECT_FALSE(window_->model().stage.isSwinging());
    paint();
    EXPECT_TRUE(waitFor([this] { return window_->model().stage.isSwinging(); }));
    window_->model().stage.setSwinging(false);
    paint();
    paint();
    EXPECT_FALSE(window_->model().stage.isSwinging()); // as before
}

TEST_F(ViewerWindow, LooksDarkIfTheUserWantsThat) {
    openPhoto();
    const QPalette before = QApplication::palette();
    const auto lightness = [this](QPalette::ColorRole role) {
        return panel().palette().color(role).lightness();
    };
    const auto expectReadable = [this] {
        for (const char* name : {"depthSource", "parallax", "display", "layout"}) {
            const auto* const words = setting<QLabel>(name);
            const QRect place(words->mapTo(&panel(), QPoint()), words->size());
            const QImage label = panel().grab(place).toImage();
            int least = 255;
            int most = 0;
            for (int y = 0; y < label.height(); ++y) {
                for (int x = 0; x < label.width(); ++x) {
                    least = std::min(least, qGray(label.pixel(x, y)));
                    most = std::max(most, qGray(label.pixel(x, y)));
                }
            }
            EXPECT_GT(most - least, 80) << name;
        }
    };
    expectReadable();
    QAction* const dark = window_->findChild<QAction*>("dark");
    dark->trigger();
    EXPECT_LT(lightness(QPalette::Window), 80);
    EXPECT_GT(lightness(QPalette::WindowText), 200);
    EXPECT_GT(lightness(QPalette::ButtonText), 200);
    expectReadable();
    for (const auto role : {QPalette::WindowText, QPalette::Text, QPalette::ButtonText})
        EXPECT_GT(panel().palette().color(QPalette::Disabled, role).lightness(), 130);
    const QImage box = setting<QCheckBox>("auto-focus")->grab().toImage();
    int lightest = 0; // of the box's left side
    for (int y = 0; y < box.height(); ++y)
        for (int x = 0; x < 4; ++x)
            lightest = std::max(lightest, qGray(box.pixel(x, y)));
    EXPECT_GT(lightest, 130);
    beginAgain(); // it is kept
    EXPECT_LT(lightness(QPalette::Window), 80);
    window_->findChild<QAction*>("dark")->trigger();
    EXPECT_EQ(QApplication::palette().window().color(), before.window().color());
}

TEST_F(ViewerWindow, TheWheelScrollsTheSettingsUnlessOneWasClicked) {
    openPhoto();
    QApplication::setActiveWindow(window_.get());
    picture().setFocus();
    const auto turn = [](QWidget& over) {
        const QPoint at = over.rect().center();
        QWheelEvent event(at, over.mapToGlobal(at), {}, {0, -120}, Qt::NoButton, Qt::NoModifier,
                          Qt::NoScrollPhase, false);
        QCoreApplication::sendEvent(&over, &event);
        return event.isAccepted(); // else the panel gets it
    };
    const Knobs before = knobs();
    int turned = 0;
    for (const char* name :
         {"fit", "depth", "method", "strength", "focus", "depth-curve", "columns"}) {
        auto* const whole = setting<QWidget>(name);
        for (QWidget* part : QList<QWidget*>{whole} + whole->findChildren<QWidget*>()) {
            if (qobject_cast<QLineEdit*>(part) != nullptr) continue;
            EXPECT_FALSE(turn(*part)) << name;
            ++turned;
        }
    }
    EXPECT_GE(turned, 12);
    EXPECT_EQ(knobs(), before);
    QSlider& slider = setting<KnobSlider>("strength")->slider();
    slider.setFocus(Qt::MouseFocusReason);
    turn(slider);
    EXPECT_LT(knobs().views.strengthPercent, before.views.strengthPercent);
}

TEST_F(ViewerWindow, EnterAndEscapeLeaveANumber) {
    QLocale::setDefault(QLocale(QLocale::German));
    window_.reset();
    begin(); // its numbers have a point
    openPhoto();
    QApplication::setActiveWindow(window_.get());
    auto* const number = setting<KnobSlider>("strength")->findChild<QDoubleSpinBox*>();
    EXPECT_EQ(number->text(), "10.0 %");
    const auto type = [&](const QString& text, Qt::Key end) {
        number->setFocus(Qt::MouseFocusReason);
        number->selectAll();
        QTest::keyClicks(number, text);
        EXPECT_TRUE(number->hasFocus());
        QTest::keyClick(number, end);
        EXPECT_TRUE(picture().hasFocus());
    };
    type("12,5", Qt::Key_Return);
    EXPECT_EQ(knobs().views.strengthPercent, 12.5);
    EXPECT_EQ(window_->model().settings.undoStack().count(), 1); // not one for each digit
    type("7", Qt::Key_Escape);
    EXPECT_EQ(knobs().views.strengthPercent, 12.5);
    EXPECT_EQ(number->text(), "12.5 %");
    QTest::keyClick(&picture(), Qt::Key_2);
    EXPECT_EQ(window_->model().stage.mode(), Mode::Depth);
    QTest::keyClick(&picture(), Qt::Key_Z, Qt::ControlModifier);
    EXPECT_EQ(knobs().views.strengthPercent, 10);
    type("80", Qt::Key_Return); // more than the slider has
    EXPECT_EQ(knobs().views.strengthPercent, 80);
    setting<QComboBox>("fit")->setCurrentIndex(2); // other settings leave it
    EXPECT_EQ(knobs().views.strengthPercent, 80);
    EXPECT_EQ(number->text(), "80.0 %");
}

TEST_F(ViewerWindow, SaysWhatIsCutOffAndWhatWillSmear) {
    writeImage(folder_ / "photo.png", detailedPhoto({600, 400})); // on 3 : 4
    writeImage(folder_ / "photo-depth.png", boxDepth({600, 400}));
    openPhoto();
    EXPECT_TRUE(isSaid("50 % of the width is cut off")); // 1 - 0.75 / 1.5
    auto* const fit = setting<QComboBox>("fit");
    fit->setCurrentIndex(2);
    EXPECT_TRUE(waitFor([&] { return !isSaid("cut off"); }));
    const auto warning = [this] { return setting<QLabel>("parallax")->text(); };
    EXPECT_FALSE(warning().contains("smeared"));
    setting<KnobSlider>("strength")->slider().setValue(400);
    // half the rows fall by the whole depth: an outermost view hides 40 % / 2 of them, in all 1/2
    EXPECT_TRUE(waitFor([&] { return warning().contains("10 % of the outer views"); }))
        << warning().toStdString();
}

TEST_F(ViewerWindow, FitsASmallScreenAndShowsWhereFilesCanBeDropped) {
    fs::copy(folder_ / "photo.png", folder_ / "second.png");
    drop({"photo.png", "second.png"});
    ASSERT_TRUE(waitFor([this] { return !picture().picture().isNull() && !busy(); }));
    EXPECT_FALSE(files().horizontalScrollBar()->isVisible()); // two icons have room
    EXPECT_LE(window_->minimumSizeHint().height(), 384 - 30); // 768 px at scale 2, with a title
    EXPECT_LE(window_->minimumSizeHint().width(), 683);
    const auto border = [this] { return picture().grab().toImage().pixelColor(1, 60); };
    const QColor before = border();
    QMimeData data;
    data.setUrls({QUrl::fromLocalFile(toName(folder_ / "photo.png"))});
    QDragEnterEvent enter({10, 10}, Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
    QCoreApplication::sendEvent(window_.get(), &enter);
    EXPECT_EQ(border(), picture().palette().highlight().color());
    QDragLeaveEvent leave;
    QCoreApplication::sendEvent(window_.get(), &leave);
    EXPECT_EQ(border(), before);
}

TEST_F(ViewerWindow, SlidersTurnKnobsOneUndoPerDragAndADoubleClickResets) {
    openPhoto();
    QSlider& slider = setting<KnobSlider>("strength")->slider();
    const double first = knobs().views.strengthPercent;
    slider.setSliderDown(true);
    for (int i = 1; i <= 4; ++i)
        slider.setValue(slider.value() + 10);
    slider.setSliderDown(false);
    EXPECT_DOUBLE_EQ(knobs().views.strengthPercent, first + 4);
    EXPECT_EQ(window_->model().settings.undoStack().count(), 1);
    entry("Undo strength")->trigger();
    EXPECT_DOUBLE_EQ(knobs().views.strengthPercent, first);
    EXPECT_DOUBLE_EQ(setting<KnobSlider>("strength")->value(), first);
    slider.setValue(300);
    QTest::mouseDClick(&slider, Qt::LeftButton);
    EXPECT_DOUBLE_EQ(knobs().views.strengthPercent, 10);
}

TEST_F(ViewerWindow, AutomaticSettingsAreShownAndGivenUpByTheirSliders) {
    openPhoto();
    auto* const box = setting<QCheckBox>("auto-focus");
    EXPECT_TRUE(box->isChecked());
    box->click();
    EXPECT_FALSE(knobs().choices.focus);
    box->click();
    EXPECT_TRUE(knobs().choices.focus);
    const auto chosen = [this] { return window_->model().stage.frame().setup.knobs.views.focus; };
    ASSERT_TRUE(waitFor([this] { return window_->model().stage.frame().knobs.choices.focus; }));
    EXPECT_NE(chosen(), 0.5);
    EXPECT_NEAR(setting<KnobSlider>("focus")->value(), chosen(), 0.005);
    auto* const fit = setting<QComboBox>("fit");
    fit->setCurrentIndex(1);
    EXPECT_TRUE(knobs().choices.framing);
    EXPECT_EQ(knobs().fit, FitMode::Cover);
    setting<KnobSlider>("focus")->slider().setValue(10);
    EXPECT_FALSE(knobs().choices.focus);
    EXPECT_FALSE(box->isChecked());
    EXPECT_DOUBLE_EQ(knobs().views.focus, 0.1);
    fit->setCurrentIndex(2);
    EXPECT_FALSE(knobs().choices.framing);
    EXPECT_EQ(knobs().fit, FitMode::Contain);
    setting<QCheckBox>("auto-strength")->click();
    beginAgain();
    openPhoto();
    EXPECT_TRUE(knobs().choices.strength);
    EXPECT_FALSE(knobs().choices.focus);
}

TEST_F(ViewerWindow, AClickOnThePictureFocuses) {
    openPhoto();
    standStill();
    QTest::mouseClick(&picture(), Qt::LeftButton, Qt::NoModifier, picture().rect().center());
    EXPECT_EQ(knobs().views.focus, 1);
    EXPECT_EQ(setting<KnobSlider>("focus")->value(), 1);
    // beside the picture: nothing
    QTest::mouseClick(&picture(), Qt::LeftButton, Qt::NoModifier, QPoint(2, 2));
    EXPECT_EQ(knobs().views.focus, 1);
}

TEST_F(ViewerWindow, DraggingAndTheWheelFrameThePhoto) {
    writeImage(folder_ / "photo.png", detailedPhoto({600, 400}));
    writeImage(folder_ / "photo-depth.png", boxDepth({600, 400}));
    openPhoto();
    const QPoint middle = picture().rect().center();
    const double focus = knobs().views.focus;
    const auto drag = [&](const QPoint& by) { test::drag(picture(), middle, middle + by); };
    drag({60, 40});
    const Framing dragged = knobs().framing;
    // the window shows half of the photo's width
    EXPECT_NEAR(dragged.centre.x, 0.5 - 0.5 * 60 / picture().target().width(), 1e-9);
    EXPECT_EQ(dragged.centre.y, 0.5);
    EXPECT_EQ(dragged.zoom, 1);
    EXPECT_EQ(knobs().views.focus, focus); // that was no click
    EXPECT_EQ(window_->model().settings.undoStack().count(), 1);
    drag({-20, 0});
    EXPECT_EQ(window_->model().settings.undoStack().count(), 2);
    entry("Undo frame")->trigger();
    EXPECT_EQ(knobs().framing, dragged);

    ulong now = 1000;
    const auto turn = [&](const QPoint& at, int angle) {
        QWheelEvent event(at, picture().mapToGlobal(at), {}, {0, angle}, Qt::NoButton,
                          Qt::NoModifier, Qt::NoScrollPhase, false);
        event.setTimestamp(now += 100); // ms
        QCoreApplication::sendEvent(&picture(), &event);
    };
    for (int i = 0; i < 4; ++i)
        turn(middle, 120);
    EXPECT_NEAR(knobs().framing.zoom, 2, 1e-9);
    EXPECT_NEAR(knobs().framing.centre.x, dragged.centre.x, 1e-3);
    EXPECT_EQ(window_->model().settings.undoStack().count(), 2); // the drag, all turns
    now += 600;
    turn(middle, 120);
    EXPECT_EQ(window_->model().settings.undoStack().count(), 3);
    turn({2, 2}, 120); // beside the picture: nothing
    turn(middle, -120 * 100);
    EXPECT_EQ(knobs().framing.zoom, 1); // as a step with the one before
    EXPECT_EQ(window_->model().settings.undoStack().count(), 3);
    entry("Undo zoom")->trigger();
    entry("Undo zoom")->trigger();
    EXPECT_EQ(knobs().framing, dragged);
    QTest::keyClick(window_.get(), Qt::Key_0);
    EXPECT_EQ(knobs().framing, Framing());
    entry("Undo frame")->trigger();
    EXPECT_EQ(knobs().framing, dragged);
}

TEST_F(ViewerWindow, TheMouseMovesTheCameraIfItMay) {
    openPhoto();
    entry("Follow the mouse")->trigger();
    QTest::mouseMove(&picture(), {picture().width() - 1, 20});
    EXPECT_NEAR(window_->model().stage.position(), 1, 0.01);
    EXPECT_FALSE(window_->model().stage.isSwinging());
    QTest::mouseMove(&picture(), {0, 20});
    EXPECT_NEAR(window_->model().stage.position(), -1, 0.01);
}

TEST_F(ViewerWindow, ABrokenFileIsAMessageInTheWindow) {
    spill(folder_ / "broken.jpg", "no picture");
    drop({"broken.jpg"});
    ASSERT_TRUE(waitFor([this] { return picture().headline() == "This file cannot be opened"; }));
    EXPECT_FALSE(entry("Export Native")->isEnabled());
    QSignalSpy drags(&picture(), &PictureView::dragged); // words cannot be dragged
    drag(picture(), {100, 100}, {200, 100});
    EXPECT_EQ(drags.count(), 0);
    openPhoto();
    EXPECT_TRUE(picture().headline().isEmpty());
    files().setCurrentIndex(files().model()->index(0, 0));
    ASSERT_TRUE(waitFor([this] { return picture().headline() == "This file cannot be opened"; }));
    files().setCurrentIndex(files().model()->index(1, 0));
    ASSERT_TRUE(waitFor([this] { return !picture().picture().isNull(); }));
}

TEST_F(ViewerWindow, TextsFromFilesAreNotMarkup) {
    fs::copy(folder_ / "photo.png", folder_ / "<b>a.png");
    drop({"<b>a.png"});
    ASSERT_TRUE(waitFor([this] { return !picture().picture().isNull() && !busy(); }));
    EXPECT_TRUE(
        files().model()->index(0, 0).data(Qt::ToolTipRole).toString().contains("&lt;b&gt;a.png"));
    EXPECT_EQ(window_->findChild<QLabel*>("display")->textFormat(), Qt::PlainText); // serial number
    for (const QLabel* label : window_->statusBar()->findChildren<QLabel*>())
        EXPECT_TRUE(!label->text().contains("<b>") || label->textFormat() == Qt::PlainText);
}

TEST_F(ViewerWindow, PanelsShowOnlyWhatTheMethodHas) {
    openPhoto();
    const auto isShown = [this](const char* name) { return setting<QWidget>(name)->isVisible(); };
    EXPECT_TRUE(isShown("fill") && !isShown("refine"));
    auto* method = setting<QComboBox>("method");
    method->setCurrentIndex(method->findText("Fast"));
    EXPECT_EQ(knobs().views.method, ViewMethod::Fast);
    EXPECT_TRUE(!isShown("fill") && isShown("refine"));
}

TEST_F(ViewerWindow, SettingsAndRecentFilesAreKept) {
    openPhoto();
    setting<KnobSlider>("strength")->slider().setValue(175);
    setting<KnobSlider>("depth-curve")->slider().setValue(150);
    EXPECT_EQ(knobs().depthCurve, 1.5);
    EXPECT_NE(entry("Undo depth curve"), nullptr);
    QTest::keyClick(window_.get(), Qt::Key_2);
    beginAgain();
    EXPECT_EQ(window_->model().stage.mode(), Mode::Sway);
    QTest::keyClick(window_.get(), Qt::Key_2);
    QMenu* recent = nullptr;
    for (QMenu* menu : window_->findChildren<QMenu*>())
        if (menu->title().contains("recent")) recent = menu;
    ASSERT_NE(recent, nullptr);
    emit recent->aboutToShow();
    ASSERT_EQ(recent->actions().size(), 1);
    const fs::path canonical = fs::canonical(folder_.path());
    EXPECT_EQ(recent->actions()[0]->text(), "photo.png    in " + toName(canonical));
    EXPECT_DOUBLE_EQ(knobs().views.strengthPercent, 10);
    recent->actions()[0]->trigger();
    EXPECT_TRUE(waitFor([this] { return !picture().picture().isNull(); }));
    EXPECT_EQ(window_->model().stage.mode(), Mode::Sway); // of every photo that is opened
    // a file has one entry and one icon, however it is reached; folders are there as well
    fs::create_directory_symlink(canonical, folder_ / "link");
    drop({"link/photo.png"});
    EXPECT_EQ(files().model()->rowCount(), 1);
    fs::create_directory(folder_ / "more");
    fs::copy(folder_ / "photo.png", folder_ / "more");
    drop({"more"});
    ASSERT_TRUE(waitFor([this] { return files().model()->rowCount() == 2 && !busy(); }));
    emit recent->aboutToShow();
    QStringList names;
    for (const QAction* action : recent->actions())
        names << action->text();
    const QString in = "    in " + toName(canonical);
    EXPECT_EQ(names, (QStringList{"photo.png" + in + "/more", "more" + in, "photo.png" + in}));
    files().setCurrentIndex(files().model()->index(0, 0));
    ASSERT_TRUE(waitFor([this] { return !busy(); }));
    EXPECT_DOUBLE_EQ(knobs().views.strengthPercent, 17.5); // of this photo
    EXPECT_DOUBLE_EQ(setting<KnobSlider>("strength")->value(), 17.5);
    EXPECT_EQ(setting<KnobSlider>("depth-curve")->value(), 1.5);
}

TEST_F(ViewerWindow, APictureForTwoEyesIsExportedInTheLayoutThatIsChosen) {
    openPhoto();
    QTimer choosing;
    QObject::connect(&choosing, &QTimer::timeout, &choosing, [] {
        if (auto* layout = qobject_cast<QInputDialog*>(QApplication::activeModalWidget())) {
            layout->setTextValue("Top and bottom");
            layout->accept();
        }
    });
    choosing.start(20);
    answering("eyes.png", QMessageBox::Ok, [this] { entry("Export Stereo picture")->trigger(); });
    EXPECT_EQ(window_->model().stage.eyes().picture, EyesPicture::TopBottom);
    endExport();
    EXPECT_EQ(readImage(folder_ / "eyes.png").size(), cv::Size(300, 800));
}

TEST_F(ViewerWindow, AsksBeforeAQuiltIsReplacedByTheNameThatItGets) {
    openPhoto();
    const auto exportQuilt = [this] { entry("Export Quilt")->trigger(); };
    QStringList asked = answering("holiday.png", QMessageBox::No, exportQuilt);
    EXPECT_EQ(asked, (QStringList{"photo_qs8x6a0.75.png"}));
    endExport();
    const fs::path quilt = folder_ / "holiday_qs8x6a0.75.png";
    ASSERT_TRUE(fs::exists(quilt));
    spill(quilt, "mine");
    asked = answering("holiday.png", QMessageBox::No, exportQuilt);
    ASSERT_EQ(asked.size(), 2);
    EXPECT_TRUE(asked[1].contains("holiday_qs8x6a0.75.png exists already"));
    EXPECT_FALSE(window_->model().exports.areRunning());
    EXPECT_EQ(slurp(quilt), "mine");
    answering("holiday.png", QMessageBox::Yes, exportQuilt);
    endExport();
    EXPECT_NE(slurp(quilt), "mine");
    asked = answering("a_qs5x9a0.75.png", QMessageBox::No, exportQuilt);
    ASSERT_EQ(asked.size(), 2);
    EXPECT_TRUE(asked[1].contains("a_qs5x9a0.75.png: ")) << asked[1].toStdString();
}

TEST_F(ViewerWindow, AsksBeforeANativeOrDepthLosesInItsFormat) {
    openPhoto();
    for (const auto& [text, name] :
         {std::pair{"Export Native", "n.jpg"}, std::pair{"Export Depth", "d.jpg"}}) {
        const auto act = [this, text = text] { entry(text)->trigger(); };
        const QStringList asked = answering(name, QMessageBox::No, act);
        ASSERT_EQ(asked.size(), 2);
        EXPECT_TRUE(asked[1].contains("PNG")) << asked[1].toStdString();
        EXPECT_FALSE(window_->model().exports.areRunning());
        EXPECT_FALSE(fs::exists(folder_ / name));
        answering(name, QMessageBox::Yes, act);
        endExport();
        EXPECT_TRUE(fs::exists(folder_ / name));
    }
}

TEST_F(ViewerWindow, SaysWhyNothingIsExportedYet) {
    openPhoto();
    auto* depth = setting<QComboBox>("depth");
    depth->setCurrentIndex(depth->findText("tiny"));
    const QStringList asked =
        answering("n.png", QMessageBox::No, [this] { entry("Export Native")->trigger(); });
    EXPECT_TRUE(asked.isEmpty());
    EXPECT_TRUE(isSaid("still being estimated"));
}

TEST_F(ViewerWindow, BrokenSettingsAreNotUsed) {
    for (const char* recipe : {R"({"strength":-5,"method":"real"})", R"({"method":1})", "{", "7"}) {
        window_.reset();
        QSettings().setValue("recipe", recipe);
        QSettings().setValue("mode", 99);
        begin();
        EXPECT_EQ(knobs(), Knobs()) << recipe;
        EXPECT_EQ(window_->model().stage.mode(), Mode::Sway);
    }
    window_.reset();
    QSettings().setValue("recipe", R"({"strength":12})"); // the others have their defaults
    begin();
    EXPECT_EQ(knobs().views.strengthPercent, 12);
    EXPECT_EQ(knobs().views.method, Knobs().views.method);
}

TEST_F(ViewerWindow, AChosenQuiltStaysWithAnotherUnitOfTheSameModel) {
    std::string text = slurp(sourcePath("calibration/portrait-sample.json"));
    spill(folder_ / "unit.json", text);
    text.replace(text.find("1536"), 4, "1440");
    spill(folder_ / "panel.json", text);
    Display display = sampleDisplay();
    display.quilt = {5, 9, {40, 60}, 45}; // -q 9x5 -r 60x40
    window_ = std::make_unique<MainWindow>(display, warnings_);
    const auto choose = [this](const char* file) {
        answering(file, QMessageBox::Ok, [this] { entry("Choose calibration")->trigger(); });
        return *window_->model().files.display();
    };
    const Display unit = choose("unit.json");
    EXPECT_EQ(unit.source, (folder_ / "unit.json").string());
    EXPECT_EQ(unit.quilt, display.quilt);
    const Display other = choose("panel.json");
    EXPECT_EQ(other.panelSize().width, 1440);
    EXPECT_EQ(other.quilt, defaultQuilt(other.calibration));
}

TEST_F(ViewerWindow, DepthImagesAreForPhotosOnly) {
    writeGreys(folder_ / "clip.mkv", {90, 120}, 5);
    openPhoto();
    const auto expectOffered = [this](bool offered) {
        EXPECT_EQ(entry("Depth image for this photo")->isEnabled(), offered);
        EXPECT_EQ(setting<QWidget>("depthImage")->isEnabled(), offered);
    };
    expectOffered(true);
    drop({"clip.mkv", "photo-depth.png"});
    ASSERT_TRUE(waitFor([this] {
        const auto& document = window_->model().files.document();
        return document && document->video && !busy();
    }));
    expectOffered(false);
}

TEST_F(ViewerWindow, ALargePhotoDoesNotFreezeIt) {
    writeImage(folder_ / "large.jpg", cv::Mat(3000, 4000, CV_8UC3, cv::Scalar(40, 90, 160)));
    drop({"large.jpg"});
    EXPECT_TRUE(busy()); // it is read elsewhere
    QTest::keyClick(window_.get(), Qt::Key_2);
    EXPECT_EQ(window_->model().stage.mode(), Mode::Depth);
    EXPECT_TRUE(busy());
    ASSERT_TRUE(waitFor([this] { return !picture().picture().isNull() && !busy(); }));
}

} // namespace
} // namespace altiro3D::test
