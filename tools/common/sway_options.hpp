#pragma once

#include "altiro3D/sway.hpp"
#include "common/run_tool.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// --seconds --turns --fps --size: how a swaying video moves and how large it is.
void addSwayOptions(CommandLine& commandLine);
/// Whether any of them was given.
bool hasSwayOptions(const CommandLine& commandLine);
/// @throws UsageError
SwayOptions swayOptions(const CommandLine& commandLine);
/// --size; nothing if it was not given. @throws UsageError
std::optional<cv::Size> swaySizeOption(const CommandLine& commandLine);

/// "1080 x 1440 px, 240 frames, 8 s"
std::string swayText(const SwayOptions& options, cv::Size size);

/// Writes the video and shows its progress.
void writeSwayFile(const std::filesystem::path& file, cv::Size size, const SwayOptions& options,
                   const SwayView& view);

} // namespace altiro3D::tools
