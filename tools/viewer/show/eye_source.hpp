#pragma once

#include <QFile>
#include <QObject>
#include <QUdpSocket>
#include <optional>
#include <string>

namespace altiro3D::viewer {

/// `--view-from udp:PORT|stdin`. @return the port; 0: standard input @throws UsageError
quint16 eyePort(const std::string& text);

/// Positions of a viewer, as another program writes them: one line of text at a time, x or x and y.
/// x is -1 at the left edge of the view cone, as the viewer sees it, and +1 at the right edge.
class EyeSource : public QObject {
    Q_OBJECT
  public:
    /// @throws Error ReadFailed (the port is taken)
    explicit EyeSource(quint16 port);
    /// Lines that were no position so far.
    int ignoredLines() const { return ignored_; }
    /// The x of a line, limited to -1..+1; nothing if the line is no position.
    static std::optional<double> positionOf(const QByteArray& line);

  signals:
    /// A position has come. Of datagrams that come at once, only the newest one is told.
    void moved(double x);

  private:
    void readPort();
    void readInput();
    void take(const QByteArray& lines);

    QUdpSocket socket_;
    QFile input_;
    QByteArray line_; // of standard input
    int ignored_ = 0;
};

} // namespace altiro3D::viewer
