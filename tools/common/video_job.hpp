#pragma once

#include "altiro3D/video_conversion.hpp"
#include "common/depth_options.hpp"
#include "common/display_options.hpp"
#include "common/video_options.hpp"
#include "common/video_plan.hpp"

#include <optional>
#include <string>

namespace altiro3D::tools {

/// Everything that the options determine about a run.
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

/// Opens the input and determines everything about a run except the output. Reports all errors of
/// the call.
/// @param job only `plan` must be set; the conversion uses `depth`, so keep the job alive
/// @return the conversion
/// @throws UsageError, Error
VideoConversion openVideo(const CommandLine& commandLine, VideoJob& job, Messages& messages);

} // namespace altiro3D::tools
