#pragma once

#include "common/video_plan.hpp"

namespace altiro3D::tools {

/// Makes a video as planned, or shows it: decode, depth, render and encode side by side, with
/// progress, a report, and a proper end on Ctrl-C. What the options of the command line do not say,
/// or what the tool has no options for, is as in the standard profile.
/// @return the exit status
/// @throws UsageError, Error
int runVideo(const CommandLine& commandLine, const VideoPlan& plan, Messages& messages);

} // namespace altiro3D::tools
