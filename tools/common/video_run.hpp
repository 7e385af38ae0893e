#pragma once

#include "common/video_plan.hpp"

namespace altiro3D::tools {

/// Makes or shows a video as planned: decode, depth, render and encode in parallel, with progress,
/// a report, and a clean end on Ctrl-C. Settings without an option on the command line are those of
/// the standard profile.
/// @return the exit status
/// @throws UsageError, Error
int runVideo(const CommandLine& commandLine, const VideoPlan& plan, Messages& messages);

} // namespace altiro3D::tools
