#pragma once

#include "viewer/model/network_download.hpp"

#include <QDialog>

class QLabel;
class QProgressBar;
class QPushButton;

namespace altiro3D::viewer {

/// Offers to download a depth network: says what would be downloaded, from where and under which
/// licence, then shows how far it is. It is accepted when the network is installed.
class NetworkDialog : public QDialog {
    Q_OBJECT
  public:
    /// @param network from networkToDownload() @param folder for its file
    NetworkDialog(const NetworkProfile& network, const std::filesystem::path& folder,
                  QWidget* parent);

    void reject() override; ///< Cancels the download.

  private:
    void start();
    void end(const QString& problem);
    void showProgress(qint64 bytes);

    double bytes_;
    NetworkDownload download_;
    QLabel* state_;
    QProgressBar* bar_;
    QPushButton* begin_;
};

} // namespace altiro3D::viewer
