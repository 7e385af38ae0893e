#pragma once

#include "altiro3D/video_conversion.hpp"
#include "common/depth_options.hpp"
#include "common/display_options.hpp"
#include "common/video_options.hpp"
#include "common/video_plan.hpp"

#include <optional>
#include <string>

namespace altiro3D::tools {

/// Everything that the options determine about a run. One job may make several videos.
struct VideoJob {
    VideoPlan plan;
    VideoProfile profile;
    ChosenDisplay display;
    QuiltLayout layout;               ///< layout of quilts
    NativeOptions native;             ///< how Natives are made
    std::string path;                 ///< "direct" or "quilt", for reports
    std::optional<ChosenDepth> depth; ///< absent if frames are quilts
    VideoDepthOptions depthOptions;   ///< how often depth is estimated
    VideoWriterOptions encoding;      ///< how frames are encoded
};

/// Determines what does not depend on the input: options, profile and display. Reports errors of
/// the call.
/// @param job `plan` must be set
/// @throws UsageError, Error
void prepareVideo(const CommandLine& commandLine, VideoJob& job, Messages& messages);

/// Chooses the source of depth, unless the job has one already or the frames are quilts.
/// @param job from prepareVideo()
/// @throws UsageError, Error
void openDepth(const CommandLine& commandLine, VideoJob& job, Messages& messages);

/// The layout of the quilts that a run makes, and of the views of its Natives.
/// @param job from prepareVideo(); its frames are no quilts
/// @throws UsageError, Error
QuiltLayout layoutOfViews(const CommandLine& commandLine, const VideoJob& job, Messages& messages);

/// Opens the input and determines everything about a run except the output. Reports all errors of
/// the input.
/// @param job from prepareVideo(), or of an earlier video with another plan; the conversion uses
///        `depth`, so keep the job alive
/// @return the conversion
/// @throws UsageError, Error, NotTaken
VideoConversion openVideo(const CommandLine& commandLine, VideoJob& job, Messages& messages);

} // namespace altiro3D::tools
