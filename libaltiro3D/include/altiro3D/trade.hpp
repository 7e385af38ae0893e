#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace altiro3D {

/// A way to make views, with a name for tables.
struct NamedViewOptions {
    std::string name;    ///< "fast", "layered", ...
    ViewOptions options; ///< Method and knobs.
};

/// The settings that are worth comparing: every method with its defaults, and its knobs at other
/// values. The most accurate one comes last.
///
/// @param base strength and focus of all of them
/// @return the settings, with names that differ
ALTIRO3D_EXPORT std::vector<NamedViewOptions> tradeSettings(const ViewOptions& base = {});

/// Each method with its default knobs, cheapest first; named as the method.
///
/// @param base strength and focus of all of them, and their knobs
/// @return "fast", "layered", "real"
ALTIRO3D_EXPORT std::vector<NamedViewOptions> defaultSettings(const ViewOptions& base = {});

/// What views cost.
struct ViewCost {
    double millisecondsPerView = 0; ///< Wall time of a whole set of views, divided by their number.
    /// What all views of a photo share (edges, the hidden background), done once: wall time, in
    /// all; part of the whole set's.
    double preparationMilliseconds = 0;
};

/// Measures what views cost on this machine, with the threads of `cv::setNumThreads()`.
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]
/// @param options method and knobs
/// @param views number of views of a set, 1..1024, evenly spaced
/// @param repetitions sets to make; the fastest counts, 1..1000
/// @return the times
/// @throws Error InvalidArgument (views, repetitions, options), TooLarge (the quilt of all views),
///         and as Depth2Quilt::render()
ALTIRO3D_EXPORT ViewCost measureViews(const cv::Mat& photo, const cv::Mat& depth,
                                      const ViewOptions& options, int views, int repetitions);

/// Accuracy of a view.
struct ViewAccuracy {
    double psnrWhole = 0;  ///< PSNR of the whole frame in dB.
    double ssimWhole = 0;  ///< SSIM of the whole frame.
    double psnrInside = 0; ///< PSNR without the bands at both sides in dB.
    double ssimInside = 0; ///< SSIM without the bands at both sides.
};

/// Compares a view with the true one.
///
/// @param view [rows x cols, CV_8UC3, BGR]
/// @param truth [as view]
/// @param band width in px of the bands that "inside" leaves out at the left and at the right, 0 or
///        more; both are kept if nothing would be left
/// @return psnr() and ssim()
/// @throws Error Mismatch (sizes or types differ), InvalidArgument (empty, not of 8 bits, band)
ALTIRO3D_EXPORT ViewAccuracy compareViews(const cv::Mat& view, const cv::Mat& truth, int band);

/// A measured stereo scene: a photo, its true disparity, and what a second camera saw.
struct ALTIRO3D_EXPORT StereoScene {
    std::string name;            ///< For tables.
    cv::Mat photo;               ///< [rows x cols, CV_8UC3, BGR]
    cv::Mat depth;               ///< [as photo, CV_32FC1, 0..1]: disparity / largest disparity.
    cv::Mat truth;               ///< [as photo]: the second camera's photo.
    double largestDisparity = 0; ///< In px; content at depth d stands d times this further left.

    /// Options with which the view at position +1 is the second camera's: focus 0 and S/2 =
    /// largestDisparity, docs/mathematics.md, (3.2).
    /// @param knobs all the rest
    /// @return the options
    ViewOptions options(const ViewOptions& knobs) const;
    /// Width of the band that "inside" leaves out. @return ceil(largest disparity) + 2 px
    int band() const;
};

/// Makes a scene from its pictures.
///
/// @param name for tables and errors
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param rawDisparity [as photo, CV_32FC1], 0 and non-finite = unknown: filled along the row by
///        the smaller of the two valid neighbours
/// @param scale raw values per px of disparity, > 0
/// @param truth [as photo], what the second camera saw
/// @return the scene; photo and truth share memory with the arguments
/// @throws Error Mismatch (sizes differ), InvalidArgument (empty, wrong type, scale)
ALTIRO3D_EXPORT StereoScene makeStereoScene(const std::string& name, const cv::Mat& photo,
                                            const cv::Mat& rawDisparity, double scale,
                                            const cv::Mat& truth);

} // namespace altiro3D
