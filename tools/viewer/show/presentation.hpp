#pragma once

#include "cli/display_options.hpp"
#include "viewer/player/video_player.hpp"
#include "viewer/show/slide_show.hpp"

namespace altiro3D::viewer {

/// What is shown on a display, and how.
struct ShowJob {
    std::vector<std::filesystem::path> files; ///< And folders; "-" alone: standard input.
    tools::DisplayOptions display;
    std::string screen; ///< By its name or number; empty: the display's own.
    SlideShow::Settings slides;
    PlaySettings play;
};
/// Reads --show and what belongs to it. @throws UsageError
ShowJob showJob(const tools::CommandLine& commandLine);

/// Says why videos have no sound, if the computer has no sound output.
void detailSilence(tools::Messages& messages);

/// Shows files one after the other, or the Natives from standard input, on the display until the
/// user closes it or, without --loop, several files have been shown.
/// @throws UsageError, Error
int present(int& argc, char** argv, const ShowJob& job, tools::Messages& messages);

/// Shows the test picture on the display until the user closes it, and says how to read it.
/// @throws UsageError, Error
int presentTestPicture(int& argc, char** argv, const ShowJob& job, tools::Messages& messages);

} // namespace altiro3D::viewer
