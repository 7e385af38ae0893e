#pragma once

#include "viewer/model/depth_maker.hpp"
#include "viewer/model/settings.hpp"
#include "viewer/model/worker.hpp"
#include "viewer/player/video_player.hpp"

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>

namespace altiro3D::viewer {

/// The open files, of which one is read in the background, and the player of a video.
class Files : public QObject {
    Q_OBJECT
  public:
    /// @param display the display that Natives are made for @param settings follow the current file
    Files(Display display, Settings& settings);

    /// Adds files and opens the first one. A photo and its depth image become one entry. A folder
    /// is replaced by its files when it is read, unless they are views of one scene.
    void open(const std::vector<std::filesystem::path>& files);
    void open(const std::vector<Source>& sources);
    void select(int index);
    void close(int index);
    /// Reads the current source again, as another kind or with another depth image.
    void reopen(Reading reading, const std::filesystem::path& depth);

    const std::vector<Source>& sources() const { return sources_; }
    int current() const { return current_; } ///< Index of a source; -1: none.
    /// The open document; null if there is none or it could not be read.
    const std::shared_ptr<const Document>& document() const { return document_; }
    bool isReading() const { return reading_; }
    /// Number of the latest reading; another one for every file that is opened.
    quint64 readings() const { return readings_; }
    /// Why the current source could not be read or played on; empty if it could.
    const QString& problem() const { return problem_; }

    const std::shared_ptr<const Display>& display() const { return display_; }
    void setDisplay(Display display);
    const std::shared_ptr<DepthMaker>& depthMaker() const { return depthMaker_; }

    bool isPlaying() const { return playing_; }
    void setPlaying(bool playing);
    // What the player of the open video tells; zeros if none is open.
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
    /// Notes that a picture was shown. If it is the latest one of the video, the next one may come.
    void noteShown(const std::shared_ptr<const Document>& picture);

  signals:
    void sourcesChanged();
    /// isReading(), problem() or display() has changed.
    void stateChanged();
    /// document() is that of another reading, or there is none.
    void opened();
    /// document() has another picture of the video.
    void pictureCame();
    void playingChanged(bool playing);
    void playSettingsChanged();

  private:
    /// Waits in the worker until the player has ended, then calls a function there.
    void endPlayer(std::function<void()> then);
    void readCurrent();
    void takeFiles(const Source& folder, const FolderFiles& found);
    void takeDepthWish(); // from the settings
    void play();

    Settings& settings_;
    std::vector<Source> sources_;
    int current_ = -1;
    std::shared_ptr<const Document> document_;
    QString problem_;
    Notes folderNotes_; // about a folder, for the first of its files
    bool reading_ = false;
    quint64 readings_ = 0; // results of earlier ones are dropped
    std::shared_ptr<const Display> display_;
    std::shared_ptr<DepthMaker> depthMaker_ = std::make_shared<DepthMaker>();
    bool playing_ = true;
    PlaySettings playSettings_;
    std::atomic<bool> pictureWaits_{false}; // a picture of the video is not shown yet
    std::optional<std::chrono::steady_clock::time_point> shownSince_; // of a picture, until shown
    std::mutex wishMutex_;
    std::string depthWish_ = kBestDepth; // Knobs::depth, for the player's thread
    EndingPlayers endingPlayers_;
    Worker worker_;
    std::shared_ptr<VideoPlayer> player_; // last: its pictures and their tasks use the rest
};

} // namespace altiro3D::viewer
