#pragma once

#include "viewer/window/main_window.hpp"
#include "viewer_scenes.hpp"

#include <QAbstractButton>
#include <QAction>
#include <QApplication>
#include <QDropEvent>
#include <QFileDialog>
#include <QFileInfo>
#include <QLineEdit>
#include <QMessageBox>
#include <QMimeData>
#include <QMouseEvent>
#include <QTimer>
#include <QUrl>
#include <gtest/gtest.h>

/// What people do with the viewer's window.
namespace altiro3D::test {

/// The window for a small display, shown.
inline std::unique_ptr<viewer::MainWindow>
shownWindow(const std::vector<std::string>& warnings = {}) {
    auto window = std::make_unique<viewer::MainWindow>(sampleDisplay({150, 200}), warnings);
    window->resize(1000, 700);
    window->show();
    EXPECT_TRUE(QTest::qWaitForWindowExposed(window.get()));
    return window;
}

/// An entry of a menu by its text without dots and marks.
inline QAction* entryOf(const QWidget& window, const QString& text) {
    for (QAction* action : window.findChildren<QAction*>()) {
        if (action->text().remove('&').remove(QChar(0x2026)) == text) return action;
    }
    return nullptr;
}

inline void dropOn(QWidget& window, const std::vector<std::filesystem::path>& files) {
    QList<QUrl> urls;
    for (const std::filesystem::path& file : files)
        urls << QUrl::fromLocalFile(toName(file));
    QMimeData data;
    data.setUrls(urls);
    QDragEnterEvent enter({10, 10}, Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
    QCoreApplication::sendEvent(&window, &enter);
    EXPECT_TRUE(enter.isAccepted());
    QDropEvent event({10, 10}, Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
    QCoreApplication::sendEvent(&window, &event);
}

/// Drags the mouse with its left button.
inline void drag(QWidget& widget, const QPoint& from, const QPoint& to) {
    QTest::mousePress(&widget, Qt::LeftButton, Qt::NoModifier, from);
    for (int i = 1; i <= 4; ++i) { // QTest::mouseMove() holds no button
        QMouseEvent move(QEvent::MouseMove, from + (to - from) * i / 4, Qt::NoButton,
                         Qt::LeftButton, Qt::NoModifier);
        QCoreApplication::sendEvent(&widget, &move);
    }
    QTest::mouseRelease(&widget, Qt::LeftButton, Qt::NoModifier, to);
}

/// Calls a function that opens dialogs, types a name into the first file dialog and gives one
/// answer to all questions, until `so`. Returns the questions; of a file dialog, the name that it
/// proposed.
inline QStringList answering(const std::filesystem::path& name, QMessageBox::StandardButton answer,
                             const std::function<void()>& act,
                             const std::function<bool(const QStringList&)>& so = {}) {
    QStringList asked;
    QTimer timer;
    QObject::connect(&timer, &QTimer::timeout, &timer, [&] {
        QWidget* const dialog = QApplication::activeModalWidget();
        if (auto* files = qobject_cast<QFileDialog*>(dialog)) {
            if (!asked.isEmpty()) return;
            asked << QFileInfo(files->selectedFiles().value(0)).fileName();
            files->findChild<QLineEdit*>("fileNameEdit")->setText(toName(name));
            QMetaObject::invokeMethod(files, "accept", Qt::QueuedConnection);
        } else if (auto* box = qobject_cast<QMessageBox*>(dialog)) {
            asked << box->text() + " " + box->informativeText();
            QAbstractButton* const button = box->button(answer);
            (button != nullptr ? button : box->button(QMessageBox::Ok))->click();
        }
    });
    timer.start(20);
    act();
    if (so) {
        EXPECT_TRUE(waitFor([&] { return so(asked); }));
    }
    return asked;
}

} // namespace altiro3D::test
