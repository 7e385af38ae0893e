#pragma once

#include "viewer/model/making.hpp"

#include <QtGlobal>
#include <memory>

namespace altiro3D::viewer {

/// What the window shows of a document.
enum class Mode {
    Sway,   ///< One view, from a camera that moves.
    Depth,  ///< The depth map, near = white.
    Quilt,  ///< All views.
    Native, ///< What the panel shows, px by px.
    Lens,   ///< What an eye sees of the Native through the lenses.
    Stereo  ///< For two eyes: the whole photo as Request::eyes says.
};

/// The modes of a kind of document; the first one is the default.
std::vector<Mode> modesOf(Kind kind);

/// Depth that the user has painted.
struct PaintedDepth {
    cv::Mat depth{};      ///< [any size, CV_32FC1, 0..1], shows all of the photo; empty: none.
    quint64 revision = 0; ///< Another number for every other content.
};

/// A request for a picture for the window.
struct Request {
    std::shared_ptr<const Document> document;
    Knobs knobs;
    std::shared_ptr<const Display> display;
    Mode mode = Mode::Sway;
    double position = 0;    ///< Position of camera or eye, -1 leftmost .. +1 rightmost.
    cv::Size area;          ///< Area for the picture, px of the screen.
    cv::Point pan;          ///< Mode Native: offset from the middle, px.
    PaintedDepth painted{}; ///< Takes the place of the photo's depth.
    bool isDraft = false;   ///< Modes Sway and Depth: fewer px; Native and Lens: as Setup::isDraft.
    tools::EyesOptions eyes{}; ///< Mode Stereo.
    bool fills =
        false; ///< Mode Stereo: each eye's picture has black bars, so that the area is full.
};

/// A picture for the window.
struct Frame {
    Request request;
    cv::Mat picture;           ///< [CV_8UC3, BGR]
    cv::Size target;           ///< Size on the screen, px; the picture's size if shown exactly.
    cv::Mat depth;             ///< Sway, Depth: depth of the fitted photo; else empty.
    Setup setup;               ///< With the whole depth, for exports.
    std::string depthSource;   ///< Source of the depth, for people; empty without depth.
    double parallaxPixels = 0; ///< Of a photo: parallax between adjacent views, px of a view.
    double hiddenPercent = 0;  ///< Of a photo: see viewer::hiddenPercent().
};

class DepthMaker;

/// Makes the pictures for the window and caches intermediate results for the next one. One thread
/// at a time.
class Studio {
  public:
    /// @param depthMaker for photos without their own depth
    explicit Studio(std::shared_ptr<DepthMaker> depthMaker);
    ~Studio();

    /// @throws Error and other exceptions of the library
    Frame render(const Request& request);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The largest size with an aspect that fits into an area.
cv::Size inside(cv::Size area, double aspect);

/// The depth of the photo's px that is visible at a position of a view.
/// @param depth of the fitted photo @param position of the camera @param at in px of the view
double depthSeenAt(const cv::Mat& depth, const ViewOptions& views, double position, cv::Point at);

} // namespace altiro3D::viewer
