#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/qt/display_search.hpp"

#include <QImage>
#include <QWidget>
#include <opencv2/core/mat.hpp>

class QScreen;

namespace altiro3D::qt {

/// Shows a Native with one px of the picture on one px of the screen, independent of the desktop's
/// scale: no scaling, no smoothing. A picture larger than the widget is cropped equally on both
/// sides, a smaller one is centred on black.
class ALTIRO3D_EXPORT NativeWidget : public QWidget {
    Q_OBJECT
  public:
    /// An empty, black widget. @param parent owner; null: a top-level window
    explicit NativeWidget(QWidget* parent = nullptr);

    /// Shows a picture. Its memory is shared, so do not write to it afterwards.
    /// @param native [rows x cols, CV_8UC3, BGR]; empty: black
    /// @throws Error InvalidArgument (type)
    void setNative(const cv::Mat& native);
    /// The picture shown. @return an image that shares its memory; null if there is none
    [[nodiscard]] const QImage& image() const { return image_; }

    /// The widget's size. @return width x height in px of the screen
    [[nodiscard]] QSize deviceSize() const;
    /// Whether the picture fills the widget exactly, as required to show a Native correctly.
    /// @return true if it does
    [[nodiscard]] bool isExact() const { return image_.size() == deviceSize(); }

    /// Shows the widget full screen on one screen, without frame and mouse pointer. Escape, F11 and
    /// a double click call leave(). If the screen is disconnected, the widget hides, because the
    /// desktop would move it to another screen; it comes back with the screen.
    /// @param screen one of QGuiApplication::screens()
    void showOn(QScreen& screen);

  public slots:
    /// Hides the widget and emits left().
    void leave();

  signals:
    /// Full screen has ended.
    void left();

  protected:
    /// Paints the picture. @param event not used
    void paintEvent(QPaintEvent* event) override;
    /// Handles Escape and F11. @param event the key
    void keyPressEvent(QKeyEvent* event) override;
    /// Leaves the full screen. @param event the click
    void mouseDoubleClickEvent(QMouseEvent* event) override;
    /// Emits left(). @param event accepted
    void closeEvent(QCloseEvent* event) override;

  private:
    QImage image_;
    ScreenFacts screen_; // the screen of showOn(); no size after left()
};

} // namespace altiro3D::qt
