#include "altiro3D/qt/native_widget.hpp"

#include "altiro3D/qt/image.hpp"
#include "support/compare.hpp"
#include "support/random_pictures.hpp"

#include <QGuiApplication>
#include <QScreen>
#include <QSignalSpy>
#include <QTest>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

cv::Mat noise(int cols, int rows) {
    return randomPicture({cols, rows}, CV_8UC3, 3);
}

// What a widget paints, in px of the screen. The tests run at several scales of the desktop.
cv::Mat painted(QWidget& widget) {
    return qt::toPicture(widget.grab().toImage());
}

TEST(NativeWidget, PaintsOnePxOfThePictureOnOnePxOfTheScreen) {
    qt::NativeWidget widget;
    widget.resize(98, 54);
    const cv::Mat native = noise(widget.deviceSize().width(), widget.deviceSize().height());
    widget.setNative(native);
    EXPECT_TRUE(widget.isExact());
    EXPECT_TRUE(samePicture(painted(widget), native));
}

TEST(NativeWidget, StandsInTheMiddleOnBlackOrIsCutOff) {
    qt::NativeWidget widget;
    widget.resize(30, 14);
    const QSize device = widget.deviceSize();
    const cv::Mat small = noise(device.width() - 11, device.height() - 4);
    widget.setNative(small);
    EXPECT_FALSE(widget.isExact());
    cv::Mat expected(device.height(), device.width(), CV_8UC3, cv::Scalar::all(0));
    small.copyTo(expected(cv::Rect(5, 2, small.cols, small.rows)));
    EXPECT_TRUE(samePicture(painted(widget), expected));
    const cv::Mat large = noise(device.width() + 8, device.height() + 4);
    widget.setNative(large);
    EXPECT_TRUE(
        samePicture(painted(widget), large(cv::Rect(4, 2, device.width(), device.height()))));
}

TEST(NativeWidget, IsBlackWithoutAPicture) {
    qt::NativeWidget widget;
    widget.resize(10, 8);
    const QSize device = widget.deviceSize();
    EXPECT_TRUE(samePicture(painted(widget),
                            cv::Mat(device.height(), device.width(), CV_8UC3, cv::Scalar::all(0))));
}

TEST(NativeWidget, FillsExactlyTheScreenItIsShownOnUntilEscape) {
    QScreen& screen = *QGuiApplication::primaryScreen();
    for (const int key : {int(Qt::Key_Escape), int(Qt::Key_F11)}) {
        qt::NativeWidget widget;
        widget.resize(screen.geometry().size());
        const cv::Mat native = noise(widget.deviceSize().width(), widget.deviceSize().height());
        widget.setNative(native);
        widget.showOn(screen);
        ASSERT_TRUE(QTest::qWaitForWindowExposed(&widget));
        EXPECT_EQ(widget.geometry(), screen.geometry());
        EXPECT_TRUE(widget.isExact());
        EXPECT_TRUE(samePicture(painted(widget), native));
        const QSignalSpy left(&widget, &qt::NativeWidget::left);
        QTest::keyClick(&widget, Qt::Key_A);
        EXPECT_TRUE(widget.isVisible());
        QTest::keyClick(&widget, static_cast<Qt::Key>(key));
        EXPECT_FALSE(widget.isVisible());
        EXPECT_EQ(left.count(), 1);
    }
}

// Another screen must not be covered; a screen is a display again when it is plugged in again.
TEST(NativeWidget, GoesAndComesWithItsScreen) {
    QScreen& screen = *QGuiApplication::primaryScreen();
    qt::NativeWidget widget;
    const QSignalSpy left(&widget, &qt::NativeWidget::left);
    emit qGuiApp->screenAdded(&screen);
    EXPECT_FALSE(widget.isVisible()); // it was shown nowhere
    widget.showOn(screen);
    emit qGuiApp->screenRemoved(&screen);
    EXPECT_FALSE(widget.isVisible());
    emit qGuiApp->screenAdded(&screen);
    EXPECT_TRUE(widget.isVisible());
    EXPECT_EQ(widget.geometry(), screen.geometry());
    EXPECT_EQ(left.count(), 0);
    widget.close(); // by the window manager
    EXPECT_EQ(left.count(), 1);
    emit qGuiApp->screenAdded(&screen);
    EXPECT_FALSE(widget.isVisible());
}

} // namespace
} // namespace altiro3D::test
