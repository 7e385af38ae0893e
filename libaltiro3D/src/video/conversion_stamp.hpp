#pragma once

#include "altiro3D/quilt.hpp"
#include "altiro3D/video_conversion.hpp"

namespace altiro3D {

/// Everything that shapes the frames and the file of a conversion, for
/// ResumableVideoOptions::settings: the state of all files that are read, by size and time, what
/// tables and networks hold, and all options. The caller's settings come first.
///
/// @param conversion complete, with its depth source
/// @param layout of the quilts
/// @return the settings
RunSettings conversionStamp(const VideoConversion& conversion, const QuiltLayout& layout);

} // namespace altiro3D
