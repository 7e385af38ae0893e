#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/video_types.hpp"

#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// How the camera of a swaying video moves: the 3D of a picture, for people without a display.
struct SwayOptions {
    double secondsPerTurn = 4; ///< From the middle to the right, to the left and back, s, 0.1..600.
    int turns = 2;             ///< How often, 1..1000.
    Fraction frameRate{30, 1}; ///< Frames a second, 1..240.
};

/// Checks the options.
/// @param options what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const SwayOptions& options);

/// Frames of one turn: seconds x rate, rounded to a multiple of 4 (at least 4), so that the
/// middle and the two outermost views are all shown.
///
/// @param options time of a turn and frame rate
/// @return n of docs/mathematics.md, (3.6)
/// @throws Error InvalidArgument (options)
ALTIRO3D_EXPORT int framesPerTurn(const SwayOptions& options);

/// Position of the camera in a frame: p = sin(2 pi k / n), docs/mathematics.md, (3.6): slow at both
/// ends, fastest in the middle, where it begins. The way back has the very positions of the way
/// there, and the frame after the last one is the first: a loop has no seam.
///
/// @param frame k, 0 or more; it goes on turn after turn
/// @param framesPerTurn n, a multiple of 4, at least 4
/// @return -1..+1; 0 at frame 0, +1 after a quarter of the turn, -1 after three
/// @throws Error InvalidArgument (out of these ranges)
ALTIRO3D_EXPORT double swayPosition(int frame, int framesPerTurn);

/// A size for a video that any player plays: the picture's own, at most 1920 px long and 1080 px
/// wide whichever way it stands, even sides of at least 16 px, at most 100 : 1.
///
/// @param picture its size in px
/// @param aspect width : height that it is shown with; its px need not be square, and neither
///        of its sides shrinks to make them so. More than 0; counts as 0.01..100.
/// @return size in px
/// @throws Error InvalidArgument (an empty picture, aspect)
ALTIRO3D_EXPORT cv::Size swaySize(cv::Size picture, double aspect);

/// fitPhoto() for a picture whose px need not be square, onto px that are. A picture that is one px
/// larger, whose odd side became even, is cut and not resampled.
///
/// @param picture its size in px
/// @param aspect width : height that it is shown with, 0.01..100
/// @param result size of the video in px, width : height 0.01..100
/// @param mode see FitMode
/// @return the fit, for applyFit()
/// @throws Error InvalidArgument (an empty picture or result, an aspect out of its range)
ALTIRO3D_EXPORT PhotoFit swayFit(cv::Size picture, double aspect, cv::Size result,
                                 FitMode mode = FitMode::Cover);

/// The fit of a whole photo, in its own shape, to the video of swaySize().
///
/// @param photo its size in px
/// @param mode used where the photo's shape is beyond 1 : 100, or `size` has another shape
/// @param size size of the video in px; empty: swaySize()
/// @return the fit, for fitScene(); its size is that of the video
/// @throws Error InvalidArgument (an empty photo)
ALTIRO3D_EXPORT PhotoFit photoSwayFit(cv::Size photo, FitMode mode = FitMode::Cover,
                                      cv::Size size = {});

/// Makes the picture that a camera sees. It is called from one thread.
///
/// @param position -1 leftmost .. +1 rightmost; what lies beyond counts as the end
/// @param picture [rows x cols, CV_8UC3, BGR]; reused if it fits
/// @throws Error InvalidArgument (a position that is NaN), from those that are made here
using SwayView = std::function<void(double position, cv::Mat& picture)>;

/// The views of a photo with depth, at any position: those of Depth2Quilt::renderView(), bit for
/// bit, but what they have in common is done once.
///
/// @param photo [rows x cols, CV_8UC3, BGR], sides at most 32766 px; must not change afterwards
/// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; must not change afterwards
/// @param options what views look like
/// @return makes pictures of the photo's size
/// @throws Error InvalidArgument (types, options), Mismatch (photo and depth differ in size),
///         TooLarge, OutOfMemory
ALTIRO3D_EXPORT SwayView photoViews(const cv::Mat& photo, const cv::Mat& depth,
                                    const ViewOptions& options = {});

/// The views of a quilt.
///
/// @param quilt [layout size, CV_8UC3, BGR]; must not change afterwards
/// @param layout its layout
/// @param fit of one tile to the pictures, see swayFit()
/// @param between Nearest: each picture is a view. Linear: two neighbours are blended, which moves
///        smoothly but shows edges double where they are more than a px apart.
/// @return makes pictures of fit.size; throws as applyFit() if the fit is not one for the tiles
/// @throws Error InvalidArgument (type, layout), TooLarge (layout), Mismatch (the quilt has not the
///         layout's size)
ALTIRO3D_EXPORT SwayView quiltViews(const cv::Mat& quilt, const QuiltLayout& layout,
                                    const PhotoFit& fit, ViewFilter between = ViewFilter::Nearest);

/// Writes the video: H.264 4:2:0 at a constant rate, which any player plays. The file appears whole
/// or not at all.
///
/// @param path .mp4, .m4v, .mov or .mkv
/// @param size of the pictures that `view` makes, px, even sides, 16..16384
/// @param options see SwayOptions
/// @param view makes the pictures
/// @param progress if given, called before each frame with its number and the number of all
/// @throws Error InvalidArgument (options, size, a picture of another size), Unsupported (the
///         name's extension, no encoder in this FFmpeg), WriteFailed, and what `view` throws
ALTIRO3D_EXPORT void writeSway(const std::filesystem::path& path, cv::Size size,
                               const SwayOptions& options, const SwayView& view,
                               const std::function<void(int frame, int frames)>& progress = {});

} // namespace altiro3D
