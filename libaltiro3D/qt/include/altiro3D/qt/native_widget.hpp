#pragma once

#include "altiro3D/export.hpp"

#include <QImage>
#include <QWidget>
#include <opencv2/core/mat.hpp>

class QScreen;

namespace altiro3D::qt {

/// Shows a Native with one px of the picture on one px of the screen, whatever the desktop's scale:
/// no scaling, no smoothing. What is larger than the widget is cut off on both sides alike, what is
/// smaller stands in the middle on black.
class ALTIRO3D_EXPORT NativeWidget : public QWidget {
    Q_OBJECT
  public:
    /// An empty, black widget.
    /// @param parent owns it; null: a window of its own
    explicit NativeWidget(QWidget* parent = nullptr);

    /// Shows a picture; its memory is shared, so do not write into it afterwards.
    /// @param native [rows x cols, CV_8UC3, BGR]; empty: black
    /// @throws Error InvalidArgument (type)
    void setNative(const cv::Mat& native);
    /// The picture that is shown. @return shares memory with it; null if there is none
    const QImage& image() const { return image_; }

    /// The widget's size. @return width x height in px of the screen
    QSize deviceSize() const;
    /// The picture fills the widget exactly, so a display with this Native shows it rightly.
    /// @return true if it does
    bool isExact() const { return image_.size() == deviceSize(); }

    /// Goes full screen on one screen, without frame and mouse pointer. Escape, F11 and a double
    /// click end it by leave().
    /// @param screen one of QGuiApplication::screens()
    void showOn(QScreen& screen);

  public slots:
    /// Hides it and says so.
    void leave();

  signals:
    /// The user has left the full screen.
    void left();

  protected:
    /// Paints the picture. @param event not read
    void paintEvent(QPaintEvent* event) override;
    /// Escape and F11. @param event the key
    void keyPressEvent(QKeyEvent* event) override;
    /// Leaves the full screen. @param event the click
    void mouseDoubleClickEvent(QMouseEvent* event) override;

  private:
    QImage image_;
};

} // namespace altiro3D::qt
