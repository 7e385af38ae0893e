// The first start, and the window without a mouse and without eyes.

#include "viewer/window/picture_view.hpp"

#include "viewer/window/main_window.hpp"
#include "viewer_scenes.hpp"
#include "window_actions.hpp"

#include <QAccessible>
#include <QAction>
#include <QComboBox>
#include <QLabel>
#include <QMenu>
#include <QMenuBar>
#include <QPushButton>
#include <QSettings>
#include <QToolBar>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

class ViewerWelcome : public ::testing::Test {
  protected:
    void SetUp() override {
        QSettings().clear();
        writeImage(folder_ / "own.png", detailedPhoto({60, 80}));
        writeImage(folder_ / "other.png", detailedPhoto({60, 80}));
        begin();
    }
    void begin() { window_ = shownWindow(); }
    Model& model() { return window_->model(); }
    WelcomeCard* card() { return window_->findChild<WelcomeCard*>(); }
    bool hasPicture() {
        return !window_->findChild<PictureView*>()->picture().isNull() && !model().stage.isBusy();
    }
    QString words() {
        QString all;
        for (const QLabel* label : card()->findChildren<QLabel*>())
            all += label->text() + "\n";
        return all;
    }
    // The card and the sample are gone, and do not come back.
    void expectNoWelcome() {
        ASSERT_TRUE(waitFor([this] { return card() == nullptr; }));
        begin();
        window_->welcome({});
        EXPECT_EQ(card(), nullptr);
        EXPECT_TRUE(model().files.sources().empty());
    }

    TemporaryDirectory folder_;
    std::unique_ptr<MainWindow> window_;
};

TEST_F(ViewerWelcome, ShowsTheSampleSwayingAndWhatCanBeDone) {
    window_->welcome({});
    ASSERT_TRUE(waitFor([this] { return hasPicture(); }));
    ASSERT_NE(card(), nullptr);
    EXPECT_TRUE(card()->isVisible());
    EXPECT_TRUE(words().contains("No light-field display was found")) << words().toStdString();
    EXPECT_EQ(model().files.sources().front().file.filename(), "sample.jpg");
    EXPECT_EQ(model().files.document()->kind, Kind::Scene);
    EXPECT_TRUE(model().stage.isSwinging());
    // its depth is estimated, as that of the user's photos, and its picture is not covered
    ASSERT_TRUE(waitFor([this] { return model().stage.frame().setup.depthSource == "tiny"; }));
    EXPECT_TRUE(words().contains("depth is estimated"));
    const auto& picture = *window_->findChild<PictureView*>();
    const auto placeOf = [this](const QWidget& widget) {
        return QRect(widget.mapTo(window_.get(), QPoint()), widget.size());
    };
    EXPECT_FALSE(placeOf(*card()).intersects(placeOf(picture)));
    EXPECT_FALSE(QSettings().value("recent").toStringList().join("").contains("sample"));
    // all words are seen
    for (const QLabel* label : card()->findChildren<QLabel*>())
        EXPECT_GE(label->height(), label->heightForWidth(label->width()))
            << label->text().toStdString();
}

TEST_F(ViewerWelcome, GreetsADisplayByItsName) {
    window_->welcome("Looking Glass <b>Portrait</b>, LKG-P1");
    EXPECT_TRUE(words().contains("Welcome, Looking Glass <b>Portrait</b>, LKG-P1\n"));
    EXPECT_TRUE(words().contains("F11"));
    for (const QLabel* label : card()->findChildren<QLabel*>())
        EXPECT_EQ(label->textFormat(), Qt::PlainText);
}

TEST_F(ViewerWelcome, LeavesWithTheSampleWhenSomethingIsOpened) {
    window_->welcome({});
    ASSERT_TRUE(waitFor([this] { return hasPicture(); }));
    model().files.open(std::vector<fs::path>{folder_ / "own.png"});
    ASSERT_TRUE(waitFor([this] { return hasPicture() && model().files.sources().size() == 1; }));
    EXPECT_EQ(model().files.sources().front().file, folder_ / "own.png");
    ASSERT_TRUE(waitFor([this] {
        const auto& document = model().files.document();
        return document && document->source.file == folder_ / "own.png";
    }));
    expectNoWelcome();
}

TEST_F(ViewerWelcome, ClosedItStaysAwayAndTheSampleStays) {
    window_->welcome({});
    ASSERT_TRUE(waitFor([this] { return hasPicture(); }));
    card()->findChild<QPushButton*>("welcomeClose")->click();
    EXPECT_EQ(model().files.sources().size(), 1u);
    ASSERT_TRUE(waitFor([this] { return card() == nullptr; }));
    dropOn(*window_, {folder_ / "own.png", folder_ / "other.png"}); // then it leaves as well
    ASSERT_TRUE(waitFor([this] { return model().files.sources().size() == 2 && hasPicture(); }));
    EXPECT_EQ(model().files.sources()[0].file, folder_ / "own.png");
    EXPECT_EQ(model().files.current(), 0);
    expectNoWelcome();
}

QString accessibleName(QWidget* widget) {
    QAccessibleInterface* const it = QAccessible::queryAccessibleInterface(widget);
    return it != nullptr ? it->text(QAccessible::Name) : QString();
}

TEST_F(ViewerWelcome, AllThatTakesKeysHasANameAndIsReached) {
    window_->welcome({});
    ASSERT_TRUE(waitFor([this] { return hasPicture(); }));
    window_->findChild<QAction*>("paintDepth")->trigger();
    QList<QWidget*> expected;
    for (auto* widget : window_->findChildren<QWidget*>()) {
        if (!widget->isVisible() || !widget->isEnabled()) continue;
        if (!(widget->focusPolicy() & Qt::TabFocus) || widget->focusProxy() != nullptr) continue;
        expected << widget;
        EXPECT_FALSE(accessibleName(widget).isEmpty())
            << widget->metaObject()->className() << " " << widget->objectName().toStdString()
            << " in " << widget->parentWidget()->objectName().toStdString();
    }
    EXPECT_GT(expected.size(), 10);
    // Tab goes through all of them
    QApplication::setActiveWindow(window_.get());
    expected.front()->setFocus();
    QSet<QWidget*> reached;
    for (int i = 0; i < 200; ++i) {
        reached << QApplication::focusWidget();
        QTest::keyClick(QApplication::focusWidget(), Qt::Key_Tab);
    }
    for (QWidget* widget : expected)
        EXPECT_TRUE(reached.contains(widget))
            << widget->metaObject()->className() << " " << accessibleName(widget).toStdString();
}

TEST_F(ViewerWelcome, EveryButtonOfTheBarsIsInAMenuOrHasAKey) {
    QSet<QAction*> inMenus;
    for (const QAction* title : window_->menuBar()->actions()) {
        EXPECT_TRUE(title->text().contains('&')) << title->text().toStdString();
        for (QAction* action : title->menu()->actions())
            inMenus << action;
    }
    const auto* bar = window_->findChild<QToolBar*>("tools");
    for (QAction* action : bar->actions()) {
        if (action->isSeparator() || action->text().isEmpty()) continue;
        EXPECT_TRUE(inMenus.contains(action)) << action->text().toStdString();
    }
}

} // namespace
} // namespace altiro3D::test
