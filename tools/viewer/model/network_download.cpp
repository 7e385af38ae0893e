#include "viewer/model/network_download.hpp"

#include "altiro3D/version.hpp"
#include "cli/run_tool.hpp"
#include "viewer/model/knobs.hpp"

#include <QDir>
#include <QFile>
#include <QNetworkProxyFactory>
#include <QNetworkReply>
#include <utility>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

QString nameOf(const fs::path& path) {
    return QFile::decodeName(path.string().c_str());
}

} // namespace

std::optional<NetworkProfile> networkToDownload() {
    for (const NetworkProfile& network : modelCatalog()) {
        if (network.large || !canRun(network)) continue;
        const bool isHere = !findModelFile(network.file, modelSearchPath()).empty();
        if (isHere || network.url.empty() || network.bytes == 0 || network.sha256.empty())
            return std::nullopt; // of those after it none is better
        return network;
    }
    return std::nullopt;
}

fs::path networkFolder() {
    return KnobStore::standardFile().parent_path() / "models";
}

NetworkDownload::NetworkDownload(NetworkProfile network, fs::path folder, QObject* parent)
    : QObject(parent), network_(std::move(network)), folder_(std::move(folder)) {
    patience_.setSingleShot(true);
    patience_.setInterval(kPatienceMilliseconds);
    connect(&patience_, &QTimer::timeout, this,
            [this] { end(tr("The server does not answer any more; try again later")); });
}

NetworkDownload::~NetworkDownload() {
    cancel();
}

QUrl NetworkDownload::address() const {
    const auto base = tools::environment("ALTIRO3D_MODEL_BASE_URL");
    return QUrl(QString::fromStdString(base ? *base + "/" + network_.file : network_.url));
}

void NetworkDownload::start() {
    if (isRunning()) return;
    QDir().mkpath(nameOf(folder_));
    part_ = std::make_unique<QSaveFile>(nameOf(file()));
    if (!part_->open(QIODevice::WriteOnly))
        return end(tr("%1 cannot be written: %2").arg(nameOf(file()), part_->errorString()));
    hash_.reset();
    bytes_ = 0;
    QNetworkProxyFactory::setUseSystemConfiguration(true);
    QNetworkRequest request(address());
    request.setHeader(QNetworkRequest::UserAgentHeader, QString("altiro3D/") + version());
    request.setAttribute(QNetworkRequest::RedirectPolicyAttribute,
                         QNetworkRequest::NoLessSafeRedirectPolicy);
    request.setRawHeader("Accept-Encoding", "identity"); // the bytes as they are
    reply_ = manager_.get(request);
    connect(reply_, &QNetworkReply::readyRead, this, &NetworkDownload::take);
    connect(reply_, &QNetworkReply::finished, this, &NetworkDownload::finish);
    patience_.start();
}

void NetworkDownload::take() {
    patience_.start();
    const int status = reply_->attribute(QNetworkRequest::HttpStatusCodeAttribute).toInt();
    const QByteArray data = reply_->readAll();
    if (status != 200) return; // the page of an error
    bytes_ += data.size();
    if (bytes_ > static_cast<qint64>(network_.bytes))
        return end(tr("The server has another, larger file; nothing was kept"));
    hash_.addData(data);
    if (part_->write(data) != data.size())
        return end(tr("%1 cannot be written: %2").arg(nameOf(file()), part_->errorString()));
    emit progressed(bytes_);
}

void NetworkDownload::finish() {
    take();
    if (!isRunning()) return;
    const int status = reply_->attribute(QNetworkRequest::HttpStatusCodeAttribute).toInt();
    const bool isWhole = bytes_ == static_cast<qint64>(network_.bytes);
    if (status >= 400)
        return end(tr("The server refused the file (status %1); try again later").arg(status));
    if (bytes_ > 0 && !isWhole)
        return end(tr("The connection ended before all of the file had come; try again"));
    if (reply_->error() != QNetworkReply::NoError || status != 200)
        return end(tr("%1 cannot be reached: %2. To do it by hand, open %3 with a browser, on any "
                      "computer, and save the file as %4")
                       .arg(reply_->url().host(), reply_->errorString(), address().toString(),
                            nameOf(file())));
    if (hash_.result().toHex().toStdString() != network_.sha256)
        return end(tr("What came is not the file of the list (its SHA-256 differs); nothing was "
                      "kept"));
    if (!part_->commit())
        return end(tr("%1 cannot be written: %2").arg(nameOf(file()), part_->errorString()));
    end({});
}

void NetworkDownload::cancel() {
    patience_.stop();
    part_.reset(); // removes what is not complete
    if (QNetworkReply* const reply = std::exchange(reply_, nullptr)) {
        reply->disconnect(this);
        reply->abort();
        reply->deleteLater();
    }
}

void NetworkDownload::end(const QString& problem) {
    cancel();
    emit ended(problem);
}

} // namespace altiro3D::viewer
