#pragma once

#include "altiro3D/video_conversion.hpp"
#include "cli/bridge.hpp"
#include "cli/depth_options.hpp"
#include "cli/eyes_options.hpp"
#include "cli/outputs.hpp"
#include "cli/picture_options.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// The command line, the input and the outputs of a run of video2native.
namespace altiro3D::tools {

/// A set of settings for one purpose; options on the command line override it.
struct VideoProfile {
    std::string name;
    ViewMethod method = ViewMethod::Layered;
    bool keep = false;  ///< views at the panel's resolution, continuous view positions
    int depthEvery = 0; ///< see VideoDepthOptions
    EncoderPreset preset = EncoderPreset::SuperFast;
    double crf = 16;
    double bitsPerPixel = 50; ///< most bits per px of the panel and second, 0: any
};

/// The profile "balanced".
const VideoProfile& standardVideoProfile();

/// --codec --crf --preset --max-rate --compat --no-audio --no-subtitles
void addEncoderOptions(CommandLine& commandLine);

/// The command line of a run.
struct VideoJob {
    // The names of the files of the current video; in a run over a folder, those of the folder
    // until makeVideo() sets them. An empty path: not given.
    std::filesystem::path input;
    std::filesystem::path depthInput; ///< A video or a directory of pictures.
    std::filesystem::path output;     ///< "-": standard output
    std::filesystem::path report;
    VideoProduct product = VideoProduct::Native;
    std::filesystem::path native; ///< A Native video to make beside a video for two eyes.
    bool fromQuilt = false;
    bool show = false;         ///< Shown on the display, no output.
    bool canReadAgain = false; ///< The input is a file, so that a run can be resumed.
    bool isFolder = false;     ///< The input is a folder of videos.
    bool isFromFolder = false; ///< Left out if it holds Natives, quilts, or photo and depth.
    bool isChecked = false;    ///< The names of inputs and outputs are checked.
    std::string place;         ///< "[2/7] clip.mp4 " of a folder, for the progress line.
    VideoReaderOptions part;   ///< By options; openVideo() adds threads and eyes.

    bool replace = false; ///< `-y`
    bool resume = false;
    bool recursive = false;
    bool jsonProgress = false;
    bool isPreview = false;
    bool isMaxRateGiven = false; ///< Otherwise the display sets VideoWriterOptions::maxRate.
    VideoProfile profile;
    DisplayOptions display;
    std::optional<BridgeJob> bridge; ///< Shows the quilt or RGB-D video when it is made.
    std::string screen;              ///< `--screen`; empty: the display's own.
    QuiltRequest quilt;
    SceneOptions scene;         ///< How Natives are made, with what the profile sets.
    std::optional<FitMode> fit; ///< `--fit`; nothing: not given.
    DepthOptions depth;
    std::optional<DepthRange> depthRange;
    EyesOptions eyes; ///< How a video for two eyes is made.
    /// The pictures of the eyes stay as they were filmed: no option changes them.
    bool keepsEyes = true;
    VideoDepthOptions depthOptions; ///< How often depth is estimated.
    VideoWriterOptions encoding;    ///< How frames are encoded.
    std::string tool;
    std::vector<std::pair<std::string, std::string>> given; ///< As given, for the report.
    RunSettings
        settings; ///< Those of `given` that determine the frames and the file, to resume a run.

    // The names for people.
    std::string inputName() const { return nameOf(input, "standard input"); }
    std::string outputName() const { return nameOf(output, "standard output"); }
};
/// What a job needs the display for.
DisplayUse displayUse(const VideoJob& job);
/// Turns a command line of video2native into a job. @throws UsageError
VideoJob videoJob(const CommandLine& commandLine);
/// The same if the names are read already. @param job holds the names and nothing else
VideoJob videoJob(const CommandLine& commandLine, VideoJob job);

} // namespace altiro3D::tools
