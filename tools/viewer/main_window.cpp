#include "viewer/main_window.hpp"

#include "altiro3D/altiro3D.hpp"
#include "altiro3D/qt/image.hpp"
#include "altiro3D/qt/native_widget.hpp"
#include "viewer/knob_panel.hpp"
#include "viewer/picture_view.hpp"
#include "viewer/window_words.hpp"

#include <QAction>
#include <QActionGroup>
#include <QCloseEvent>
#include <QDockWidget>
#include <QDragEnterEvent>
#include <QFileInfo>
#include <QLabel>
#include <QListWidget>
#include <QMenuBar>
#include <QMessageBox>
#include <QMimeData>
#include <QProgressBar>
#include <QScrollArea>
#include <QSettings>
#include <QStatusBar>
#include <QStyle>
#include <QTextDocument>
#include <QTimer>
#include <QToolBar>
#include <QToolButton>
#include <algorithm>
#include <cmath>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxRecent = 10;
constexpr const char* kRecent = "recent";

struct ModeWords {
    Mode mode;
    const char* text;
    const char* tip;
};

const ModeWords kModes[] = {
    {Mode::Sway, QT_TRANSLATE_NOOP("mode", "Sway"),
     QT_TRANSLATE_NOOP("mode", "One view from a camera that moves")},
    {Mode::Depth, QT_TRANSLATE_NOOP("mode", "Depth"),
     QT_TRANSLATE_NOOP("mode", "The depth map, near is white")},
    {Mode::Quilt, QT_TRANSLATE_NOOP("mode", "Quilt"), QT_TRANSLATE_NOOP("mode", "All views")},
    {Mode::Native, QT_TRANSLATE_NOOP("mode", "Native"),
     QT_TRANSLATE_NOOP("mode", "What the panel shows, px by px; drag it to see other parts")},
    {Mode::Lens, QT_TRANSLATE_NOOP("mode", "Lens"),
     QT_TRANSLATE_NOOP("mode", "What an eye sees through the display's lenses")}};

// Names and messages contain texts from files, which must not be interpreted as markup.
QString tipOf(const QString& text) {
    return Qt::convertFromPlainText(text, Qt::WhiteSpaceNormal); // long ones are wrapped
}

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

MainWindow::MainWindow(const Display& display, const std::vector<std::string>& warnings)
    : controller_(display), picture_(new PictureView), knobs_(new KnobPanel),
      files_(new QListWidget) {
    setWindowTitle(tr("altiro3D"));
    setWindowIcon(QIcon::fromTheme("altiro3D", QIcon(":/altiro3D.svg")));
    setAcceptDrops(true);
    setCentralWidget(picture_);
    buildFiles();
    auto* knobDock = new QDockWidget(tr("Settings"));
    knobDock->setObjectName("knobDock");
    auto* scroll = new QScrollArea;
    scroll->setWidget(knobs_);
    scroll->setWidgetResizable(true);
    scroll->setFrameShape(QFrame::NoFrame);
    scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    scroll->setMinimumWidth(knobs_->minimumSizeHint().width() +
                            style()->pixelMetric(QStyle::PM_ScrollBarExtent) + 2);
    knobDock->setWidget(scroll);
    addDockWidget(Qt::RightDockWidgetArea, knobDock);
    buildActions();
    buildStatus();
    connectController();
    resize(1280, 800);
    readSettings();
    showSources();
    showDocument();
    showModes();
    if (!warnings.empty()) say(linesOf(warnings), 15000);
}

MainWindow::~MainWindow() {
    controller_.disconnect(this); // later signals must not reach the destroyed window
}

void MainWindow::buildFiles() {
    files_->setObjectName("files");
    files_->setMinimumWidth(150);
    files_->setTextElideMode(Qt::ElideMiddle);
    files_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    auto* dock = new QDockWidget(tr("Files"));
    dock->setObjectName("fileDock");
    dock->setWidget(files_);
    addDockWidget(Qt::LeftDockWidgetArea, dock);
    resizeDocks({dock}, {180}, Qt::Horizontal);
    connect(files_, &QListWidget::currentRowChanged, this, [this](int row) {
        if (row >= 0 && row != controller_.current()) controller_.select(row);
    });
}

QAction* MainWindow::action(QMenu& menu, const QString& text, const QKeySequence& keys,
                            const std::function<void()>& what, const QString& name) {
    QAction* result = menu.addAction(text);
    result->setShortcut(keys);
    result->setObjectName(name);
    connect(result, &QAction::triggered, this, what);
    return result;
}

void MainWindow::buildActions() {
    QAction* const open = buildFileMenu();
    buildEditMenu();
    buildViewMenu();
    QAction* const show = buildDisplayMenu();
    buildHelpMenu();
    buildToolBar(open, show);
}

QAction* MainWindow::buildFileMenu() {
    QMenu& file = *menuBar()->addMenu(tr("&File"));
    QAction* open = action(file, tr("&Open…"), QKeySequence::Open, [this] { openDialog(); });
    open->setIconText(tr("Open"));
    action(file, tr("Open a &folder…"), QKeySequence(tr("Ctrl+Shift+O")),
           [this] { openDirectoryDialog(); });
    depthImage_ = action(file, tr("&Depth image for this photo…"), QKeySequence(tr("Ctrl+D")),
                         [this] { openDepthDialog(); });
    recent_ = file.addMenu(tr("Open &recent"));
    connect(recent_, &QMenu::aboutToShow, this, &MainWindow::fillRecent);
    file.addSeparator();
    const std::pair<Product, QKeySequence> products[] = {
        {Product::Native, QKeySequence(tr("Ctrl+S"))},
        {Product::Quilt, QKeySequence(tr("Ctrl+Shift+S"))},
        {Product::Views, {}},
        {Product::Depth, {}},
        {Product::SwayVideo, {}}};
    for (const auto& [product, keys] : products) {
        exports_.emplace_back(product, action(file, tr("Export %1…").arg(nameOf(product)), keys,
                                              [this, p = product] { exportDialog(p); }));
    }
    exports_.front().second->setIconText(tr("Export"));
    file.addSeparator();
    closeFile_ = action(file, tr("&Close file"), QKeySequence(tr("Ctrl+W")),
                        [this] { controller_.close(controller_.current()); });
    action(file, tr("&Quit"), QKeySequence(tr("Ctrl+Q")), [this] { close(); });
    return open;
}

void MainWindow::buildEditMenu() {
    QMenu& edit = *menuBar()->addMenu(tr("&Edit"));
    QAction* undo = controller_.undoStack().createUndoAction(this, tr("&Undo"));
    undo->setShortcut(QKeySequence::Undo);
    QAction* redo = controller_.undoStack().createRedoAction(this, tr("&Redo"));
    redo->setShortcuts({QKeySequence(tr("Ctrl+Shift+Z")), QKeySequence(tr("Ctrl+Y"))});
    edit.addAction(undo);
    edit.addAction(redo);
    edit.addSeparator();
    action(edit, tr("Reset the &frame"), QKeySequence(Qt::Key_0),
           [this] { controller_.resetFrame(); });
    action(edit, tr("Reset &all settings"), QKeySequence(tr("Ctrl+R")),
           [this] { controller_.resetKnobs(); });
}

void MainWindow::buildViewMenu() {
    QMenu& view = *menuBar()->addMenu(tr("&View"));
    modes_ = new QActionGroup(this);
    int number = 1;
    for (const ModeWords& words : kModes) {
        QAction* mode = action(view, tr(words.text), QKeySequence(QString::number(number++)),
                               [this, m = words.mode] { controller_.setMode(m); });
        mode->setCheckable(true);
        mode->setData(int(words.mode));
        mode->setToolTip(tr("%1 (%2)").arg(tr(words.tip)).arg(number - 1));
        modes_->addAction(mode);
    }
    view.addSeparator();
    swing_ = action(view, tr("S&wing automatically"), QKeySequence(Qt::Key_Space),
                    [this] { controller_.setSwinging(swing_->isChecked()); });
    swing_->setCheckable(true);
    swing_->setIconText(tr("Swing"));
    swing_->setToolTip(tr("The camera swings automatically (Space)"));
    follow_ = action(view, tr("&Follow the mouse"), QKeySequence(Qt::Key_M), [] {});
    follow_->setCheckable(true);
    follow_->setIconText(tr("Follow mouse"));
    follow_->setToolTip(tr("The camera follows the mouse (M)"));
    QAction* play = action(view, tr("&Play the video"), QKeySequence(Qt::Key_P), [] {});
    play->setCheckable(true);
    play->setChecked(controller_.isPlaying());
    connect(play, &QAction::toggled, this, [this](bool on) { controller_.setPlaying(on); });
    view.addSeparator();
    for (const QDockWidget* dock : findChildren<QDockWidget*>())
        view.addAction(dock->toggleViewAction());
}

QAction* MainWindow::buildDisplayMenu() {
    QMenu& display = *menuBar()->addMenu(tr("&Display"));
    QAction* show = action(display, tr("&Show on the display"), QKeySequence(Qt::Key_F11),
                           [this] { showOnDisplay(); });
    show->setIconText(tr("Show on display"));
    show->setToolTip(tr("Full screen on the light-field display, px by px (F11)"));
    action(display, tr("&Find displays…"), {}, [this] { tellDisplays(); });
    action(display, tr("&Choose calibration…"), {}, [this] { calibrationDialog(); });
    return show;
}

void MainWindow::buildHelpMenu() {
    QMenu& help = *menuBar()->addMenu(tr("&Help"));
    action(help, tr("&About altiro3D"), {}, [this] {
        QMessageBox::about(this, tr("altiro3D"),
                           tr("<h3>altiro3D %1</h3><p>Photos and flat video as glasses-free 3D "
                              "pictures for light-field displays.</p><p>Click on the picture to "
                              "focus there. Drag it to move the frame, turn the wheel to "
                              "zoom; 0 resets both. Double-click a slider to reset it.</p>")
                               .arg(version()));
    });
}

void MainWindow::buildToolBar(QAction* open, QAction* show) {
    auto* bar = addToolBar(tr("Tools"));
    bar->setObjectName("tools");
    bar->setMovable(false);
    bar->addAction(open);
    bar->addAction(exports_.front().second);
    bar->addSeparator();
    bar->addActions(modes_->actions());
    bar->addSeparator();
    bar->addAction(swing_);
    bar->addAction(follow_);
    auto* room = new QWidget;
    room->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Preferred);
    bar->addWidget(room);
    bar->addAction(show);
}

void MainWindow::buildStatus() {
    status_ = new QLabel;
    status_->setTextFormat(Qt::PlainText);
    busy_ = new QLabel;
    progress_ = new QProgressBar;
    progress_->setMaximumWidth(160);
    progress_->setRange(0, 100);
    cancel_ = new QToolButton;
    cancel_->setText(tr("Cancel"));
    cancel_->setObjectName("cancel");
    status_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
    statusBar()->addWidget(status_, 1);
    statusBar()->addPermanentWidget(busy_);
    statusBar()->addPermanentWidget(progress_);
    statusBar()->addPermanentWidget(cancel_);
    progress_->hide();
    cancel_->hide();
    unsay_ = new QTimer(this);
    unsay_->setSingleShot(true);
    connect(unsay_, &QTimer::timeout, this, [this] {
        said_.clear();
        showStatus();
    });
    connect(cancel_, &QToolButton::clicked, this, [this] { controller_.cancelExport(); });
}

void MainWindow::say(const QString& text, int milliseconds) {
    said_ = text;
    unsay_->start(milliseconds);
    showStatus();
}

void MainWindow::showStatus() {
    const QString& text = said_.isEmpty() ? facts_ : said_;
    QString line = text; // the tip has a line for each sentence
    line.replace('\n', "; ");
    const int room = statusBar()->width() - 40 - (progress_->isVisible() ? 260 : 0);
    status_->setText(status_->fontMetrics().elidedText(line, Qt::ElideRight, room));
    status_->setToolTip(tipOf(text));
}

void MainWindow::connectController() {
    connect(&controller_, &Controller::sourcesChanged, this, &MainWindow::showSources);
    connect(&controller_, &Controller::documentChanged, this, &MainWindow::showDocument);
    connect(&controller_, &Controller::frameReady, this, &MainWindow::showFrame);
    connect(&controller_, &Controller::modeChanged, this, &MainWindow::showModes);
    connect(&controller_, &Controller::swingingChanged, swing_, &QAction::setChecked);
    connect(&controller_, &Controller::knobsChanged, this, [this] {
        knobs_->show(controller_.knobs());
        showLayout();
    });
    connect(&controller_, &Controller::displayChanged, this, &MainWindow::showLayout);
    connect(&controller_, &Controller::exportProgress, this,
            [this](double done) { progress_->setValue(qRound(done * 100)); });
    connect(&controller_, &Controller::exportEnded, this,
            [this](const QString& file, const QString& problem) {
                progress_->hide();
                cancel_->hide();
                showDocument();
                if (!problem.isEmpty())
                    warn(this, tr("Export"), problem);
                else if (file.isEmpty())
                    say(tr("Cancelled"), 8000);
                else
                    say(tr("Written: %1").arg(file), 15000);
            });

    connect(knobs_, &KnobPanel::turned, this,
            [this](const Knobs& knobs, const QString& what, int gesture) {
                controller_.turn(knobs, what, gesture);
            });
    connect(knobs_, &KnobPanel::resetWanted, this, [this] { controller_.resetKnobs(); });
    connect(knobs_, &KnobPanel::calibrationWanted, this, &MainWindow::calibrationDialog);
    connect(knobs_, &KnobPanel::depthImageWanted, this, &MainWindow::openDepthDialog);
    connect(knobs_, &KnobPanel::readingChosen, this, [this](Reading reading) {
        if (const auto& document = controller_.document())
            controller_.reopen(reading, document->source.depth);
    });

    connect(picture_, &PictureView::resized, this, [this] {
        const QSize size = picture_->deviceSize();
        controller_.setArea({size.width(), size.height()});
    });
    connect(picture_, &PictureView::clicked, this,
            [this](double x, double y) { controller_.focusAt(x, y); });
    connect(picture_, &PictureView::dragged, this, [this](const QPoint& by, int gesture) {
        const QSize size = picture_->target();
        controller_.panBy({by.x(), by.y()});
        controller_.moveFrame({double(by.x()) / size.width(), double(by.y()) / size.height()},
                              gesture);
    });
    connect(picture_, &PictureView::wheeled, this,
            [this](double x, double y, double notches, int gesture) {
                constexpr double kNotchesToDouble = 4;
                controller_.zoomFrame({x, y}, std::exp2(notches / kNotchesToDouble), gesture);
            });
    connect(picture_, &PictureView::hovered, this, [this](double x) {
        if (!follow_->isChecked()) return;
        controller_.setSwinging(false);
        controller_.setPosition(x);
    });
}

void MainWindow::showSources() {
    const QSignalBlocker blocker(files_);
    files_->clear();
    for (const Source& source : controller_.sources()) {
        QString name = toName(source.file.has_filename() ? source.file.filename()
                                                         : source.file.parent_path().filename());
        auto* item = new QListWidgetItem(name, files_);
        item->setToolTip(tipOf(toName(source.file) +
                               (source.depth.empty() ? QString() : "\n" + toName(source.depth))));
    }
    files_->setCurrentRow(controller_.current());
}

void MainWindow::showDocument() {
    const auto& document = controller_.document();
    {
        const QSignalBlocker blocker(files_);
        files_->setCurrentRow(controller_.current());
    }
    const bool any = controller_.current() >= 0;
    const Source* source =
        any ? &controller_.sources()[static_cast<std::size_t>(controller_.current())] : nullptr;
    setWindowTitle(any ? tr("%1 – altiro3D").arg(toName(source->file.filename())) : tr("altiro3D"));
    if (!controller_.problem().isEmpty()) {
        if (document)
            picture_->setWords(tr("This cannot be shown"), controller_.problem());
        else
            picture_->setWords(tr("This file cannot be opened"), controller_.problem());
    } else if (!any) {
        picture_->setWords(tr("Drop a photo here"),
                           tr("or press Ctrl+O. Photos, photos with depth, quilts, Natives, "
                              "videos and folders can be opened."));
    } else if (!document && controller_.isBusy()) {
        picture_->setWords(tr("Opening…"), toName(source->file.filename()));
    }
    if (!any || !controller_.problem().isEmpty()) {
        facts_.clear();
        showStatus();
    }
    const bool current = document && controller_.problem().isEmpty();
    if (current && document != told_ && !document->notes.empty()) {
        std::vector<std::string> lines;
        for (const Note& note : document->notes)
            lines.push_back(note.text);
        say(linesOf(lines), 10000);
    }
    told_ = document;
    if (current) remember(document->source.file);
    knobs_->show(document.get(),
                 current ? QString::fromStdString(controller_.frame().depthSource) : QString());
    showLayout();
    const bool scene = document && document->kind == Kind::Scene;
    depthImage_->setEnabled(scene && !document->video);
    closeFile_->setEnabled(any);
    const std::vector<Product> products =
        current ? productsOf(document->kind) : std::vector<Product>();
    for (const auto& [product, exportAction] : exports_) {
        exportAction->setEnabled(!controller_.isExporting() &&
                                 std::count(products.begin(), products.end(), product) > 0);
    }
    busy_->setText(controller_.isBusy() ? tr("Working…") : QString());
    showModes();
}

void MainWindow::showFrame() {
    const Frame& frame = controller_.frame();
    if (!controller_.problem().isEmpty()) return; // the words say so
    if (frame.picture.empty()) {
        if (controller_.current() < 0) showDocument();
        return;
    }
    picture_->setPicture(qt::toImage(frame.picture), {frame.target.width, frame.target.height});
    const Mode mode = frame.request.mode;
    const bool canFocus = !frame.depth.empty();
    picture_->setCursor(canFocus               ? Qt::CrossCursor
                        : mode == Mode::Native ? Qt::OpenHandCursor
                                               : Qt::ArrowCursor);
    const auto& document = frame.request.document;
    knobs_->showParallax(frame.parallaxPixels);
    if (frame.request.knobs == controller_.knobs() && frame.setup.isChosen)
        knobs_->showChosen(frame.setup.knobs);
    knobs_->show(document.get(), QString::fromStdString(frame.depthSource));
    QString text = QString::fromStdString(document->facts());
    if (document->video) {
        const auto dropped = controller_.videoCounts().dropped;
        if (dropped > 0) text += tr(", %1 pictures dropped").arg(dropped);
    }
    if (mode == Mode::Lens) {
        const double angle =
            frame.request.position * viewConeDegrees(frame.request.display->calibration) / 2;
        text += tr("    seen from %1°").arg(angle, 0, 'f', 1);
    } else if (canFocus) {
        text += tr("    Click to focus there, drag to move the frame, turn the wheel to zoom");
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

void MainWindow::showLayout() {
    const auto& document = controller_.document();
    const bool quilt = document && document->kind == Kind::Quilt;
    knobs_->show(controller_.display(),
                 quilt ? document->layout : layoutOf(controller_.knobs(), controller_.display()));
}

void MainWindow::showModes() {
    const auto& document = controller_.document();
    const std::vector<Mode> available = modesOf(document ? document->kind : Kind::Scene);
    for (QAction* action : modes_->actions()) {
        const auto mode = static_cast<Mode>(action->data().toInt());
        action->setEnabled(std::count(available.begin(), available.end(), mode) > 0);
        action->setChecked(mode == controller_.mode());
    }
}

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
    knobs.automatic = {settings.value("autoFit", false).toBool() && knobs.fit == FitMode::Cover,
                       settings.value("autoFocus", false).toBool(),
                       settings.value("autoStrength", false).toBool()};
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
    follow_->setChecked(settings.value("follow", false).toBool());
    restoreGeometry(settings.value("geometry").toByteArray());
    restoreState(settings.value("state").toByteArray());
}

void MainWindow::writeSettings() const {
    QSettings settings;
    const Knobs& knobs = controller_.knobs();
    settings.setValue("method", int(knobs.views.method));
    settings.setValue("strength", knobs.views.strengthPercent);
    settings.setValue("focus", knobs.views.focus);
    settings.setValue("fit", int(knobs.fit));
    settings.setValue("autoFit", knobs.automatic.framing);
    settings.setValue("autoFocus", knobs.automatic.focus);
    settings.setValue("autoStrength", knobs.automatic.strength);
    settings.setValue("best", knobs.best);
    settings.setValue("depth", QString::fromStdString(knobs.depth));
    settings.setValue("mode", int(controller_.mode()));
    settings.setValue("swing", swing_->isChecked());
    settings.setValue("follow", follow_->isChecked());
    settings.setValue("geometry", saveGeometry());
    settings.setValue("state", saveState());
}

void MainWindow::closeEvent(QCloseEvent* event) {
    writeSettings();
    controller_.setSwinging(false);
    controller_.cancelExport();
    onDisplay_.reset();
    event->accept();
}

void MainWindow::resizeEvent(QResizeEvent* event) {
    QMainWindow::resizeEvent(event);
    showStatus(); // it has another room
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
    if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
    std::vector<fs::path> files;
    for (const QUrl& url : event->mimeData()->urls()) {
        if (url.isLocalFile()) files.push_back(toPath(url.toLocalFile()));
    }
    if (!files.empty()) controller_.open(files);
    event->acceptProposedAction();
}

} // namespace altiro3D::viewer
