#pragma once

#include "common/display_options.hpp"

#include <QProcess>
#include <opencv2/core/mat.hpp>

namespace altiro3D::tools {

/// Shows Natives on the display with altiro3Dview, which is installed beside the tool.
class DisplayPlayer {
  public:
    /// Reads --serial and --screen. @throws Error
    DisplayPlayer(const CommandLine& commandLine, const ChosenDisplay& display);

    /// Sends a Native to the viewer and waits until all of it is written.
    /// @param native [rows x cols, CV_8UC3, BGR]
    /// @return false if the viewer has ended
    bool show(const cv::Mat& native);
    /// Result of end() if a signal ended the viewer.
    static constexpr int kCrashed = -1;
    /// Waits until the viewer has ended. @return its exit status, or kCrashed
    int end();

  private:
    QProcess viewer_;
    cv::Mat rgb_;
};

} // namespace altiro3D::tools
