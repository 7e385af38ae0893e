#pragma once

#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"
#include "common/display_options.hpp"
#include "common/outputs.hpp"

#include <filesystem>
#include <string>

/// The input and outputs of a run of video2native.
namespace altiro3D::tools {

/// Names and kinds of the input and outputs of one run. An empty path: not given.
struct VideoPlan {
    std::filesystem::path input;
    std::filesystem::path depth; ///< a video or a directory of pictures
    std::filesystem::path output;
    std::filesystem::path report;
    VideoProduct product = VideoProduct::Native;
    bool fromQuilt = false;
    bool show = false;         ///< shown on the display, no output
    bool isFile = false;       ///< the input can be read again, so that a run can be resumed
    bool isFromFolder = false; ///< Left out if it turns out to be a Native video.
    bool isChecked = false;    ///< checkOutputs() is not needed: the folder's run has done it.
    std::string place;         ///< "[2/7] clip.mp4 " of a folder, for the progress line
    VideoReaderOptions part;

    /// The input's name for people.
    std::string inputName() const { return input == "-" ? "standard input" : input.string(); }
};

/// Derives the plan from the command line.
/// @throws UsageError if its options exclude each other
VideoPlan planVideo(const CommandLine& commandLine);

/// Whether the input is a folder of videos.
bool takesFolder(const CommandLine& commandLine);

/// Adds the files that a run reads besides its input: calibrations, network and profile.
void addCommonInputs(const CommandLine& commandLine, const ChosenDisplay& display,
                     Outputs& outputs);

/// Checks the names of a run before any work, see Outputs::check().
/// @throws UsageError, Error
void checkOutputs(const CommandLine& commandLine, const VideoPlan& plan,
                  const ChosenDisplay& display);

/// The options that determine the frames and the file, as a JSON object of texts. A run can only be
/// resumed with the same options.
RunSettings settingsOf(const CommandLine& commandLine);

} // namespace altiro3D::tools
