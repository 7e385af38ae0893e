#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

/// The graph of an ONNX file in its engine: network_engines.cpp. One thread at a time per object.
class NetworkGraph {
  public:
    NetworkGraph() = default;
    virtual ~NetworkGraph() = default;
    NetworkGraph(const NetworkGraph&) = delete;
    NetworkGraph& operator=(const NetworkGraph&) = delete;

    /// @param blob [1 x 3 x rows x cols, CV_32F]
    /// @return the last output of the graph, of any shape; valid until the next call
    /// @throws Error NetworkFailed; cv::Exception or std::bad_alloc if memory is short
    virtual cv::Mat run(const cv::Mat& blob) = 0;
};

/// @param file for messages
/// @param contents of the file
/// @param cuda runs on CUDA instead of the CPU
/// @param anySize a shape at the end of the graph that is fixed to one size is left open
/// @throws Error BadFormat; cv::Exception or std::bad_alloc if memory is short
std::unique_ptr<NetworkGraph> loadWithOpenCv(const std::string& file, const std::string& contents,
                                             bool cuda, bool anySize);

/// As loadWithOpenCv(), on the CPU. Only if hasOnnxRuntime().
std::unique_ptr<NetworkGraph> loadWithOnnxRuntime(const std::string& file,
                                                  const std::string& contents);

/// An input of the graph. A side that the graph does not fix is 0.
struct GraphInput {
    std::string name;
    std::vector<std::int64_t> shape;
    bool hasShape = false;
};

/// The facts about an ONNX file that DepthNetwork checks before an engine sees it.
struct OnnxFacts {
    bool hasGraph = false;
    bool broken = false;                   // a message is cut off
    std::vector<GraphInput> inputs;        // without weights
    std::set<std::string> externalWeights; // other files that contain weights
};

/// Reads the facts. Any bytes are safe; a file that is not ONNX has no graph.
///
/// OpenCV reads out of bounds if weights are in another file and gives wrong results for an input
/// size that the graph does not support. ONNX Runtime opens any file that the model names. Their
/// messages are written for their own developers. The facts needed for a clear error are therefore
/// read first, from the protobuf fields involved (numbers as in the public onnx.proto), also in
/// the graphs of conditions, loops and functions.
OnnxFacts readOnnxFacts(std::string_view model);

} // namespace altiro3D
