#pragma once

#include "video/video_options.hpp"
#include "viewer/model/document.hpp"
#include "viewer/model/knobs.hpp"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace altiro3D::viewer {

/// How far an export of a video is.
struct VideoExportState {
    double share = 0;                  ///< The part that is done, 0..1; 0 if the length is unknown.
    double end = 0;                    ///< Made so far, s of the video.
    std::optional<double> length;      ///< The video's, s.
    double framesPerSecond = 0;        ///< Speed.
    std::optional<double> secondsLeft; ///< Nothing until it can be estimated.
    std::optional<double> bytes;       ///< The finished file's, estimated.
    bool finishing = false;            ///< All pictures are made; it can no longer be cancelled.
};

/// Result of an export that was not an error.
struct VideoExportResult {
    std::string file;                 ///< Empty: cancelled.
    double bytes = 0;                 ///< The file's.
    double end = 0;                   ///< Its length, s; of a cancelled run what was made.
    bool keepsParts = false;          ///< A later run can continue this one, which was cancelled.
    std::vector<std::string> notes{}; ///< Remarks about the video, a sentence each.
};

/// Why a video cannot be exported, for people; empty if it can.
/// @param document the open video @param knobs its settings, `depth` from DepthMaker::choose()
std::string videoExportObstacle(const Document& document, const Knobs& knobs);

/// The job of video2native that makes a Native video with the settings of the window.
/// @param document the open video, without an obstacle @param knobs as for the obstacle
/// @param display that it is made for
/// @param goesOn continue an unfinished run of that file; otherwise it is removed
tools::VideoJob videoJobOf(const Document& document, const Knobs& knobs, const Display& display,
                           const std::filesystem::path& file, bool goesOn);

/// Runs it. The file gets its name when it is complete. A cancelled run keeps its parts of about
/// 6 s next to it, see VideoConverter, and leaves a file of that name as it is.
/// @param display its quilt has the layout of the views
/// @param goOn receives the state, at most four times a second; returns false to cancel
/// @throws Error
VideoExportResult exportVideo(const tools::VideoJob& job, const Display& display,
                              const std::function<bool(const VideoExportState&)>& goOn);

} // namespace altiro3D::viewer
