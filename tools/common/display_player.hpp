#pragma once

#include "common/display_options.hpp"

#include <QProcess>
#include <opencv2/core/mat.hpp>

namespace altiro3D::tools {

/// Shows Natives on the display through altiro3Dview, which stands beside the tool.
class DisplayPlayer {
  public:
    /// Reads --serial and --screen. @throws Error
    DisplayPlayer(const CommandLine& commandLine, const ChosenDisplay& display);

    /// Shows a Native, when the viewer has taken those before. [rows x cols, CV_8UC3, BGR]
    /// @return false if the user has left
    bool show(const cv::Mat& native);
    /// What end() gives for a viewer that a signal has ended.
    static constexpr int kCrashed = -1;
    /// Waits until the viewer has ended; its exit status.
    int end();

  private:
    QProcess viewer_;
    cv::Mat rgb_;
};

} // namespace altiro3D::tools
