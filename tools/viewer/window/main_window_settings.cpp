// What the window keeps from run to run: its settings and the recent files.

#include "altiro3D/error.hpp"
#include "viewer/window/knob_panel.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/paint_bar.hpp"
#include "viewer/window/window_words.hpp"

#include <QAction>
#include <QFileInfo>
#include <QMenu>
#include <QSettings>
#include <algorithm>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxRecent = 10;
constexpr const char* kRecent = "recent";

// An enumerator from the settings file, which may contain anything.
template <class Word>
Word knownOr(Word standard, const QVariant& setting, std::initializer_list<Word> known) {
    bool isNumber = false;
    const int number = setting.toInt(&isNumber);
    const auto found = std::find_if(known.begin(), known.end(),
                                    [number](Word word) { return int(word) == number; });
    return isNumber && found != known.end() ? *found : standard;
}

} // namespace

void MainWindow::remember(const fs::path& file) {
    QSettings settings;
    QStringList recent = settings.value(kRecent).toStringList();
    const QString name = QFileInfo(toName(file)).absoluteFilePath();
    if (!recent.isEmpty() && recent.front() == name) return;
    recent.removeAll(name);
    recent.prepend(name);
    settings.setValue(kRecent, QStringList(recent.mid(0, kMaxRecent)));
    settings.setValue("folder", QFileInfo(name).absolutePath());
}

void MainWindow::fillRecent() {
    recent_->clear();
    for (const QString& name : QSettings().value(kRecent).toStringList()) {
        QString shown = QFileInfo(name).fileName();
        shown.replace("&", "&&");
        QAction* entry = recent_->addAction(shown);
        entry->setToolTip(tipOf(name));
        connect(entry, &QAction::triggered, this,
                [this, name] { controller_.open(std::vector<fs::path>{toPath(name)}); });
    }
    if (recent_->isEmpty()) recent_->addAction(tr("Nothing yet"))->setEnabled(false);
}

void MainWindow::readSettings() {
    const QSettings settings;
    Knobs knobs;
    ViewOptions& views = knobs.views;
    views.method = knownOr(views.method, settings.value("method"),
                           {ViewMethod::Fast, ViewMethod::Real, ViewMethod::Layered});
    views.strengthPercent = settings.value("strength", views.strengthPercent).toDouble();
    views.focus = settings.value("focus", views.focus).toDouble();
    knobs.fit = knownOr(knobs.fit, settings.value("fit"),
                        {FitMode::Cover, FitMode::Contain, FitMode::Stretch});
    const AutoChoices standard = knobs.automatic;
    knobs.automatic = {settings.value("autoFit", standard.framing).toBool() &&
                           knobs.fit == FitMode::Cover,
                       settings.value("autoFocus", standard.focus).toBool(),
                       settings.value("autoStrength", standard.strength).toBool(),
                       settings.value("limitStrength", standard.limit).toBool()};
    knobs.best = settings.value("best", knobs.best).toBool();
    knobs.depth =
        settings.value("depth", QString::fromStdString(knobs.depth)).toString().toStdString();
    try {
        validate(views); // the file may contain anything
        controller_.restoreKnobs(knobs);
    } catch (const Error&) {
        // then the defaults stay
    }
    knobs_->show(controller_.knobs());
    showLayout();
    controller_.setMode(knownOr(Mode::Sway, settings.value("mode"),
                                {Mode::Sway, Mode::Depth, Mode::Quilt, Mode::Native, Mode::Lens}));
    controller_.setSwinging(settings.value("swing", true).toBool());
    swing_->setChecked(controller_.isSwinging());
    showsStrip_->setChecked(settings.value("strip", true).toBool());
    follow_->setChecked(settings.value("follow", false).toBool());
    restoreGeometry(settings.value("geometry").toByteArray());
    restoreState(settings.value("state").toByteArray());
    paintBar_->hide();
    showStrip();
}

void MainWindow::writeSettings() const {
    QSettings settings;
    const Knobs& knobs = controller_.standardKnobs();
    settings.setValue("method", int(knobs.views.method));
    settings.setValue("strength", knobs.views.strengthPercent);
    settings.setValue("focus", knobs.views.focus);
    settings.setValue("fit", int(knobs.fit));
    settings.setValue("autoFit", knobs.automatic.framing);
    settings.setValue("autoFocus", knobs.automatic.focus);
    settings.setValue("autoStrength", knobs.automatic.strength);
    settings.setValue("limitStrength", knobs.automatic.limit);
    settings.setValue("best", knobs.best);
    settings.setValue("depth", QString::fromStdString(knobs.depth));
    settings.setValue("mode", int(controller_.mode()));
    settings.setValue("swing", swing_->isChecked());
    settings.setValue("strip", showsStrip_->isChecked());
    settings.setValue("follow", follow_->isChecked());
    settings.setValue("geometry", saveGeometry());
    settings.setValue("state", saveState());
}

} // namespace altiro3D::viewer
