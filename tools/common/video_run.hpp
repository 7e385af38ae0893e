#pragma once

#include "common/video_job.hpp"
#include "common/video_plan.hpp"

#include <string>

namespace altiro3D::tools {

/// Makes or shows a video as planned: decode, depth, render and encode in parallel, with progress,
/// a report, and a clean end on Ctrl-C. Settings without an option on the command line are those of
/// the standard profile.
/// @return the exit status
/// @throws UsageError, Error
int runVideo(const CommandLine& commandLine, const VideoPlan& plan, Messages& messages);

/// The part of runVideo() that depends on the input.
/// @param job from prepareVideo(), with the plan of this video
/// @param report receives the report, if it is not null
/// @return the exit status
/// @throws UsageError, Error, NotTaken
int makeVideo(const CommandLine& commandLine, VideoJob& job, std::string* report,
              Messages& messages);

/// Lets the first Ctrl-C set isStopWanted(), and a second one end the process.
void catchStop();

/// Makes the encoder give the same bytes in every run: x264's slower presets read uninitialized
/// memory.
void repeatEncoder(const VideoWriterOptions& encoding);

/// Whether Ctrl-C was pressed.
bool isStopWanted();

/// Makes Natives of the videos of a folder; one that fails does not stop the rest, Ctrl-C does.
/// @return the exit status
/// @throws UsageError, Error
int runVideoFolder(const CommandLine& commandLine, Messages& messages);

} // namespace altiro3D::tools
