#include "viewer/window/network_dialog.hpp"

#include "video/video_run.hpp"
#include "viewer/window/window_words.hpp"

#include <QDialogButtonBox>
#include <QFormLayout>
#include <QProgressBar>
#include <QPushButton>
#include <QRegularExpression>

namespace altiro3D::viewer {

namespace {

QLabel* factLabel(const char* object, const QString& text) {
    auto* label = plainLabel(text, object);
    label->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
    return label;
}

QString sizeOf(double bytes) {
    return QString::fromStdString(tools::bytesText(bytes));
}

// Lets a long word be broken after every 32 characters; labels break lines at blanks only.
QString breakable(QString word) {
    const QString place(QChar(0x200B)); // to break, without a width
    return word.replace(QRegularExpression("(.{32})(?=.)"), "\\1" + place);
}

} // namespace

NetworkDialog::NetworkDialog(const NetworkProfile& network, const std::filesystem::path& folder,
                             QWidget* parent)
    : QDialog(parent), bytes_(static_cast<double>(network.bytes)), download_(network, folder),
      state_(factLabel("networkState", {})), bar_(new QProgressBar) {
    setObjectName("networkDialog");
    setWindowTitle(tr("Better depth"));
    setMinimumWidth(560);
    auto* words = plainLabel(
        tr("A larger network estimates depth more accurately, and takes longer. Nothing of your "
           "pictures leaves this computer: the network is downloaded once and then works "
           "without a connection."));
    auto* form = new QFormLayout;
    form->addRow(tr("Network"), factLabel("networkName", QString::fromStdString(network.name)));
    form->addRow(tr("Address"),
                 factLabel("networkAddress", breakable(download_.address().toString())));
    form->addRow(tr("Size"), factLabel("networkSize", sizeOf(bytes_)));
    form->addRow(tr("SHA-256"),
                 factLabel("networkHash", breakable(QString::fromStdString(network.sha256))));
    form->addRow(tr("Licence"),
                 factLabel("networkLicence", QString::fromStdString(network.licence)));
    form->addRow(tr("Kept in"), factLabel("networkFolder", breakable(toName(folder))));
    bar_->setRange(0, 1000);
    for (QWidget* later : std::initializer_list<QWidget*>{bar_, state_}) {
        QSizePolicy policy = later->sizePolicy(); // the dialog has room for them
        policy.setRetainSizeWhenHidden(true);
        later->setSizePolicy(policy);
        later->hide();
    }
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Cancel);
    begin_ = buttons->addButton(tr("Download"), QDialogButtonBox::ActionRole);
    begin_->setObjectName("download");
    begin_->setDefault(true);
    setLayout(boxOf<QVBoxLayout>(-1, words, form, bar_, state_, buttons));
    connect(begin_, &QPushButton::clicked, this, &NetworkDialog::start);
    connect(buttons, &QDialogButtonBox::rejected, this, &NetworkDialog::reject);
    connect(&download_, &NetworkDownload::progressed, this, &NetworkDialog::showProgress);
    connect(&download_, &NetworkDownload::ended, this, &NetworkDialog::end);
}

void NetworkDialog::start() {
    begin_->setEnabled(false);
    bar_->show();
    state_->show();
    showProgress(0);
    download_.start();
}

void NetworkDialog::showProgress(qint64 bytes) {
    const auto done = static_cast<double>(bytes);
    bar_->setValue(qRound(1000 * done / bytes_));
    state_->setText(tr("%1 of %2").arg(sizeOf(done), sizeOf(bytes_)));
}

void NetworkDialog::end(const QString& problem) {
    if (problem.isEmpty()) return accept();
    bar_->hide();
    state_->setText(problem);
    begin_->setText(tr("Try again"));
    begin_->setEnabled(true);
    adjustSize(); // the sentence may take several lines
}

void NetworkDialog::reject() {
    download_.cancel();
    QDialog::reject();
}

} // namespace altiro3D::viewer
