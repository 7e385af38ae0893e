#pragma once

#include "altiro3D/depth_source.hpp"
#include "cli/run_tool.hpp"

#include <optional>
#include <string>

namespace altiro3D::tools {

/// Input of the tool, for the wording and the choice of depth options.
enum class Medium { Photo, Video };

/// -n -l --net-profile --network-size --engine -d --rgbd --depth-kind --stereo --embedded-depth
/// --unblurred; for videos also --depth
void addDepthOptions(CommandLine& commandLine, Medium medium = Medium::Photo);

/// The halves of an RGB-D image or video by option, name and shape. Says so if the shape decides
/// that they are squeezed.
/// @param stated by the option @param aspect width : height of the whole as it is seen
RgbdLayout rgbdOf(const std::filesystem::path& file, const RgbdLayout& stated, double aspect,
                  Messages& messages);

/// The layout of an RGB-D image or video to write: depth at the right, halves squeezed if the name
/// says so (HRGBD).
RgbdLayout savedRgbdLayout(const std::filesystem::path& file);

/// The warning that near and far of given depth look exchanged, and what turns them round.
/// @param file holds the depth
/// @param kind what the numbers were taken for
/// @param isNamed an option of photo2native tells where the depth is (-d, --rgbd)
std::string invertedText(const std::filesystem::path& file, DepthKind kind, bool isNamed);

/// Where depth comes from.
struct DepthOptions {
    Medium medium = Medium::Photo;
    bool fromFiles = false;         ///< A separate file (`-d`, `--depth`).
    std::optional<RgbdLayout> rgbd; ///< A part of the picture (`--rgbd`).
    DepthKind kind = DepthKind::NearWhite;
    std::string given;   ///< Given depth as text, for people and reports; empty: it is not given.
    std::string network; ///< `-n`: a file, or a name of the catalogue; empty: the standard one.
    bool isLarge = false;
    std::filesystem::path profile;  ///< `--net-profile`; empty: that of the catalogue.
    std::optional<int> networkSize; ///< Longer side of the network's input, px.
    InferenceEngine engine = InferenceEngine::Best;
    bool isDefault = false;                 ///< No option chooses the source; true without options.
    std::optional<StereoInput> stereo;      ///< `--stereo`
    bool isPair = false;                    ///< The eyes are in two files.
    bool areVideos = false;                 ///< `--stereo videos`
    bool isFlat = false;                    ///< `--stereo off`: no eyes are looked for.
    PhotoDepthOptions stored{false, false}; ///< What is taken from photos; without options, depth.
    bool refusesVr = false; ///< Refuse a photo for headsets, by its name; true without options.

    /// Whether each photo is named with its depth image, or with the right eye's picture.
    bool takesPairs() const { return fromFiles || isPair; }
};
/// Reads them. @throws UsageError
DepthOptions depthOptions(const CommandLine& commandLine, Medium medium = Medium::Photo);

} // namespace altiro3D::tools
