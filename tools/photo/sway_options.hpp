#pragma once

#include "altiro3D/sway.hpp"
#include "cli/run_tool.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// --seconds --turns --fps --size: motion and size of a swaying video
void addSwayOptions(CommandLine& commandLine);
/// --lg FILE, for tools that also make the video; it belongs to the section of outputs.
/// @param of beginning of the last sentence of its help, which ends in "plays everywhere"
void addSwayFileOption(CommandLine& commandLine, const std::string& of);
/// Refuses options of addSwayOptions() without --lg. @throws UsageError
void requireSwayFile(const CommandLine& commandLine);
/// @throws UsageError
SwayOptions swayOptions(const CommandLine& commandLine);
/// --size; nothing if it was not given. @throws UsageError
std::optional<cv::Size> swaySizeOption(const CommandLine& commandLine);

/// "1080 x 1440 px, 240 frames, 8 s"
std::string swayText(const SwayOptions& options, cv::Size size);

/// Writes the video and shows the progress.
/// @throws Stopped if the run is stopped; no file appears
void writeSwayFile(const std::filesystem::path& file, cv::Size size, const SwayOptions& options,
                   const SwayView& view);

/// Writes the video of a quilt's views and shows the progress.
/// @param quilt [layout size, CV_8UC3, BGR]
/// @param aspect width : height of a view as it is shown
/// @param wanted size of the video, see swaySizeOption()
/// @param fit how the views are fitted to that size
/// @return size of the video
cv::Size writeQuiltSwayFile(const std::filesystem::path& file, const cv::Mat& quilt,
                            const QuiltLayout& layout, double aspect,
                            std::optional<cv::Size> wanted, FitMode fit, ViewFilter between,
                            const SwayOptions& options);

} // namespace altiro3D::tools
