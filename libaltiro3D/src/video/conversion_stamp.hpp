#pragma once

#include "altiro3D/quilt.hpp"
#include "altiro3D/video_conversion.hpp"

namespace altiro3D {

/// Everything that determines the frames and the file of a conversion, for
/// ResumableVideoOptions::settings: size and time of all input files, the contents of tables and
/// networks, and all options. The caller's settings come first.
///
/// @param conversion complete, with its depth source
/// @param layout layout of the quilts
/// @return the settings
RunSettings conversionStamp(const VideoConversion& conversion, const QuiltLayout& layout);

} // namespace altiro3D
