#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

/// An input of the graph. A side that the graph leaves open is 0.
struct GraphInput {
    std::string name;
    std::vector<std::int64_t> shape;
    bool hasShape = false;
};

/// The facts about an ONNX file that DepthNetwork checks before OpenCV sees it.
struct OnnxFacts {
    bool hasGraph = false;
    bool broken = false;                   // a message ends before its contents do
    std::vector<GraphInput> inputs;        // without those that are weights
    std::set<std::string> externalWeights; // other files that hold weights
};

/// Reads the facts; total: any bytes are fine, what is no ONNX file has no graph.
///
/// OpenCV reads outside of memory when weights are in another file, computes nonsense when the
/// input has another size than the graph was made for, and its texts are for its own developers. So
/// the few facts needed to say it better are read first, with a walk over the protobuf fields that
/// are involved (numbers as in the public onnx.proto).
OnnxFacts readOnnxFacts(std::string_view model);

} // namespace altiro3D
