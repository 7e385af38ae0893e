// Networks on OpenCV's DNN module.

#include "altiro3D/error.hpp"
#include "base/text.hpp"
#include "depth/network/network_graph.hpp"

#include <new>
#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/dnn/all_layers.hpp>
#include <vector>

namespace altiro3D {

namespace {

std::string wordsOf(const cv::Exception& exception) {
    return oneLine(exception.err.empty() ? exception.msg : exception.err);
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
    OpenCvGraph(std::string file, const std::string& contents, bool cuda, bool anySize);
    cv::Mat run(const cv::Mat& blob) override;

  private:
    std::string file_;
    cv::dnn::Net net_;
    std::string outputLayer_;
};

OpenCvGraph::OpenCvGraph(std::string file, const std::string& contents, bool cuda, bool anySize)
    : file_(std::move(file)) {
    const auto fail = [&](const std::string& words) {
        throw Error(ErrorCode::BadFormat, file_,
                    "OpenCV " CV_VERSION " cannot load this graph (" + words +
                        "), expected a loadable graph; export it for ONNX opset 11");
    };
    try {
        net_ = cv::dnn::readNetFromONNX(contents.data(), contents.size());
        if (cuda) {
            net_.setPreferableBackend(cv::dnn::DNN_BACKEND_CUDA);
            net_.setPreferableTarget(cv::dnn::DNN_TARGET_CUDA);
        } else {
            net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
            net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
        }
        // Of several outputs the last one, because decoders put their finest output last.
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
    if (outputLayer_.empty())
        throw Error(ErrorCode::BadFormat, file_, "has no output, expected a depth map");
}

cv::Mat OpenCvGraph::run(const cv::Mat& blob) {
    try {
        net_.setInput(blob);
        return net_.forward(outputLayer_);
    } catch (const cv::Exception& exception) {
        if (exception.code == cv::Error::StsNoMem) throw;
        throw Error(ErrorCode::NetworkFailed, file_,
                    "OpenCV " CV_VERSION " cannot run this graph (" + wordsOf(exception) +
                        "), expected one that it can run; try the input size of its profile, or "
                        "another network");
    }
}

} // namespace

std::unique_ptr<NetworkGraph> loadWithOpenCv(const std::string& file, const std::string& contents,
                                             bool cuda, bool anySize) {
    return std::make_unique<OpenCvGraph>(file, contents, cuda, anySize);
}

} // namespace altiro3D
