#pragma once

#include "altiro3D/quilt.hpp"
#include "common/display_options.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::viewer {

/// What a file is taken for.
enum class Reading {
    Automatic, ///< What its name and size suggest.
    Photo,
    RgbdRight, ///< Photo and depth in one picture, depth on the right; and so on.
    RgbdLeft,
    RgbdTop,
    RgbdBottom,
    Quilt,
    Native
};

/// Something to open.
struct Source {
    std::filesystem::path file;  ///< Picture, directory of views, or video.
    std::filesystem::path depth; ///< Depth image that goes with it; empty: none.
    Reading reading = Reading::Automatic;
};

/// What an opened file holds.
enum class Kind {
    Scene, ///< A photo, with depth or without.
    Quilt,
    Native
};

/// An opened file; does not change.
struct Document {
    Source source;
    Kind kind = Kind::Scene;
    cv::Mat picture;                 ///< [CV_8UC3, BGR]: photo, quilt or Native.
    cv::Mat rawDepth;                ///< The photo's depth, as in its file; empty if there is none.
    cv::Mat depth;                   ///< Of a video's photo: its depth map; else empty.
    QuiltLayout layout;              ///< Of a quilt.
    std::optional<double> certainty; ///< Of the layout, 0..1, if it was found in the picture.
    bool video = false;              ///< A picture of a video; others follow.
    Notes notes;                     ///< Remarks about the files.

    /// "Photo, 900 x 1200 px, with depth"
    std::string facts() const;
};

/// Ends of the names of what is opened, without the point: of pictures, and of videos. A picture of
/// any other name is opened by what it holds; these are what the dialog and the desktop entry
/// offer.
const std::vector<std::string>& pictureEndings();
const std::vector<std::string>& videoEndings();

/// True for the names of files that are read as videos, and for capture devices (/dev/video0) and
/// links to them.
bool isVideoName(const std::filesystem::path& file);

/// Opens a picture, a directory of views, or the first picture of a video.
/// @param display whose panel and quilt tell Natives and lay out views
/// @throws Error and whatever reading it throws
Document readDocument(const Source& source, const Display& display);

/// The document of a picture that has been read.
/// @param picture [CV_8UC3 or CV_16UC3, BGR]
Document documentOf(const Source& source, const cv::Mat& picture, const Display& display);

/// Puts photos and their depth images together: "a.jpg" and "a-depth.png" (or a_depth, a.depth) are
/// one thing to open.
std::vector<Source> pairUp(const std::vector<std::filesystem::path>& files);

} // namespace altiro3D::viewer
