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
/// --lg FILE, for tools that make the video besides, in a section of options for outputs.
/// @param of what it tells of the pictures
void addSwayFileOption(CommandLine& commandLine, const std::string& of);
/// Refuses options of addSwayOptions() without --lg. @throws UsageError
void requireSwayFile(const CommandLine& commandLine);
/// @throws UsageError
SwayOptions swayOptions(const CommandLine& commandLine);
/// --size; nothing if it was not given. @throws UsageError
std::optional<cv::Size> swaySizeOption(const CommandLine& commandLine);

/// "1080 x 1440 px, 240 frames, 8 s"
std::string swayText(const SwayOptions& options, cv::Size size);

/// Writes the video and shows its progress.
void writeSwayFile(const std::filesystem::path& file, cv::Size size, const SwayOptions& options,
                   const SwayView& view);

/// The same through the views of a quilt.
/// @param quilt without unused px
/// @param aspect width : height that a view is shown with
/// @param wanted size of the video, see swaySizeOption()
/// @param fit of the views to that size
/// @return size of the video
cv::Size writeQuiltSwayFile(const std::filesystem::path& file, const cv::Mat& quilt,
                            const QuiltLayout& layout, double aspect,
                            std::optional<cv::Size> wanted, FitMode fit, ViewFilter between,
                            const SwayOptions& options);

} // namespace altiro3D::tools
