#pragma once

#include "altiro3D/depth_source.hpp"
#include "cli/run_tool.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// Makes sure that a network does not crash this process. A network whose SHA-256 is in the
/// catalogue is trusted; any other is first tested in a child process (probeNetwork()). Warns if a
/// file has a name of the catalogue but other contents.
///
/// The result is kept in the user's cache until the file changes, so the test runs only once.
///
/// @param file the ONNX file @param profile preparation of its input
/// @param catalog the known networks @param inputSize, engine as for DepthNetwork
/// @throws Error NetworkFailed
void requireHarmless(const std::filesystem::path& file, const NetworkProfile& profile,
                     const std::vector<NetworkProfile>& catalog, cv::Size inputSize,
                     InferenceEngine engine, Messages& messages);

/// Depth of a photo by the standard network, for looksInverted(). Empty if there is none, if its
/// file is not the catalogue's, which might crash, or if it fails.
cv::Mat trustedEstimate(const cv::Mat& photo);

/// The command that downloads a network of the catalogue, with its path on this machine; where
/// that is not installed, the address and where the file belongs.
std::string howToDownload(const NetworkProfile& network);

/// A source of estimated depth that can be loaded, with a name for tables: "altiro3d, 256 px".
struct NamedDepthSource {
    std::string name;
    /// Loads the source. Throws Error if its network cannot be loaded or cannot run with this size.
    std::function<std::unique_ptr<DepthSource>()> load;
    bool isUsual = true; ///< False for a network with another input size than its own.
};

/// The sources worth comparing, best first: each installed network that is not large, with its own
/// input size and with half of it. The first one is the default.
/// @param messages must outlive the sources, which report doubts about a network's file
std::vector<NamedDepthSource> depthSources(Messages& messages);

} // namespace altiro3D::tools
