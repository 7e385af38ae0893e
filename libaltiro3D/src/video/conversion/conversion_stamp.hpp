#pragma once

#include "altiro3D/quilt.hpp"
#include "altiro3D/video_conversion.hpp"
#include "base/json_reader.hpp"

namespace altiro3D {

/// Takes the range of given depth that an earlier run or a plan has measured, unless one is set.
/// @param settings of the run or the plan
void takeDepthRange(VideoConversion& conversion, const Json& settings);

/// Everything that determines the frames and the file of a conversion, for
/// ResumableVideoOptions::settings: size and time of all input files, the contents of tables and
/// networks, and all options. The caller's settings come first.
///
/// @param conversion complete, with its depth source
/// @param layout layout of the quilts
/// @return the settings
RunSettings conversionStamp(const VideoConversion& conversion, const QuiltLayout& layout);

} // namespace altiro3D
