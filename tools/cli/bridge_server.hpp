#pragma once

#include <QHostAddress>
#include <QTcpServer>
#include <filesystem>
#include <map>
#include <string>

class QTcpSocket;

namespace altiro3D::tools {

/// Serves files to one computer while an event loop runs: GET and HEAD of random names, and nothing
/// else.
class BridgeServer {
  public:
    /// @param wanted address to bind, perhaps with a port; empty: `own`
    /// @param own address that reaches the peer @param peer the only one that is answered
    /// @throws UsageError, Error (the address cannot be bound)
    BridgeServer(const std::string& wanted, const QHostAddress& own, const QHostAddress& peer);

    /// Adds a file. @return its URI
    std::string add(const std::filesystem::path& file);
    /// "http://192.168.1.7:40123"
    std::string address() const;

  private:
    void answer(QTcpSocket& socket, const QByteArray& request) const;

    QTcpServer server_;
    QHostAddress peer_;
    std::string secret_;                                 // of the names
    std::map<std::string, std::filesystem::path> files_; // by their names
};

} // namespace altiro3D::tools
