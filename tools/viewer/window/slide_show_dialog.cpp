#include "viewer/window/slide_show_dialog.hpp"

#include "viewer/window/window_words.hpp"

#include <QCheckBox>
#include <QDialogButtonBox>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QPushButton>
#include <QRadioButton>
#include <QSettings>
#include <random>

namespace altiro3D::viewer {

SlideShowDialog::SlideShowDialog(std::size_t openFiles, QWidget* parent)
    : QDialog(parent), name_(new QLabel), each_(new QDoubleSpinBox) {
    setObjectName("slideShow");
    setWindowTitle(tr("Slide show"));
    const QSettings settings;
    auto* ofFiles = named(new QRadioButton(openFiles == 1 ? tr("The open file")
                                                          : tr("The %1 open files").arg(openFiles)),
                          "ofFiles", tr("The open files"));
    ofFolder_ = named(new QRadioButton(tr("All of a folder")), "ofFolder", tr("All of a folder"),
                      tr("Files that come into the folder are shown too."));
    const auto check = [&settings](const char* object, const QString& words, const char* key) {
        auto* box = named(new QCheckBox(words), object, words);
        box->setChecked(settings.value(key).toBool());
        return box;
    };
    shuffles_ = check("shuffles", tr("In random order"), "showShuffles");
    loops_ = check("loops", tr("Begin again after the last file"), "showLoops");
    named(each_, "each", tr("Seconds for each picture"),
          tr("How long a picture is shown. Videos are shown to their end."));
    each_->setRange(1, 3600);
    each_->setDecimals(0);
    each_->setSuffix(tr(" s"));
    each_->setValue(settings.value("showEach", SlideShow::Settings().each).toDouble());
    name_->setTextFormat(Qt::PlainText);
    auto* choose = named(new QPushButton(tr("Choose…")), "chooseFolder", tr("Choose a folder"));
    auto* form = new QFormLayout;
    form->addRow(tr("Seconds for each picture"), each_);
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel);
    buttons->button(QDialogButtonBox::Ok)->setText(tr("Show"));
    auto* words = plainLabel(tr("The files are shown on the display with the usual settings. "
                                "Escape ends the show."));
    setLayout(boxOf<QVBoxLayout>(-1, ofFiles, boxOf<QHBoxLayout>(1, ofFolder_, name_, choose), form,
                                 shuffles_, loops_, words, buttons));
    ofFiles->setEnabled(openFiles > 0);
    (openFiles > 0 ? ofFiles : ofFolder_)->setChecked(true);
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
