#include "viewer/show/eye_source.hpp"

#include "altiro3D/error.hpp"
#include "cli/run_tool.hpp"

#include <QNetworkDatagram>
#include <QSocketNotifier>
#include <algorithm>
#include <cmath>
#include <utility>

namespace altiro3D::viewer {

namespace {

constexpr int kLongestLine = 256;    // bytes
constexpr int kMostDatagrams = 1000; // at a time

} // namespace

quint16 eyePort(const std::string& text) {
    if (text == "stdin" && QSysInfo::kernelType() == "winnt")
        throw tools::UsageError("--view-from stdin is not read on Windows, expected udp:PORT");
    if (text == "stdin") return 0;
    const auto words = QString::fromStdString(text).split(':');
    const quint16 port = words.size() == 2 && words[0] == "udp" ? words[1].toUShort() : 0;
    if (port == 0)
        throw tools::UsageError("--view-from is " + text +
                                ", expected udp:PORT (1..65535) or stdin");
    return port;
}

EyeSource::EyeSource(quint16 port) {
    if (port == 0) {
        auto* const input = new QSocketNotifier(0, QSocketNotifier::Read, this);
        connect(input, &QSocketNotifier::activated, this, &EyeSource::readInput);
        input_.open(0, QIODevice::ReadOnly | QIODevice::Unbuffered);
        return;
    }
    connect(&socket_, &QUdpSocket::readyRead, this, &EyeSource::readPort);
    if (!socket_.bind(QHostAddress::LocalHost, port, QAbstractSocket::DontShareAddress))
        throw Error(ErrorCode::ReadFailed, "--view-from udp:" + std::to_string(port),
                    "cannot listen (" + socket_.errorString().toStdString() +
                        "), expected another port");
}

std::optional<double> EyeSource::positionOf(const QByteArray& line) {
    if (line.size() > kLongestLine) return std::nullopt;
    const QList<QByteArray> words = line.simplified().split(' ');
    bool isGood = words.size() <= 2;
    for (const QByteArray& word : words) {
        bool isNumber = false;
        isGood = std::isfinite(word.toDouble(&isNumber)) && isNumber && isGood;
    }
    if (!isGood) return std::nullopt;
    return std::clamp(words[0].toDouble(), -1.0, 1.0);
}

void EyeSource::readPort() {
    QByteArray lines;
    for (int i = 0; i < kMostDatagrams && socket_.hasPendingDatagrams(); ++i)
        lines += socket_.receiveDatagram().data() + '\n';
    take(lines);
}

void EyeSource::readInput() {
    char byte = '\n';
    if (!input_.getChar(&byte)) static_cast<QSocketNotifier*>(sender())->setEnabled(false);
    if (byte == '\n')
        take(std::exchange(line_, {}));
    else if (line_.size() <= kLongestLine) // one byte more, so that positionOf() refuses the line
        line_ += byte;
}

void EyeSource::take(const QByteArray& lines) {
    std::optional<double> newest;
    for (const QByteArray& line : lines.split('\n')) {
        if (line.isEmpty()) continue;
        const std::optional<double> position = positionOf(line);
        if (position) newest = position;
        ignored_ += position ? 0 : 1;
    }
    if (newest) emit moved(*newest);
}

} // namespace altiro3D::viewer
