#pragma once

#include "viewer/studio.hpp"
#include "viewer/video_player.hpp"
#include "viewer/worker.hpp"

#include <QElapsedTimer>
#include <QObject>
#include <QTimer>
#include <QUndoStack>
#include <atomic>
#include <mutex>

namespace altiro3D::viewer {

/// The viewer without its window: what is open, how it is looked at, and the work that this takes.
///
/// Lives in one thread and never blocks it: a worker reads files and makes pictures, and a newer
/// request replaces an older one. Exports have their own worker. Ends cleanly at any time.
class Controller : public QObject {
    Q_OBJECT
  public:
    /// @param display with its calibration
    explicit Controller(Display display, QObject* parent = nullptr);
    /// Cancels what it can and waits for the rest.
    ~Controller() override;

    /// Adds files (photos with their depth images as one) and opens the first of them.
    void open(const std::vector<std::filesystem::path>& files);
    /// Adds one thing and opens it.
    void open(const Source& source);
    /// Opens one of the list again, for instance after its Source has been changed.
    void select(int index);
    /// Takes one from the list.
    void close(int index);
    /// Opens the current one as something else, or with another depth image.
    void reopen(Reading reading, const std::filesystem::path& depth);

    const std::vector<Source>& sources() const { return sources_; }
    /// Index of the current one; -1 without any.
    int current() const { return current_; }
    /// What is open; null while nothing is, or if it could not be read.
    const std::shared_ptr<const Document>& document() const { return document_; }
    /// Why the current one could not be opened or shown; empty if it could.
    const QString& problem() const { return playerProblem_.isEmpty() ? problem_ : playerProblem_; }
    /// Some reading or depth estimation is under way.
    bool isBusy() const { return opening_ || waiting_; }

    const Knobs& knobs() const { return knobs_; }
    /// Turns knobs.
    /// @param what is turned, for the list of what can be undone
    /// @param gesture turns with the same number (not 0) are undone as one
    void turn(const Knobs& knobs, const QString& what, int gesture = 0);
    /// All knobs as they are at first, which can be undone.
    void resetKnobs();
    /// Knobs from the settings; not undone.
    void restoreKnobs(const Knobs& knobs);
    QUndoStack& undoStack() { return undoStack_; }

    const Display& display() const { return *display_; }
    void setDisplay(Display display);

    Mode mode() const { return mode_; }
    void setMode(Mode mode);
    /// Of camera or eye, -1 .. +1.
    double position() const { return position_; }
    void setPosition(double position);
    /// The camera swings by itself, in modes Sway and Lens.
    bool isSwinging() const { return swinging_; }
    void setSwinging(bool swinging);
    /// A video plays; at first it does.
    bool isPlaying() const { return playing_; }
    void setPlaying(bool playing);
    /// Of the video that is open; zeros without one.
    VideoPlayer::Counts videoCounts() const;
    /// Room for the picture, px of the screen.
    void setArea(cv::Size area);
    /// Moves a Native in its window, px.
    void panBy(cv::Point by);
    /// Sets the focus to what is seen at a place of the picture, each 0..1.
    void focusAt(double x, double y);

    /// The whole Native is made, too, whenever something changes: for nativeReady().
    void setPresenting(bool presenting);

    /// The last picture that was made; its document may be one before the current.
    const Frame& frame() const { return frame_; }

    /// Why nothing can be exported just now, for people; empty if it can.
    QString exportObstacle() const;
    /// What would be exported. Only where exportObstacle() is empty.
    Setup exportSetup() const;
    /// Writes a product of what is shown. @return false if exportObstacle() says why not
    bool startExport(Product product, const std::filesystem::path& target);
    void cancelExport() { cancelling_ = true; }
    bool isExporting() const { return exporting_; }

  signals:
    void sourcesChanged();
    /// Another document, another problem, or busy or no more.
    void documentChanged();
    void knobsChanged();
    void displayChanged();
    void modeChanged();
    void swingingChanged(bool swinging);
    void frameReady();
    /// @param native [panel size, CV_8UC3]
    void nativeReady(const cv::Mat& native);
    /// The next picture of a video waits to be taken.
    void pictureArrived();
    void exportProgress(double done);
    /// @param problem empty if it was written, or cancelled
    void exportEnded(const QString& file, const QString& problem);

  private:
    class Turn;
    void setKnobs(const Knobs& knobs);
    /// Waits for the player and does something, both in the worker.
    void endPlayer(std::function<void()> then);
    void readCurrent();
    void requestFrame();
    void requestNative();
    void takeFrame(const Frame& frame);
    void swing();
    void play();
    void takePicture();

    std::vector<Source> sources_;
    int current_ = -1;
    std::shared_ptr<const Document> document_;
    QString problem_;
    QString playerProblem_; // why the video plays no more
    bool opening_ = false;
    bool waiting_ = false; // for the first picture of a document or of other depth
    quint64 readings_ = 0; // so that an overtaken one is known
    Knobs knobs_;
    QUndoStack undoStack_;
    std::shared_ptr<const Display> display_;
    Mode mode_ = Mode::Sway;
    double position_ = 0;
    bool swinging_ = false;
    QTimer swingTimer_;
    QElapsedTimer swingClock_;
    cv::Size area_;
    cv::Point pan_;
    bool presenting_ = false;
    bool playing_ = true;
    quint64 frameReading_ = 0; // which reading the last frame is of
    Frame frame_;
    bool exporting_ = false;
    std::atomic<bool> cancelling_{false};
    std::atomic<bool> pictureWaits_{false}; // of a video: not shown yet
    struct Arrival {
        quint64 reading = 0;                      // which one it is of
        std::shared_ptr<const Document> document; // null: no more, because of
        QString problem;
    };
    std::mutex arrivalMutex_;
    Arrival arrival_;                    // from the player's thread
    std::string depthWish_ = kBestDepth; // for it: Knobs::depth

    std::shared_ptr<DepthMaker> depthMaker_;
    std::shared_ptr<Studio> studio_; // used by worker_ alone
    EndingPlayers endingPlayers_;
    Worker exporter_;
    Worker worker_;
    std::shared_ptr<VideoPlayer> player_; // last: its pictures and their tasks use the rest
};

} // namespace altiro3D::viewer
