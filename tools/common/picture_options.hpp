#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/photo_fit.hpp"
#include "common/run_tool.hpp"

namespace altiro3D::tools {

/// --strength --focus -k
void addViewOptions(CommandLine& commandLine);
ViewOptions viewOptions(const CommandLine& commandLine);

/// --fit
void addFitOption(CommandLine& commandLine, const std::string& standard);
/// @param standard used where the option is not given
FitMode fitOption(const CommandLine& commandLine, FitMode standard);
/// "cover", "contain" or "stretch"
std::string fitName(FitMode mode);

/// Warns where a Native loses its sub-pixels on the way to the file.
void warnAboutNativeFormat(const std::filesystem::path& file, Messages& messages);

/// Reads a photo or quilt; remarks about the file become warnings.
cv::Mat readPhotoFile(const std::filesystem::path& file, Messages& messages);

} // namespace altiro3D::tools
