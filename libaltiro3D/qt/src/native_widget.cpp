#include "altiro3D/qt/native_widget.hpp"

#include "altiro3D/qt/image.hpp"

#include <QKeyEvent>
#include <QPainter>
#include <QScreen>
#include <QWindow>

namespace altiro3D::qt {

NativeWidget::NativeWidget(QWidget* parent) : QWidget(parent) {
    setAttribute(Qt::WA_OpaquePaintEvent);
    setFocusPolicy(Qt::StrongFocus);
}

void NativeWidget::setNative(const cv::Mat& native) {
    image_ = toImage(native);
    update();
}

QSize NativeWidget::deviceSize() const {
    const qreal ratio = devicePixelRatioF();
    return {qRound(width() * ratio), qRound(height() * ratio)};
}

void NativeWidget::showOn(QScreen& screen) {
    setWindowFlags(Qt::Window | Qt::FramelessWindowHint);
    setCursor(Qt::BlankCursor);
    create();
    windowHandle()->setScreen(&screen);
    setGeometry(screen.geometry());
    showFullScreen();
    setFocus();
    activateWindow();
}

void NativeWidget::leave() {
    hide();
    emit left();
}

void NativeWidget::paintEvent(QPaintEvent* /*event*/) {
    QPainter painter(this);
    painter.fillRect(rect(), Qt::black);
    if (image_.isNull()) return;
    // from here on in px of the screen
    const qreal ratio = devicePixelRatioF();
    if (ratio != 1) painter.scale(1 / ratio, 1 / ratio);
    const QSize device = deviceSize();
    painter.setRenderHint(QPainter::SmoothPixmapTransform, false);
    painter.drawImage((device.width() - image_.width()) / 2,
                      (device.height() - image_.height()) / 2, image_);
}

void NativeWidget::keyPressEvent(QKeyEvent* event) {
    if (isFullScreen() && (event->key() == Qt::Key_Escape || event->key() == Qt::Key_F11)) {
        leave();
    } else {
        QWidget::keyPressEvent(event);
    }
}

void NativeWidget::mouseDoubleClickEvent(QMouseEvent* event) {
    if (isFullScreen())
        leave();
    else
        QWidget::mouseDoubleClickEvent(event);
}

} // namespace altiro3D::qt
