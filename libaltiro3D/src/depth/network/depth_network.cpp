#include "altiro3D/depth_network.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/enum_table.hpp"
#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "depth/network/network_graph.hpp"
#include "depth/network/network_input.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kMaxModelBytes = 0x7fffffff; // limit of a protobuf message
constexpr const char* kNoMemory =
    "does not fit into memory, expected a smaller network or more memory to be free";

// Names the format of a file that is not ONNX; nullptr if it is not recognized.
const char* familiarKind(std::string_view contents) {
    if (startsWith(contents, "version https://git-lfs"))
        return "a Git LFS pointer, not the file itself";
    if (startsWith(contents, "\x89PNG")) return "a PNG picture";
    if (startsWith(contents, "\xff\xd8\xff")) return "a JPEG picture";
    if (startsWith(contents, "PK\x03\x04")) return "a ZIP archive or a PyTorch file";
    if (startsWith(contents, "\x1f\x8b")) return "a gzip archive";
    if (contents.substr(0, 8).substr(std::min<std::size_t>(4, contents.size())) == "TFL3") {
        return "a TensorFlow Lite file";
    }
    const std::size_t text = contents.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    if (text == std::string_view::npos) return nullptr;
    if (contents[text] == '<') return "a web page or XML";
    if (text < 16 && contents[text] == '{') return "a JSON text";
    return nullptr;
}

std::string listed(const std::vector<std::int64_t>& shape) {
    constexpr std::size_t kMaxShown = 8;
    std::string text = "[";
    for (std::size_t i = 0; i < shape.size(); ++i) {
        if (i == kMaxShown) return text + ", ...]";
        text += i == 0 ? "" : ", ";
        text += shape[i] == 0 ? "?" : std::to_string(shape[i]);
    }
    return text + ']';
}

std::string listed(const cv::MatSize& size) {
    std::vector<std::int64_t> shape;
    for (int i = 0; i < size.dims(); ++i)
        shape.push_back(size[i]);
    return listed(shape);
}

// Whether an input may have this side.
bool fits(int side, const NetworkProfile& profile) {
    return side >= 1 && side <= 4096 && side % profile.multipleOf == 0;
}

void checkWeightsInside(const fs::path& file, const OnnxFacts& facts) {
    if (facts.externalWeights.empty()) return;
    const std::string& location = *facts.externalWeights.begin();
    std::error_code error;
    const bool there = fs::exists(file.parent_path() / location, error);
    std::string problem = "keeps its weights in another file, \"" + shortened(location) + '"';
    if (!there) problem += ", which is missing";
    if (facts.externalWeights.size() > 1) {
        problem += " (and " + std::to_string(facts.externalWeights.size() - 1) + " more)";
    }
    throw Error(there ? ErrorCode::Unsupported : ErrorCode::BadFormat, file.string(),
                problem + ", expected one ONNX file that holds its weights");
}

void checkInput(const fs::path& file, const OnnxFacts& facts, const NetworkProfile& profile) {
    const std::string name = file.string();
    if (facts.inputs.size() != 1) {
        std::string names;
        constexpr std::size_t kMaxShown = 3;
        const std::size_t shown = std::min(facts.inputs.size(), kMaxShown);
        for (std::size_t i = 0; i < shown; ++i)
            names += (i == 0 ? " (" : ", ") + shortened(facts.inputs[i].name);
        if (shown < facts.inputs.size())
            names += " and " + std::to_string(facts.inputs.size() - shown) + " more";
        throw Error(ErrorCode::BadFormat, name,
                    "takes " + std::to_string(facts.inputs.size()) + " inputs" + names +
                        (names.empty() ? "" : ")") + ", expected one, the picture");
    }
    const GraphInput& input = facts.inputs.front();
    if (!input.hasShape) return;
    const auto& shape = input.shape;
    const auto open = [](std::int64_t side, std::int64_t value) {
        return side <= 0 || side == value;
    };
    if (shape.size() != 4 || !open(shape[0], 1) || !open(shape[1], 3)) {
        throw Error(ErrorCode::BadFormat, name,
                    "takes an input of shape " + listed(shape) +
                        ", expected [1, 3, height, width]");
    }
    if (!open(shape[2], profile.inputHeight) || !open(shape[3], profile.inputWidth)) {
        throw Error(ErrorCode::Mismatch, name,
                    "takes pictures of " + pairText(shape[3], shape[2]) + " px, expected " +
                        pairText(profile.inputWidth, profile.inputHeight) + " px" +
                        " as in the profile \"" + profile.name + '"');
    }
}

int interpolation(ResizeKernel kernel) {
    constexpr int kKernels[] = {cv::INTER_NEAREST, cv::INTER_LINEAR, cv::INTER_CUBIC,
                                cv::INTER_AREA};
    return entryOf(kKernels, kernel);
}

} // namespace

struct DepthNetwork::Impl {
    fs::path file;
    NetworkProfile profile;
    InferenceTarget target = InferenceTarget::Cpu;
    InferenceEngine engine = InferenceEngine::Best; // after load(): the engine in use
    std::unique_ptr<NetworkGraph> graph;
    NetworkInput input;
    cv::Size nominal; // size of the input as chosen in the constructor

    bool isOtherSize() const {
        return nominal != cv::Size(profile.inputWidth, profile.inputHeight);
    }
    bool mayVary() const { return isOtherSize() || profile.inputShape == InputShape::Photo; }
    int longerSide() const { return std::max(nominal.width, nominal.height); }
    void load();
    InferenceEngine chooseEngine(const OnnxFacts& facts) const;
    void infer(const cv::Mat& photo, int side, cv::Mat& raw);
};

void DepthNetwork::Impl::load() {
    const std::string name = file.string();
    const std::string contents = readFile(file, kMaxModelBytes);
    if (contents.empty()) {
        throw Error(ErrorCode::BadFormat, name, "is empty, expected an ONNX file");
    }
    if (const char* kind = familiarKind(contents)) {
        throw Error(ErrorCode::BadFormat, name,
                    std::string("is ") + kind + ", expected an ONNX file");
    }
    const OnnxFacts facts = readOnnxFacts(contents);
    if (!facts.hasGraph || facts.broken) {
        // Every ONNX file begins with the number and value of its version field.
        const bool begun = contents.front() == '\x08';
        throw Error(ErrorCode::BadFormat, name,
                    std::string(begun ? "is damaged or cut off" : "is not an ONNX file") +
                        ", expected a whole ONNX file");
    }
    checkWeightsInside(file, facts);
    checkInput(file, facts, profile);

    engine = chooseEngine(facts);
    orOutOfMemory(name, kNoMemory, [&] {
        graph = engine == InferenceEngine::OnnxRuntime
                    ? loadWithOnnxRuntime(name, contents)
                    : loadWithOpenCv(name, contents, target == InferenceTarget::Cuda, mayVary());
    });
}

InferenceEngine DepthNetwork::Impl::chooseEngine(const OnnxFacts& facts) const {
    const InferenceEngine wanted = engine != InferenceEngine::Best ? engine : profile.engine;
    if (wanted == InferenceEngine::OnnxRuntime) {
        if (!hasOnnxRuntime()) {
            throw Error(ErrorCode::Unsupported, file.string(),
                        "needs ONNX Runtime, which this build of altiro3D does not have, expected "
                        "a network that OpenCV can run");
        }
        if (target == InferenceTarget::Cuda) {
            throw Error(ErrorCode::Unsupported, file.string(),
                        "cannot run on CUDA with ONNX Runtime, expected the CPU");
        }
        return wanted;
    }
    if (wanted == InferenceEngine::OpenCv || !hasOnnxRuntime() || target != InferenceTarget::Cpu)
        return InferenceEngine::OpenCv;
    // Only OpenCV runs a file at another size than the one it is fixed to.
    const std::vector<std::int64_t>& shape = facts.inputs.front().shape;
    const bool open = !facts.inputs.front().hasShape || (shape[2] <= 0 && shape[3] <= 0);
    return open || !mayVary() ? InferenceEngine::OnnxRuntime : InferenceEngine::OpenCv;
}

cv::Size networkInputSize(const NetworkProfile& profile, cv::Size nominal, cv::Size photo,
                          int side) {
    if (profile.inputShape != InputShape::Photo) return nominal;
    const bool wide = photo.width >= photo.height;
    const double shape = wide ? static_cast<double>(photo.height) / photo.width
                              : static_cast<double>(photo.width) / photo.height;
    const int steps = static_cast<int>(std::lround(side * shape / profile.multipleOf));
    const int shorter = std::max(steps, 1) * profile.multipleOf;
    return wide ? cv::Size(side, shorter) : cv::Size(shorter, side);
}

// Scales the values, then resamples them as float without keeping the aspect. Result: `resized_`.
//
// The kernels are separable, and OpenCV's weight is exactly 1 along an axis that keeps its size.
// Resampling the rows first and then the columns therefore gives the same numbers as cv::resize,
// and the whole photo is never held as float (12 bytes per px).
void NetworkInput::resample(const NetworkProfile& profile, const cv::Mat& photo, cv::Size size) {
    const int kernel = interpolation(profile.resizeKernel);
    if (photo.cols <= size.width || photo.rows <= size.height) {
        // If either axis grows, OpenCV uses another area kernel, which is not separable.
        cv::Mat scaled;
        photo.convertTo(scaled, CV_32F, profile.scale);
        cv::resize(scaled, resized_, size, 0, 0, kernel);
        return;
    }
    constexpr int kBandRows = 32;
    narrowed_.create(photo.rows, size.width, CV_32FC3);
    const int bands = (photo.rows + kBandRows - 1) / kBandRows;
    cv::parallel_for_(cv::Range(0, bands), [&](const cv::Range& range) {
        cv::Mat scaled;
        for (int band = range.start; band < range.end; ++band) {
            const cv::Range rows(band * kBandRows, std::min((band + 1) * kBandRows, photo.rows));
            photo.rowRange(rows).convertTo(scaled, CV_32F, profile.scale);
            cv::Mat part = narrowed_.rowRange(rows);
            cv::resize(scaled, part, part.size(), 0, 0, kernel);
        }
    });
    cv::resize(narrowed_, resized_, size, 0, 0, kernel);
}

// Scales, resamples, then applies mean and std, in the same order as the networks' own tools. Cubic
// resampling of floats may exceed 0..1, as it does there.
const cv::Mat& NetworkInput::make(const NetworkProfile& profile, const cv::Mat& photo,
                                  cv::Size size) {
    resample(profile, photo, size);
    const int shape[] = {1, 3, size.height, size.width};
    blob_.create(4, shape, CV_32F);
    std::array<cv::Mat, 3> planes;
    const bool swap = profile.channelOrder == ChannelOrder::Rgb;
    for (int i = 0; i < 3; ++i) {
        cv::Mat& plane = planes[static_cast<std::size_t>(swap ? 2 - i : i)];
        plane = cv::Mat(size, CV_32FC1, blob_.ptr<float>(0, i));
    }
    cv::split(resized_, planes.data());
    for (int i = 0; i < 3; ++i) {
        const double mean = profile.mean[static_cast<std::size_t>(i)];
        const double std = profile.std[static_cast<std::size_t>(i)];
        if (mean == 0 && std == 1) continue;
        cv::Mat plane(size, CV_32FC1, blob_.ptr<float>(0, i));
        plane.convertTo(plane, CV_32F, 1 / std, -mean / std);
    }
    return blob_;
}

void DepthNetwork::Impl::infer(const cv::Mat& photo, int side, cv::Mat& raw) {
    const std::string name = file.string();
    const cv::Size size = networkInputSize(profile, nominal, photo.size(), side);
    const cv::Mat output = graph->run(input.make(profile, photo, size));
    const bool image = output.dims == 3 || (output.dims == 4 && output.size[1] == 1);
    if (!image || output.size[0] != 1 || output.type() != CV_32FC1 || output.empty()) {
        throw Error(ErrorCode::NetworkFailed, name,
                    "puts out " + listed(output.size) + " of " + cv::typeToString(output.type()) +
                        ", expected [1, height, width] or [1, 1, height, width] of CV_32FC1");
    }
    const cv::Mat values(output.size[output.dims - 2], output.size[output.dims - 1], CV_32FC1,
                         output.data);
    if (!cv::checkRange(values)) {
        throw Error(ErrorCode::NetworkFailed, name,
                    "puts out NaN or infinity for this picture, expected finite numbers");
    }
    values.copyTo(raw);
}

DepthNetwork::DepthNetwork(const fs::path& file, NetworkProfile profile, InferenceTarget target,
                           cv::Size inputSize, InferenceEngine engine) try
    : impl_(std::make_unique<Impl>()) {
    validate(profile);
    if (inputSize == cv::Size()) inputSize = {profile.inputWidth, profile.inputHeight};
    check(fits(inputSize.width, profile) && fits(inputSize.height, profile), "inputSize",
          "is " + sizeText(inputSize) + ", expected sides of 1..4096 px, " + "multiples of " +
              std::to_string(profile.multipleOf));
    impl_->nominal = inputSize;
    impl_->file = file;
    impl_->profile = std::move(profile);
    impl_->target = target;
    impl_->engine = engine;
    if (target == InferenceTarget::Cuda && bestInferenceTarget() != InferenceTarget::Cuda) {
        throw Error(ErrorCode::Unsupported, file.string(),
                    "cannot run on CUDA, which this OpenCV does not offer, expected the CPU");
    }
    impl_->load();
    if (impl_->isOtherSize()) { // only a trial shows whether the graph runs at this size
        cv::Mat raw;
        infer(cv::Mat(inputSize, CV_8UC3, cv::Scalar::all(128)), raw);
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

DepthNetwork::~DepthNetwork() = default;
DepthNetwork::DepthNetwork(DepthNetwork&&) noexcept = default;
DepthNetwork& DepthNetwork::operator=(DepthNetwork&&) noexcept = default;

const NetworkProfile& DepthNetwork::profile() const {
    return impl_->profile;
}

cv::Size DepthNetwork::inputSize() const {
    return impl_->nominal;
}

const fs::path& DepthNetwork::file() const {
    return impl_->file;
}

InferenceTarget DepthNetwork::target() const {
    return impl_->target;
}

InferenceEngine DepthNetwork::engine() const {
    return impl_->engine;
}

void DepthNetwork::infer(const cv::Mat& photo, cv::Mat& raw) try {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    orOutOfMemory(impl_->file.string(), kNoMemory,
                  [&] { impl_->infer(photo, impl_->longerSide(), raw); });
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void DepthNetwork::estimate(const cv::Mat& photo, cv::Mat& depth, int longerSide) try {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    const int side = longerSide == 0 ? impl_->longerSide() : longerSide;
    check(fits(side, impl_->profile), "longerSide",
          "is " + std::to_string(side) + " px, expected 1..4096 px, a multiple of " +
              std::to_string(impl_->profile.multipleOf));
    cv::Mat raw;
    orOutOfMemory(impl_->file.string(), kNoMemory, [&] { impl_->infer(photo, side, raw); });
    DepthNormalization options;
    const bool isMetric = impl_->profile.output == NetworkOutput::MetricDepth;
    options.kind = isMetric ? DepthKind::Metric : DepthKind::NearWhite;
    normalizeDepth(raw, depth, options);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
