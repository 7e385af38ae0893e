#pragma once

#include "common/run_tool.hpp"
#include "viewer/video_player.hpp"

namespace altiro3D::viewer {

/// Reads --volume and --mute.
/// @throws UsageError
PlaySettings playSettings(const tools::CommandLine& commandLine);

/// Says why videos have no sound, if the computer has no sound output.
void detailSilence(tools::Messages& messages);

/// Shows files one after the other, or the Natives from standard input, on the display until the
/// user closes it or, without --loop, several files have been shown.
/// @throws UsageError, Error
int present(int& argc, char** argv, const tools::CommandLine& commandLine,
            tools::Messages& messages);

/// Shows the test picture on the display until the user closes it, and says how to read it.
/// @throws UsageError, Error
int presentTestPicture(int& argc, char** argv, const tools::CommandLine& commandLine,
                       tools::Messages& messages);

} // namespace altiro3D::viewer
