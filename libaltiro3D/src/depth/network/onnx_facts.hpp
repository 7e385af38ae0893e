#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

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
