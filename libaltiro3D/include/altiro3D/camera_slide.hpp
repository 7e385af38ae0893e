#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D {

/// Passes the pictures of a moving camera (CameraSlide) [rows x cols, CV_8UC3, BGR, of one size] to
/// a function, in order, until the function returns false. The source is called several times and
/// must pass the same pictures each time.
using SlidePictureSource = std::function<void(const std::function<bool(const cv::Mat&)>& take)>;

/// The frames of a video.
/// @param file as for VideoReader
/// @param notes if given, receives the remarks of the reader each time
/// @return the source; it throws as VideoReader
[[nodiscard]] ALTIRO3D_EXPORT SlidePictureSource slideVideo(std::filesystem::path file,
                                                            Notes* notes = nullptr);

/// Photos, in the order in which they were taken.
/// @param files as for readPhoto()
/// @param notes if given, receives the remarks of readPhoto() each time
/// @return the source; it throws as readPhoto(), and Error Mismatch for photos of different sizes
[[nodiscard]] ALTIRO3D_EXPORT SlidePictureSource
slidePhotos(std::vector<std::filesystem::path> files, Notes* notes = nullptr);

/// How each view of a slide is made.
enum class SlideViews {
    Nearest, ///< From the nearest picture, moved as a whole. Fast.
    Between  ///< From two near pictures, one on either side; each px is moved on its own.
};

/// Options of CameraSlide.
struct SlideOptions {
    SlideViews views = SlideViews::Between; ///< How views are made.
    /// The depth of zero parallax, 0 (farthest) .. 1 (nearest); not set: the median of the
    /// tracked features.
    std::optional<double> focus;
    /// Width : height of the views, 0.01..100; 0: that of the part that all pictures show.
    double aspect = 0;
    int longestSide = 1600; ///< Largest side of a view, px, 16..16384. Views are not enlarged.
    /// Largest parallax relative to the focus, between the outermost views, 0..1e6 widths of a
    /// view; 0: no limit. If the path is longer, its middle part is used.
    double mostParallax = 0;
    /// Horizontal angle of view of the pictures, after the turn by 90 degrees if there is one
    /// (SlideReport::turned), degrees, 1..150; 0: it is estimated.
    double viewDegrees = 0;
    /// The camera stands still, and the scene turns in front of it by at most 35 degrees.
    bool turntable = false;
    std::vector<std::string> names; ///< Names of the pictures for messages; empty: numbers.
};

/// Checks the options.
/// @param options the options to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const SlideOptions& options);

/// What was found in a slide.
struct ALTIRO3D_EXPORT SlideReport {
    int pictures = 0; ///< Pictures in the clip.
    int used = 0;     ///< Pictures that views are chosen from.
    /// Parallax of the nearest features against the farthest ones between the outermost views, % of
    /// a view's width.
    double parallaxPercent = 0;
    double stretchPercent = 100; ///< Part of the camera's path that is used, %.
    /// Vertical distance (RMS without outliers) of features from their predicted places in the
    /// worst picture, px of a view.
    double verticalPixels = 0;
    double horizontalPixels = 0; ///< The same horizontally.
    double speedRatio = 1;       ///< Largest step between neighbouring pictures : median step.
    double awayPercent = 0; ///< Largest distance of the camera from a straight line, % of the path.
    double turnDegrees = 0; ///< Largest turn of the camera, degrees.
    double misfitPercent = 0; ///< Features that do not fit a scene at rest, %.
    double focus = 0.5;       ///< Depth of zero parallax, see SlideOptions::focus.
    bool fromRight = false;   ///< The camera moves from right to left.
    bool turned = false;      ///< The camera moves vertically: pictures are turned by 90 degrees.
    /// The pictures that are used: index in the clip, from 0, and position, 0 = the leftmost view,
    /// 1 = the rightmost one.
    std::vector<std::pair<int, double>> positions;
    /// Times for reading the pictures, tracking features, finding the path and making views, s.
    double seconds[4] = {};

    /// Describes the slide for people: the camera's path, pictures used, residuals, speed, focus.
    /// @return five lines
    [[nodiscard]] std::vector<std::string> lines() const;
};

/// Real views from a camera that moved sideways past a scene at rest, such as a phone slid by hand
/// or a camera on a rail. Finds how the camera moved and turned (docs/mathematics.md, 8), and makes
/// views of evenly spaced cameras that look straight ahead:
///
///     CameraSlide slide(slideVideo("clip.mp4"));
///     slide.makeViews(48, [&](int view, const cv::Mat& picture) { ... });
///
/// One thread at a time per object.
class ALTIRO3D_EXPORT CameraSlide {
  public:
    /// Reads all pictures and finds the path.
    /// @param source the pictures; at most 600 of them are looked at
    /// @param options see SlideOptions
    /// @param name of the clip, for errors
    /// @throws Error BadFormat: fewer than two pictures; too little texture; the camera stands
    ///         still, turns, zooms or moves forwards; the scene moves; the pictures are warped.
    ///         InvalidArgument (options, type), Mismatch (sizes). Exceptions of `source` pass
    ///         through.
    explicit CameraSlide(SlidePictureSource source, const SlideOptions& options = {},
                         const std::string& name = "slide");
    ~CameraSlide();
    CameraSlide(CameraSlide&&) noexcept;            ///< Moves.
    CameraSlide& operator=(CameraSlide&&) noexcept; ///< Moves. @return *this

    /// What was found. @return the findings
    [[nodiscard]] const SlideReport& report() const;
    /// Remarks for the user. @return the remarks, usually none
    [[nodiscard]] const Notes& notes() const;
    /// Size of the views. @return px
    [[nodiscard]] cv::Size viewSize() const;

    /// Makes evenly spaced views from the leftmost camera to the rightmost. Pictures are reread.
    /// @param count number of views, 1..1000; a single one is the middle view
    /// @param take receives each view once [viewSize(), CV_8UC3, BGR] and its number, 0 = leftmost,
    ///        in ascending or descending order
    /// @throws Error InvalidArgument (count), BadFormat (fewer pictures than before); exceptions of
    ///         the source and of `take`
    void makeViews(int count, const std::function<void(int view, const cv::Mat& picture)>& take);

    /// Makes the middle view and its depth from the parallax of pictures around it. Reads the
    /// pictures again.
    /// @param photo [viewSize(), CV_8UC3, BGR]
    /// @param depth [viewSize(), CV_32FC1, any range, larger = nearer], for normalizeDepth()
    /// @throws Error BadFormat (fewer pictures than before); exceptions of the source
    void makeDepth(cv::Mat& photo, cv::Mat& depth);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
