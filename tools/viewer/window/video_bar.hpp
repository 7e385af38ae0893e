#pragma once

#include "viewer/model/files.hpp"

#include <QTimer>
#include <QWidget>

class QComboBox;
class QLabel;
class QSlider;
class QToolButton;

namespace altiro3D::viewer {

/// The bar below a video: play, position, sound and speed. It is hidden while no video is open;
/// its keys work while it is shown.
class VideoBar : public QWidget {
    Q_OBJECT
  public:
    /// @param files must outlive this
    explicit VideoBar(Files& files);

  private:
    void buildControls();
    void connectControls();
    void change(const std::function<void(PlaySettings&)>& what);
    void showVideo();    // whether there is one
    void showState();    // its position and tracks
    void showSettings(); // volume, speed, ...

    Files& files_;
    QToolButton* play_;
    QSlider* position_;
    QLabel* time_;
    QToolButton* mute_;
    QSlider* volume_;
    QComboBox* track_;
    QComboBox* speed_;
    QToolButton* loop_;
    QTimer ticks_;
    std::vector<int> tracks_; // stream indices, as in track_
};

/// A widget that holds a picture and the bar below it.
QWidget* withVideoBar(QWidget* picture, Files& files);

/// A time for people: "1:05", "1:02:03".
QString timeText(double seconds);

} // namespace altiro3D::viewer
