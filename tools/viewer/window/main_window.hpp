#pragma once

#include "viewer/model/model.hpp"

#include <QMainWindow>
#include <QPointer>
#include <QTimer>

class QActionGroup;
class QDockWidget;
class QLabel;
class QProgressBar;
class QToolBar;
class QToolButton;
namespace altiro3D::qt {
class NativeWidget;
struct ScreenFacts;
} // namespace altiro3D::qt

namespace altiro3D::viewer {

class KnobPanel;
class PaintBar;
class PhotoStrip;
class PictureView;
class SlidePresenter;
class VideoExportDialog;
class WelcomeCard;

/// The window: the picture, the settings on the right, several files below. QSettings
/// keeps its state from run to run.
class MainWindow : public QMainWindow {
    Q_OBJECT
  public:
    /// @param display the display that Natives are made for @param warnings about it, shown once
    MainWindow(const Display& display, const std::vector<std::string>& warnings);
    ~MainWindow() override;

    Model& model() { return model_; }

    /// Opens the sample photo with a card above it, until the user opens something or closes it
    /// once; then never again. No effect without the sample.
    /// @param display name of the display that was found; empty: none
    void welcome(const QString& display);

  protected:
    void closeEvent(QCloseEvent* event) override;
    void dragEnterEvent(QDragEnterEvent* event) override;
    void dragLeaveEvent(QDragLeaveEvent* event) override;
    void dropEvent(QDropEvent* event) override;
    void resizeEvent(QResizeEvent* event) override;

  private:
    void buildFileMenu(QToolBar& bar);
    void buildEditMenu();
    void buildViewMenu(QToolBar& bar);
    void buildEyesMenu(QMenu& view);
    void showEyes(); // the options of pictures for two eyes
    void buildDisplayMenu(QToolBar& bar);
    void buildHelpMenu();
    void buildStrip();
    void buildStatus();
    void buildPaintBar();
    void usePaintBar(); // after another choice
    void showPointer();
    void paint(double x, double y, bool shift);
    void connectModel();
    QAction* action(QMenu& menu, const QString& text, const QKeySequence& keys,
                    const std::function<void()>& what);
    QAction* action(QMenu& menu, const char* name, const QString& text, const QKeySequence& keys,
                    const std::function<void()>& what);
    /// Adds an entry that is on or off. @param what receives which, after every change
    QAction* toggle(QMenu& menu, const char* name, const QString& text, const QKeySequence& keys,
                    const std::function<void(bool)>& what);
    void changeEyes(const std::function<void(tools::EyesOptions&)>& change);

    /// Opens files in the usual mode; of files that are open already it shows the first one.
    void open(const std::vector<std::filesystem::path>& files);
    void openDialog();
    void openDepthDialog();
    void openDirectoryDialog();
    void showNetworks();
    void betterDepthDialog();
    void calibrationDialog();
    void useCalibration(const Calibration& calibration, const std::filesystem::path& file);
    void exportDialog(Product product);
    bool chooseEyes(); ///< How their pictures are arranged. @return false: cancelled
    void exportVideo();
    void endVideoExport(const VideoExportResult& result, const QString& problem);
    void exportAllDialog();
    void endExportAll(const BatchReport& report);
    void showProgress(bool runs); ///< Shows or hides the progress of an export.
    void showStrip();
    bool mayLosePaintedDepth();
    void showAction(); // after an action of the user: restarts the count of dropped pictures
    void showOnDisplay();
    void showForEyes();
    /// Full screen, until the user leaves it.
    qt::NativeWidget* showOn(QScreen& screen);
    void showTestPicture();
    void lensByEye();
    /// The screen that was chosen, or that of the display found; null, after a message, if there is
    /// none. The calibration of the display is used.
    QScreen* displayScreen();
    /// The screen that was chosen; null if none was, or, after a message, if it is not connected.
    std::optional<std::size_t> chosenScreen(const std::vector<qt::ScreenFacts>& screens);
    void fillScreens();
    void showSlides();
    void endSlides();
    void endWelcome();
    void tellDisplays();
    void remember(const std::filesystem::path& file);
    void fillRecent();
    void showSources();
    void showDocument();
    void showFrame();
    void showModes();
    void showLayout();
    /// Shows a message in the status bar for some time, one line per sentence.
    void say(const QString& text, int milliseconds);
    void showStatus();
    void readSettings();
    void writeSettings() const;

    Model model_;
    Settings& settings_ = model_.settings;
    Files& files_ = model_.files;
    Stage& stage_ = model_.stage;
    Exports& exports_ = model_.exports;
    PictureView* picture_;
    KnobPanel* knobs_ = nullptr;
    PhotoStrip* strip_ = nullptr;
    QDockWidget* stripDock_ = nullptr;
    QAction* showsStrip_ = nullptr;
    QActionGroup* modes_ = nullptr;
    QActionGroup* eyesPictures_ = nullptr;
    QAction* swapEyes_ = nullptr;
    QMenu* recent_ = nullptr;
    QMenu* screens_ = nullptr;
    QString screen_; // chosen by hand; empty: that of the display
    QAction* swing_ = nullptr;
    bool swingsAfterPaint_ = false;
    QAction* follow_ = nullptr;
    QAction* dark_ = nullptr;
    std::vector<std::pair<Product, QAction*>> products_;
    QAction* depthImage_ = nullptr;
    QAction* closeFile_ = nullptr;
    PaintBar* paintBar_ = nullptr;
    WelcomeCard* welcome_ = nullptr; // only while it is shown
    bool hasSample_ = false;         // the first file is the sample
    bool closesWhenSaved_ = false;   // once the painted depth is written
    std::int64_t droppedBefore_ = 0; // pictures of the video, before the user's last action
    QAction* exportAll_ = nullptr;
    QAction* exportVideo_ = nullptr;
    QPointer<VideoExportDialog> videoExport_; // while a video is exported
    QAction* copyKnobs_ = nullptr;
    QAction* next_ = nullptr;
    QAction* previous_ = nullptr;
    QLabel* status_ = nullptr;
    QString facts_;
    QString said_;
    QString notes_; // of the last document that had some
    QTimer unsay_;
    std::shared_ptr<const Document> told_; // its notes have been shown
    QLabel* busy_ = nullptr;
    QProgressBar* progress_ = nullptr;
    QToolButton* cancel_ = nullptr;
    std::unique_ptr<qt::NativeWidget> onDisplay_;
    std::vector<std::string> slideProblems_;
    std::unique_ptr<SlidePresenter> slides_; // while a slide show runs
};

} // namespace altiro3D::viewer
