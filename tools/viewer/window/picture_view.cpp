#include "viewer/window/picture_view.hpp"

#include "viewer/model/knobs.hpp"
#include "viewer/window/window_words.hpp"

#include <QApplication>
#include <QMouseEvent>
#include <QPainter>
#include <QPushButton>
#include <QWheelEvent>

namespace altiro3D::viewer {

namespace {

const QColor kGround(26, 27, 30);
const QColor kText(225, 226, 230);
const QColor kFaintText(150, 152, 160);

bool isInside(const QPointF& at) {
    return at.x() >= 0 && at.x() < 1 && at.y() >= 0 && at.y() < 1;
}

} // namespace

PictureView::PictureView(QWidget* parent) : QWidget(parent) {
    setAttribute(Qt::WA_OpaquePaintEvent);
    setMouseTracking(true);
    setFocusPolicy(Qt::ClickFocus);
    setObjectName("picture");
}

void PictureView::setPicture(const QImage& image, QSize target) {
    target_ = target;
    put(image, {}, {});
}

void PictureView::put(const QImage& image, const QString& headline, const QString& advice) {
    picture_ = image;
    headline_ = headline;
    advice_ = advice;
    update();
}

QSize PictureView::deviceSize() const {
    const qreal ratio = devicePixelRatioF();
    return {qRound(width() * ratio), qRound(height() * ratio)};
}

QRect PictureView::pictureRect() const {
    const QSize area = deviceSize();
    return {QPoint((area.width() - target_.width()) / 2, (area.height() - target_.height()) / 2),
            target_};
}

QPointF PictureView::inPicture(const QPointF& place) const {
    const QRect picture = pictureRect();
    const QPointF at = place * devicePixelRatioF() - picture.topLeft();
    return {at.x() / qMax(1, picture.width()), at.y() / qMax(1, picture.height())};
}

void PictureView::paintEvent(QPaintEvent* /*event*/) {
    QPainter painter(this);
    painter.fillRect(rect(), kGround);
    if (!picture_.isNull()) {
        painter.save();
        const qreal ratio = devicePixelRatioF();
        if (ratio != 1) painter.scale(1 / ratio, 1 / ratio); // px of the screen
        const QRect place = pictureRect();
        painter.setRenderHint(QPainter::SmoothPixmapTransform, picture_.size() != target_);
        painter.drawImage(place, picture_);
        painter.restore();
        paintPointer(painter);
    } else {
        paintWords(painter);
    }
    if (!showsDrop_) return;
    constexpr int kWidth = 4;
    painter.setPen(QPen(palette().highlight(), kWidth));
    painter.setBrush(Qt::NoBrush);
    painter.drawRect(rect().adjusted(kWidth / 2, kWidth / 2, -kWidth / 2, -kWidth / 2));
}

// Black beside white is seen on every picture.
void PictureView::paintPointer(QPainter& painter) const {
    if (pointer_ == Pointer::Frame) return;
    painter.setRenderHint(QPainter::Antialiasing);
    for (const auto& [colour, width] : {std::pair{Qt::black, 3.0}, std::pair{Qt::white, 1.2}}) {
        painter.setPen(QPen(colour, width));
        painter.setBrush(Qt::NoBrush);
        const double radius = radius_ * target_.width() / devicePixelRatioF();
        if (pointer_ == Pointer::Lasso)
            painter.drawPolyline(line_);
        else if (hovering_)
            painter.drawEllipse(mouse_, radius, radius);
    }
}

void PictureView::setPointer(Pointer pointer, double radius) {
    if (pointer != pointer_) endStroke();
    pointer_ = pointer;
    radius_ = radius;
    update();
}

void PictureView::endStroke() {
    if (!stroking_) return;
    stroking_ = false;
    line_.clear();
    update();
    emit strokeEnded();
}

void PictureView::leaveEvent(QEvent* event) {
    QWidget::leaveEvent(event);
    hovering_ = false;
    if (pointer_ != Pointer::Frame) update();
}

void PictureView::paintWords(QPainter& painter) const {
    const QRect column = rect().adjusted(24, 0, -24, 0);
    QFont large = font();
    large.setPointSizeF(font().pointSizeF() * 1.7);
    const QFontMetrics largeMetrics(large);
    const int wrap = Qt::AlignHCenter | Qt::AlignTop | Qt::TextWordWrap;
    QRect words = fontMetrics().boundingRect(column.adjusted(40, 0, -40, 0), wrap, advice_);
    QRect headline = largeMetrics.boundingRect(column, wrap, headline_);
    const int gap = 14;
    headline.moveCenter(column.center());
    headline.moveTop(column.center().y() - (headline.height() + gap + words.height()) / 2);
    words.moveCenter(column.center());
    words.moveTop(headline.bottom() + gap);
    painter.setFont(large);
    painter.setPen(kText);
    painter.drawText(headline, wrap, headline_);
    painter.setFont(font());
    painter.setPen(kFaintText);
    painter.drawText(words, wrap, advice_);
}

void PictureView::mousePressEvent(QMouseEvent* event) {
    if (event->button() != Qt::LeftButton) return;
    if (pointer_ != Pointer::Frame) {
        if (picture_.isNull()) return;
        stroking_ = true;
        line_ = QPolygonF({event->localPos()});
        const QPointF at = inPicture(event->localPos());
        emit strokeBegan(at.x(), at.y(), event->modifiers().testFlag(Qt::ShiftModifier));
        return;
    }
    pressed_ = last_ = event->pos();
    dragging_ = false;
}

void PictureView::mouseMoveEvent(QMouseEvent* event) {
    if (pointer_ != Pointer::Frame) {
        mouse_ = event->localPos();
        hovering_ = true;
        update();
        if (!stroking_) return;
        if (pointer_ == Pointer::Lasso) line_ << mouse_;
        const QPointF at = inPicture(mouse_);
        emit strokeMoved(at.x(), at.y());
        return;
    }
    if ((event->buttons() & Qt::LeftButton) != 0) {
        if (picture_.isNull()) return; // nothing to drag
        if (!dragging_) {
            if ((event->pos() - pressed_).manhattanLength() < QApplication::startDragDistance())
                return;
            dragGesture_ = nextGesture();
            dragging_ = true;
        }
        emit dragged((event->pos() - last_) * devicePixelRatioF(), dragGesture_);
        last_ = event->pos();
        return;
    }
    emit hovered(2.0 * event->x() / qMax(1, width() - 1) - 1);
}

void PictureView::mouseReleaseEvent(QMouseEvent* event) {
    if (event->button() != Qt::LeftButton) return;
    if (stroking_) return endStroke();
    if (pointer_ != Pointer::Frame || dragging_ || picture_.isNull()) return;
    const QPointF at = inPicture(event->pos());
    if (isInside(at)) emit clicked(at.x(), at.y());
}

void PictureView::wheelEvent(QWheelEvent* event) {
    constexpr ulong kPauseMilliseconds = 500;
    const int turned = event->angleDelta().y();
    if (turned == 0 || picture_.isNull()) return;
    const QPointF at = inPicture(event->position());
    if (!isInside(at)) return;
    if (wheelGesture_ == 0 || event->timestamp() - wheeledAt_ > kPauseMilliseconds)
        wheelGesture_ = nextGesture();
    wheeledAt_ = event->timestamp();
    constexpr double kStep = QWheelEvent::DefaultDeltasPerStep;
    emit wheeled(at.x(), at.y(), turned / kStep, wheelGesture_);
}

WelcomeCard::WelcomeCard(const QString& display, const std::function<void()>& onOpen,
                         const std::function<void()>& onClose) {
    setObjectName("welcome");
    setFrameShape(QFrame::StyledPanel);
    setAutoFillBackground(true);
    const bool isFound = !display.isEmpty();
    auto* headline = plainLabel(isFound ? tr("Welcome, %1").arg(display)
                                        : tr("Welcome. No light-field display was found."));
    QFont large = headline->font();
    large.setPointSizeF(large.pointSizeF() * 1.3);
    large.setBold(true);
    headline->setFont(large);
    auto* advice =
        plainLabel(tr("This is a sample; its depth is estimated, as of your photos. Drop a photo, "
                      "a video or a folder anywhere in the window, or press Ctrl+O. ") +
                   (isFound ? tr("F11 shows the picture on the display, and Display > Test picture "
                                 "shows whether it is set up well.")
                            : tr("The sway shows what a display would show; Lens shows what an eye "
                                 "would see. Export writes files for a display.")));
    auto* open = named(new QPushButton(tr("Open a &photo…")), "welcomeOpen", {});
    auto* close = named(new QPushButton(tr("&Close this")), "welcomeClose", {});
    connect(open, &QPushButton::clicked, this, onOpen);
    connect(close, &QPushButton::clicked, this, onClose);
    setLayout(
        boxOf<QVBoxLayout>(-1, headline, advice, boxOf<QHBoxLayout>(1, open, new QWidget, close)));
    setAccessibleName(headline->text());
    setAccessibleDescription(advice->text());
}

} // namespace altiro3D::viewer
