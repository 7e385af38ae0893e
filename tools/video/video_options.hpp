#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/run_tool.hpp"

#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// A set of settings for one purpose; options on the command line override it.
struct VideoProfile {
    std::string name;
    ViewMethod method = ViewMethod::Layered;
    bool keep = false;  ///< views at the panel's resolution, continuous view positions
    int depthEvery = 0; ///< see VideoDepthOptions
    EncoderPreset preset = EncoderPreset::SuperFast;
    double crf = 16;
    double bitsPerPixel = 50; ///< most bits per px of the panel and second, 0: any
};

/// --profile
void addProfileOption(CommandLine& commandLine);
/// "live", "balanced" or "best"; without --profile live to show a video, else balanced.
/// @throws UsageError
VideoProfile videoProfile(const CommandLine& commandLine, bool show);

/// --from --to --preview, --input-format --input-options
void addVideoInputOptions(CommandLine& commandLine);
/// @throws UsageError
VideoReaderOptions videoReaderOptions(const CommandLine& commandLine);

/// --codec --crf --preset --max-rate --compat --no-audio --no-subtitles
void addEncoderOptions(CommandLine& commandLine);
/// Reads the encoder options; the video sets size and times, and its size the default of maxRate.
/// @throws UsageError
VideoWriterOptions encoderOptions(const CommandLine& commandLine, const VideoProfile& profile);

/// The cap of a Native's rate by its profile, Mbit/s; 0: none.
double defaultMaxRate(const VideoProfile& profile, cv::Size panel);

/// Whether a file is a HEIC or AVIF picture, by its first bytes. FFmpeg opens some as videos.
bool isHeifPicture(const std::filesystem::path& file);

/// Whether a file is a single picture, which FFmpeg reads as a video of one frame.
/// @param facts of the file; if they do not decide it, the file is read
bool isPicture(const std::filesystem::path& file, const VideoFacts& facts);

} // namespace altiro3D::tools
