#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/placement.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/scene.hpp"
#include "altiro3D/splats.hpp"
#include "altiro3D/stereo_views.hpp"
#include "altiro3D/sway.hpp"

#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>

namespace altiro3D {

// Products of a scene other than Native and quilt, which NativeMaker makes. They show the whole
// photo unless a function says otherwise.

/// Places a frame of a video as placeScene() does. The flaws of the depth are measured in the first
/// frame of a scene of the video and kept for the others, so that edges do not waver.
///
/// @param frame, aspect, size as for placeScene()
/// @param options as for placeScene(); flaws that they state are used as they are
/// @param kept flaws of the current scene of the video; empty: they are measured in this frame.
///        Receives the flaws that were corrected.
/// @return the placed frame
/// @throws Error as placeScene()
[[nodiscard]] ALTIRO3D_EXPORT Placement placeFrame(const Scene& frame, double aspect, cv::Size size,
                                                   const PlacementOptions& options,
                                                   std::optional<DepthFlaws>& kept);

/// Longer side of a depth map that is saved, px: depth has less detail than a photo.
constexpr int kSavedDepthSide = 4096;

/// The depth of a scene as it is saved: aligned with the whole photo.
///
/// @param scene photo and depth of any size. If it is moved here, its photo is released early.
/// @param longerSide the longer side of the result in px, if the photo is larger
/// @return [rows x cols, CV_32FC1, 0..1, 1 = nearest] with the shape of the photo
/// @throws Error as fitDepth(), checkDepthRange(), InvalidArgument (longerSide below 1)
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat savedDepth(Scene scene, int longerSide = kSavedDepthSide);

/// The pictures of both eyes of a whole photo, in its own shape.
///
/// @param scene photo and depth
/// @param options as for placeScene(); fit, framing and strength are replaced
/// @param strengthPercent parallax between the eyes, % of the width (kEyesStrength)
/// @param from the eyes to render
/// @return both pictures, of the photo's size
/// @throws Error as placeScene() and renderEyes(); one side of the photo must not exceed 100 times
///         the other
[[nodiscard]] ALTIRO3D_EXPORT StereoPair photoEyes(const Scene& scene,
                                                   const PlacementOptions& options,
                                                   double strengthPercent,
                                                   EyesFrom from = EyesFrom::Both);

/// The fit of a photo, in its own shape, to its swaying video, with the margins that its views
/// show. Beyond 1 : 100 it is squeezed.
/// @param photo its size in px
/// @param options strength and focus; fit, used where `size` has another shape
/// @param part the part to show, in px of the photo; empty: all of it
/// @param size of the video in px; empty: swaySize()
/// @return the fit; its size is that of the video
/// @throws Error InvalidArgument (an empty photo or part), as withMargins()
[[nodiscard]] ALTIRO3D_EXPORT PhotoFit swayFitOf(cv::Size photo, const PlacementOptions& options,
                                                 const std::optional<cv::Rect>& part = {},
                                                 cv::Size size = {});

/// The views of a photo for its swaying video.
///
/// @param scene photo and depth
/// @param options used: `views`, `refine` and `depthCurve`
/// @param fit from swayFitOf()
/// @return renders pictures of the fit's size, for writeSway()
/// @throws Error as fitScene() and photoViews()
[[nodiscard]] ALTIRO3D_EXPORT SwayView swayViewsOf(const Scene& scene,
                                                   const PlacementOptions& options,
                                                   const PhotoFit& fit);

/// The splats of a photo, or of a part of it: splatsOf() after shrinking it to `side`.
///
/// @param scene photo and depth
/// @param options used: `views.focus`, `refine` and `depthCurve`
/// @param part of the photo, px; not set: all of it
/// @param side longer side after shrinking, px, 16..8192; a smaller part is not enlarged
/// @param focalLength 35 mm equivalent, mm, up to 5000; 0, unknown: kUsualFocalLength
/// @return the splats with the camera of the part
/// @throws Error as fitScene() and splatsOf(), InvalidArgument
[[nodiscard]] ALTIRO3D_EXPORT SplatScene photoSplats(const Scene& scene,
                                                     const PlacementOptions& options,
                                                     const std::optional<cv::Rect>& part = {},
                                                     int side = 1024, double focalLength = 0);
/// Focal length assumed for photos that do not state one, mm: between a phone's and a camera's.
constexpr double kUsualFocalLength = 35;

/// Writes the views of a quilt as pictures, several at a time.
///
/// @param fileOf the file of a view; it is called by several threads
/// @param quilt [layout size, CV_8UC3, BGR]
/// @param layout its layout
/// @param goOn receives the part that is written, 0..1, from one thread at a time; false cancels.
///        May be empty.
/// @return false if the work was cancelled; the views are then removed, as after an error
/// @throws Error as writeImage(), Mismatch (size of the quilt), InvalidArgument (layout)
ALTIRO3D_EXPORT bool writeViews(const std::function<std::filesystem::path(int view)>& fileOf,
                                const cv::Mat& quilt, const QuiltLayout& layout,
                                const std::function<bool(double)>& goOn = {});

} // namespace altiro3D
