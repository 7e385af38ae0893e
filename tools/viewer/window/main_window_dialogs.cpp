// The window's dialogs: files, calibrations, exports, displays.

#include "altiro3D/depth_network.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/page.hpp"
#include "altiro3D/qt/display_search.hpp"
#include "altiro3D/qt/native_widget.hpp"
#include "cli/folders.hpp"
#include "cli/run_tool.hpp"
#include "video/video_run.hpp"
#include "viewer/show/presentation.hpp"
#include "viewer/show/slide_presenter.hpp"
#include "viewer/window/knob_panel.hpp"
#include "viewer/window/lens_by_eye_dialog.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/manual.hpp"
#include "viewer/window/network_dialog.hpp"
#include "viewer/window/picture_view.hpp"
#include "viewer/window/slide_show_dialog.hpp"
#include "viewer/window/video_bar.hpp"
#include "viewer/window/video_export_dialog.hpp"
#include "viewer/window/window_words.hpp"

#include <QActionGroup>
#include <QBoxLayout>
#include <QFileDialog>
#include <QGuiApplication>
#include <QInputDialog>
#include <QProgressBar>
#include <QRegularExpression>
#include <QSettings>
#include <QToolButton>
#include <utility>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

bool agrees(QWidget* parent, const QString& title, const QString& question) {
    QMessageBox box(QMessageBox::Warning, title, question, QMessageBox::Yes | QMessageBox::No,
                    parent);
    box.setTextFormat(Qt::PlainText);
    box.setDefaultButton(QMessageBox::No);
    return box.exec() == QMessageBox::Yes;
}

// Asks for a file to write; its format is the chosen one if no other is typed. Empty: none.
fs::path fileToSave(QWidget* parent, const QString& title, const fs::path& proposed,
                    const char* formats) {
    QFileDialog dialog(parent, title, toName(proposed.parent_path()));
    dialog.setAcceptMode(QFileDialog::AcceptSave);
    if (*formats != '\0') {
        const auto useFormat = [&dialog](const QString& format) {
            dialog.setDefaultSuffix(
                format.section("*.", 1).section(QRegularExpression("\\W"), 0, 0));
        };
        dialog.setNameFilters(QObject::tr(formats).split(";;"));
        QObject::connect(&dialog, &QFileDialog::filterSelected, &dialog, useFormat);
        useFormat(dialog.selectedNameFilter());
    }
    dialog.selectFile(toName(proposed.filename()));
    return dialog.exec() == QDialog::Accepted ? toPath(dialog.selectedFiles().value(0))
                                              : fs::path();
}

} // namespace

void MainWindow::openDialog() {
    QStringList patterns = {"*.ply", "*.splat", "*.spz"};
    for (const auto* endings : {&imageExtensions(), &tools::videoEndings()})
        for (const std::string& ending : *endings) // contents decide, also of other names
            patterns << "*" + QString::fromStdString(ending);
    std::vector<fs::path> files;
    for (const QString& name : QFileDialog::getOpenFileNames(
             this, tr("Open"), QSettings().value("folder").toString(),
             tr("Pictures, videos and splats (%1);;All files (*)").arg(patterns.join(' '))))
        files.push_back(toPath(name));
    open(files);
}

void MainWindow::openDirectoryDialog() {
    const QString name = QFileDialog::getExistingDirectory(this, tr("Open a folder"),
                                                           QSettings().value("folder").toString());
    if (!name.isEmpty()) open({toPath(name)});
}

void MainWindow::openDepthDialog() {
    const auto& document = files_.document();
    if (!document || document->video) return;
    const QString name = QFileDialog::getOpenFileName(this, tr("Depth image, near is white"),
                                                      toName(document->source.file.parent_path()));
    if (!name.isEmpty()) files_.reopen(Reading::Photo, toPath(name));
}

void MainWindow::showNetworks() {
    try {
        knobs_->showNetworks(networkToDownload().has_value());
    } catch (const Error&) {
        knobs_->showNetworks(false); // its list tells why
    }
}

void MainWindow::betterDepthDialog() {
    const QString title = tr("Better depth");
    try {
        const std::optional<NetworkProfile> network = networkToDownload();
        if (!network) {
            const auto best = standardNetwork();
            QMessageBox::information(
                this, title,
                best ? tr("The best depth network for this computer is installed already: %1")
                           .arg(QString::fromStdString(best->profile.name))
                     : tr("No depth network is known that could be downloaded"));
            return;
        }
        NetworkDialog dialog(*network, networkFolder(), this);
        if (dialog.exec() != QDialog::Accepted) return;
        stage_.findNetworks();
        showNetworks();
        if (const auto& document = files_.document();
            document && document->kind == Kind::Scene && settings_.knobs().depth != kGivenDepth) {
            Knobs knobs = settings_.knobs();
            knobs.depth = kBestDepth; // a photo's own depth takes precedence
            settings_.turn(knobs, tr("depth"));
        }
        say(tr("The network %1 is installed and used").arg(QString::fromStdString(network->name)),
            15000);
    } catch (const std::exception& error) {
        warn(this, title, error);
    }
}

void MainWindow::calibrationDialog() {
    const QString name =
        QFileDialog::getOpenFileName(this, tr("Calibration of the display"), {},
                                     tr("Calibrations (visual.json *.json);;All files (*)"));
    if (name.isEmpty()) return;
    try {
        refusePipe(toPath(name));
        useCalibration(readCalibration(toPath(name)), toPath(name));
    } catch (const std::exception& error) {
        warn(this, tr("Calibration"), error);
    }
}

void MainWindow::useCalibration(const Calibration& calibration, const fs::path& file) {
    const Display& before = *files_.display();
    Display display = displayOf(calibration, file.string());
    display.invert = before.invert;
    // a quilt that was chosen (-q, -r) stays, where it is for such a panel
    if (display.panelSize() == before.panelSize() &&
        before.quilt != defaultQuilt(before.calibration))
        display.quilt = before.quilt;
    files_.setDisplay(std::move(display));
}

bool MainWindow::chooseEyes() {
    QStringList names;
    for (const QAction* entry : eyesPictures_->actions())
        names << entry->text();
    bool chosen = false;
    const QString name = QInputDialog::getItem(
        this, tr("Export %1").arg(nameOf(Product::Eyes)), tr("Layout of the two pictures"), names,
        names.indexOf(eyesPictures_->checkedAction()->text()), false, &chosen);
    if (chosen) eyesPictures_->actions()[names.indexOf(name)]->trigger();
    return chosen;
}

void MainWindow::exportDialog(Product product) {
    if (const QString why = exports_.obstacle(); !why.isEmpty()) return say(why, 10000);
    if (product == Product::Eyes && !chooseEyes()) return;
    fs::path from = files_.document()->source.file;
    if (!from.has_filename()) from = from.parent_path();
    const std::string ending = product == Product::Eyes ? tools::eyesEnding(stage_.eyes())
                                                        : entryOf(kProducts, product).ending;
    fs::path proposed = from.parent_path() / (from.stem().string() + ending);
    try {
        proposed = productFile(exports_.setup(), product, proposed);
    } catch (const Error&) {
        // the name tells another layout: the user will think of one
    }
    const QString title = tr("Export %1").arg(nameOf(product));
    const fs::path typed = fileToSave(this, title, proposed, entryOf(kProducts, product).formats);
    if (typed.empty()) return;
    if (const QString why = exports_.obstacle(); !why.isEmpty())
        return say(why, 10000); // a video may have changed meanwhile
    if (product != Product::Views && product != Product::SwayVideo && product != Product::Page &&
        !canWriteImage(typed))
        return warn(this, title,
                    tr("%1: no picture format is known by this extension, expected .png")
                        .arg(toName(typed)));
    if (product == Product::Page && !isPageFileName(typed))
        return warn(this, title,
                    tr("%1: is not the name of a page, expected .html").arg(toName(typed)));
    fs::path file;
    try {
        file = productFile(exports_.setup(), product, typed);
    } catch (const Error& error) {
        return warn(this, title, error);
    }
    // the dialog has asked about the name that was typed only
    if (file != typed && tools::isThere(file) &&
        !agrees(this, title, tr("%1 exists already. Replace it?").arg(toName(file))))
        return;
    for (const std::string& loss : lossesOf(product, file)) {
        if (!agrees(this, title, tr("%1. Write it anyway?").arg(QString::fromStdString(loss))))
            return;
    }
    if (exports_.start(product, file)) showProgress(true);
}

void MainWindow::showProgress(bool runs) {
    progress_->setValue(0);
    progress_->setVisible(runs);
    cancel_->setVisible(runs);
    showDocument();
}

void MainWindow::exportVideo() {
    const QString title = tr("Export video");
    if (const QString why = exports_.videoObstacle(); !why.isEmpty()) return warn(this, title, why);
    const fs::path from = files_.document()->source.file;
    const fs::path file = fileToSave(
        this, title, from.parent_path() / (from.stem().string() + "_native.mp4"), kVideoFormats);
    if (file.empty()) return;
    if (!canWriteVideo(file))
        return warn(this, title,
                    tr("%1: no video format is known by this extension, expected .mp4, .mkv or "
                       ".mov")
                        .arg(toName(file)));
    const bool goesOn =
        isVideoUnfinished(file) &&
        agrees(this, title,
               tr("An export to %1 was not finished. Go on with it? \"No\" begins again.")
                   .arg(toName(file)));
    if (!exports_.startVideo(file, goesOn)) return;
    videoExport_ = new VideoExportDialog(toName(file), this);
    connect(&exports_, &Exports::videoProgress, videoExport_.data(), &VideoExportDialog::tell);
    connect(videoExport_.data(), &VideoExportDialog::cancelWanted, &exports_, &Exports::cancel);
    videoExport_->show();
    showDocument();
}

void MainWindow::endVideoExport(const VideoExportResult& result, const QString& problem) {
    delete videoExport_.data();
    showDocument();
    if (!problem.isEmpty()) return warn(this, tr("Export video"), problem);
    if (result.file.empty())
        return say(result.keepsParts ? tr("Cancelled; export to the same name to go on from there")
                                     : tr("Cancelled"),
                   15000);
    QString written =
        tr("Written: %1 (%2, %3)")
            .arg(QString::fromStdString(result.file),
                 QString::fromStdString(tools::bytesText(result.bytes)), timeText(result.end));
    if (!result.notes.empty()) written += "\n" + linesOf(result.notes);
    say(written, 15000);
}

void MainWindow::exportAllDialog() {
    const QString title = tr("Export all Natives");
    const QString name = QFileDialog::getExistingDirectory(
        this, tr("Folder for the Natives"), QSettings().value("exportFolder").toString());
    if (name.isEmpty()) return;
    const fs::path folder = toPath(name);
    std::error_code error;
    int there = 0;
    for (const BatchItem& item : exports_.batch(folder))
        there += int(fs::exists(item.native, error));
    if (there > 0 &&
        !agrees(this, title,
                tr("%1 of the files exist already in %2. Replace them?").arg(there).arg(name)))
        return;
    QSettings().setValue("exportFolder", name);
    if (exports_.startAll(folder)) showProgress(true);
}

void MainWindow::endExportAll(const BatchReport& report) {
    showProgress(false);
    const QString written = tr("%1 Natives written").arg(report.written);
    say(report.cancelled ? tr("Cancelled, %1").arg(written) : written, 15000);
    if (report.problems.empty()) return;
    QMessageBox box(QMessageBox::Warning, tr("Export all Natives"),
                    tr("%1; %2 files were not exported:").arg(written).arg(report.problems.size()),
                    QMessageBox::Ok, this);
    box.setTextFormat(Qt::PlainText);
    constexpr int kListed = 5;
    const QString all = linesOf(report.problems);
    const QString listed = all.section('\n', 0, kListed - 1);
    box.setInformativeText(listed);
    if (listed != all) box.setDetailedText(all);
    box.exec();
}

std::optional<std::size_t> MainWindow::chosenScreen(const std::vector<qt::ScreenFacts>& screens) {
    if (screen_.isEmpty()) return std::nullopt;
    for (std::size_t i = 0; i < screens.size(); ++i)
        if (nameOf(screens[i], i) == screen_) return i;
    warn(this, tr("Screen"),
         tr("The screen %1 is not connected: choose another one with Display > Screen")
             .arg(screen_));
    return std::nullopt;
}

QScreen* MainWindow::displayScreen() {
    const std::vector<qt::ScreenFacts> screens = screenFacts();
    const Display& own = *files_.display();
    const std::vector<qt::FoundDisplay> displays =
        qt::findDisplays(screens, calibrationsAnd(own.calibration, own.source));
    std::optional<std::size_t> screen = chosenScreen(screens);
    const qt::FoundDisplay* display = nullptr; // on that screen
    if (screen) {
        for (const qt::FoundDisplay& found : displays)
            if (found.screen == screen) display = &found;
    } else if (!screen_.isEmpty()) {
        return nullptr;
    } else if (const auto chosen =
                   qt::chooseDisplay(displays, screens, own.calibration, own.panelSize())) {
        display = &displays[*chosen];
        screen = display->screen;
    } else {
        tellDisplays();
        return nullptr;
    }
    if (display != nullptr && display->calibration &&
        fingerprint(*display->calibration) != fingerprint(own.calibration))
        useCalibration(*display->calibration, display->calibrationFile);
    const std::vector<std::string> problems =
        display != nullptr ? display->problems
                           : qt::problemsOf(screens[*screen], files_.display()->panelSize());
    if (!problems.empty()) say(linesOf(problems), 15000);
    return QGuiApplication::screens()[static_cast<int>(*screen)];
}

qt::NativeWidget* MainWindow::showOn(QScreen& screen) {
    onDisplay_ = std::make_unique<qt::NativeWidget>();
    connect(onDisplay_.get(), &qt::NativeWidget::left, this,
            [this] { stage_.setPresenting(false); });
    onDisplay_->showOn(screen);
    return onDisplay_.get();
}

void MainWindow::showSlides() {
    SlideShowDialog dialog(files_.sources().size(), this);
    if (dialog.exec() != QDialog::Accepted) return;
    std::vector<fs::path> names;
    if (!dialog.folder().isEmpty()) {
        names.push_back(toPath(dialog.folder()));
    } else {
        for (const Source& source : files_.sources())
            for (const fs::path& name : {source.file, source.depth})
                if (!name.empty()) names.push_back(name);
    }
    QScreen* const screen = displayScreen();
    if (screen == nullptr) return;
    try {
        slideProblems_.clear();
        slides_ = std::make_unique<SlidePresenter>(
            dialog.settings(), ShowFiles(names), files_.display(), qt::factsOf(*screen),
            [this](const std::string& problem) { slideProblems_.push_back(problem); });
    } catch (const std::exception& error) {
        return warn(this, tr("Slide show"), error);
    }
    onDisplay_.reset();
    stage_.setPresenting(false);
    files_.setPlaying(false);
    connect(slides_.get(), &SlidePresenter::ended, this, &MainWindow::endSlides,
            Qt::QueuedConnection);
    slides_->setPlaySettings(files_.playSettings());
    slides_->start(*screen);
}

void MainWindow::endSlides() {
    slides_.reset();
    if (!slideProblems_.empty())
        warn(this, tr("Slide show"),
             tr("Not shown:") + "\n" + linesOf(std::exchange(slideProblems_, {})));
}

void MainWindow::showOnDisplay() {
    if (!files_.document()) return say(tr("Open a file first"), 8000);
    QScreen* const screen = displayScreen();
    if (screen == nullptr) return;
    connect(&stage_, &Stage::nativeReady, showOn(*screen), &qt::NativeWidget::setNative);
    stage_.setPresenting(true);
}

void MainWindow::showForEyes() {
    const auto& document = files_.document();
    if (!document || document->kind == Kind::Native)
        return say(document ? tr("A Native is for a display of lenses; open a photo or a quilt")
                            : tr("Open a file first"),
                   8000);
    const auto chosen = chosenScreen(screenFacts());
    if (!chosen && !screen_.isEmpty()) return;
    QScreen& on = chosen ? *QGuiApplication::screens()[static_cast<int>(*chosen)] : *screen();
    connect(&stage_, &Stage::nativeReady, showOn(on), &qt::NativeWidget::setNative);
    stage_.setPresenting(true, qt::factsOf(on).size);
}

void MainWindow::showTestPicture() {
    QScreen* const screen = displayScreen();
    if (screen == nullptr) return;
    stage_.setPresenting(false);
    showOn(*screen)->setNative(makeTestPicture(*files_.display()));
    QMessageBox::information(this, tr("Test picture"), linesOf(testPictureAdvice()));
}

// The picture goes to the screen that was chosen, to that of a display, or to any but the window's;
// the panel to another one, if there is one.
void MainWindow::lensByEye() {
    const std::vector<qt::ScreenFacts> screens = screenFacts();
    const QList<QScreen*> all = QGuiApplication::screens();
    const auto own = static_cast<std::size_t>(all.indexOf(screen()));
    const auto besides = [&](std::size_t taken) {
        return screens.size() == 1 ? taken : static_cast<std::size_t>(taken == 0);
    };
    std::optional<std::size_t> lens = chosenScreen(screens);
    if (!lens && !screen_.isEmpty()) return;
    const Display& display = *files_.display();
    const auto displays = qt::findDisplays(screens, calibrations());
    const auto chosen =
        qt::chooseDisplay(displays, screens, display.calibration, display.panelSize());
    if (!lens && chosen) lens = displays[*chosen].screen;
    const std::size_t shown = lens.value_or(besides(own));
    stage_.setPresenting(false);
    onDisplay_.reset();
    try {
        LensByEyeDialog dialog(*files_.display(), *all[static_cast<int>(shown)], this);
        connect(&dialog, &LensByEyeDialog::saved, this, &MainWindow::useCalibration);
        const std::size_t panel = shown == own ? besides(own) : own;
        dialog.standOn(*all[static_cast<int>(panel)]);
        dialog.exec();
    } catch (const Error& error) {
        warn(this, tr("Lens by eye"), error);
    }
}

void MainWindow::welcome(const QString& display) {
    fs::path sample = dataFile("examples/sample.jpg");
    if (sample.empty()) sample = dataFile("docs/examples/sample.jpg");
    if (sample.empty() || QSettings().value("welcomed").toBool()) return;
    welcome_ = new WelcomeCard(
        display, [this] { openDialog(); }, [this] { endWelcome(); });
    static_cast<QBoxLayout*>(picture_->parentWidget()->layout())->insertWidget(0, welcome_);
    files_.open(std::vector<fs::path>{sample});
    hasSample_ = true;
    try { // estimate the depth, as of most photos: the depth beside the sample is better
        Knobs knobs = settings_.knobs();
        if (const auto network = standardNetwork()) knobs.depth = network->profile.name;
        settings_.turn(knobs, tr("depth"));
        settings_.undoStack().clear();
    } catch (const Error&) {
        // the list of networks tells it
    }
    stage_.setSwinging(true);
}

void MainWindow::endWelcome() {
    if (welcome_ == nullptr) return;
    QSettings().setValue("welcomed", true);
    welcome_->hide();
    welcome_->deleteLater(); // its button may have asked for it
    welcome_ = nullptr;
}

void MainWindow::tellDisplays() {
    const std::vector<qt::ScreenFacts> screens = screenFacts();
    const std::vector<qt::FoundDisplay> displays = qt::findDisplays(screens, calibrations());
    QString text;
    for (const qt::FoundDisplay& display : displays) {
        text += "<p><b>" + QString::fromStdString(display.name).toHtmlEscaped() + "</b>";
        if (display.problems.empty()) text += tr(": ready");
        for (const std::string& problem : display.problems)
            text += "<br>" + QString::fromStdString(problem).toHtmlEscaped();
        text += "</p>";
    }
    if (displays.empty())
        text =
            tr("<p><b>No light-field display was found.</b></p><p>Connect its video and USB "
               "cables, extend the desktop to it, and mount its volume, or choose its screen with "
               "Display &gt; Screen. Without one, look with Sway, Quilt and Lens.</p>");
    QMessageBox::information(this, tr("Displays"), text);
}

} // namespace altiro3D::viewer
