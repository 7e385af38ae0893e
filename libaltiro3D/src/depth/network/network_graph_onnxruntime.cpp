// Networks on ONNX Runtime, if the library is built with it.

#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "base/text.hpp"
#include "depth/network/network_graph.hpp"

#ifdef ALTIRO3D_HAVE_ONNXRUNTIME
#include <algorithm>
#include <limits>
#include <new>
#include <onnxruntime_cxx_api.h>
#include <opencv2/core/utility.hpp>
#include <utility>
#include <vector>
#endif

namespace altiro3D {

#ifdef ALTIRO3D_HAVE_ONNXRUNTIME

namespace {

// ONNX Runtime logs to stderr by default; its errors reach us as exceptions.
void ignore(void* /*data*/, OrtLoggingLevel /*level*/, const char* /*category*/,
            const char* /*logger*/, const char* /*place*/, const char* /*text*/) {}

// One per process, and never destroyed: sessions of static objects may outlive it.
Ort::Env& environment() {
    static Ort::Env* const env = new Ort::Env(ORT_LOGGING_LEVEL_FATAL, "altiro3D", ignore, nullptr);
    return *env;
}

std::string engineName() {
    return "ONNX Runtime " + Ort::GetVersionString();
}

// ONNX Runtime reports a lack of memory as an error like any other.
void passOnLackOfMemory(const Ort::Exception& exception) {
    const std::string words = exception.what();
    for (const char* sign : {"bad_alloc", "bad allocation", "Failed to allocate memory"})
        if (words.find(sign) != std::string::npos) throw std::bad_alloc();
}

class OnnxRuntimeGraph : public NetworkGraph {
  public:
    OnnxRuntimeGraph(std::string file, const std::string& contents);
    cv::Mat run(const cv::Mat& blob) override;

  private:
    std::string file_;
    Ort::Session session_{nullptr};
    std::string input_;
    std::string output_;
    Ort::Value result_{nullptr};
};

OnnxRuntimeGraph::OnnxRuntimeGraph(std::string file, const std::string& contents)
    : file_(std::move(file)) {
    try {
        Ort::SessionOptions options;
        options.SetIntraOpNumThreads(cv::getNumThreads());
        options.SetInterOpNumThreads(1);
        options.SetGraphOptimizationLevel(ORT_ENABLE_ALL);
        options.DisableMemPattern(); // photos differ in shape
        // Threads that spin while they wait take time from those that decode, render and encode.
        options.AddConfigEntry("session.intra_op.allow_spinning", "0");
        session_ = Ort::Session(environment(), contents.data(), contents.size(), options);
        Ort::AllocatorWithDefaultOptions memory;
        if (session_.GetInputCount() == 1) input_ = session_.GetInputNameAllocated(0, memory).get();
        const std::size_t outputs = session_.GetOutputCount();
        // Of several outputs the last one, because decoders put their finest output last.
        if (outputs > 0) output_ = session_.GetOutputNameAllocated(outputs - 1, memory).get();
    } catch (const Ort::Exception& exception) {
        passOnLackOfMemory(exception);
        throw Error(ErrorCode::BadFormat, file_,
                    engineName() + " cannot load this graph (" + oneLine(exception.what()) +
                        "), expected a loadable graph");
    }
    if (output_.empty())
        throw Error(ErrorCode::BadFormat, file_, "has no output, expected a depth map");
}

cv::Mat OnnxRuntimeGraph::run(const cv::Mat& blob) {
    try {
        const Ort::MemoryInfo place =
            Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
        std::vector<std::int64_t> shape(blob.size.p, blob.size.p + blob.dims);
        // ONNX Runtime does not write to its inputs.
        const Ort::Value input = Ort::Value::CreateTensor<float>(
            place, reinterpret_cast<float*>(blob.data), blob.total(), shape.data(), shape.size());
        const char* const inputs[] = {input_.c_str()};
        const char* const outputs[] = {output_.c_str()};
        std::vector<Ort::Value> results =
            session_.Run(Ort::RunOptions(nullptr), inputs, &input, 1, outputs, 1);
        result_ = std::move(results.front());
        const auto facts = result_.GetTensorTypeAndShapeInfo();
        const std::vector<std::int64_t> shapeOut = facts.GetShape();
        const auto isSide = [](std::int64_t side) {
            return side >= 1 && side <= std::numeric_limits<int>::max();
        };
        if (facts.GetElementType() != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT || shapeOut.empty() ||
            shapeOut.size() > CV_MAX_DIM ||
            !std::all_of(shapeOut.begin(), shapeOut.end(), isSide)) {
            throw Error(ErrorCode::NetworkFailed, file_,
                        "has an output that is not 32-bit floats, expected [1, height, width] or "
                        "[1, 1, height, width] of 32-bit floats");
        }
        const std::vector<int> sides(shapeOut.begin(), shapeOut.end());
        return cv::Mat(sides, CV_32F, result_.GetTensorMutableData<float>());
    } catch (const Ort::Exception& exception) {
        passOnLackOfMemory(exception);
        throw Error(ErrorCode::NetworkFailed, file_,
                    engineName() + " cannot run this graph (" + oneLine(exception.what()) +
                        "), expected one that it can run; try the input size of its profile, or "
                        "another network");
    }
}

} // namespace

bool hasOnnxRuntime() {
    return true;
}

std::unique_ptr<NetworkGraph> loadWithOnnxRuntime(const std::string& file,
                                                  const std::string& contents) {
    return std::make_unique<OnnxRuntimeGraph>(file, contents);
}

#else

bool hasOnnxRuntime() {
    return false;
}

std::unique_ptr<NetworkGraph> loadWithOnnxRuntime(const std::string& file,
                                                  const std::string& /*contents*/) {
    throw Error(ErrorCode::Unsupported, file, "needs ONNX Runtime, which is not built in");
}

#endif

} // namespace altiro3D
