#include "viewer/window/main_window.hpp"

#include "altiro3D/altiro3D.hpp"
#include "altiro3D/qt/image.hpp"
#include "altiro3D/qt/native_widget.hpp"
#include "cli/picture_options.hpp"
#include "viewer/show/slide_presenter.hpp"
#include "viewer/window/knob_panel.hpp"
#include "viewer/window/paint_bar.hpp"
#include "viewer/window/photo_strip.hpp"
#include "viewer/window/picture_view.hpp"
#include "viewer/window/video_bar.hpp"
#include "viewer/window/video_export_dialog.hpp"
#include "viewer/window/window_words.hpp"

#include <QAction>
#include <QActionGroup>
#include <QCloseEvent>
#include <QDockWidget>
#include <QDragEnterEvent>
#include <QLabel>
#include <QMessageBox>
#include <QMimeData>
#include <QProgressBar>
#include <QScreen>
#include <QScrollArea>
#include <QShortcut>
#include <QStatusBar>
#include <QStyle>
#include <QToolButton>
#include <algorithm>
#include <cmath>
#include <utility>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

MainWindow::MainWindow(const Display& display, const std::vector<std::string>& warnings)
    : model_(display), picture_(new PictureView) {
    QLocale::setDefault(QLocale::c()); // numbers as in the words beside them, also in dialogs
    setLocale(QLocale());
    knobs_ = new KnobPanel;
    setWindowTitle(tr("altiro3D"));
    setWindowIcon(QIcon::fromTheme("altiro3D", QIcon(":/altiro3D.svg")));
    setAcceptDrops(true);
    picture_->setAccessibleName(tr("Picture"));
    setCentralWidget(withVideoBar(picture_, files_));
    buildStrip();
    auto* knobDock = new QDockWidget(tr("Settings"));
    knobDock->setObjectName("knobDock");
    auto* scroll = new QScrollArea;
    scroll->setWidget(knobs_);
    scroll->setAccessibleName(tr("Settings"));
    scroll->setWidgetResizable(true);
    scroll->setFrameShape(QFrame::NoFrame);
    scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    scroll->setMinimumWidth(knobs_->minimumSizeHint().width() +
                            style()->pixelMetric(QStyle::PM_ScrollBarExtent) + 2);
    knobDock->setWidget(scroll);
    addDockWidget(Qt::RightDockWidgetArea, knobDock);
    buildPaintBar();
    auto* bar = addToolBar(tr("Tools"));
    bar->setObjectName("tools");
    bar->setMovable(false);
    buildFileMenu(*bar);
    buildEditMenu();
    buildViewMenu(*bar);
    buildDisplayMenu(*bar);
    buildHelpMenu();
    buildStatus();
    connectModel();
    const QSize frame(16, 48); // of the desktop around the window
    resize(QSize(1280, 800).boundedTo(screen()->availableSize() - frame));
    showNetworks();
    readSettings();
    showSources();
    showDocument();
    std::vector<std::string> sentences = warnings;
    if (const std::string& note = settings_.storeNote(); !note.empty()) sentences.push_back(note);
    if (!sentences.empty()) say(linesOf(sentences), 15000);
}

MainWindow::~MainWindow() {
    for (QObject* part : std::initializer_list<QObject*>{&settings_, &files_, &stage_, &exports_})
        part->disconnect(this); // later signals must not reach the destroyed window
}

void MainWindow::buildStrip() {
    strip_ = new PhotoStrip;
    stripDock_ = new QDockWidget(tr("Photos"));
    stripDock_->setObjectName("stripDock");
    stripDock_->setFeatures(QDockWidget::NoDockWidgetFeatures);
    stripDock_->setTitleBarWidget(new QWidget); // the icons need no title
    stripDock_->setWidget(strip_);
    addDockWidget(Qt::BottomDockWidgetArea, stripDock_);
    setCorner(Qt::BottomLeftCorner, Qt::LeftDockWidgetArea);
    setCorner(Qt::BottomRightCorner, Qt::RightDockWidgetArea);
    connect(strip_, &PhotoStrip::chosen, this, [this](int index) {
        if (index != files_.current()) files_.select(index);
    });
}

void MainWindow::showStrip() {
    stripDock_->setVisible(showsStrip_->isChecked() && files_.sources().size() > 1);
}

void MainWindow::buildStatus() {
    status_ = plainLabel();
    status_->setWordWrap(false);
    busy_ = new QLabel;
    progress_ = new QProgressBar;
    progress_->setMaximumWidth(160);
    progress_->setRange(0, 100);
    cancel_ = named(new QToolButton, "cancel", {});
    cancel_->setText(tr("Cancel"));
    status_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
    statusBar()->addWidget(status_, 1);
    statusBar()->addPermanentWidget(busy_);
    statusBar()->addPermanentWidget(progress_);
    statusBar()->addPermanentWidget(cancel_);
    progress_->hide();
    cancel_->hide();
    unsay_.setSingleShot(true);
    connect(&unsay_, &QTimer::timeout, this, [this] {
        said_.clear();
        showStatus();
    });
    connect(cancel_, &QToolButton::clicked, this, [this] { exports_.cancel(); });
}

void MainWindow::say(const QString& text, int milliseconds) {
    said_ = text;
    unsay_.start(milliseconds);
    showStatus();
}

void MainWindow::showStatus() {
    const QString& text = said_.isEmpty() ? facts_ : said_;
    QString line = text; // the tip has a line for each sentence
    line.replace('\n', "; ");
    const int room = statusBar()->width() - 40 - (progress_->isVisible() ? 260 : 0);
    status_->setText(status_->fontMetrics().elidedText(line, Qt::ElideMiddle, room));
    status_->setToolTip(tipOf(text));
}

void MainWindow::connectModel() {
    connect(&files_, &Files::sourcesChanged, this, &MainWindow::showSources);
    connect(&stage_, &Stage::stateChanged, this, &MainWindow::showDocument);
    connect(&stage_, &Stage::frameReady, this, &MainWindow::showFrame);
    connect(&stage_, &Stage::modeChanged, this, &MainWindow::showModes);
    connect(&stage_, &Stage::eyesChanged, this, &MainWindow::showEyes);
    connect(knobs_, &KnobPanel::eyesStrengthTurned, this, [this](double strength) {
        changeEyes([strength](tools::EyesOptions& eyes) { eyes.strengthPercent = strength; });
    });
    connect(&stage_, &Stage::swingingChanged, swing_, &QAction::setChecked);
    connect(&settings_, &Settings::knobsChanged, this, [this] {
        knobs_->show(settings_.knobs());
        showLayout();
    });
    connect(&stage_, &Stage::modeChanged, this, &MainWindow::showAction);
    connect(&settings_, &Settings::knobsChanged, this, &MainWindow::showAction);
    connect(&files_, &Files::playSettingsChanged, this, &MainWindow::showAction);
    connect(&files_, &Files::sourcesChanged, this, &MainWindow::showAction);
    connect(&files_, &Files::playingChanged, this, &MainWindow::showAction);
    connect(&exports_, &Exports::progress, this,
            [this](double done) { progress_->setValue(qRound(done * 100)); });
    connect(&exports_, &Exports::ended, this, [this](const QString& file, const QString& problem) {
        showProgress(false);
        const bool closes = std::exchange(closesWhenSaved_, false);
        if (!problem.isEmpty())
            warn(this, tr("Export"), problem);
        else if (file.isEmpty())
            say(tr("Cancelled"), 8000);
        else
            say(tr("Written: %1").arg(file), 15000);
        if (closes && problem.isEmpty() && !file.isEmpty()) close();
    });
    connect(&exports_, &Exports::allEnded, this, &MainWindow::endExportAll);
    connect(&exports_, &Exports::videoEnded, this, &MainWindow::endVideoExport);

    connect(knobs_, &KnobPanel::turned, &settings_, &Settings::turn);
    connect(knobs_, &KnobPanel::resetWanted, &settings_, &Settings::reset);
    connect(knobs_, &KnobPanel::numberLeft, this, [this] { picture_->setFocus(); });
    connect(knobs_, &KnobPanel::calibrationWanted, this, &MainWindow::calibrationDialog);
    connect(knobs_, &KnobPanel::depthImageWanted, this, &MainWindow::openDepthDialog);
    connect(knobs_, &KnobPanel::betterDepthWanted, this, &MainWindow::betterDepthDialog);
    connect(knobs_, &KnobPanel::readingChosen, this, [this](Reading reading) {
        if (const auto& document = files_.document())
            files_.reopen(reading, document->source.depth);
    });

    connect(picture_, &PictureView::resized, this, [this] {
        const QSize size = picture_->deviceSize();
        stage_.setArea({size.width(), size.height()});
    });
    connect(picture_, &PictureView::clicked, &stage_, &Stage::focusAt);
    connect(picture_, &PictureView::dragged, this, [this](const QPoint& by, int gesture) {
        const QSize size = picture_->target();
        stage_.panBy({by.x(), by.y()});
        stage_.moveFrame({double(by.x()) / size.width(), double(by.y()) / size.height()}, gesture);
    });
    connect(picture_, &PictureView::wheeled, this,
            [this](double x, double y, double notches, int gesture) {
                constexpr double kNotchesToDouble = 4;
                stage_.zoomFrame({x, y}, std::exp2(notches / kNotchesToDouble), gesture);
            });
    connect(picture_, &PictureView::hovered, this, [this](double x) {
        if (!follow_->isChecked() || paintBar_->paint()) return;
        stage_.setSwinging(false);
        stage_.setPosition(x);
    });
}

void MainWindow::showSources() {
    if (files_.sources().size() != 1) endWelcome();
    if (files_.sources().empty()) hasSample_ = false;
    if (hasSample_ && files_.sources().size() > 1) { // leaves when the user opens something
        hasSample_ = false;
        later(this, [this] { files_.close(0); });
    }
    strip_->setSources(files_.sources());
    strip_->setCurrent(files_.current());
    showStrip();
}

void MainWindow::showDocument() {
    const auto& document = files_.document();
    strip_->setCurrent(files_.current());
    const bool any = files_.current() >= 0;
    const Source* source =
        any ? &files_.sources()[static_cast<std::size_t>(files_.current())] : nullptr;
    setWindowTitle(any ? tr("%1 – altiro3D").arg(toName(source->file.filename())) : tr("altiro3D"));
    if (!stage_.problem().isEmpty()) {
        picture_->setWords(document ? tr("This cannot be shown") : tr("This file cannot be opened"),
                           stage_.problem());
    } else if (!any) {
        picture_->setWords(tr("Drop a photo here"),
                           tr("or press Ctrl+O. Photos, photos with depth, quilts, Natives, "
                              "videos and folders can be opened."));
    } else if (!document && stage_.isBusy()) {
        picture_->setWords(tr("Opening…"), toName(source->file.filename()));
    }
    if (!any || !stage_.problem().isEmpty()) {
        facts_.clear();
        showStatus();
    }
    const bool current = document && stage_.problem().isEmpty();
    if (current && document != told_) {
        if (said_ == notes_) said_.clear(); // of the file before
        showStatus();
        const QString notes = linesOf(
            document->notes, [](const Note& note) { return QString::fromStdString(note.text); });
        if (!notes.isEmpty()) say(notes_ = notes, 10000);
        if (welcome_ == nullptr) remember(document->source.file);
    }
    told_ = document;
    knobs_->show(document.get(),
                 current ? QString::fromStdString(stage_.frame().setup.depthSource) : QString());
    showLayout();
    const bool scene = document && document->kind == Kind::Scene;
    depthImage_->setEnabled(scene && !document->video);
    closeFile_->setEnabled(any);
    const std::vector<Product> products =
        current ? productsOf(document->kind) : std::vector<Product>();
    for (const auto& [product, exportAction] : products_) {
        exportAction->setEnabled(!exports_.areRunning() &&
                                 std::count(products.begin(), products.end(), product) > 0);
    }
    exportVideo_->setEnabled(current && document->video && document->kind != Kind::Native &&
                             !exports_.areRunning());
    exportAll_->setEnabled(any && !exports_.areRunning());
    copyKnobs_->setEnabled(any);
    next_->setEnabled(files_.current() + 1 < static_cast<int>(files_.sources().size()));
    previous_->setEnabled(files_.current() > 0);
    busy_->setText(stage_.isBusy() ? tr("Working…") : QString());
    showModes();
}

void MainWindow::showFrame() {
    const Frame& frame = stage_.frame();
    if (!stage_.problem().isEmpty()) return; // the words say so
    if (frame.picture.empty()) {
        if (files_.current() < 0) showDocument();
        return;
    }
    picture_->setPicture(qt::toImage(frame.picture), {frame.target.width, frame.target.height});
    const Mode mode = frame.setup.mode;
    const bool canFocus = !frame.depth.empty();
    showPointer();
    picture_->setCursor(canFocus               ? Qt::CrossCursor
                        : mode == Mode::Native ? Qt::OpenHandCursor
                                               : Qt::ArrowCursor);
    const auto& document = frame.setup.document;
    knobs_->showParallax(frame.parallaxPixels, frame.hiddenPercent);
    if (frame.knobs == settings_.knobs()) knobs_->showChosen(frame.setup.knobs);
    knobs_->show(document.get(), QString::fromStdString(frame.setup.depthSource));
    QString text = QString::fromStdString(document->facts());
    const cv::Size size = document->picture.size();
    const std::string cut = tools::cutText(static_cast<double>(size.width) / size.height,
                                           frame.setup.display->aspect(), frame.setup.knobs.fit);
    if (document->kind == Kind::Scene && !cut.empty() && mode != Mode::Stereo)
        text += tr("; %1, \"Shape\" shows all of it").arg(QString::fromStdString(cut));
    if (document->video) {
        const auto all = files_.videoCounts().dropped;
        droppedBefore_ = std::min(droppedBefore_, all); // of the video before
        const auto dropped = all - droppedBefore_;
        if (dropped > 0) text += tr(", %1 pictures dropped").arg(dropped);
    }
    if (mode == Mode::Lens) {
        const double angle =
            frame.setup.position * viewConeDegrees(frame.setup.display->calibration) / 2;
        text += tr("    seen from %1°").arg(angle, 0, 'f', 1);
    } else if (mode == Mode::Stereo) {
        const tools::EyesOptions& eyes = frame.setup.eyes;
        text += tr("    for two eyes, %1").arg(altiro3D::nameOf(eyes.picture).words);
        if (eyes.swapped) text += tr(", exchanged");
    } else if (paintBar_->paint()) {
        text += tr("    Paint on the picture, [ and ] change the brush, Escape ends it");
    } else if (canFocus) {
        text +=
            document->splats
                ? tr("    Click to focus there, drag to turn the camera, turn the wheel to zoom")
                : tr("    Click to focus there, drag to move the frame, turn the wheel to zoom");
    }
    const Framing framing = document->kind == Kind::Scene ? framingOf(frame.setup) : Framing();
    if (framing != Framing()) {
        text += tr("    center %1,%2, zoom %3")
                    .arg(framing.centre.x, 0, 'f', 3)
                    .arg(framing.centre.y, 0, 'f', 3)
                    .arg(framing.zoom, 0, 'f', 2);
    }
    facts_ = text;
    showStatus();
}

void MainWindow::showAction() {
    droppedBefore_ = files_.videoCounts().dropped;
    showFrame();
}

void MainWindow::showLayout() {
    const auto& document = files_.document();
    const bool quilt = document && document->kind == Kind::Quilt;
    knobs_->show(*files_.display(),
                 quilt ? document->layout : layoutOf(settings_.knobs(), *files_.display()));
}

void MainWindow::showModes() {
    const auto& document = files_.document();
    const std::vector<Mode> available = modesOf(document);
    for (QAction* action : modes_->actions()) {
        const auto mode = static_cast<Mode>(action->data().toInt());
        action->setEnabled(std::count(available.begin(), available.end(), mode) > 0);
        action->setChecked(mode == stage_.mode());
    }
    showEyes();
}

void MainWindow::closeEvent(QCloseEvent* event) {
    if (!mayLosePaintedDepth()) return event->ignore();
    writeSettings();
    stage_.setSwinging(false);
    exports_.cancel();
    onDisplay_.reset();
    slides_.reset();
    event->accept();
}

void MainWindow::resizeEvent(QResizeEvent* event) {
    QMainWindow::resizeEvent(event);
    showStatus(); // it has another room
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
    if (!event->mimeData()->hasUrls()) return;
    event->acceptProposedAction();
    picture_->setDropShown(true);
}

void MainWindow::dragLeaveEvent(QDragLeaveEvent* /*event*/) {
    picture_->setDropShown(false);
}

void MainWindow::dropEvent(QDropEvent* event) {
    std::vector<fs::path> files;
    for (const QUrl& url : event->mimeData()->urls()) {
        if (url.isLocalFile()) files.push_back(toPath(url.toLocalFile()));
    }
    picture_->setDropShown(false);
    open(files);
    event->acceptProposedAction();
}

void MainWindow::buildPaintBar() {
    paintBar_ = new PaintBar;
    paintBar_->setMovable(false);
    paintBar_->hide();
    addToolBar(Qt::BottomToolBarArea, paintBar_);
    paintBar_->toggleViewAction()->setVisible(false); // the Edit menu shows it
    connect(paintBar_, &PaintBar::changed, this, &MainWindow::usePaintBar);
    connect(paintBar_, &PaintBar::saveWanted, this, [this] { exportDialog(Product::Depth); });
    connect(paintBar_, &PaintBar::discardWanted, this, [this] { stage_.unpaint(); });
    connect(paintBar_, &QToolBar::visibilityChanged, this, [this](bool visible) {
        if (!isVisible() || isMinimized()) return; // the window itself hides
        paintBar_->choose(visible ? std::optional(PaintTool::Nearer) : std::nullopt);
    });
    const std::pair<Qt::Key, std::function<void()>> keys[] = {
        {Qt::Key_BracketLeft, [this] { paintBar_->resizeBrush(-1); }},
        {Qt::Key_BracketRight, [this] { paintBar_->resizeBrush(1); }},
        {Qt::Key_Escape, [this] { paintBar_->hide(); }}};
    for (const auto& [key, what] : keys)
        connect(new QShortcut(key, this), &QShortcut::activated, this, what);
    connect(picture_, &PictureView::strokeBegan, this, &MainWindow::paint);
    connect(picture_, &PictureView::strokeMoved, this, [this](double x, double y) {
        stage_.continueStroke({x, y});
    });
    connect(picture_, &PictureView::strokeEnded, this, [this] { stage_.endStroke(); });
}

void MainWindow::usePaintBar() {
    if (paintBar_->paint()) {
        swingsAfterPaint_ = swingsAfterPaint_ || stage_.isSwinging();
        // strokes are drawn on the view from the middle
        if (stage_.mode() != Mode::Depth) stage_.setMode(Mode::Sway);
        stage_.setSwinging(false);
        if (stage_.position() != 0) stage_.setPosition(0);
    } else if (std::exchange(swingsAfterPaint_, false)) {
        stage_.setSwinging(true);
    }
    showPointer();
}

void MainWindow::showPointer() {
    const auto paint = paintBar_->paint();
    const Mode mode = stage_.frame().setup.mode;
    paintBar_->setPainted(stage_.isPainted());
    if (!paint || (mode != Mode::Sway && mode != Mode::Depth))
        return picture_->setPointer(PictureView::Pointer::Frame, 0);
    picture_->setPointer(paint->tool == PaintTool::Lasso ? PictureView::Pointer::Lasso
                                                         : PictureView::Pointer::Brush,
                         stage_.brushRadius(paint->radius));
}

void MainWindow::paint(double x, double y, bool shift) {
    auto paint = paintBar_->paint();
    if (!paint) return;
    if (shift) {
        paint->amount = -paint->amount;
        if (paint->tool == PaintTool::Nearer)
            paint->tool = PaintTool::Farther;
        else if (paint->tool == PaintTool::Farther)
            paint->tool = PaintTool::Nearer;
    }
    if (stage_.beginStroke(*paint, {x, y})) return;
    if (stage_.position() != 0) {
        stage_.setSwinging(false);
        stage_.setPosition(0);
        say(tr("The camera is back in the middle, where depth can be painted"), 8000);
    } else if (!stage_.canPaint()) {
        say(tr("Depth can be painted on photos, not on videos, quilts and Natives"), 8000);
    }
}

// Asks if depth was painted and not saved.
bool MainWindow::mayLosePaintedDepth() {
    const auto files = stage_.unsavedDepths();
    if (files.empty()) return true;
    QMessageBox box(QMessageBox::Question, tr("Painted depth"),
                    tr("The depth that you have painted is not saved. Close anyway?"),
                    QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel, this);
    box.setTextFormat(Qt::PlainText);
    box.setInformativeText(linesOf(files, toName));
    box.setDefaultButton(QMessageBox::Cancel);
    const int answer = box.exec();
    if (answer != QMessageBox::Save) return answer == QMessageBox::Discard;
    if (stage_.isPainted()) {
        exportDialog(Product::Depth);
        closesWhenSaved_ = exports_.areRunning(); // else it was cancelled
    } else {
        open({files.front()}); // to be saved when it is seen
    }
    return false;
}

} // namespace altiro3D::viewer
