#include "common/display_player.hpp"

#include "altiro3D/error.hpp"
#include "common/run_tool.hpp"

#include <QCoreApplication>
#include <QFile>
#include <opencv2/imgproc.hpp>
#include <string>

namespace altiro3D::tools {

DisplayPlayer::DisplayPlayer(const CommandLine& commandLine, const ChosenDisplay& display) {
    QStringList arguments{"--show", "-"};
    if (!display.isMapOnly && !display.files.empty()) { // behind the map, if there is one
        arguments << "-c" << QFile::decodeName(display.files.back().c_str());
    }
    for (const char* option : {"serial", "screen"}) {
        if (const auto value = commandLine.value(option)) {
            arguments << QString("--") + option << QString::fromLocal8Bit(value->c_str());
        }
    }
    viewer_.setProcessChannelMode(QProcess::ForwardedChannels);
    viewer_.start(QCoreApplication::applicationDirPath() + "/altiro3Dview", arguments);
    if (!viewer_.waitForStarted()) {
        throw Error(ErrorCode::NotFound, "altiro3Dview",
                    "cannot be started, expected it beside video2native");
    }
}

bool DisplayPlayer::show(const cv::Mat& native) {
    const std::string head =
        "P6\n" + std::to_string(native.cols) + " " + std::to_string(native.rows) + "\n255\n";
    cv::cvtColor(native, rgb_, cv::COLOR_BGR2RGB);
    const auto bytes = static_cast<qint64>(rgb_.total() * rgb_.elemSize());
    viewer_.write(head.data(), static_cast<qint64>(head.size()));
    viewer_.write(reinterpret_cast<const char*>(rgb_.data), bytes);
    while (viewer_.state() == QProcess::Running && viewer_.bytesToWrite() > 0)
        viewer_.waitForBytesWritten(100);
    return viewer_.state() == QProcess::Running;
}

int DisplayPlayer::end() {
    viewer_.closeWriteChannel();
    viewer_.waitForFinished(-1);
    if (viewer_.exitStatus() == QProcess::NormalExit) return viewer_.exitCode();
    return kCrashed;
}

} // namespace altiro3D::tools
