#pragma once

#include "cli/chosen_depth.hpp"
#include "cli/folders.hpp"
#include "video/video_options.hpp"

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::tools {

/// Everything that is determined about a run. It may make several videos, one after the other.
struct VideoRun {
    /// @param of what the command line says @param chosen its display
    VideoRun(VideoJob of, ChosenDisplay chosen) : job(std::move(of)), display(std::move(chosen)) {}
    /// Finds the display. @throws UsageError, Error
    VideoRun(const VideoJob& of, Messages& messages);

    VideoJob job; ///< The present video's, with what its input determines.
    ChosenDisplay display;
    QuiltLayout layout;               ///< Layout of quilts.
    std::string path;                 ///< "direct" or "quilt", for reports.
    std::optional<ChosenDepth> depth; ///< Absent if frames are quilts.
    VideoFacts inputFacts;            ///< The facts of the input that was opened last.
};

/// Whether a file is a single picture, which FFmpeg reads as a video of one frame.
/// @param facts of the file; if they do not decide it, the file is read
bool isPicture(const std::filesystem::path& file, const VideoFacts& facts);

/// Depth that a video file has in a video stream of its own.
struct DepthTrack {
    bool isDeep = false; ///< It has 16 bits, which count as distances; else white is near.
    bool fits = false;   ///< It has the shape of the colours, so that it is used.

    DepthKind kind() const { return isDeep ? DepthKind::Metric : DepthKind::NearWhite; }
    std::string text() const {
        return isDeep ? "as distances, because it has 16 bits" : "white as near";
    }
};
constexpr const char* kMisfitText = "because it has another shape than the colours";

/// Finds the depth stream of a video file. @param facts of the file
std::optional<DepthTrack> findDepthTrack(const std::filesystem::path& file,
                                         VideoReaderOptions reading, const VideoFacts& facts);

/// Chooses the source of depth, unless the run has one already or the frames are quilts.
/// @throws UsageError, Error
void openDepth(VideoRun& run, Messages& messages);

/// The layout of the quilts that a run makes, and of the views of its Natives.
/// @param run its frames are no quilts
/// @throws UsageError, Error
QuiltLayout layoutOfViews(const VideoRun& run, Messages& messages);

/// Opens the input and determines everything about a run except the output. Reports all errors of
/// the input.
/// @param run `job` is that of this video; the conversion uses `depth`, so keep the run alive
/// @return the conversion
/// @throws UsageError, Error, NotTaken
VideoConversion openVideo(VideoRun& run, Messages& messages);

/// Makes or shows a video: decode, depth, render and encode in parallel, with progress, a report,
/// and a clean end on Ctrl-C.
/// @return the exit status
/// @throws UsageError, Error
int runVideo(const VideoJob& job, Messages& messages);

/// The part of runVideo() that depends on the input.
/// @param run with the job of this video
/// @param report receives the report, if it is not null
/// @return the exit status
/// @throws UsageError, Error, NotTaken
int makeVideo(VideoRun& run, std::string* report, Messages& messages);

/// The same of a video of a folder, whose names are checked.
/// @param place "[2/7] clip.mp4 ", for the progress line
int makeVideo(VideoRun& run, const FolderItem& file, const std::string& place, std::string* report,
              Messages& messages);

/// "45.1 MB"
std::string bytesText(double bytes);
/// Size and rate of a file: "45.1 MB, 120.3 Mbit/s". @param seconds its length
std::string bytesAndRateText(double bytes, double seconds);
/// Says how many cores it takes to play a Native, if it is H.264 4:4:4, which graphics hardware
/// does not decode, and one core can hardly play it. @param rate Mbit/s
void tellDecoding(const VideoRun& run, double rate, Messages& messages);

/// Shows the videos of a run on the displays of Looking Glass Bridge, if its job names a Bridge.
void showByBridge(const VideoRun& run, const std::vector<std::filesystem::path>& files,
                  Messages& messages);

/// Makes the encoder give the same bytes in every run: x264's slower presets read uninitialized
/// memory.
void repeatEncoder(const VideoWriterOptions& encoding);

/// Makes Natives of the videos of a folder; one that fails does not stop the rest, Ctrl-C does.
/// @return the exit status
/// @throws UsageError, Error
int runVideoFolder(const VideoJob& job, Messages& messages);

/// Adds the options of many machines, see chunk_folder.hpp and altiro3D/video_conversion.hpp.
void addVideoChunkOptions(CommandLine& commandLine);
/// Plans a run, makes a chunk or joins the chunks, if the command line says so. The folder of a
/// plan also holds `joined`, the size and time of the output that the join wrote.
/// @param arguments the command line's words, the program's name first
/// @param addOptions adds all options of the tool to another command line, which reads the words of
///        the plan
/// @return the exit status; nothing for other command lines
/// @throws UsageError, Error
std::optional<int> runVideoChunks(const CommandLine& commandLine,
                                  const std::vector<std::string>& arguments,
                                  const std::function<void(CommandLine&)>& addOptions,
                                  Messages& messages);

} // namespace altiro3D::tools
