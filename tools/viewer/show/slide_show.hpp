#pragma once

#include "viewer/model/document.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace altiro3D::viewer {

inline bool operator==(const Source& a, const Source& b) {
    return a.file == b.file && a.depth == b.depth;
}
inline bool operator!=(const Source& a, const Source& b) {
    return !(a == b);
}

/// The files of a show in the order in which they are shown, and the place in it. Files may join
/// and leave while the show runs.
class ShowList {
  public:
    /// @param shuffles shows the files in random order, each once before any is shown again
    ShowList(bool shuffles, bool loops, unsigned seed);

    /// Sets the files, in their natural order. The current file stays current; if it is gone,
    /// next() goes to the file that would have followed. With `shuffles` new files join the present
    /// round.
    void set(const std::vector<Source>& files);

    std::size_t size() const { return order_.size(); }
    /// The file at the present place. Nothing if there are no files, or its file has gone.
    std::optional<Source> current() const;
    /// What next() and previous() would make current. Nothing at the ends if the list does not
    /// loop.
    std::optional<Source> following();
    std::optional<Source> preceding() const;
    /// Goes on or back. @return false at the end: the place stays
    bool next();
    bool previous();

  private:
    std::vector<Source> round(); // a new order of all files
    std::size_t nextIndex() const { return isGone_ ? at_ : at_ + 1; }

    bool shuffles_;
    bool loops_;
    std::mt19937 random_;
    std::vector<Source> order_;
    std::vector<Source> nextRound_; // empty: not yet decided
    std::size_t at_ = 0;            // of order_; the file itself, or the one that follows it
    bool isGone_ = true;            // the current file has gone, or there was none yet
};

/// One file of a show, ready to be shown.
struct Slide {
    Source source;
    cv::Mat native; ///< [panel, CV_8UC3, BGR]; of a video the first picture.
    /// Makes the Native of a picture of a video, from its time in s; empty for other files.
    std::function<cv::Mat(const cv::Mat&, double)> nativeOfFrame;
    /// Makes the picture for eyes at another place, see EyeSource; empty: it stays.
    std::function<cv::Mat(double)> pictureFrom;
    std::string problem; ///< Why it cannot be shown; empty: it can.
    double madeFrom = 0; ///< With pictureFrom: the place that `native` is made for.

    bool isVideo() const { return static_cast<bool>(nativeOfFrame); }
};

/// Decides which file of a list is shown, when the next one is made, and when it is shown. Without
/// threads, windows and clocks: the caller tells the time, makes slides and shows pictures. At most
/// four slides are in memory: the shown one, the one that is wanted and its neighbours.
class SlideShow {
  public:
    struct Settings {
        double each = 20; ///< Time of a picture, s. A video is shown to its end.
        double fade = 0.5;
        bool loops = false;
        bool shuffles = false;
        unsigned seed = 0;
    };
    struct Work {
        /// Begins to make a slide; put() receives it, during the call or later.
        std::function<void(const Source&)> make;
        /// Receives the reason why a file is left out of the show.
        std::function<void(const std::string&)> report;
    };

    SlideShow(const Settings& settings, Work work);

    /// Sets the files of the show, in their natural order.
    void setFiles(const std::vector<Source>& files);
    void put(const Slide& slide);
    /// Goes on to the time `now`, in s; time does not go back.
    void tick(double now);
    /// Shows the next or the previous file as soon as it is made.
    void next() {
        if (list_.next()) wanted_ = list_.current();
    }
    void previous() {
        if (list_.previous()) wanted_ = list_.current();
    }
    void setPaused(bool paused) { isPaused_ = paused; }
    void endVideo();

    bool isPaused() const { return isPaused_; }
    /// True after the last file, or if no file can be shown.
    bool isOver() const { return isOver_; }
    bool hasShown() const { return shown_.has_value(); }
    bool isFading() const { return !before_.empty(); }
    /// The slide that is shown; null before the first one. Valid until the next call of tick().
    const Slide* shown() const { return shown_ ? &*shown_ : nullptr; }
    /// Grows when another slide is shown.
    int changes() const { return changes_; }
    /// Blends into a picture of the slide that is shown, for the time of the last tick(). Each
    /// sub-pixel of a Native belongs to one view, so a blend of two Natives shows the blend of
    /// their views.
    /// @param native its Native, or that of a frame of its video
    /// @param blended the picture to show; shares memory with `native` when nothing fades
    void blend(const cv::Mat& native, cv::Mat& blended) const;
    std::size_t slidesKept() const { return kept_.size() + (shown_ ? 1U : 0U); }

  private:
    const Slide* ready(const Source& source) const;
    void show(const Slide& slide);
    void request();
    void prune();

    Settings settings_;
    Work work_;
    ShowList list_;
    std::vector<Source> all_;
    std::vector<Source> files_; // all without those that failed
    std::vector<Source> failed_;
    std::vector<Slide> kept_;
    std::optional<Slide> shown_;
    std::optional<Source> wanted_; // to be shown as soon as it is ready
    std::optional<Source> making_;
    cv::Mat before_; // what fades out
    double now_ = 0;
    double since_ = 0;     // when the shown slide began, without the time of pauses
    double fadeSince_ = 0; // when the fade began: pauses do not stop it
    bool isPaused_ = false;
    bool isOver_ = false;
    int changes_ = 0;
};

/// Sizes and times of files: another text means that the contents have changed.
using FileStamps = std::map<std::filesystem::path, std::string>;

/// Tells files that are still being written: their size or time has changed within kSeconds.
class SteadyFiles {
  public:
    static constexpr double kSeconds = 2;

    /// @param stamps those of all files; at the first call all of them are steady
    /// @param now s, from any start
    /// @return the files that are steady
    std::set<std::filesystem::path> look(const FileStamps& stamps, double now);
    bool isWaiting() const { return isWaiting_; }

  private:
    struct Known {
        std::string stamp;
        double since; // s
    };
    std::map<std::filesystem::path, Known> known_;
    bool hasLooked_ = false;
    bool isWaiting_ = false;
};

/// The files of a show: those that were named, and what the named folders hold now, by the rules of
/// photo2native's folders.
class ShowFiles {
  public:
    /// What does not exist and what is left out becomes a note.
    /// @param names files and folders
    /// @throws Error NotFound (there is nothing to show), ReadFailed, and as searchFolder()
    explicit ShowFiles(const std::vector<std::filesystem::path>& names);

    /// In the order of the names, those of a folder in natural order.
    const std::vector<Source>& files() const { return files_; }
    const std::vector<std::filesystem::path>& folders() const { return folders_; }
    const Notes& notes() const { return notes_; }

    /// Reads the folders again if they have changed. Files that have gone leave. Those that are
    /// being written stay out until they are steady, and come back with their new contents.
    /// @param now s, from any start
    /// @return false if such a file waits: call it again
    bool refresh(double now);

  private:
    std::vector<std::filesystem::path> names_;
    std::vector<std::filesystem::path> folders_;
    std::vector<Source> files_;
    Notes notes_;
    FileStamps stamps_; // of the last refresh()
    SteadyFiles steady_;
};

} // namespace altiro3D::viewer
