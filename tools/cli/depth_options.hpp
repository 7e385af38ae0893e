#pragma once

#include "altiro3D/depth_source.hpp"
#include "cli/run_tool.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// Input of the tool, for the wording and the choice of depth options.
enum class Medium { Photo, Video };

/// -n -l --net-profile --network-size --engine -d --rgbd --depth-kind --stereo --embedded-depth
/// --unblurred; for videos also --depth
void addDepthOptions(CommandLine& commandLine, Medium medium = Medium::Photo);

/// An engine's name for people. @return "OpenCV" or "ONNX Runtime"
std::string engineName(InferenceEngine engine);

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
    bool isDefault = false;                ///< No option chooses the source.
    std::optional<StereoInput> stereo;     ///< `--stereo`
    bool isPair = false;                   ///< The eyes are in two files.
    bool isFlat = false;                   ///< `--stereo off`: no eyes are looked for.
    PhotoDepthOptions photo{false, false}; ///< What is taken from photos.
    bool refusesVr = false;                ///< No option says what the photo holds.

    /// Whether each photo is named with its depth image, or with the right eye's picture.
    bool takesPairs() const { return fromFiles || isPair; }
};
/// Reads them. @throws UsageError
DepthOptions depthOptions(const CommandLine& commandLine, Medium medium = Medium::Photo);

/// A photo, its depth, and where that comes from.
struct ReadPhoto : Scene {
    DepthOrigin origin = DepthOrigin::Estimated;
    std::string source;         ///< Of the depth, for people and reports.
    std::filesystem::path file; ///< The depth image or right eye's picture; empty: none was used.
    bool isUnblurred = false;   ///< The sharp original of a portrait (`--unblurred`).
    double focalLength35mm = 0; ///< By EXIF; 0: unknown.
};

/// The source of depth that the options choose.
class ChosenDepth {
  public:
    /// A network that the options choose is loaded at once, if they name it or if the medium is
    /// video, else when a photo needs it.
    /// @throws UsageError, Error
    ChosenDepth(const DepthOptions& options, Messages& messages);

    /// Estimates depth with another source; depth that comes with a photo still goes before it.
    void setEstimator(std::shared_ptr<DepthSource> estimator);
    /// Releases the network and its memory, after the last read().
    void release();
    /// The network; null if none is used, or if no photo has needed it yet.
    const DepthNetwork* network() const { return source_ ? source_->network() : nullptr; }
    /// The file of the network that the options choose, whether or not it is loaded; empty: none.
    const std::filesystem::path& networkFile() const { return networkFile_; }
    /// The source as text, for people and reports.
    const std::string& description() const { return description_; }
    /// Meaning of the numbers of given depth, or of source().
    DepthKind kind() const { return source_ ? source_->kind() : options_.kind; }
    /// The source that estimates depth; only if depth is not given by files.
    const std::shared_ptr<DepthSource>& source() const { return source_; }

    /// Reads the photo of one item and reads or estimates its depth, as the options say.
    /// @param photoFile photo, or RGB-D image
    /// @param depthFile depth image with `-d`, the right eye's picture with `--stereo files`, else
    ///        empty
    /// @param flatDepth value of the depth map if the depth has no range
    ReadPhoto read(const std::filesystem::path& photoFile, const std::filesystem::path& depthFile,
                   double flatDepth, Messages& messages, StageTimes& times);
    /// Estimates the depth of the last photo again; only if it was estimated.
    /// @return the source as text
    std::string estimateScene(const cv::Mat& photo, double flatDepth, Scene& scene);

  private:
    void chooseNetwork(Messages& messages);
    void tellEngine(const Messages& messages);

    DepthOptions options_;
    bool isEngineTold_ = false;
    std::shared_ptr<DepthSource> source_; // null if depth is given by files
    std::filesystem::path networkFile_;
    std::string description_;
};

} // namespace altiro3D::tools
