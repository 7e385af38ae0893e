#pragma once

#include "altiro3D/depth_network.hpp"
#include "common/run_tool.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// Makes sure that loading and running a network does not end this process: one whose SHA-256 is in
/// the catalogue is trusted, any other is tried in a child process first (probeNetwork()). Warns of
/// a file that has the name of one in the catalogue and other contents.
///
/// What was found out about a file is kept in the user's cache for as long as the file stays as it
/// is, so it costs time once.
///
/// @param file the ONNX file @param profile how it is fed
/// @param catalog the known networks @param inputSize, engine as for DepthNetwork
/// @throws Error NetworkFailed
void requireHarmless(const std::filesystem::path& file, const NetworkProfile& profile,
                     const std::vector<NetworkProfile>& catalog, cv::Size inputSize,
                     InferenceEngine engine, Messages& messages);

/// The command that downloads a network of the catalogue, as it is called on this machine.
std::string downloadCommand(const std::string& name);

} // namespace altiro3D::tools
