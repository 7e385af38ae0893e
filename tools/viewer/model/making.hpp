#pragma once

#include "altiro3D/placement.hpp"
#include "cli/eyes_options.hpp"
#include "viewer/model/document.hpp"
#include "viewer/model/knobs.hpp"

#include <QtGlobal>
#include <functional>
#include <memory>
#include <optional>

namespace altiro3D::viewer {

/// Receives the progress, 0..1; returns false to cancel.
using Progress = std::function<bool(double)>;

/// What the window shows of a document.
enum class Mode {
    Sway,   ///< One view, from a camera that moves.
    Depth,  ///< The depth map, near = white.
    Quilt,  ///< All views.
    Native, ///< What the panel shows, px by px.
    Lens,   ///< What an eye sees of the Native through the lenses.
    Stereo  ///< For two eyes: the whole photo as Request::eyes says.
};

/// The modes of a document (null: those of a photo); the first one is the default.
std::vector<Mode> modesOf(const std::shared_ptr<const Document>& document);

/// Depth that the user has painted.
struct PaintedDepth {
    cv::Mat depth{};      ///< [any size, CV_32FC1, 0..1], shows all of the photo; empty: none.
    quint64 revision = 0; ///< Another number for every other content.
};

/// A picture that is wanted.
struct Request {
    std::shared_ptr<const Document> document{};
    Knobs knobs{};
    std::shared_ptr<const Display> display{};
    PaintedDepth painted{};    ///< Takes the place of the photo's depth.
    tools::EyesOptions eyes{}; ///< Mode Stereo.
    Mode mode = Mode::Sway;
    double position = 0;  ///< Position of camera or eye, -1 leftmost .. +1 rightmost.
    cv::Size area{};      ///< Area for the picture, px of the screen.
    cv::Point pan{};      ///< Mode Native: offset from the middle, px.
    bool isDraft = false; ///< To be quick: fewer px, Natives of photos with less detail.
    /// Mode Stereo: each eye's picture has black bars, so that the area is full.
    bool fills = false;
    /// Mode Stereo: the eyes look from around `position`.
    bool follows = false;
    bool throughLens = false; ///< Mode Stereo: on the display itself, as eyesToNative() does.
};

/// The depth of a photo.
struct PhotoDepth {
    cv::Mat depth{};           ///< [any size, CV_32FC1, 0..1], covers all of the photo.
    HiddenLayer hidden{};      ///< A stereo pair's, as long as its depth is used.
    bool flat = false;         ///< The depth has no range, see depthOf().
    std::string depthSource{}; ///< For people; empty without depth.
};

/// A request with the depth of its photo, which is all that its picture is made of.
struct Setup : Request, PhotoDepth {
    DepthEdges edges = DepthEdges::Unknown; ///< Scene::edges, also of depth that was painted on.
    std::string from{};                     ///< Names source and strokes: differs with the depth.
};

/// The depth of a photo; without a range it lies at the focus, as in the tools, so that all views
/// are equal.
cv::Mat depthOf(const Setup& setup);

/// The layout of the quilt: the document's own if it is a quilt, else layoutOf().
QuiltLayout quiltLayout(const Setup& setup);

Framing framingOf(const Setup& setup);

/// How a photo is fitted, with the margins that its views show. @param size of the views
PhotoFit fitOf(const Setup& setup, cv::Size size);

/// Photo and depth on the panel; empty for quilts and Natives. @param size of the views
Placement placed(const Setup& setup, cv::Size size);

/// As above, of a video's frame. @param kept as for placeFrame()
Placement placed(const Setup& setup, cv::Size size, std::optional<DepthFlaws>& kept);

/// The photo alone, fitted in this way.
cv::Mat fittedPhoto(const Setup& setup, cv::Size size);

/// The scene of placed(), faster, with a photo from fittedPhoto() of the same size.
Scene fitted(const Setup& setup, cv::Size size, const cv::Mat& fittedPhoto);

/// Makes the quilt of a photo, or returns the document's quilt.
/// @param fitted of a photo, from placed() at the layout's tile size
cv::Mat makeQuilt(const Setup& setup, const Scene& fitted);

/// The size that a photo is fitted to for a Native, see NativeMaker::workSize().
cv::Size nativeFitSize(const Setup& setup);

/// Makes the Native exactly as photo2native and quilt2native do, or returns the document's Native.
/// @param fitted of a photo, at nativeFitSize()
cv::Mat makeNative(const Setup& setup, const Scene& fitted);

/// Makes Natives of quilts that have one layout, such as the pictures of a video: each as
/// makeNative() makes it of a quilt of that file.
/// @param isVideo px of views are then not blended, as in quilt2native
/// @return a function of a quilt [CV_8UC3, BGR]; it may be called by one thread at a time
std::function<cv::Mat(const cv::Mat&)> quiltConverter(const std::filesystem::path& file,
                                                      const QuiltLayout& layout,
                                                      const Display& display, bool isVideo);

/// The setup for pictures of two eyes: the whole photo, with their strength.
Setup forEyes(Setup setup);

/// Width : height of what each eye sees.
double eyesAspect(const Setup& setup);

/// The pictures of both eyes as photo2native and quilt2native make them. @param setup any
StereoPair makeEyes(const Setup& setup);

/// A result that can be exported.
enum class Product { Native, Quilt, Views, Depth, SwayVideo, Eyes, Page };

std::vector<Product> productsOf(Kind kind);

/// The file that writeProduct() writes for a name: a quilt's layout is appended to its name.
/// @throws Error Mismatch if a quilt's name states another layout
std::filesystem::path productFile(const Setup& setup, Product product,
                                  const std::filesystem::path& target);

/// Warnings about what the file's format loses of a product, one sentence each.
std::vector<std::string> lossesOf(Product product, const std::filesystem::path& file);

/// Sets the framing, focus and strength that Knobs::choices leaves to the photo, as photo2native
/// does. Then nothing is automatic.
void chooseAutomatic(Setup& setup);

/// How much of an outermost view the photo does not show, %, by the rule that limits the strength
/// automatically; 0 if the rule allows this strength.
double hiddenPercent(const Setup& setup);

/// Makes a product and writes it.
/// @param target a file, which is replaced if it exists; for views a directory without views
/// @return what was written, for people; empty if the work was cancelled
/// @throws Error; no incomplete file is left
std::string writeProduct(Setup setup, Product product, const std::filesystem::path& target,
                         const Progress& progress);

} // namespace altiro3D::viewer
