#pragma once

#include <QElapsedTimer>
#include <QImage>
#include <QWidget>

namespace altiro3D::viewer {

/// The middle of the window: a picture on a dark background, or a text if there is none.
class PictureView : public QWidget {
    Q_OBJECT
  public:
    explicit PictureView(QWidget* parent = nullptr);

    /// @param image the picture @param target its size in px of the screen
    void setPicture(const QImage& image, QSize target);
    /// Shows a headline and advice instead of a picture.
    void setWords(const QString& headline, const QString& advice);

    /// Size of the picture in px of the screen.
    QSize target() const { return target_; }
    const QImage& picture() const { return picture_; }
    const QString& headline() const { return headline_; }
    /// Size of the widget in px of the screen.
    QSize deviceSize() const;

    QSize sizeHint() const override { return {720, 720}; }
    QSize minimumSizeHint() const override { return {240, 240}; }

  signals:
    void resized();
    /// A click on the picture; x and y 0..1 from its upper left corner.
    void clicked(double x, double y);
    /// The mouse moves over the widget; x is -1 at its left border, +1 at the right one.
    void hovered(double x);
    /// The picture is dragged, px of the screen. All steps of one drag have the same gesture
    /// number.
    void dragged(const QPoint& by, int gesture);
    /// The wheel turns over the picture; x and y as in clicked(), notches > 0 away from the user.
    /// Turns within half a second have the same gesture number.
    void wheeled(double x, double y, double notches, int gesture);

  protected:
    void paintEvent(QPaintEvent* event) override;
    void resizeEvent(QResizeEvent* event) override;
    void mousePressEvent(QMouseEvent* event) override;
    void mouseMoveEvent(QMouseEvent* event) override;
    void mouseReleaseEvent(QMouseEvent* event) override;
    void wheelEvent(QWheelEvent* event) override;

  private:
    QRect pictureRect() const; // px of the screen
    /// A place of the widget, in widths and heights of the picture.
    QPointF inPicture(const QPointF& place) const;
    void paintWords(QPainter& painter) const;

    QImage picture_;
    QSize target_;
    QString headline_;
    QString advice_;
    QPoint pressed_;
    QPoint last_;
    bool dragging_ = false;
    int dragGesture_ = 0;
    int wheelGesture_ = 0;
    QElapsedTimer sinceWheel_;
};

} // namespace altiro3D::viewer
