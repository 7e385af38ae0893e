#pragma once

#include "common/run_tool.hpp"

namespace altiro3D::viewer {

/// Whether there is a desktop to open windows on.
bool hasDesktop();

/// Prints the displays, screens and volumes that are found, for people or (--json) for programs.
int listDisplays(int& argc, char** argv, const tools::CommandLine& commandLine,
                 tools::Messages& messages);

/// Shows one Native on the display until the user leaves it.
/// @throws UsageError, Error
int present(int& argc, char** argv, const tools::CommandLine& commandLine,
            tools::Messages& messages);

} // namespace altiro3D::viewer
