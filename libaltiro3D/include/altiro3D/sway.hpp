#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/video_io.hpp"

#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// Camera motion of a swaying video, which shows the depth of a picture on an ordinary screen.
struct SwayOptions {
    double secondsPerTurn = 4; ///< Duration of a turn (middle, right, left, middle), s, 0.1..600.
    int turns = 2;             ///< Number of turns, 1..1000.
    Fraction frameRate{30, 1}; ///< Frames per second, 1..240.
};

/// Checks the options.
/// @param options the options to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const SwayOptions& options);

/// Frames of one turn: seconds x rate, rounded to a multiple of 4, at least 4. The middle and the
/// two outermost views are then all shown.
/// @param options time of a turn and frame rate
/// @return n of docs/mathematics.md, (3.6)
/// @throws Error InvalidArgument (options)
[[nodiscard]] ALTIRO3D_EXPORT int framesPerTurn(const SwayOptions& options);

/// Camera position of a frame: p = sin(2 pi k / n), docs/mathematics.md, (3.6). The motion starts
/// in the middle, where it is fastest, and slows down at both ends. The way back has the same
/// positions. The frame after the last equals the first, so the video loops without a seam.
/// @param frame k, 0 or more; continues over all turns
/// @param framesPerTurn n, a multiple of 4, at least 4
/// @return -1..+1; 0 at frame 0, +1 after a quarter of the turn, -1 after three quarters
/// @throws Error InvalidArgument (out of these ranges)
[[nodiscard]] ALTIRO3D_EXPORT double swayPosition(int frame, int framesPerTurn);

/// A video size that any player supports: the picture's own, with the longer side limited to 1920
/// px, the shorter one to 1080 px, even sides of at least 16 px, and an aspect of at most 100 : 1.
/// @param picture its size in px
/// @param aspect width : height as shown, > 0, clamped to 0.01..100. Pixels need not be square; to
///        make them square, one side is enlarged and none is shrunk.
/// @return size in px
/// @throws Error InvalidArgument (an empty picture, aspect)
[[nodiscard]] ALTIRO3D_EXPORT cv::Size swaySize(cv::Size picture, double aspect);

/// As fitPhoto(), for a picture whose pixels need not be square; the result's pixels are square. A
/// picture that is one px larger than the result, because an odd side became even, is cropped and
/// not resampled.
/// @param picture its size in px
/// @param aspect width : height as shown, 0.01..100
/// @param result size of the video in px, width : height 0.01..100
/// @param mode crop, bars or distortion
/// @return the fit, for applyFit()
/// @throws Error InvalidArgument (an empty picture or result, an aspect out of its range)
[[nodiscard]] ALTIRO3D_EXPORT PhotoFit swayFit(cv::Size picture, double aspect, cv::Size result,
                                               FitMode mode = FitMode::Cover);

/// Renders the picture at a camera position. It is called from one thread. The functions that
/// photoViews() and quiltViews() return throw Error InvalidArgument if the position is NaN.
/// @param position -1 leftmost .. +1 rightmost; clamped
/// @param picture [rows x cols, CV_8UC3, BGR]; reused if it fits
using SwayView = std::function<void(double position, cv::Mat& picture)>;

/// The views of a photo with depth at any position. They equal those of Depth2Quilt::renderView()
/// bit for bit; the work that all views share is done once.
/// @param scene as for Depth2Quilt::render(); must not change afterwards
/// @param options method, strength, focus and the options of each method
/// @return renders pictures of the photo's size without its margins (Scene::shown)
/// @throws Error InvalidArgument (types, options), Mismatch (sizes differ), TooLarge, OutOfMemory
[[nodiscard]] ALTIRO3D_EXPORT SwayView photoViews(const Scene& scene,
                                                  const ViewOptions& options = {});

/// The views of a quilt.
/// @param quilt [layout size, CV_8UC3, BGR]; must not change afterwards
/// @param layout its layout
/// @param fit fit of one tile to the pictures, see swayFit()
/// @param between Nearest: each picture is one view. Linear: two neighbouring views are blended;
///        the motion is smooth, but edges appear double where they are more than one px apart.
/// @return renders pictures of fit.size; throws as applyFit() if the fit does not match the tiles
/// @throws Error InvalidArgument (type, layout), TooLarge (layout), Mismatch (size of the quilt)
[[nodiscard]] ALTIRO3D_EXPORT SwayView quiltViews(const cv::Mat& quilt, const QuiltLayout& layout,
                                                  const PhotoFit& fit,
                                                  ViewFilter between = ViewFilter::Nearest);

/// Writes the video as H.264 4:2:0 at a constant rate. The file appears complete or not at all.
/// @param path .mp4, .m4v, .mov or .mkv
/// @param size size of the pictures that `view` renders, px, even sides, 16..16384
/// @param options speed, turns and frame rate
/// @param view renders the pictures
/// @param goOn called before each frame; false cancels, and no file appears. May be empty.
/// @return false if the work was cancelled
/// @throws Error InvalidArgument (options, size, a picture of another size), Unsupported (the
///         extension, no encoder in this FFmpeg), WriteFailed; exceptions of `view` pass through
ALTIRO3D_EXPORT bool writeSway(const std::filesystem::path& path, cv::Size size,
                               const SwayOptions& options, const SwayView& view,
                               const VideoProgressFunction& goOn = {});

} // namespace altiro3D
