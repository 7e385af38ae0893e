#include "viewer/window/video_export_dialog.hpp"

#include "video/video_run.hpp"
#include "viewer/window/video_bar.hpp"
#include "viewer/window/window_words.hpp"

#include <QDialogButtonBox>
#include <QFormLayout>
#include <QProgressBar>
#include <QPushButton>

namespace altiro3D::viewer {

VideoExportDialog::VideoExportDialog(const QString& file, QWidget* parent)
    : QDialog(parent), bar_(new QProgressBar) {
    setObjectName("videoExport");
    setWindowTitle(tr("Export video"));
    setAttribute(Qt::WA_DeleteOnClose);
    bar_->setRange(0, 0); // busy, until the first picture is made
    auto* form = new QFormLayout;
    const auto add = [form](const char* object, const QString& words, const QString& begin) {
        auto* label = named(new QLabel(begin), object, words);
        form->addRow(words, label);
        return label;
    };
    time_ = add("videoTime", tr("Made so far"), tr("Starting…"));
    left_ = add("videoLeft", tr("Time left"), tr("–"));
    size_ = add("videoSize", tr("Size of the file"), tr("–"));
    auto* buttons = new QDialogButtonBox;
    cancel_ = buttons->addButton(QDialogButtonBox::Cancel);
    named(cancel_, "cancelVideo", tr("Cancel"),
          tr("What is made so far is kept: export to the same name to go on later."));
    setLayout(boxOf<QVBoxLayout>(-1, plainLabel(file), bar_, form, buttons));
    setMinimumWidth(420);
    connect(buttons, &QDialogButtonBox::rejected, this, &VideoExportDialog::reject);
}

void VideoExportDialog::tell(const VideoExportState& state) {
    if (state.finishing) {
        bar_->setRange(0, 0);
        time_->setText(tr("Finishing the file…"));
        left_->setText(tr("–"));
        cancel_->setEnabled(false);
        return;
    }
    if (state.length) {
        bar_->setRange(0, 1000);
        bar_->setValue(qRound(1000 * state.share));
    }
    QString time = timeText(state.end);
    if (state.length) time = tr("%1 of %2").arg(time, timeText(*state.length));
    time_->setText(
        tr("%1, %2 pictures per second").arg(time).arg(state.framesPerSecond, 0, 'f', 1));
    if (state.secondsLeft) left_->setText(tr("about %1").arg(timeText(*state.secondsLeft)));
    if (state.bytes)
        size_->setText(tr("about %1").arg(QString::fromStdString(tools::bytesText(*state.bytes))));
}

void VideoExportDialog::reject() {
    if (!cancel_->isEnabled()) return;
    cancel_->setEnabled(false);
    left_->setText(tr("Stopping…"));
    emit cancelWanted();
}

} // namespace altiro3D::viewer
