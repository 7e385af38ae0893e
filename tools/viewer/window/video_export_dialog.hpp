#pragma once

#include "viewer/model/video_export.hpp"

#include <QDialog>

class QLabel;
class QProgressBar;
class QPushButton;

namespace altiro3D::viewer {

/// Shows how far an export of a video is. The window behind it can be used.
class VideoExportDialog : public QDialog {
    Q_OBJECT
  public:
    /// @param file that is written
    VideoExportDialog(const QString& file, QWidget* parent);

    void tell(const VideoExportState& state);

    void reject() override; ///< As Cancel: Escape, or the window's cross.

  signals:
    void cancelWanted();

  private:
    QLabel* time_;
    QLabel* left_;
    QLabel* size_;
    QProgressBar* bar_;
    QPushButton* cancel_;
};

} // namespace altiro3D::viewer
