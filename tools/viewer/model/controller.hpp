#pragma once

#include "viewer/model/depth_canvas.hpp"
#include "viewer/model/knobs.hpp"
#include "viewer/model/studio.hpp"
#include "viewer/model/video_export.hpp"
#include "viewer/model/worker.hpp"
#include "viewer/player/video_player.hpp"

#include <QElapsedTimer>
#include <QObject>
#include <QTimer>
#include <QUndoStack>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <tuple>

namespace altiro3D::viewer {

/// A photo or quilt of which a Native is exported.
struct BatchItem {
    Source source;
    Knobs knobs;
    std::filesystem::path native; ///< The file to write, which is replaced if it exists.
    /// What was painted on its depth, by the source of the depth (DepthMaker::choose()).
    std::map<std::string, PaintedDepth> painted;
};

struct BatchReport {
    std::size_t written = 0;
    std::vector<std::string> problems; ///< One sentence for each file that was not exported.
    bool cancelled = false;
};

/// Names the Natives of many files in one folder, as photo2native names those of a folder:
/// `a.jpg` becomes `a_native.png`. Files of the same name in several folders get a number.
std::vector<std::filesystem::path> nativesOf(const std::vector<Source>& sources,
                                             const std::filesystem::path& folder);

/// The viewer without its window: the open files, the state of the view, and the work in the
/// background.
///
/// Used from one thread, which it never blocks: a worker reads files and makes pictures, and a
/// newer request replaces an older one. Exports have their own worker. It can be destroyed at any
/// time.
class Controller : public QObject {
    Q_OBJECT
  public:
    /// @param display the display that Natives are made for
    explicit Controller(Display display, QObject* parent = nullptr);
    /// Cancels an export and waits for the remaining work.
    ~Controller() override;

    /// Adds files and opens the first one. A photo and its depth image become one entry. A folder
    /// is replaced by its files when it is read, unless they are views of one scene.
    void open(const std::vector<std::filesystem::path>& files);
    void open(const Source& source);
    void select(int index);
    void close(int index);
    /// Reads the current source again, as another kind or with another depth image.
    void reopen(Reading reading, const std::filesystem::path& depth);

    const std::vector<Source>& sources() const { return sources_; }
    int current() const { return current_; } ///< Index of a source; -1: none.
    /// The open document; null if there is none or it could not be read.
    const std::shared_ptr<const Document>& document() const { return document_; }
    /// Why the current source could not be opened or shown; empty if it could.
    const QString& problem() const { return playerProblem_.isEmpty() ? problem_ : playerProblem_; }
    /// True while a file is read, or while the first picture of a document or of another choice of
    /// depth is made.
    bool isBusy() const { return opening_ || waiting_; }

    /// The settings of the current file: those that the user made for it, in this run or an earlier
    /// one, else standardKnobs().
    const Knobs& knobs() const { return knobs_; }
    /// The settings of files without their own.
    const Knobs& standardKnobs() const { return standardKnobs_; }
    /// Gives the current settings to all open files, and to those that are opened later and have
    /// none of their own. Each keeps its frame.
    void copyKnobsToAll();
    /// Why settings are not kept from run to run, one sentence; empty if they are.
    QString storeNote() const { return QString::fromStdString(store_.note()); }
    /// Changes settings; the user can undo it until another file is opened.
    /// @param what name of the setting, for the undo menu
    /// @param gesture consecutive changes with the same number (not 0) are undone together
    void turn(const Knobs& knobs, const QString& what, int gesture = 0);
    void resetKnobs(); ///< As turn(), to the defaults.
    /// Sets standardKnobs(), and the current settings; this cannot be undone.
    void restoreKnobs(const Knobs& knobs);
    QUndoStack& undoStack() { return undoStack_; }

    /// Uses depth networks that were installed since the start.
    void findNetworks();

    const Display& display() const { return *display_; }
    void setDisplay(Display display);

    Mode mode() const { return mode_; }
    void setMode(Mode mode);
    /// Position of camera or eye, -1 leftmost .. +1 rightmost.
    double position() const { return position_; }
    void setPosition(double position);
    bool isSwinging() const { return swinging_; }
    void setSwinging(bool swinging);
    bool isPlaying() const { return playing_; }
    void setPlaying(bool playing);
    // Of the open video; zeros if none is open.
    VideoPlayer::Counts videoCounts() const {
        return player_ ? player_->counts() : VideoPlayer::Counts();
    }
    VideoPlayer::State videoState() const {
        return player_ ? player_->state() : VideoPlayer::State();
    }
    /// How videos are played; the track belongs to the open one.
    const PlaySettings& playSettings() const { return playSettings_; }
    void setPlaySettings(const PlaySettings& settings);
    void seekVideo(double seconds) {
        if (player_) player_->seek(seconds);
    }
    /// How pictures for two eyes are made: in mode Stereo, on a screen, and when they are exported.
    const tools::EyesOptions& eyes() const { return eyes_; }
    void setEyes(const tools::EyesOptions& eyes);
    void setArea(cv::Size area); ///< For the picture, px of the screen.
    void panBy(cv::Point by);    ///< Of a Native in its window, px.
    /// Sets the focus to the depth at a position of the picture, x and y 0..1.
    void focusAt(double x, double y);

    /// Whether a stroke can begin: the window shows a photo or its depth, from the middle.
    bool canPaint() const;
    /// Begins a stroke that changes the depth of the current photo; the user can undo it. Depth
    /// that was painted stays with the photo and the source of its depth until the program ends.
    /// @param at of the picture in the window, x and y 0..1; may lie outside
    /// @return false if canPaint() is false or the picture is not up to date
    bool beginStroke(const Paint& paint, cv::Point2d at);
    void continueStroke(cv::Point2d at);
    void endStroke();
    /// A brush's radius in widths of the picture in the window. @param radius see Paint
    double brushRadius(double radius) const;
    bool isPainted() const { return !paintedNow().depth.empty(); }
    /// Discards what was painted on the current photo; the user can undo it.
    void unpaint();
    /// Photos with painted depth that was not exported as a depth image.
    std::vector<std::filesystem::path> unsavedDepths() const;

    /// Whether the picture in the window is a photo whose frame can be moved.
    bool canFrame() const;
    /// Moves the frame: content follows the mouse, up to the photo's ends.
    /// @param by in widths and heights of the picture in the window @param gesture as for turn()
    void moveFrame(cv::Point2d by, int gesture);
    /// Enlarges the content around a place of the picture, x and y 0..1.
    /// @param factor > 0 @param gesture as for turn()
    void zoomFrame(cv::Point2d at, double factor, int gesture);
    void resetFrame();

    /// If true, also makes the whole Native after every change and emits nativeReady().
    /// @param eyesScreen px of a screen: the picture for two eyes that fills it, not the Native
    void setPresenting(bool presenting, cv::Size eyesScreen = {});

    /// The last picture that was made; it may belong to an earlier document than the current one.
    const Frame& frame() const { return frame_; }

    /// Why nothing can be exported now, for people; empty if an export is possible.
    QString exportObstacle() const;
    /// The setup for an export; valid only if exportObstacle() is empty.
    Setup exportSetup() const;
    /// Starts to write a product of the current picture. @return false if exportObstacle() is not
    /// empty
    bool startExport(Product product, const std::filesystem::path& target);
    /// What startExportAll() writes: the Natives of the open files, in a folder.
    std::vector<BatchItem> batch(const std::filesystem::path& folder) const;
    /// Starts to write them, each with the settings of its file. @return false if an export is
    /// under way or nothing is open
    bool startExportAll(const std::filesystem::path& folder);
    /// Why the open file cannot be exported as a Native video, for people; empty if it can.
    QString videoExportObstacle() const;
    /// Starts to make a Native video of the open video, see exportVideo(), and stops playing it.
    /// @param goesOn continue an unfinished run of that file
    /// @return false if videoExportObstacle() is not empty
    bool startVideoExport(const std::filesystem::path& file, bool goesOn);
    void cancelExport() { cancelling_ = true; }
    bool isExporting() const { return exporting_; }

  signals:
    void sourcesChanged();
    /// document(), problem() or isBusy() has changed.
    void documentChanged();
    void knobsChanged();
    void displayChanged();
    void modeChanged();
    void swingingChanged(bool swinging);
    void playingChanged(bool playing);
    void playSettingsChanged();
    void eyesChanged();
    void frameReady();
    /// @param native [size of the panel, or of the screen for two eyes, CV_8UC3]
    void nativeReady(const cv::Mat& native);
    void exportProgress(double done);
    /// @param problem empty if the file was written or the export was cancelled
    void exportEnded(const QString& file, const QString& problem);
    void exportAllEnded(const BatchReport& report);
    void videoExportProgress(const VideoExportState& state);
    /// @param problem empty if the file was written or the export was cancelled
    void videoExportEnded(const VideoExportResult& result, const QString& problem);

  private:
    /// File, its depth image, its reading, and where its depth is from.
    using PaintKey = std::tuple<std::filesystem::path, std::filesystem::path, int, std::string>;
    struct Painted {
        PaintedDepth depth;
        int strokes = 0;
        bool isSaved = false;
    };
    PaintKey paintKey() const; // of the current photo
    PaintedDepth paintedNow() const;
    PhotoFit shownFit() const;
    cv::Point2d inPhoto(cv::Point2d at) const;
    void showCanvas(int strokes);
    void putPart(const PaintKey& key, const cv::Rect& place, const cv::Mat& part, int strokes);
    void setSaved(quint64 revision); // of painted depth
    void setPainted(const PaintKey& key, const Painted& painted);
    /// Sets the settings of the current file, or the standard ones if none is open.
    void setKnobs(const Knobs& knobs);
    void showKnobs(const Knobs& knobs);
    /// Sets the settings that belong to the current file, if it is another one than before.
    void changeKnobs();
    Knobs knobsOf(const std::filesystem::path& file) const;
    /// Waits in the worker until the player has ended, then calls a function there.
    void endPlayer(std::function<void()> then);
    void readCurrent();
    void takeFiles(const Source& folder, const FolderFiles& found);
    Progress beginExport();   ///< @return receives the progress
    Knobs videoKnobs() const; // with the depth that is used
    void requestFrame();
    void requestNative();
    void takeFrame(const Frame& frame);
    void noteShown(const Frame& frame);
    FramedPhoto framedPhoto() const;
    /// The settings with the frame that is shown, which the user moves from now on.
    Knobs withFrame() const;
    void swing();
    void play();
    void takePicture(const std::shared_ptr<const Document>& document,
                     std::chrono::steady_clock::time_point since);

    std::vector<Source> sources_;
    int current_ = -1;
    std::shared_ptr<const Document> document_;
    QString problem_;
    Notes folderNotes_;     // about a folder, for the first of its files
    QString playerProblem_; // why the video stopped
    bool opening_ = false;
    bool waiting_ = false; // for the first picture of a document or of other depth
    quint64 readings_ = 0; // number of the latest reading; results of earlier ones are dropped
    Knobs knobs_;
    Knobs standardKnobs_;
    std::filesystem::path knobsFile_; // the file that knobs_ belongs to; empty: none
    KnobStore store_{KnobStore::standardFile()};
    QTimer storeTimer_;
    std::map<PaintKey, Painted> painted_;
    std::unique_ptr<DepthCanvas> canvas_;
    PaintKey canvasKey_;
    PaintTool tool_ = PaintTool::Nearer;
    QUndoStack undoStack_;
    std::shared_ptr<const Display> display_;
    Mode mode_ = Mode::Sway;
    double position_ = 0;
    QTimer restTimer_; // runs while a setting moves: Natives are drafts
    bool swinging_ = false;
    QTimer swingTimer_;
    QElapsedTimer swingClock_;
    cv::Size area_;
    cv::Point pan_;
    bool presenting_ = false;
    cv::Size eyesScreen_; // that the picture for two eyes is presented on; empty: a Native is
    tools::EyesOptions eyes_{EyesPicture::Anaglyph};
    bool playing_ = true;
    PlaySettings playSettings_;
    quint64 frameReading_ = 0; // the reading that the last frame belongs to
    Frame frame_;
    bool exporting_ = false;
    std::atomic<bool> cancelling_{false};
    std::atomic<bool> pictureWaits_{false}; // a picture of the video is not shown yet
    std::optional<std::chrono::steady_clock::time_point> shownSince_; // of a picture, until shown
    std::mutex wishMutex_;
    std::string depthWish_ = kBestDepth; // Knobs::depth, for the player's thread

    std::shared_ptr<DepthMaker> depthMaker_;
    std::shared_ptr<Studio> studio_; // used by worker_ alone
    EndingPlayers endingPlayers_;
    Worker exporter_;
    Worker worker_;
    std::shared_ptr<VideoPlayer> player_; // last: its pictures and their tasks use the rest
};

} // namespace altiro3D::viewer
