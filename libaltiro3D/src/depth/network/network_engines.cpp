#include "depth/network/network_graph.hpp"

#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/dnn/all_layers.hpp>
#include <utility>
#include <vector>

#ifdef ALTIRO3D_HAVE_ONNXRUNTIME
#include <limits>
#include <onnxruntime_cxx_api.h>
#endif

namespace altiro3D {

namespace {

std::string wordsOf(const cv::Exception& exception) {
    return oneLine(exception.err.empty() ? exception.msg : exception.err);
}

[[noreturn]] void failRun(const std::string& file, const std::string& engine,
                          const std::string& words) {
    throw Error(ErrorCode::NetworkFailed, file,
                engine + " cannot run this graph (" + words +
                    "), expected one that it can run; try the input size of its profile, or "
                    "another network");
}

void requireOutput(const std::string& file, const std::string& name) {
    if (name.empty())
        throw Error(ErrorCode::BadFormat, file, "has no output, expected a depth map");
}

// Disables the layers at the end of the graph that only change the shape of the output. Files made
// for one size have a fixed shape there. The layers cannot be removed, because OpenCV computes the
// shapes of all layers. OpenCV's importer turns Squeeze and similar layers into Reshape layers.
void freeShapeAtEnd(cv::dnn::Net& net, const std::string& outputLayer) {
    int id = net.getLayerId(outputLayer);
    constexpr int kMaxSteps = 16;
    for (int step = 0; step < kMaxSteps && id > 0; ++step) {
        const auto layer = net.getLayer(id);
        const auto reshape = layer.dynamicCast<cv::dnn::ReshapeLayer>();
        if (reshape.empty() && layer->type != "Identity") return; // OpenCV appends an Identity
        if (!reshape.empty()) {
            reshape->newShapeDesc = {0, 0, 0, 0}; // 0: keeps this side
            reshape->newShapeRange = cv::Range::all();
        }
        const auto inputs = net.getLayerInputs(id);
        if (inputs.size() != 1) return;
        id = net.getLayerId(inputs[0]->name);
    }
}

class OpenCvGraph : public NetworkGraph {
  public:
    OpenCvGraph(std::string file, const std::string& contents, bool cuda, bool anySize)
        : file_(std::move(file)) {
        const auto fail = [&](const std::string& words) {
            throw Error(ErrorCode::BadFormat, file_,
                        "OpenCV " CV_VERSION " cannot load this graph (" + words +
                            "), expected a loadable graph; export it for ONNX opset 11");
        };
        try {
            net_ = cv::dnn::readNetFromONNX(contents.data(), contents.size());
            net_.setPreferableBackend(cuda ? cv::dnn::DNN_BACKEND_CUDA
                                           : cv::dnn::DNN_BACKEND_OPENCV);
            net_.setPreferableTarget(cuda ? cv::dnn::DNN_TARGET_CUDA : cv::dnn::DNN_TARGET_CPU);
            // If there are several outputs, the last one: decoders put their finest output last.
            const std::vector<cv::String> outputs = net_.getUnconnectedOutLayersNames();
            if (!outputs.empty()) outputLayer_ = outputs.back();
            if (anySize) freeShapeAtEnd(net_, outputLayer_);
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const cv::Exception& exception) {
            if (exception.code == cv::Error::StsNoMem) throw;
            fail(wordsOf(exception));
        } catch (const std::exception& exception) {
            fail(oneLine(exception.what()));
        }
        requireOutput(file_, outputLayer_);
    }

    cv::Mat run(const cv::Mat& blob) override {
        try {
            net_.setInput(blob);
            return net_.forward(outputLayer_);
        } catch (const cv::Exception& exception) {
            if (exception.code == cv::Error::StsNoMem) throw;
            failRun(file_, "OpenCV " CV_VERSION, wordsOf(exception));
        }
    }

  private:
    std::string file_;
    cv::dnn::Net net_;
    std::string outputLayer_;
};

} // namespace

std::unique_ptr<NetworkGraph> loadWithOpenCv(const std::string& file, const std::string& contents,
                                             bool cuda, bool anySize) {
    return std::make_unique<OpenCvGraph>(file, contents, cuda, anySize);
}

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
    OnnxRuntimeGraph(std::string file, const std::string& contents) : file_(std::move(file)) {
        try {
            Ort::SessionOptions options;
            options.SetIntraOpNumThreads(cv::getNumThreads());
            options.SetInterOpNumThreads(1);
            options.SetGraphOptimizationLevel(ORT_ENABLE_ALL);
            options.DisableMemPattern(); // photos differ in shape
            // Threads that spin take time from those that decode, render and encode.
            options.AddConfigEntry("session.intra_op.allow_spinning", "0");
            session_ = Ort::Session(environment(), contents.data(), contents.size(), options);
            Ort::AllocatorWithDefaultOptions memory;
            if (session_.GetInputCount() == 1)
                input_ = session_.GetInputNameAllocated(0, memory).get();
            const std::size_t outputs = session_.GetOutputCount();
            // the last output, as with OpenCV
            if (outputs > 0) output_ = session_.GetOutputNameAllocated(outputs - 1, memory).get();
        } catch (const Ort::Exception& exception) {
            passOnLackOfMemory(exception);
            throw Error(ErrorCode::BadFormat, file_,
                        engineName() + " cannot load this graph (" + oneLine(exception.what()) +
                            "), expected a loadable graph");
        }
        requireOutput(file_, output_);
    }

    cv::Mat run(const cv::Mat& blob) override {
        try {
            const Ort::MemoryInfo place =
                Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
            std::vector<std::int64_t> shape(blob.size.p, blob.size.p + blob.dims);
            // ONNX Runtime does not write to its inputs.
            const Ort::Value input =
                Ort::Value::CreateTensor<float>(place, reinterpret_cast<float*>(blob.data),
                                                blob.total(), shape.data(), shape.size());
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
                throw Error(
                    ErrorCode::NetworkFailed, file_,
                    "has an output that is not 32-bit floats, expected [1, height, width] or "
                    "[1, 1, height, width] of 32-bit floats");
            }
            const std::vector<int> sides(shapeOut.begin(), shapeOut.end());
            return cv::Mat(sides, CV_32F, result_.GetTensorMutableData<float>());
        } catch (const Ort::Exception& exception) {
            passOnLackOfMemory(exception);
            failRun(file_, engineName(), oneLine(exception.what()));
        }
    }

  private:
    std::string file_;
    Ort::Session session_{nullptr};
    std::string input_;
    std::string output_;
    Ort::Value result_{nullptr};
};

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

InferenceTarget bestInferenceTarget(InferenceEngine engine) {
    if (engine == InferenceEngine::OnnxRuntime) return InferenceTarget::Cpu;
    const std::pair cuda(cv::dnn::DNN_BACKEND_CUDA, cv::dnn::DNN_TARGET_CUDA);
    const auto offered = cv::dnn::getAvailableBackends();
    const bool isOffered = std::find(offered.begin(), offered.end(), cuda) != offered.end();
    return isOffered ? InferenceTarget::Cuda : InferenceTarget::Cpu;
}

} // namespace altiro3D
