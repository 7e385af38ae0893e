// The window's menus and tool bar.

#include "altiro3D/error.hpp"
#include "altiro3D/version.hpp"
#include "cli/run_tool.hpp"
#include "viewer/show/presentation.hpp"
#include "viewer/window/knob_panel.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/manual.hpp"
#include "viewer/window/paint_bar.hpp"
#include "viewer/window/window_words.hpp"

#include <QAction>
#include <QActionGroup>
#include <QApplication>
#include <QDockWidget>
#include <QFileInfo>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QPainter>
#include <QProxyStyle>
#include <QSettings>
#include <QStyle>
#include <QStyleOption>
#include <QToolBar>
#include <QUrl>
#include <algorithm>
#include <opencv2/core/version.hpp>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

struct ModeWords {
    Mode mode;
    const char* text;
    const char* tip;
};

const ModeWords kModes[] = {
    {Mode::Sway, "Sway", "One view from a camera that moves"},
    {Mode::Depth, "Depth", "The depth map, near is white"},
    {Mode::Quilt, "Quilt", "All views"},
    {Mode::Native, "Native", "What the panel shows, px by px; drag it to see other parts"},
    {Mode::Lens, "Lens", "What an eye sees through the display's lenses"},
    {Mode::Stereo, "Stereo",
     "A picture for two eyes, for red-cyan glasses or as View > Two "
     "eyes says"}};

constexpr EyesPicture kEyesPictures[] = {
    EyesPicture::Anaglyph,   EyesPicture::AnaglyphHalf,   EyesPicture::AnaglyphGrey,
    EyesPicture::SideBySide, EyesPicture::SideBySideHalf, EyesPicture::Crossed,
    EyesPicture::TopBottom,  EyesPicture::TopBottomHalf,  EyesPicture::Rows,
    EyesPicture::Columns,    EyesPicture::Checkerboard};

constexpr int kMaxRecent = 10;
constexpr const char* kRecent = "recent";

// Fusion outlines boxes darker than the ground, which is not seen on a dark one.
class DarkStyle : public QProxyStyle {
  public:
    DarkStyle() : QProxyStyle("Fusion") {}
    void drawPrimitive(PrimitiveElement element, const QStyleOption* option, QPainter* painter,
                       const QWidget* widget) const override {
        QProxyStyle::drawPrimitive(element, option, painter, widget);
        if (element != PE_IndicatorCheckBox) return;
        painter->setPen(option->palette.color(QPalette::Disabled, QPalette::Text));
        painter->setBrush(Qt::NoBrush);
        painter->drawRect(option->rect.adjusted(0, 0, -1, -1));
    }
};

// Gives all windows dark colours, or those of the desktop.
void useDarkLook(bool dark) {
    static const QString kOwnStyle = QApplication::style()->objectName();
    static const QPalette kOwn = QApplication::palette();
    if (dark == (QApplication::palette().window().color().value() < 128)) return;
    QPalette palette = kOwn;
    if (dark) {
        palette = QPalette(QColor(53, 53, 53)); // the rest follows from the buttons
        palette.setColor(QPalette::Base, QColor(35, 35, 35));
        palette.setColor(QPalette::Highlight, QColor(42, 110, 170));
        palette.setColor(QPalette::HighlightedText, Qt::white);
        palette.setColor(QPalette::Link, QColor(110, 170, 230));
        palette.setColor(QPalette::ToolTipBase, QColor(70, 70, 70));
        palette.setColor(QPalette::ToolTipText, Qt::white);
        for (const auto role : {QPalette::WindowText, QPalette::Text, QPalette::ButtonText})
            palette.setColor(QPalette::Disabled, role, QColor(150, 150, 150));
        QApplication::setStyle(new DarkStyle); // not all styles take a palette
    } else {
        QApplication::setStyle(kOwnStyle);
    }
    QApplication::setPalette(palette);
}

// One name for each file, however it was reached.
QString pathOf(const QString& name) {
    const QString path = QFileInfo(name).canonicalFilePath();
    return path.isEmpty() ? QFileInfo(name).absoluteFilePath() : path;
}

} // namespace

QAction* MainWindow::action(QMenu& menu, const QString& text, const QKeySequence& keys,
                            const std::function<void()>& what) {
    QAction* result = menu.addAction(text);
    result->setShortcut(keys);
    connect(result, &QAction::triggered, this, what);
    return result;
}

QAction* MainWindow::action(QMenu& menu, const char* name, const QString& text,
                            const QKeySequence& keys, const std::function<void()>& what) {
    QAction* result = action(menu, text, keys, what);
    result->setObjectName(name);
    return result;
}

QAction* MainWindow::toggle(QMenu& menu, const char* name, const QString& text,
                            const QKeySequence& keys, const std::function<void(bool)>& what) {
    QAction* result = action(menu, name, text, keys, [] {});
    result->setCheckable(true);
    connect(result, &QAction::toggled, this, what);
    return result;
}

void MainWindow::changeEyes(const std::function<void(tools::EyesOptions&)>& change) {
    tools::EyesOptions eyes = stage_.eyes();
    change(eyes);
    stage_.setEyes(eyes);
}

void MainWindow::buildFileMenu(QToolBar& bar) {
    QMenu& file = *menuBar()->addMenu(tr("&File"));
    QAction* open = action(file, tr("&Open…"), QKeySequence::Open, [this] { openDialog(); });
    open->setIconText(tr("Open"));
    bar.addAction(open);
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
        {Product::SwayVideo, {}},
        {Product::Eyes, {}},
        {Product::Page, {}}};
    for (const auto& [product, keys] : products)
        products_.emplace_back(product, action(file, tr("Export %1…").arg(nameOf(product)), keys,
                                               [this, p = product] { exportDialog(p); }));
    products_.front().second->setIconText(tr("Export"));
    bar.addAction(products_.front().second);
    bar.addSeparator();
    exportVideo_ = action(file, "exportVideo", tr("Export &video…"),
                          QKeySequence(tr("Ctrl+Shift+E")), [this] { exportVideo(); });
    exportAll_ = action(file, "exportAll", tr("Export &all Natives…"), QKeySequence(tr("Ctrl+E")),
                        [this] { exportAllDialog(); });
    file.addSeparator();
    closeFile_ = action(file, tr("&Close file"), QKeySequence(tr("Ctrl+W")),
                        [this] { files_.close(files_.current()); });
    action(file, tr("&Quit"), QKeySequence(tr("Ctrl+Q")), [this] { close(); });
}

void MainWindow::buildEditMenu() {
    QMenu& edit = *menuBar()->addMenu(tr("&Edit"));
    QAction* undo = settings_.undoStack().createUndoAction(this, tr("&Undo"));
    undo->setShortcut(QKeySequence::Undo);
    QAction* redo = settings_.undoStack().createRedoAction(this, tr("&Redo"));
    redo->setShortcuts({QKeySequence(tr("Ctrl+Shift+Z")), QKeySequence(tr("Ctrl+Y"))});
    edit.addAction(undo);
    edit.addAction(redo);
    edit.addSeparator();
    action(edit, "paintDepth", tr("&Paint the depth"), QKeySequence(Qt::Key_B),
           [this] { paintBar_->setVisible(!paintBar_->isVisible()); });
    action(edit, "betterDepthMenu", tr("&Better depth…"), {}, [this] { betterDepthDialog(); });
    edit.addSeparator();
    action(edit, tr("Reset the &frame"), QKeySequence(Qt::Key_0), [this] { stage_.resetFrame(); });
    copyKnobs_ = action(edit, tr("&Copy settings to all files"), {}, [this] {
        settings_.copyTo(files_.sources());
        say(tr("All open files have these settings, each with its own frame"), 8000);
    });
    action(edit, tr("Reset &all settings"), QKeySequence(tr("Ctrl+R")),
           [this] { settings_.reset(); });
}

void MainWindow::buildViewMenu(QToolBar& bar) {
    QMenu& view = *menuBar()->addMenu(tr("&View"));
    modes_ = new QActionGroup(this);
    int number = 1;
    for (const ModeWords& words : kModes) {
        QAction* mode = action(view, tr(words.text), QKeySequence(QString::number(number++)),
                               [this, m = words.mode] { stage_.setMode(m); });
        mode->setCheckable(true);
        mode->setData(int(words.mode));
        mode->setToolTip(tr("%1 (%2)").arg(tr(words.tip)).arg(number - 1));
        modes_->addAction(mode);
    }
    view.addSeparator();
    bar.addActions(modes_->actions());
    bar.addSeparator();
    buildEyesMenu(view);
    swing_ = toggle(view, "", tr("S&wing automatically"), QKeySequence(Qt::Key_Space),
                    [this](bool on) { stage_.setSwinging(on); });
    swing_->setIconText(tr("Swing"));
    swing_->setToolTip(tr("The camera swings automatically (Space)"));
    follow_ = toggle(view, "", tr("&Follow the mouse"), QKeySequence(Qt::Key_M), [](bool) {});
    follow_->setIconText(tr("Follow mouse"));
    follow_->setToolTip(tr("The camera follows the mouse (M)"));
    bar.addActions({swing_, follow_});
    QAction* play = toggle(view, "", tr("&Play the video"), QKeySequence(Qt::Key_P),
                           [this](bool on) { files_.setPlaying(on); });
    play->setChecked(files_.isPlaying());
    connect(&files_, &Files::playingChanged, play, &QAction::setChecked);
    view.addSeparator();
    next_ = action(view, tr("&Next file"), QKeySequence(Qt::Key_PageDown),
                   [this] { files_.select(files_.current() + 1); });
    previous_ = action(view, tr("P&revious file"), QKeySequence(Qt::Key_PageUp),
                       [this] { files_.select(files_.current() - 1); });
    view.addSeparator();
    for (const QDockWidget* dock : findChildren<QDockWidget*>())
        if (dock != stripDock_) view.addAction(dock->toggleViewAction());
    showsStrip_ =
        toggle(view, "showsStrip", tr("S&trip of photos"), {}, [this](bool) { showStrip(); });
    dark_ = toggle(view, "dark", tr("Dar&k"), {}, useDarkLook);
}

void MainWindow::buildEyesMenu(QMenu& view) {
    constexpr double kStep = 0.25; // %
    QMenu& eyes = *view.addMenu(tr("&Two eyes"));
    eyesPictures_ = new QActionGroup(this);
    for (const EyesPicture picture : kEyesPictures) {
        QString words = tr(altiro3D::nameOf(picture).words);
        words[0] = words[0].toUpper();
        QAction* const entry = action(eyes, words, {}, [this, picture] {
            changeEyes([picture](tools::EyesOptions& to) { to.picture = picture; });
        });
        entry->setCheckable(true);
        entry->setData(int(picture));
        eyesPictures_->addAction(entry);
    }
    eyes.addSeparator();
    swapEyes_ =
        toggle(eyes, "swapEyes", tr("E&xchange the eyes"), QKeySequence(Qt::Key_X),
               [this](bool on) { changeEyes([on](tools::EyesOptions& to) { to.swapped = on; }); });
    const auto deeper = [this](double by) {
        changeEyes([by](tools::EyesOptions& to) {
            to.strengthPercent = std::clamp(to.strengthPercent + by, 0.0, kMaxEyesStrength);
        });
    };
    QAction* const more =
        action(eyes, tr("&More depth"), QKeySequence("Shift+Up"), [deeper] { deeper(kStep); });
    QAction* const less =
        action(eyes, tr("&Less depth"), QKeySequence("Shift+Down"), [deeper] { deeper(-kStep); });
    for (QAction* entry : {swapEyes_, more, less})
        entry->setShortcutContext(Qt::ApplicationShortcut); // also over a full screen
}

void MainWindow::showEyes() {
    const tools::EyesOptions& eyes = stage_.eyes();
    for (QAction* entry : eyesPictures_->actions())
        entry->setChecked(entry->data().toInt() == int(eyes.picture));
    swapEyes_->setChecked(eyes.swapped);
    knobs_->showEyes(stage_.mode() == Mode::Stereo, eyes.strengthPercent);
}

void MainWindow::buildDisplayMenu(QToolBar& bar) {
    QMenu& display = *menuBar()->addMenu(tr("&Display"));
    QAction* show = action(display, tr("&Show on the display"), QKeySequence(Qt::Key_F11),
                           [this] { showOnDisplay(); });
    show->setIconText(tr("Show on display"));
    show->setToolTip(tr("Full screen on the light-field display, px by px (F11)"));
    auto* room = new QWidget;
    room->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Preferred);
    bar.addWidget(room);
    bar.addAction(show);
    action(display, tr("Show for two &eyes"), QKeySequence("Shift+F11"), [this] { showForEyes(); });
    action(display, "slideShowMenu", tr("S&lide show…"), {}, [this] { showSlides(); });
    screens_ = display.addMenu(tr("S&creen"));
    screens_->setObjectName("screens");
    connect(screens_, &QMenu::aboutToShow, this, &MainWindow::fillScreens);
    action(display, "testPicture", tr("&Test picture"), {}, [this] { showTestPicture(); });
    action(display, "lensByEye", tr("Lens by e&ye…"), {}, [this] { lensByEye(); });
    action(display, tr("&Find displays…"), {}, [this] { tellDisplays(); });
    action(display, tr("&Choose calibration…"), {}, [this] { calibrationDialog(); });
}

void MainWindow::buildHelpMenu() {
    QMenu& help = *menuBar()->addMenu(tr("&Help"));
    action(help, "keys", tr("&Keys"), QKeySequence(Qt::Key_F1),
           [this] { keysDialog(this)->show(); });
    action(help, "manual", tr("&Manual"), QKeySequence(tr("Ctrl+F1")), [this] {
        const fs::path guide = dataFile("docs/guide.md");
        QUrl page = QUrl::fromLocalFile(toName(guide));
        page.setFragment("look-and-show");
        if (guide.empty())
            warn(this, tr("Manual"), tr("The manual is not installed with this copy of altiro3D"));
        else
            new Manual(page, this); // deletes itself
    });
    help.addSeparator();
    action(help, tr("&About altiro3D"), {}, [this] {
        QMessageBox::about(this, tr("About altiro3D"),
                           tr("<h3>altiro3D %1</h3><p>Photos and flat video as glasses-free 3D "
                              "pictures for light-field displays.</p><p>It is open source, under "
                              "the MIT licence.</p><p>With OpenCV %2 and Qt %3.</p>")
                               .arg(version(), CV_VERSION, qVersion()));
    });
}

void MainWindow::open(const std::vector<fs::path>& files) {
    if (files.empty()) return;
    stage_.setMode(Mode::Sway);
    const QString first = pathOf(toName(files.front()));
    const auto& sources = files_.sources();
    for (std::size_t i = 0; i < sources.size() && files.size() == 1; ++i)
        if (pathOf(toName(sources[i].file)) == first) return files_.select(int(i));
    files_.open(files);
    for (const fs::path& file : files)
        if (tools::isDirectory(file)) remember(file);
}

void MainWindow::remember(const fs::path& file) {
    QSettings settings;
    const QStringList recent = settings.value(kRecent).toStringList();
    const QString name = pathOf(toName(file));
    if (!recent.isEmpty() && recent.front() == name) return;
    QStringList names{name};
    for (const QString& other : recent)
        if (pathOf(other) != name && names.size() < kMaxRecent) names << other;
    settings.setValue(kRecent, names);
    settings.setValue("folder", QFileInfo(name).absolutePath());
}

void MainWindow::fillRecent() {
    recent_->clear();
    for (const QString& name : QSettings().value(kRecent).toStringList()) {
        const QFileInfo file(name);
        QString shown = tr("%1    in %2").arg(file.fileName(), file.path());
        shown.replace("&", "&&");
        QAction* entry = recent_->addAction(shown);
        entry->setToolTip(tipOf(name));
        connect(entry, &QAction::triggered, this, [this, name] { open({toPath(name)}); });
    }
    if (recent_->isEmpty()) recent_->addAction(tr("Nothing yet"))->setEnabled(false);
}

void MainWindow::fillScreens() {
    screens_->clear();
    const auto add = [this](const QString& text, const QString& name) {
        QAction* const entry = screens_->addAction(text);
        entry->setCheckable(true);
        entry->setChecked(name == screen_);
        connect(entry, &QAction::triggered, this, [this, name] { screen_ = name; });
    };
    add(tr("That of the display"), {});
    const std::vector<qt::ScreenFacts> screens = screenFacts();
    for (std::size_t i = 0; i < screens.size(); ++i) {
        const qt::ScreenFacts& screen = screens[i];
        const QString name = nameOf(screen, i);
        QString text = name;
        if (!screen.model.empty()) text += ", " + QString::fromStdString(screen.model);
        text += tr(", %1 × %2 px").arg(screen.size.width).arg(screen.size.height);
        add(text.replace("&", "&&"), name);
    }
}

void MainWindow::readSettings() {
    const QSettings settings;
    Knobs knobs;
    knobs.depth =
        settings.value("depth", QString::fromStdString(knobs.depth)).toString().toStdString();
    try { // the file may contain anything
        const QString recipe = settings.value("recipe").toString();
        if (!recipe.isEmpty())
            static_cast<Recipe&>(knobs) = parseRecipe(recipe.toStdString(), "recipe");
        settings_.restore(knobs);
    } catch (const Error&) {
        // then the defaults stay
    }
    tools::EyesOptions eyes = stage_.eyes();
    for (const EyesPicture picture : kEyesPictures)
        if (settings.value("eyes") == QVariant(altiro3D::nameOf(picture).option))
            eyes.picture = picture;
    eyes.swapped = settings.value("swapEyes").toBool();
    const double between = settings.value("eyesStrength", eyes.strengthPercent).toDouble();
    if (between >= 0 && between <= kMaxEyesStrength) eyes.strengthPercent = between;
    stage_.setEyes(eyes);
    stage_.setSwinging(settings.value("swing", true).toBool());
    showsStrip_->setChecked(settings.value("strip", true).toBool());
    follow_->setChecked(settings.value("follow", false).toBool());
    dark_->setChecked(settings.value("dark", false).toBool());
    screen_ = settings.value("screen").toString();
    restoreGeometry(settings.value("geometry").toByteArray());
    restoreState(settings.value("state").toByteArray());
    paintBar_->hide();
}

void MainWindow::writeSettings() const {
    QSettings settings;
    const Knobs& knobs = settings_.standardKnobs();
    settings.setValue("recipe", QString::fromStdString(recipeText(knobs)));
    settings.setValue("depth", QString::fromStdString(knobs.depth));
    const tools::EyesOptions& eyes = stage_.eyes();
    settings.setValue("eyes", altiro3D::nameOf(eyes.picture).option);
    settings.setValue("swapEyes", eyes.swapped);
    settings.setValue("eyesStrength", eyes.strengthPercent);
    settings.setValue("swing", swing_->isChecked() || swingsAfterPaint_);
    settings.setValue("strip", showsStrip_->isChecked());
    settings.setValue("follow", follow_->isChecked());
    settings.setValue("dark", dark_->isChecked());
    settings.setValue("screen", screen_);
    settings.setValue("geometry", saveGeometry());
    settings.setValue("state", saveState());
}

} // namespace altiro3D::viewer
