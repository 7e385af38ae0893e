#pragma once

#include "altiro3D/depth_source.hpp"
#include "common/run_tool.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// Photos or videos: what depth options speak of.
enum class Medium { Photo, Video };

/// -n -l --net-profile --network-size -d --rgbd --depth-kind --embedded-depth --unblurred; with
/// videos --depth, too
void addDepthOptions(CommandLine& commandLine, Medium medium = Medium::Photo);

/// Where the depth of photos comes from, by the options.
class ChosenDepth {
  public:
    /// Reads the options and loads the network, if one is to be used.
    /// @throws UsageError, Error
    ChosenDepth(const CommandLine& commandLine, Messages& messages, Medium medium = Medium::Photo);

    /// Depth is read from a file of its own (`-d`, `--depth`).
    bool fromFiles() const { return fromFiles_; }
    /// Depth is part of the picture (`--rgbd`): where.
    std::optional<DepthSide> rgbdSide() const { return rgbdSide_; }
    /// The network, if one is used.
    const DepthNetwork* network() const { return source_ ? source_->network() : nullptr; }
    /// What it is, for people and reports.
    const std::string& description() const { return description_; }
    /// What the last read() took its depth from, for people and reports.
    const std::string& used() const { return used_; }

    /// Reads photo and depth of one item, by whatever way the options say.
    /// @param photoFile photo, or one-picture RGB-D
    /// @param depthFile depth image with `-d`, else empty
    /// @param flatDepth depth where there is no range
    /// @return the photo and its depth map
    Scene read(const std::filesystem::path& photoFile, const std::filesystem::path& depthFile,
               double flatDepth, Messages& messages, StageTimes& times);

    /// What the numbers of given depth, or of estimate(), mean.
    DepthKind kind() const;
    /// Raw depth numbers of a picture, by the network or the built-in estimator.
    /// @param picture [rows x cols, CV_8UC3, BGR]
    /// @param raw [any size, CV_32FC1], see kind()
    void estimate(const cv::Mat& picture, cv::Mat& raw);

  private:
    void chooseNetwork(const CommandLine& commandLine, Messages& messages);
    void choosePhotoDepth(const CommandLine& commandLine);

    bool fromFiles_ = false;
    std::optional<DepthSide> rgbdSide_;
    DepthKind kind_ = DepthKind::NearWhite;
    std::unique_ptr<DepthSource> source_; // absent: fromFiles_, each photo has its own
    std::string description_;
    std::string used_;
};

} // namespace altiro3D::tools
