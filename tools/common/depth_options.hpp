#pragma once

#include "altiro3D/depth_source.hpp"
#include "common/run_tool.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// Input of the tool, for the wording and the choice of depth options.
enum class Medium { Photo, Video };

/// -n -l --net-profile --network-size --engine -d --rgbd --depth-kind --stereo --embedded-depth
/// --unblurred;
/// for videos also --depth
void addDepthOptions(CommandLine& commandLine, Medium medium = Medium::Photo);

/// An engine's name for people. @return "OpenCV" or "ONNX Runtime"
std::string engineName(InferenceEngine engine);

/// The halves of an RGB-D image or video by option, name and shape. Says so if the shape decides
/// that they are squeezed.
/// @param stated by the option @param aspect width : height of the whole as it is seen
RgbdLayout rgbdOf(const std::filesystem::path& file, const RgbdLayout& stated, double aspect,
                  Messages& messages);

/// The warning that near and far of given depth look exchanged, and what turns them round.
/// @param file holds the depth
/// @param kind what the numbers were taken for
/// @param isNamed an option of photo2native tells where the depth is (-d, --rgbd)
std::string invertedText(const std::filesystem::path& file, DepthKind kind, bool isNamed);

/// The source of depth that the options choose.
class ChosenDepth {
  public:
    /// Reads the options. A network that they choose is loaded at once, if they name it or if the
    /// medium is video, else when a photo needs it.
    /// @throws UsageError, Error
    ChosenDepth(const CommandLine& commandLine, Messages& messages, Medium medium = Medium::Photo);

    /// True if depth is read from a separate file (`-d`, `--depth`).
    bool fromFiles() const { return fromFiles_; }
    /// Where the depth is if it is part of the picture (`--rgbd`).
    const std::optional<RgbdLayout>& rgbd() const { return rgbd_; }
    /// True if no option chooses where estimated depth comes from.
    bool isDefault() const { return isDefault_; }
    /// Estimates depth with another source; depth that comes with a photo still goes before it.
    void use(std::shared_ptr<DepthSource> estimator);
    /// The network; null if none is used, or if no photo has needed it yet.
    const DepthNetwork* network() const { return source_ ? source_->network() : nullptr; }
    /// The file of the network that the options choose, whether or not it is loaded; empty: none.
    const std::filesystem::path& networkFile() const { return networkFile_; }
    /// The source as text, for people and reports.
    const std::string& description() const { return description_; }
    /// What the last read() took its depth from, for people and reports.
    const std::string& used() const { return used_; }

    /// Reads the photo of one item and reads or estimates its depth, as the options say.
    /// @param photoFile photo, or RGB-D image
    /// @param depthFile depth image with `-d`, the right eye's picture with `--stereo files`, else
    ///        empty
    /// @param flatDepth value of the depth map if the depth has no range
    /// @return the photo and its depth map
    Scene read(const std::filesystem::path& photoFile, const std::filesystem::path& depthFile,
               double flatDepth, Messages& messages, StageTimes& times);

    /// Meaning of the numbers of given depth, or of source().
    DepthKind kind() const;
    /// Whether the last photo was the sharp original of a portrait (--unblurred).
    bool isUnblurred() const { return isUnblurred_; }
    /// True if the depth of the last photo was estimated, not given.
    bool isEstimated() const { return origin_ == DepthOrigin::Estimated; }
    /// The source that estimates depth; only if depth is not given by files.
    DepthSource& source() { return *source_; }
    /// Estimates the depth of the last photo again. Requires isEstimated().
    void estimateScene(const cv::Mat& photo, double flatDepth, Scene& scene);

  private:
    void chooseNetwork(const CommandLine& commandLine, Medium medium, Messages& messages);
    void tellEngine(const Messages& messages);
    void choosePhotoDepth(const CommandLine& commandLine);

    bool fromFiles_ = false;
    bool isStereoFiles_ = false;
    std::optional<RgbdLayout> rgbd_;
    DepthKind kind_ = DepthKind::NearWhite;
    bool isDefault_ = false;
    PhotoDepthOptions photoDepth_{false, false};
    bool refusesVr_ = false; // no option says what the photo holds
    bool isEngineTold_ = false;
    std::optional<StereoInput> stereo_;   // one picture with both eyes
    std::shared_ptr<DepthSource> source_; // null with fromFiles_
    std::filesystem::path networkFile_;
    std::string description_;
    std::string used_;
    bool isUnblurred_ = false;
    DepthOrigin origin_ = DepthOrigin::Estimated; // of the last photo
};

} // namespace altiro3D::tools
