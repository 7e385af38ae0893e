#pragma once

#include "viewer/model/depth_canvas.hpp"
#include "viewer/model/files.hpp"
#include "viewer/model/studio.hpp"

#include <QElapsedTimer>
#include <map>
#include <tuple>

namespace altiro3D::viewer {

/// The picture of the current file as the window shows it, and what the mouse does to it.
///
/// A worker makes the pictures; a newer request replaces an older one.
class Stage : public QObject {
    Q_OBJECT
  public:
    Stage(Files& files, Settings& settings);

    /// Why the current source could not be opened or shown; empty if it could.
    const QString& problem() const {
        return files_.problem().isEmpty() ? problem_ : files_.problem();
    }
    /// True while a file is read, or while the first picture of a document or of another choice of
    /// depth is made.
    bool isBusy() const { return files_.isReading() || waiting_; }
    /// The last picture that was made; it may belong to an earlier document than the current one.
    const Frame& frame() const { return frame_; }
    /// Whether the picture belongs to the current file.
    bool isShown() const { return frame_.setup.document && frameReading_ == files_.readings(); }

    /// Uses depth networks that were installed since the start.
    void findNetworks();

    Mode mode() const { return mode_; }
    void setMode(Mode mode);
    /// Position of camera or eye, -1 leftmost .. +1 rightmost.
    double position() const { return position_; }
    void setPosition(double position);
    bool isSwinging() const { return swingTimer_.isActive(); }
    void setSwinging(bool swinging);
    /// How pictures for two eyes are made: in mode Stereo, on a screen, and when they are exported.
    const tools::EyesOptions& eyes() const { return eyes_; }
    void setEyes(const tools::EyesOptions& eyes);
    void setArea(cv::Size area); ///< For the picture, px of the screen.
    void panBy(cv::Point by);    ///< Moves a Native in its window, px.
    /// If true, also makes the whole Native after every change and emits nativeReady().
    /// @param eyesScreen px of a screen: the picture for two eyes that fills it, not the Native
    void setPresenting(bool presenting, cv::Size eyesScreen = {});

    /// Sets the focus to the depth at a position of the picture, x and y 0..1.
    void focusAt(double x, double y);
    /// Whether the picture in the window is a photo whose frame can be moved.
    bool canFrame() const;
    /// Moves the frame: content follows the mouse, up to the photo's ends.
    /// @param by in widths and heights of the picture in the window @param gesture as for turn()
    void moveFrame(cv::Point2d by, int gesture);
    /// Enlarges the content around a place of the picture, x and y 0..1.
    /// @param factor > 0 @param gesture as for turn()
    void zoomFrame(cv::Point2d at, double factor, int gesture);
    void resetFrame();

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
    /// Discards what was painted on the current photo; the user can undo it.
    void unpaint();
    /// What was painted on the current photo.
    PaintedDepth painted() const;
    bool isPainted() const { return !painted().depth.empty(); }
    /// The same of any source, by the source of the depth (DepthMaker::choose()).
    std::map<std::string, PaintedDepth> painted(const Source& source) const;
    /// Photos with painted depth that was not exported as a depth image.
    std::vector<std::filesystem::path> unsavedDepths() const;
    void setSaved(quint64 revision); ///< Notes that painted depth was exported.

  signals:
    /// Files::document(), Files::display(), problem() or isBusy() has changed.
    void stateChanged();
    void modeChanged();
    void swingingChanged(bool swinging);
    void eyesChanged();
    void frameReady();
    /// @param native [size of the panel, or of the screen for two eyes, CV_8UC3]
    void nativeReady(const cv::Mat& native);

  private:
    /// File, its depth image, its reading, and where its depth is from.
    using PaintKey = std::tuple<std::filesystem::path, std::filesystem::path, Reading, std::string>;
    struct Painted {
        PaintedDepth depth;
        int strokes = 0;
        bool isSaved = false;
    };
    void takeDocument();
    void takeKnobs();
    void swing();
    std::optional<Request> requestOf(Mode mode, cv::Size area) const;
    void requestFrame();
    void requestNative();
    void requestAll();
    void takeFrame(const Frame& frame, const QString& problem);
    void changeFrame(const QString& what, int gesture,
                     const std::function<Framing(const Framing&, const FramedPhoto&)>& change);

    PaintKey paintKey() const; // of the current photo
    PhotoFit shownFit() const;
    cv::Point2d inPhoto(cv::Point2d at) const;
    void useCanvas(const PaintKey& key, const cv::Mat& depth);
    void showCanvas(int strokes);
    void putPart(const PaintKey& key, const cv::Rect& place, const cv::Mat& part, int strokes);
    void setPainted(const PaintKey& key, const Painted& painted);

    Files& files_;
    Settings& settings_;
    QString problem_;      // of the picture
    bool waiting_ = false; // for the first picture of a document or of other depth
    Mode mode_ = Mode::Sway;
    double position_ = 0;
    QTimer swingTimer_;
    QElapsedTimer swingClock_;
    cv::Size area_;
    cv::Point pan_;
    bool presenting_ = false;
    cv::Size eyesScreen_; // that the picture for two eyes is presented on; empty: a Native is
    tools::EyesOptions eyes_{EyesPicture::Anaglyph};
    Frame frame_;
    quint64 frameReading_ = 0; // the reading that it belongs to
    std::map<PaintKey, Painted> painted_;
    std::unique_ptr<DepthCanvas> canvas_;
    PaintKey canvasKey_;
    Studio studio_; // used by worker_ alone
    Worker worker_; // last: its tasks use the rest
};

} // namespace altiro3D::viewer
