#pragma once

#include "viewer/model/stage.hpp"
#include "viewer/model/video_export.hpp"

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

/// Writes files in the background, one export at a time: of the picture, of all open files, or of a
/// video.
class Exports : public QObject {
    Q_OBJECT
  public:
    Exports(Files& files, Settings& settings, Stage& stage);
    /// Cancels an export and waits for its end.
    ~Exports() override;

    bool areRunning() const { return running_; }
    void cancel() { cancelling_ = true; }

    /// Why nothing can be exported now, for people; empty if an export is possible.
    QString obstacle() const;
    /// The setup for an export; valid only if obstacle() is empty.
    Setup setup() const;
    /// Starts to write a product of the current picture. @return false if obstacle() is not empty
    bool start(Product product, const std::filesystem::path& target);
    /// What startAll() writes: the Natives of the open files, in a folder.
    std::vector<BatchItem> batch(const std::filesystem::path& folder) const;
    /// Starts to write them, each with the settings of its file. @return false if an export is
    /// under way or nothing is open
    bool startAll(const std::filesystem::path& folder);
    /// Why the open file cannot be exported as a Native video, for people; empty if it can.
    QString videoObstacle() const;
    /// Starts to make a Native video of the open video, see exportVideo(), and stops playing it.
    /// @param goesOn continue an unfinished run of that file
    /// @return false if videoObstacle() is not empty
    bool startVideo(const std::filesystem::path& file, bool goesOn);

  signals:
    void progress(double done);
    /// @param problem empty if the file was written or the export was cancelled
    void ended(const QString& file, const QString& problem);
    void allEnded(const BatchReport& report);
    void videoProgress(const VideoExportState& state);
    /// @param problem empty if the file was written or the export was cancelled
    void videoEnded(const VideoExportResult& result, const QString& problem);

  private:
    /// @param work runs in the background and returns what is called here at its end
    void run(std::function<std::function<void()>()> work);
    Progress teller();        ///< Tells the progress.
    Knobs videoKnobs() const; // with the depth that is used

    Files& files_;
    Settings& settings_;
    Stage& stage_;
    bool running_ = false;
    std::atomic<bool> cancelling_{false};
    Worker worker_; // last: its tasks use the rest
};

} // namespace altiro3D::viewer
