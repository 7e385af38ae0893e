#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/scene.hpp"
#include "altiro3D/view_options.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <tuple>

namespace altiro3D {

/// How a scene is placed on a display.
struct PlacementOptions {
    ViewOptions views;            ///< Method, strength, focus and the options of each method.
    FitMode fit = FitMode::Cover; ///< How a photo is fitted to the panel if their shapes differ.
    Framing framing;              ///< The part of a photo that is shown.
    DepthRefineOptions refine;    ///< How the depth of a fitted photo is refined.
    /// Exponent for bendDepth(), 0.5..2. `views.focus` refers to the depth that bendDepth() gives.
    double depthCurve = 1;

    /// All fields, to compare or save them. @param o the options @return references to its fields
    template <typename Options>
    static auto fields(Options& o) {
        return std::tie(o.views, o.fit, o.framing, o.refine.flaws, o.depthCurve);
    }
};

/// A scene on a display.
struct Placement {
    Scene scene;      ///< Photo and refined depth, fitted; for NativeMaker or Depth2Quilt.
    PhotoFit fit;     ///< How it was fitted.
    DepthFlaws flaws; ///< Flaws of the depth that were corrected.
};

/// Applies PlacementOptions::depthCurve to a scene, as placeScene() does.
/// @param scene as for placeScene() @param exponent as for bendDepth()
/// @return the scene; bendDepth() has changed its depth and the depth of its hidden layer
/// @throws Error as bendDepth()
[[nodiscard]] ALTIRO3D_EXPORT Scene withDepthCurve(const Scene& scene, double exponent);

/// Adds the margins that views from the side show at the edges of the panel. Their width is the
/// largest shift plus 2 px, rounded up to a multiple of 1/32 of the result's width (so small
/// changes of the options keep the fit), and at most half the width. If nothing shifts, there are
/// none.
/// @param fit from fitPhoto()
/// @param picture size of the picture in px that the fit was made for
/// @param options strength and focus of the views
/// @return the fit with margins, as withMargins(fit, picture, pixels)
/// @throws Error InvalidArgument (options)
[[nodiscard]] ALTIRO3D_EXPORT PhotoFit withMargins(const PhotoFit& fit, cv::Size picture,
                                                   const ViewOptions& options);

/// Computes the fit of a photo, with the margins that views from the side show.
/// @param photo size of the photo in px
/// @param aspect width : height, in px of the photo, of the part that fills the panel, 0.01..100:
///        the shape of the panel if the px of the photo are square
/// @param size of the result in px
/// @param options fit, framing, strength and focus
/// @return the fit, for fitScene()
/// @throws Error as fitPhoto(), InvalidArgument (options)
[[nodiscard]] ALTIRO3D_EXPORT PhotoFit fitWithMargins(cv::Size photo, double aspect, cv::Size size,
                                                      const PlacementOptions& options);

/// Fits a scene to a panel and refines its depth: fitWithMargins(), fitScene(). With method Fast,
/// which gains little from exact edges, estimated depth (DepthEdges::Aligned) is refined only if
/// `options.refine` states flaws.
/// @param scene a photo of any size and its depth of any size; see DepthSource::readScene()
/// @param aspect as for fitPhoto()
/// @param size of the fitted photo in px: NativeMaker::workSize() or NativeMaker::quiltSize()
/// @param options how to place it. Frames of a video should keep the flaws of the first one of
///        their scene, so that edges do not waver.
/// @return the fitted scene
/// @throws Error as fitPhoto() and fitScene()
[[nodiscard]] ALTIRO3D_EXPORT Placement placeScene(const Scene& scene, double aspect, cv::Size size,
                                                   const PlacementOptions& options);

/// The settings that chooseFromScene() chooses; the others stay (docs/mathematics.md, 7).
struct AutoChoices {
    /// Choose the centre of the part that is shown. For photos, also enlarge it, by at most 5 %
    /// (scans: 10 %), until no view shows what lies outside the photo or the border of a scan.
    /// Requires FitMode::Cover.
    bool framing = false;
    bool focus = false;    ///< The depth of the subject.
    bool strength = false; ///< The largest parallax that the display shows without double edges.
    /// Limit the given strength for estimated depth to what that depth supports; (7.4).
    bool limit = false;
    /// The photo is the first frame of a video's scene; the other frames may have any depth.
    bool isVideo = false;

    /// Whether something is to be chosen. @return true if framing, focus, strength or limit is set
    [[nodiscard]] bool any() const { return framing || focus || strength || limit; }

    /// All fields, to compare or save them. @param o the choices @return references to its fields
    template <typename Choices>
    static auto fields(Choices& o) {
        return std::tie(o.framing, o.focus, o.strength, o.limit, o.isVideo);
    }
};

/// Largest strength that is chosen, %.
constexpr double kMaxAutoStrength = 12;
/// With a chosen strength, content moves between the outermost views by at most this, % of the
/// width: as with strength 10 and focus 0.5.
constexpr double kMaxAutoParallax = 5;
/// A chosen or limited strength is reduced until at most this part of an outermost view is
/// disoccluded or stretched, %. Steep depth and uncertain depth therefore get less strength.
constexpr double kMaxAutoHidden = 5;

/// What chooseFromScene() has chosen.
struct ChosenOptions {
    PlacementOptions options; ///< With the framing, focus and strength that were chosen.
    /// Part of the photo: a scan's border is left out at each side at which views would show it.
    /// All of the photo for videos, and if the framing was not to be chosen. Use it for messages
    /// only; the chosen framing already excludes the border.
    cv::Rect inside;
};

/// Chooses framing, focus and strength of a scene, as far as `choices` requests them.
/// @param scene photo and depth, before the fit
/// @param aspect as for fitPhoto()
/// @param quilt layout: view count and view size limit the strength
/// @param options the settings that are not chosen
/// @param choices what to choose
/// @return the options for placeScene()
/// @throws Error as fitPhoto(), InvalidArgument (type of photo or depth; options; framing is to be
///         chosen, but the fit is not Cover), InvalidArgument or TooLarge (layout)
[[nodiscard]] ALTIRO3D_EXPORT ChosenOptions chooseFromScene(const Scene& scene, double aspect,
                                                            const QuiltLayout& quilt,
                                                            const PlacementOptions& options,
                                                            const AutoChoices& choices);

/// A Depth2Quilt that estimates depth with a network. It turns photos of any size into quilts.
///
/// It owns the network. One thread at a time per object.
class ALTIRO3D_EXPORT Network2Quilt {
  public:
    /// @param network a loaded network
    /// @param layout layout of the quilts
    /// @param options method, strength, focus and the options of each method
    /// @param panelAspect width : height of the picture on the panel, 0.01..100
    /// @param fit how photos of another shape are fitted to the panel
    /// @throws Error InvalidArgument (layout, options, panelAspect) or TooLarge (layout)
    Network2Quilt(DepthNetwork network, const QuiltLayout& layout, const ViewOptions& options,
                  double panelAspect, FitMode fit = FitMode::Cover);

    /// Estimates the depth of the whole photo (depthFromNetwork()), fits photo and depth to the
    /// view's size (fitScene()) and renders the views. The depth may differ in the last digits for
    /// different numbers of threads, see DepthNetwork::infer().
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param quilt [quilt rows x quilt cols, CV_8UC3, BGR]; reused if it fits
    /// @throws Error as fitPhoto() (an extreme aspect), DepthNetwork::estimate() and
    ///         Depth2Quilt::render()
    void render(const cv::Mat& photo, cv::Mat& quilt);

    /// The depth of the last photo as it was estimated, before the fit.
    /// @return [any size, CV_32FC1, 0..1, 1 = nearest]; empty before the first photo
    [[nodiscard]] const cv::Mat& depth() const { return depth_; }

  private:
    std::shared_ptr<DepthSource> source_;
    Depth2Quilt depth2quilt_;
    double panelAspect_;
    FitMode fit_;
    cv::Mat depth_;
};

} // namespace altiro3D
