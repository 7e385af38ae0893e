#include "altiro3D/qt/native_widget.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/qt/image.hpp"

#include <QGuiApplication>
#include <QKeyEvent>
#include <QPainter>
#include <QScreen>
#include <QWindow>
#include <memory>
#include <opencv2/core.hpp>

namespace altiro3D::qt {

namespace {

bool isSameScreen(const ScreenFacts& a, const ScreenFacts& b) {
    if (a.size != b.size) return false;
    if (!a.serialNumber.empty() && !b.serialNumber.empty())
        return a.serialNumber == b.serialNumber && a.model == b.model;
    return a.name == b.name && a.model == b.model;
}

} // namespace

QImage toImage(const cv::Mat& picture) {
    if (picture.empty()) return {};
    if (picture.dims != 2 || (picture.type() != CV_8UC3 && picture.type() != CV_8UC1)) {
        throw Error(ErrorCode::InvalidArgument, "picture",
                    "is of " + cv::typeToString(picture.type()) + ", expected 8-bit BGR or grey");
    }
    auto owner = std::make_unique<cv::Mat>(picture); // shares the memory and keeps it alive
    const uchar* data = owner->data;
    const auto step = static_cast<int>(owner->step[0]);
    const QImage::Format format =
        picture.type() == CV_8UC3 ? QImage::Format_BGR888 : QImage::Format_Grayscale8;
    return {data,           picture.cols, picture.rows,
            step,           format,       [](void* mat) { delete static_cast<cv::Mat*>(mat); },
            owner.release()};
}

cv::Mat toPicture(const QImage& image) {
    if (image.isNull()) return {};
    cv::Mat picture(image.height(), image.width(), CV_8UC3, cv::Scalar::all(0));
    QImage target(picture.data, picture.cols, picture.rows, static_cast<int>(picture.step[0]),
                  QImage::Format_BGR888);
    QPainter painter(&target);
    if (!image.hasAlphaChannel()) painter.setCompositionMode(QPainter::CompositionMode_Source);
    QImage source = image; // the pixels only; its size on a screen does not matter
    source.setDevicePixelRatio(1);
    painter.drawImage(0, 0, source);
    painter.end();
    return picture;
}

NativeWidget::NativeWidget(QWidget* parent) : QWidget(parent) {
    setAttribute(Qt::WA_OpaquePaintEvent);
    setFocusPolicy(Qt::StrongFocus);
    connect(qGuiApp, &QGuiApplication::screenRemoved, this, [this](QScreen* removed) {
        if (isSameScreen(factsOf(*removed), screen_)) hide();
    });
    connect(qGuiApp, &QGuiApplication::screenAdded, this, [this](QScreen* added) {
        if (isSameScreen(factsOf(*added), screen_)) showOn(*added);
    });
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
    screen_ = factsOf(screen);
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
    screen_ = {};
    hide();
    emit left();
}

void NativeWidget::closeEvent(QCloseEvent* event) {
    QWidget::closeEvent(event);
    if (isWindow()) leave();
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
