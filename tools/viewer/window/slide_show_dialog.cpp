#include "viewer/window/slide_show_dialog.hpp"

#include "viewer/window/window_words.hpp"

#include <QCheckBox>
#include <QDialogButtonBox>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QRadioButton>
#include <QSettings>
#include <QVBoxLayout>
#include <random>

namespace altiro3D::viewer {

SlideShowDialog::SlideShowDialog(std::size_t openFiles, QWidget* parent)
    : QDialog(parent),
      ofFiles_(new QRadioButton(openFiles == 1 ? tr("The open file")
                                               : tr("The %1 open files").arg(openFiles))),
      ofFolder_(new QRadioButton(tr("All of a folder"))), name_(new QLabel),
      each_(new QDoubleSpinBox), shuffles_(new QCheckBox(tr("In random order"))),
      loops_(new QCheckBox(tr("Begin again after the last file"))) {
    setObjectName("slideShow");
    setWindowTitle(tr("Slide show"));
    const QSettings settings;
    named(ofFiles_, "ofFiles", tr("The open files"));
    named(ofFolder_, "ofFolder", tr("All of a folder"),
          tr("Files that come into the folder are shown too."));
    named(each_, "each", tr("Seconds for each picture"),
          tr("How long a picture is shown. Videos are shown to their end."));
    named(shuffles_, "shuffles", tr("In random order"));
    named(loops_, "loops", tr("Begin again after the last file"));
    each_->setRange(1, 3600);
    each_->setDecimals(0);
    each_->setSuffix(tr(" s"));
    each_->setValue(settings.value("showEach", SlideShow::Settings().each).toDouble());
    shuffles_->setChecked(settings.value("showShuffles").toBool());
    loops_->setChecked(settings.value("showLoops").toBool());
    name_->setTextFormat(Qt::PlainText);
    auto* choose = named(new QPushButton(tr("Choose…")), "chooseFolder", tr("Choose a folder"));
    auto* row = new QHBoxLayout;
    row->addWidget(ofFolder_);
    row->addWidget(name_, 1);
    row->addWidget(choose);
    auto* form = new QFormLayout;
    form->addRow(tr("Seconds for each picture"), each_);
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel);
    buttons->button(QDialogButtonBox::Ok)->setText(tr("Show"));
    auto* words = new QLabel(tr("The files are shown on the display with the usual settings. "
                                "Escape ends the show."));
    words->setWordWrap(true);
    auto* column = new QVBoxLayout(this);
    column->addWidget(ofFiles_);
    column->addLayout(row);
    column->addLayout(form);
    column->addWidget(shuffles_);
    column->addWidget(loops_);
    column->addWidget(words);
    column->addWidget(buttons);
    ofFiles_->setEnabled(openFiles > 0);
    (openFiles > 0 ? ofFiles_ : ofFolder_)->setChecked(true);
    showFolder(settings.value("showFolder").toString());
    connect(choose, &QPushButton::clicked, this, &SlideShowDialog::chooseFolder);
    connect(buttons, &QDialogButtonBox::accepted, this, &SlideShowDialog::accept);
    connect(buttons, &QDialogButtonBox::rejected, this, &SlideShowDialog::reject);
}

void SlideShowDialog::showFolder(const QString& folder) {
    folder_ = folder;
    name_->setText(QFileInfo(folder).fileName());
    name_->setToolTip(tipOf(folder));
}

void SlideShowDialog::chooseFolder() {
    const QString name = QFileDialog::getExistingDirectory(this, tr("Folder to show"), folder_);
    if (name.isEmpty()) return;
    showFolder(name);
    ofFolder_->setChecked(true);
}

QString SlideShowDialog::folder() const {
    return ofFolder_->isChecked() ? folder_ : QString();
}

SlideShow::Settings SlideShowDialog::settings() const {
    SlideShow::Settings settings;
    settings.each = each_->value();
    settings.shuffles = shuffles_->isChecked();
    settings.loops = loops_->isChecked();
    settings.seed = std::random_device()();
    return settings;
}

void SlideShowDialog::accept() {
    if (ofFolder_->isChecked() && folder_.isEmpty()) return chooseFolder();
    QSettings settings;
    settings.setValue("showEach", each_->value());
    settings.setValue("showShuffles", shuffles_->isChecked());
    settings.setValue("showLoops", loops_->isChecked());
    settings.setValue("showFolder", folder_);
    QDialog::accept();
}

} // namespace altiro3D::viewer
