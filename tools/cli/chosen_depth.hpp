#pragma once

#include "altiro3D/depth_source.hpp"
#include "cli/depth_options.hpp"

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// An engine's name for people. @return "OpenCV" or "ONNX Runtime"
std::string engineName(InferenceEngine engine);

/// The names of a catalogue's networks.
std::vector<std::string> namesOf(const std::vector<NetworkProfile>& catalog);

/// A photo, its depth, and where that comes from.
struct PhotoScene : Scene {
    DepthOrigin origin = DepthOrigin::Estimated;
    std::string source;         ///< Where the depth is from, for people and reports.
    std::filesystem::path file; ///< The depth image or right eye's picture; empty: none was used.
    bool isUnblurred = false;   ///< The sharp original of a portrait (`--unblurred`).
};

/// The source of depth that the options choose.
class ChosenDepth {
  public:
    /// A network that the options choose is loaded at once, if they name it or if the medium is
    /// video, else when a photo needs it.
    /// @throws UsageError, Error
    ChosenDepth(const DepthOptions& options, Messages& messages);

    /// Estimates depth with a source; depth that comes with a photo still precedes it.
    void useEstimator(std::shared_ptr<DepthSource> estimator);
    /// Releases the network and its memory, after the last read().
    void release();
    /// The network; null if none is used, if no photo has needed it yet, and after release().
    const DepthNetwork* network() const { return source_ ? source_->network() : nullptr; }
    /// The file of the network that the options choose, whether or not it is loaded; empty: none.
    const std::filesystem::path& networkFile() const { return networkFile_; }
    /// The source as text, for people and reports.
    const std::string& description() const { return description_; }
    /// Meaning of the numbers of given depth, or of source().
    DepthKind kind() const { return source_ ? source_->kind() : options_.kind; }
    /// The source of depth that is not in separate files. Depth that comes with a photo takes
    /// precedence over the network's. Null if depth is given by files.
    const std::shared_ptr<DepthSource>& source() const { return source_; }

    /// Reads the photo of one item and reads or estimates its depth, as the options say.
    /// @param photoFile photo, or RGB-D image
    /// @param depthFile depth image with `-d`, the right eye's picture with `--stereo files`, else
    ///        empty
    /// @param flatDepth value of the depth map if the depth has no range
    PhotoScene read(const std::filesystem::path& photoFile, const std::filesystem::path& depthFile,
                    double flatDepth, Messages& messages, StageTimes& times);
    /// Estimates the depth of the last photo again; only if it was estimated.
    /// @return the source as text
    std::string estimateScene(const cv::Mat& photo, double flatDepth, Scene& scene);

  private:
    std::shared_ptr<DepthSource> chooseNetwork(Messages& messages);
    std::shared_ptr<DepthSource> openNetwork(const InstalledNetwork& chosen,
                                             const std::vector<NetworkProfile>& catalog,
                                             Messages& messages);
    void tellEngine(const Messages& messages);

    DepthOptions options_;
    bool isEngineTold_ = false;
    std::shared_ptr<DepthSource> source_; // null if depth is given by files
    std::filesystem::path networkFile_;
    std::string description_;
};

} // namespace altiro3D::tools
