#pragma once

#include <QFrame>
#include <QImage>
#include <QPolygonF>
#include <QWidget>
#include <functional>

namespace altiro3D::viewer {

/// The middle of the window: a picture on a dark background, or a text if there is none.
class PictureView : public QWidget {
    Q_OBJECT
  public:
    /// What the left button does.
    enum class Pointer {
        Frame, ///< Clicks and drags.
        Brush, ///< Strokes with a circle around the mouse.
        Lasso  ///< Strokes that leave a line.
    };

    explicit PictureView(QWidget* parent = nullptr);

    /// @param image the picture @param target its size in px of the screen
    void setPicture(const QImage& image, QSize target);
    /// @param radius of the brush, in widths of the picture
    void setPointer(Pointer pointer, double radius);
    Pointer pointer() const { return pointer_; }
    void setWords(const QString& headline, const QString& advice) { put({}, headline, advice); }

    /// Shows that files which are dragged over the window can be dropped.
    void setDropShown(bool shown) {
        showsDrop_ = shown;
        update();
    }

    /// Size of the picture in px of the screen.
    QSize target() const { return target_; }
    const QImage& picture() const { return picture_; }
    const QString& headline() const { return headline_; }
    /// Size of the widget in px of the screen.
    QSize deviceSize() const;

    QSize sizeHint() const override { return {720, 720}; }
    QSize minimumSizeHint() const override { return {160, 80}; }

  signals:
    void resized();
    /// A click on the picture; x and y 0..1 from its upper left corner.
    void clicked(double x, double y);
    /// The mouse moves over the widget; x is -1 at its left border, +1 at the right one.
    void hovered(double x);
    /// The picture is dragged, px of the screen. All steps of one drag have the same gesture
    /// number.
    void dragged(const QPoint& by, int gesture);
    /// A stroke begins, goes on and ends; x and y as in clicked(), also beyond 0..1.
    /// @param shift the key was held at the beginning
    void strokeBegan(double x, double y, bool shift);
    void strokeMoved(double x, double y);
    void strokeEnded();
    /// The wheel turns over the picture; x and y as in clicked(), notches > 0 away from the user.
    /// Turns within half a second have the same gesture number.
    void wheeled(double x, double y, double notches, int gesture);

  protected:
    void paintEvent(QPaintEvent* event) override;
    void resizeEvent(QResizeEvent* /*event*/) override { emit resized(); }
    void mousePressEvent(QMouseEvent* event) override;
    void mouseMoveEvent(QMouseEvent* event) override;
    void mouseReleaseEvent(QMouseEvent* event) override;
    void wheelEvent(QWheelEvent* event) override;
    void leaveEvent(QEvent* event) override;

  private:
    void put(const QImage& image, const QString& headline, const QString& advice);
    QRect pictureRect() const; // px of the screen
    /// A place of the widget, in widths and heights of the picture.
    QPointF inPicture(const QPointF& place) const;
    void paintWords(QPainter& painter) const;
    void paintPointer(QPainter& painter) const;
    void endStroke();

    QImage picture_;
    QSize target_;
    QString headline_;
    QString advice_;
    QPoint pressed_;
    QPoint last_;
    bool dragging_ = false;
    Pointer pointer_ = Pointer::Frame;
    double radius_ = 0;
    bool stroking_ = false;
    bool hovering_ = false;
    bool showsDrop_ = false;
    QPointF mouse_;
    QPolygonF line_; // of the lasso, px of the widget
    int dragGesture_ = 0;
    int wheelGesture_ = 0;
    ulong wheeledAt_ = 0; // ms, of the last turn of the wheel
};

/// What a new user sees above the sample photo: what can be done, or which display was found.
class WelcomeCard : public QFrame {
    Q_OBJECT
  public:
    /// @param display name of the display that was found; empty: none
    /// @param onOpen, onClose what its buttons do
    WelcomeCard(const QString& display, const std::function<void()>& onOpen,
                const std::function<void()>& onClose);
};

} // namespace altiro3D::viewer
