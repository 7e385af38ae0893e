#pragma once

#include "altiro3D/image_io.hpp"
#include "altiro3D/stereo_views.hpp"
#include "cli/run_tool.hpp"

#include <filesystem>

namespace altiro3D::tools {

/// How pictures or videos for two eyes are made.
struct EyesOptions {
    EyesPicture picture = EyesPicture::SideBySide;
    bool areFiles = false; ///< Two pictures, each of one eye.
    EyesFrom from = EyesFrom::Both;
    bool swapped = false;
    double strengthPercent = kEyesStrength; ///< `--strength`; its default is that of displays.
};

/// --stereo-layout --stereo-keep --stereo-swap
/// @param output the option that asks for the file @param files whether the layout "files" exists
void addEyesOptions(CommandLine& commandLine, const std::string& output, bool files);
/// @param output the option that asks for the file; without it, the others are refused
/// @throws UsageError
EyesOptions eyesOptions(const CommandLine& commandLine, const std::string& output);

/// Says which tag players look for, if a name lacks it.
void tellEyesTag(const std::filesystem::path& file, const EyesOptions& options,
                 const Messages& messages);

} // namespace altiro3D::tools
