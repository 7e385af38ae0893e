#include "cli/bridge_server.hpp"

#include "altiro3D/error.hpp"
#include "cli/command_line.hpp"
#include "cli/outputs.hpp"

#include <QFile>
#include <QNetworkProxy>
#include <QRandomGenerator>
#include <QTcpSocket>
#include <QUrl>
#include <memory>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr qint64 kMaxRequestBytes = 8192;
constexpr qint64 kPortionBytes = 1 << 18;

// Sends a file in portions as the socket takes them.
void send(QTcpSocket& socket, const std::shared_ptr<QFile>& file) {
    const auto more = [&socket, file] {
        while (socket.bytesToWrite() < kPortionBytes) {
            const QByteArray portion = file->read(kPortionBytes);
            if (portion.isEmpty()) return socket.disconnectFromHost();
            socket.write(portion);
        }
    };
    QObject::connect(&socket, &QTcpSocket::bytesWritten, &socket, more);
    more();
}

} // namespace

BridgeServer::BridgeServer(const std::string& wanted, const QHostAddress& own,
                           const QHostAddress& peer)
    : peer_(peer) {
    QHostAddress address = own;
    int port = 0; // any
    if (!wanted.empty()) {
        const QUrl url("http://" + QString::fromStdString(wanted), QUrl::StrictMode);
        address = QHostAddress(url.host());
        port = url.port(0);
        if (!url.isValid() || address.isNull())
            throw UsageError("--serve is " + wanted +
                             ", expected an address of this computer, perhaps with :PORT");
    }
    server_.setProxy(QNetworkProxy::NoProxy);
    if (!server_.listen(address, static_cast<quint16>(port)))
        throw Error(ErrorCode::WriteFailed, address.toString().toStdString(),
                    "cannot serve files (" + server_.errorString().toStdString() +
                        "), expected an address of this computer (--serve)");
    quint32 random[4];
    QRandomGenerator::system()->fillRange(random);
    for (const quint32 part : random)
        secret_ += QString::number(part, 16).rightJustified(8, '0').toStdString();
    QObject::connect(&server_, &QTcpServer::newConnection, &server_, [this] {
        while (QTcpSocket* const socket = server_.nextPendingConnection()) {
            QObject::connect(socket, &QTcpSocket::disconnected, socket, &QObject::deleteLater);
            if (!socket->peerAddress().isEqual(peer_, QHostAddress::TolerantConversion)) {
                socket->abort();
                continue;
            }
            auto request = std::make_shared<QByteArray>();
            QObject::connect(socket, &QTcpSocket::readyRead, socket, [this, socket, request] {
                const bool isAnswered = request->contains("\r\n\r\n");
                *request += socket->read(kMaxRequestBytes);
                if (isAnswered) return;
                if (request->contains("\r\n\r\n")) return answer(*socket, *request);
                if (request->size() >= kMaxRequestBytes) socket->abort();
            });
        }
    });
}

std::string BridgeServer::address() const {
    QUrl url;
    url.setScheme("http");
    url.setHost(server_.serverAddress().toString());
    url.setPort(server_.serverPort());
    return url.toString().toStdString();
}

std::string BridgeServer::add(const fs::path& file) {
    const std::string name = "/" + secret_ + "/" + std::to_string(files_.size() + 1) + "_" +
                             inFileName(file.filename().string());
    files_[name] = file;
    return address() + name;
}

void BridgeServer::answer(QTcpSocket& socket, const QByteArray& request) const {
    const QList<QByteArray> words = request.left(request.indexOf("\r\n")).split(' ');
    const bool isHead = words[0] == "HEAD";
    const auto found = words.size() == 3 && (isHead || words[0] == "GET")
                           ? files_.find(words[1].toStdString())
                           : files_.end();
    std::shared_ptr<QFile> file;
    if (found != files_.end())
        file = std::make_shared<QFile>(QFile::decodeName(found->second.string().c_str()));
    if (!file || !file->open(QIODevice::ReadOnly)) {
        socket.write("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
        return socket.disconnectFromHost();
    }
    socket.write("HTTP/1.1 200 OK\r\nContent-Type: application/octet-stream\r\nContent-Length: " +
                 QByteArray::number(file->size()) + "\r\nConnection: close\r\n\r\n");
    if (isHead) return socket.disconnectFromHost();
    send(socket, file);
}

} // namespace altiro3D::tools
