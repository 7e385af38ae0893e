#pragma once

#include "common/run_tool.hpp"

namespace altiro3D::viewer {

/// Shows one Native, or the Natives from standard input, on the display until the user closes it.
/// @throws UsageError, Error
int present(int& argc, char** argv, const tools::CommandLine& commandLine,
            tools::Messages& messages);

} // namespace altiro3D::viewer
