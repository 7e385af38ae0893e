#pragma once

#include "viewer/making.hpp"

#include <memory>

namespace altiro3D::viewer {

/// How a document is looked at.
enum class Mode {
    Sway,   ///< One view, from a camera that moves.
    Depth,  ///< The depth map, near = white.
    Quilt,  ///< All views.
    Native, ///< What the panel shows, px by px.
    Lens    ///< What an eye sees of the Native through the lenses.
};

/// The modes that a kind of document has; the first is the one to begin with.
std::vector<Mode> modesOf(Kind kind);

/// A picture to be made for the window.
struct Request {
    std::shared_ptr<const Document> document;
    Knobs knobs;
    std::shared_ptr<const Display> display;
    Mode mode = Mode::Sway;
    double position = 0; ///< Of camera or eye, -1 leftmost .. +1 rightmost.
    cv::Size area;       ///< Room for it, px of the screen.
    cv::Point pan;       ///< Native: px that it is moved by, from the middle.
};

/// A picture for the window.
struct Frame {
    Request request;
    cv::Mat picture;           ///< [CV_8UC3, BGR]
    cv::Size target;           ///< Px of the screen to show it on; its own size where it is exact.
    cv::Mat depth;             ///< Sway, Depth: that of the fitted photo; else empty.
    Setup setup;               ///< With the whole depth, for exports.
    std::string depthSource;   ///< Where the depth comes from, for people; empty without depth.
    double parallaxPixels = 0; ///< Of a photo: between adjacent views, px of a view.
};

class DepthMaker;

/// Makes the pictures for the window and keeps what the next one can use again. One thread at a
/// time.
class Studio {
  public:
    /// @param depthMaker for photos without depth of their own
    explicit Studio(std::shared_ptr<DepthMaker> depthMaker);
    ~Studio();

    /// @throws Error and what the library throws
    Frame render(const Request& request);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The largest size of a shape inside an area.
cv::Size inside(cv::Size area, double aspect);

/// The depth of the photo's px that is seen at a place of a view.
/// @param depth of the fitted photo @param position of the camera @param at in px of the view
double depthSeenAt(const cv::Mat& depth, const ViewOptions& views, double position, cv::Point at);

} // namespace altiro3D::viewer
