#pragma once

#include "altiro3D/depth_source.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/splats.hpp"
#include "altiro3D/video_conversion.hpp"
#include "cli/display_options.hpp"

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace altiro3D::viewer {

/// How a file is interpreted.
enum class Reading {
    Automatic, ///< Decided from its name, size and contents.
    Photo,
    RgbdRight, ///< Photo and depth in one picture, depth on the right; the next three likewise.
    RgbdLeft,
    RgbdTop,
    RgbdBottom,
    EyesLeftRight, ///< The pictures of both eyes in one, see StereoLayout; the next two likewise.
    EyesRightLeft,
    EyesTopBottom,
    Quilt,
    Native,
    Slide ///< A video or a folder of photos from a camera that moves sideways: real views.
};

/// A file to open.
struct Source {
    std::filesystem::path file;  ///< Picture, directory of views, or video.
    std::filesystem::path depth; ///< Its depth image; empty: none.
    Reading reading = Reading::Automatic;
};

/// Contents of an opened file.
enum class Kind {
    Scene, ///< A photo, with or without depth.
    Quilt,
    Native
};

/// An opened file; immutable.
struct Document {
    Source source;
    Kind kind = Kind::Scene;
    cv::Mat picture;    ///< [CV_8UC3, BGR]: photo, quilt or Native.
    cv::Mat rawDepth;   ///< The photo's depth as in its file; empty if there is none.
    HiddenLayer hidden; ///< What only the right eye of a pair sees, with disparities as depth.
    DepthOrigin origin = DepthOrigin::Given; ///< How rawDepth came to be.
    std::string depthOrigin;         ///< Where the depth that came with the photo was; else empty.
    cv::Mat depth;                   ///< Estimated depth map of a video's picture; else empty.
    QuiltLayout layout;              ///< Layout of a quilt.
    std::optional<double> certainty; ///< The layout's, 0..1, if it was found in the picture.
    bool video = false;              ///< The picture belongs to a video.
    std::optional<StereoVideo> eyes; ///< How a picture of the video holds those of both eyes.
    cv::Mat right; ///< What the right eye sees in such a video, for the depth; may be empty.
    /// Reads the depth stream of a video, which rawDepth then holds, 0..1; else null.
    std::shared_ptr<GivenDepthReader> depthTrack;
    /// The scene of a video that plays: pictures with one number share settings that are chosen by
    /// the scene, and the flaws of its depth (PlayedDepth).
    int scene = 0;
    std::shared_ptr<const SplatScene> splats; ///< What a quilt of views was rendered of, or null.
    std::optional<SplatPlacement> placement;  ///< Of these views; their depth is `depth`.
    Notes notes;                              ///< Remarks about the files.

    /// Whether depth came with the picture, or can be found by matching both eyes.
    bool hasDepth() const { return !rawDepth.empty() || !right.empty() || depthTrack; }

    /// The depth map of rawDepth.
    void readDepth(cv::Mat& map) const;

    /// "Photo, 900 x 1200 px; depth in the photo's file (GDepth, 768 x 1024 px)"
    std::string facts() const;
};

/// How the views of splats are rendered.
struct SplatSight {
    /// Its centre turns the camera: half a turn around the scene to the left (0) .. right (1), and
    /// from below (0) .. above (1). Its zoom enlarges.
    Framing framing;
    std::optional<double> focus;           ///< See placeSplats().
    std::optional<double> strengthPercent; ///< Likewise.
    QuiltLayout layout;                    ///< Of the quilt.
    bool isDraft = false;                  ///< Half the px, without harmonics.
    bool isOneView = false;                ///< The middle one is the whole quilt.

    /// All fields, to compare them. @param s the sight @return references to its fields
    static auto fields(const SplatSight& s) {
        return std::tie(s.framing, s.focus, s.strengthPercent, s.layout, s.isDraft, s.isOneView);
    }
    bool operator==(const SplatSight& other) const { return fields(*this) == fields(other); }
    bool operator!=(const SplatSight& other) const { return !(*this == other); }
};

/// The document with other views of its splats. @throws Error as chooseSplatCamera(), placeSplats()
Document withSight(const Document& document, const Display& display, const SplatSight& sight);

/// Refuses pipes: the viewer reads files more than once, and opening a pipe waits for its writer.
/// @throws Error Unsupported
void refusePipe(const std::filesystem::path& file);

/// True for files that are read as videos, judged by their names, and for capture devices
/// (/dev/video0) and links to them.
bool isVideoName(const std::filesystem::path& file);

/// The picture of a file, or the first one of a video. @throws Error as readPhoto(), VideoReader
cv::Mat firstPicture(const std::filesystem::path& file, const VideoReaderOptions& reading = {});
/// How a video is read: spatial video with both eyes, unless it is read as a flat one.
VideoReaderOptions readingOf(const Source& video);

/// What a folder holds.
struct FolderFiles {
    std::vector<Source> files; ///< The folder itself if it holds views of one scene.
    Notes notes;               ///< Says what is left out.
};

/// Finds the pictures and videos of a folder, without its subfolders. Pictures of equal size that
/// resemble each other are views of one scene.
/// @throws Error NotFound (holds none), and as listImages()
FolderFiles filesOfFolder(const std::filesystem::path& folder);

/// The half of a video's pictures that holds the depth, by its reading or its name; nothing if they
/// hold none.
std::optional<DepthSide> depthSideOf(const Source& video);

/// Opens a picture, a directory of views, or the first picture of a video.
/// @param display its panel size identifies Natives; its quilt is the default layout of views
/// @throws Error and the exceptions of reading it
Document readDocument(const Source& source, const Display& display);

/// Makes a document from a picture in memory.
/// @param picture [CV_8UC3 or CV_16UC3, BGR] @param eyes of a video with both eyes' pictures
Document documentOf(const Source& source, const cv::Mat& picture, const Display& display,
                    const std::optional<StereoVideo>& eyes = {});

/// Makes the document of a further picture of an open video, for PlayedDepth::next().
Document documentOfFrame(const Document& video, const cv::Mat& picture, const Display& display);

/// Pairs photos with their depth images, see photoOfDepthName(): "a.jpg" and "a-depth.png" become
/// one source, and so do "a.jpg" and the splats "a.ply".
std::vector<Source> pairUp(const std::vector<std::filesystem::path>& files);

} // namespace altiro3D::viewer
