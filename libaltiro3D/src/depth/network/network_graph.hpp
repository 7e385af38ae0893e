#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

/// The graph of an ONNX file in the program that runs it. One thread at a time per object.
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

} // namespace altiro3D
