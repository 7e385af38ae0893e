#pragma once

#include "altiro3D/video_conversion.hpp"
#include "common/depth_options.hpp"
#include "common/display_options.hpp"
#include "common/video_options.hpp"
#include "common/video_plan.hpp"

#include <optional>
#include <string>

namespace altiro3D::tools {

/// What the options make of a run.
struct VideoJob {
    VideoPlan plan;
    VideoProfile profile;
    ChosenDisplay display;
    QuiltLayout layout;               ///< of quilts
    NativeOptions native;             ///< how Natives are made
    std::string path;                 ///< "direct" or "quilt", for reports
    std::optional<ChosenDepth> depth; ///< absent: frames are quilts
    VideoDepthOptions depthOptions;   ///< how often it is estimated
    VideoWriterOptions encoding;      ///< how frames are encoded
};

/// Opens the input and settles everything about a run but the output: all that can be said against
/// the call is said here.
/// @param job only its plan is set; its depth is used by the conversion
/// @return the conversion
/// @throws UsageError, Error
VideoConversion openVideo(const CommandLine& commandLine, VideoJob& job, Messages& messages);

} // namespace altiro3D::tools
