#pragma once

#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"
#include "common/display_options.hpp"

#include <filesystem>
#include <string>

/// What video2native is asked for.
namespace altiro3D::tools {

/// From what to what; the names and kinds of one run. Empty paths: not given.
struct VideoPlan {
    std::filesystem::path input;
    std::filesystem::path depth; ///< a video or a directory of pictures
    std::filesystem::path output;
    std::filesystem::path report;
    VideoProduct product = VideoProduct::Native;
    bool fromQuilt = false;
    bool show = false;   ///< on the display, no output
    bool isFile = false; ///< the input can be read once more, so that a run can be resumed
    VideoReaderOptions part;

    /// The input's name for people.
    std::string inputName() const { return input == "-" ? "standard input" : input.string(); }
};

/// The plan that a command line asks for.
/// @throws UsageError where its options do not fit together
VideoPlan planVideo(const CommandLine& commandLine);

/// Checks the names of a run before any work is done: no output is an input, none would be lost.
/// @throws UsageError, Error
void checkOutputs(const CommandLine& commandLine, const VideoPlan& plan,
                  const ChosenDisplay& display);

/// The options that shape the frames and the file, as a JSON object of texts: a run is resumed with
/// the same only.
RunSettings settingsOf(const CommandLine& commandLine);

} // namespace altiro3D::tools
