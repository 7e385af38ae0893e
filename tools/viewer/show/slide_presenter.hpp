#pragma once

#include "altiro3D/qt/display_search.hpp"
#include "altiro3D/qt/native_widget.hpp"
#include "viewer/model/studio.hpp"
#include "viewer/model/worker.hpp"
#include "viewer/player/video_player.hpp"
#include "viewer/show/slide_show.hpp"

#include <QElapsedTimer>
#include <QFileSystemWatcher>
#include <QObject>
#include <QTimer>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>

class QKeyEvent;
class QScreen;

namespace altiro3D::viewer {

/// Makes the slides of a show: the Native of each file as the window makes it without changed
/// settings. One thread at a time.
class SlideMaker {
  public:
    /// @param display the display; nothing if its calibration is not known: then only Natives can
    ///        be shown
    /// @param eyes for a show for two eyes: a request of mode Stereo, whose display, document and
    ///        area are not used; nothing: Natives of all views
    SlideMaker(std::shared_ptr<const Display> display, qt::ScreenFacts screen,
               const std::optional<Request>& eyes = {});

    /// @param position of the viewer of a show for two eyes, see EyeSource
    /// @return a slide with a picture of the screen's size, or with a problem
    Slide make(const Source& source, double position = 0);

  private:
    qt::ScreenFacts screen_;
    Request request_; // without document
    std::shared_ptr<DepthMaker> depthMaker_;
    Studio studio_;
};

/// Runs a show on a screen: makes the slides in a thread, plays videos, fades, watches the folders,
/// follows the keys, and waits for a display that is unplugged.
class SlidePresenter : public QObject {
    Q_OBJECT
  public:
    /// @param files must have at least one file
    /// @param display, eyes as for SlideMaker
    /// @param report receives why a file is not shown, or not to its end
    SlidePresenter(const SlideShow::Settings& settings, ShowFiles files,
                   std::shared_ptr<const Display> display, const qt::ScreenFacts& screen,
                   std::function<void(const std::string&)> report,
                   const std::optional<Request>& eyes = {});
    ~SlidePresenter() override;

    /// How videos are played; each is shown once.
    void setPlaySettings(const PlaySettings& settings);
    const PlaySettings& playSettings() const { return playSettings_; }

    void start(QScreen& screen);
    /// The viewer of a show for two eyes has moved; the picture follows at once.
    void moveEyes(double position);

    const SlideShow& show() const { return show_; }
    const qt::NativeWidget& widget() const { return widget_; }
    /// Pictures of videos so far.
    VideoPlayer::Counts counts() const;

  signals:
    /// The show is over, or the user has left.
    void ended();

  protected:
    bool eventFilter(QObject* object, QEvent* event) override;

  private:
    bool onKey(const QKeyEvent& event);
    void make(const Source& source);
    void tick();
    void begin(const Slide& slide); // of what is shown from now on
    void draw();
    void endPlayer();
    void refresh();

    qt::NativeWidget widget_;
    ShowFiles files_;
    std::function<void(const std::string&)> report_;
    SlideShow show_;
    QElapsedTimer clock_;
    QTimer ticks_;
    QTimer rescan_;
    QFileSystemWatcher watcher_;
    int change_ = 0; // SlideShow::changes() of the slide that is on the screen
    cv::Mat native_; // of the slide or of the frame that is shown
    VideoPlayer::Counts counts_;
    PlaySettings playSettings_;
    std::atomic<qint64> deliveredAt_{0}; // ms of clock_, of the frame that arrives next
    Arrivals arrivals_;
    std::unique_ptr<VideoPlayer> player_;
    double eyesAt_ = 0; // where the viewer of a show for two eyes is
    std::shared_ptr<SlideMaker> maker_;
    std::unique_ptr<Worker> worker_; // last: it uses the others
};

} // namespace altiro3D::viewer
