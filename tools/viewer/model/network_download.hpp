#pragma once

#include "altiro3D/depth_network.hpp"

#include <QCryptographicHash>
#include <QNetworkAccessManager>
#include <QObject>
#include <QSaveFile>
#include <QTimer>
#include <QUrl>
#include <filesystem>
#include <memory>
#include <optional>

class QNetworkReply;

namespace altiro3D::viewer {

/// The depth network that is worth a download: the first of the catalogue that runs here and is not
/// large, unless it is installed. Nothing without address, size and SHA-256.
/// @throws Error as readModelCatalog()
std::optional<NetworkProfile> networkToDownload();

/// The user's folder for networks, where they are found; it need not exist.
std::filesystem::path networkFolder();

/// Downloads a network. Its file gets its name when all of it has come and has the SHA-256 of the
/// catalogue; nothing else is left behind.
class NetworkDownload : public QObject {
    Q_OBJECT
  public:
    /// Time without any data until it is given up.
    static constexpr int kPatienceMilliseconds = 30000;

    /// @param network with address, size and SHA-256 @param folder is made if it does not exist
    NetworkDownload(NetworkProfile network, std::filesystem::path folder,
                    QObject* parent = nullptr);
    ~NetworkDownload() override;

    /// Where it comes from. $ALTIRO3D_MODEL_BASE_URL replaces the place of the file, as for
    /// get-models.sh, for tests.
    QUrl address() const;
    std::filesystem::path file() const { return folder_ / network_.file; }

    /// Begins, again after an end.
    void start();
    bool isRunning() const { return reply_ != nullptr; }
    /// Stops, without ended().
    void cancel();

  signals:
    void progressed(qint64 bytes);
    /// @param problem one sentence; empty: the file is there
    void ended(const QString& problem);

  private:
    void take();
    void finish();
    void end(const QString& problem);

    NetworkProfile network_;
    std::filesystem::path folder_;
    QNetworkAccessManager manager_;
    QNetworkReply* reply_ = nullptr;
    std::unique_ptr<QSaveFile> part_;
    QCryptographicHash hash_{QCryptographicHash::Sha256};
    qint64 bytes_ = 0;
    QTimer patience_;
};

} // namespace altiro3D::viewer
