#include "altiro3D/depth_source.hpp"

#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"
#include "depth/network/network_estimate.hpp"

#include <functional>
#include <future>
#include <opencv2/core/utility.hpp>
#include <optional>

namespace altiro3D {

namespace {

// Calls a reader and puts the file's name before its notes.
template <class Read>
cv::Mat withNotes(Read read, const std::filesystem::path& file, Notes* notes) {
    Notes own;
    cv::Mat picture = read(file, &own);
    if (notes != nullptr) {
        for (const Note& note : own)
            notes->push_back({note.code, file.string() + ": " + note.text});
    }
    return picture;
}

// Photos that bring their depth do not need it.
class MissingNetwork : public DepthSource {
  public:
    std::string description() const override { return "no network"; }
    DepthKind kind() const override { return DepthKind::NearWhite; }
    void load() override {
        throw Error(ErrorCode::NotFound, "depth",
                    "no network is installed that could estimate it, expected altiro3d-depth.onnx "
                    "in a folder of networks (models/README.md), a network (-n FILE.onnx) or the "
                    "depth itself (-d)");
    }
    void read(const cv::Mat& /*image*/, cv::Mat& /*photo*/, cv::Mat& /*raw*/) override { load(); }
};

class NetworkSource : public DepthSource {
  public:
    explicit NetworkSource(DepthNetwork network)
        : profile_(network.profile()), file_(network.file()), network_(std::move(network)) {}
    // @param load called for the first photo
    NetworkSource(NetworkProfile profile, std::filesystem::path file,
                  std::function<DepthNetwork()> load)
        : profile_(std::move(profile)), file_(std::move(file)), load_(std::move(load)) {}

    std::string description() const override {
        return "network " + profile_.name + " (" + file_.string() + ")";
    }
    DepthEdges edges() const override { return DepthEdges::Decided; }
    DepthKind kind() const override { return DepthKind::NearWhite; }
    const DepthNetwork* network() const override { return network_ ? &*network_ : nullptr; }
    void load() override {
        if (!network_) network_ = load_();
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        load();
        raw = estimatePhoto(*network_, image);
        photo = image;
    }
    void readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        load();
        raw = estimateFrame(*network_, image);
        photo = image;
    }

  private:
    NetworkProfile profile_;
    std::filesystem::path file_;
    std::function<DepthNetwork()> load_;
    std::optional<DepthNetwork> network_;
};

class FileSource : public DepthSource {
  public:
    FileSource(std::filesystem::path file, DepthKind kind) : file_(std::move(file)), kind_(kind) {}
    std::string description() const override { return "depth image " + file_.string(); }
    DepthOrigin origin() const override { return DepthOrigin::Given; }
    DepthKind kind() const override { return kind_; }
    cv::Mat readImage(const std::filesystem::path& file, Notes* notes) override {
        samples_.release();
        Notes depthNotes;
        // each decoder uses one thread
        std::launch when = std::launch::deferred;
        if (cv::getNumThreads() > 1) when |= std::launch::async;
        std::future<cv::Mat> samples =
            std::async(when, [&] { return withNotes(readDepthSamples, file_, &depthNotes); });
        cv::Mat photo =
            withNotes(readPhoto, file, notes); // if both are damaged, the error names the photo
        samples_ = samples.get();
        if (notes != nullptr) notes->insert(notes->end(), depthNotes.begin(), depthNotes.end());
        return photo;
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        checkType(image, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
        raw = samples_.empty() ? readDepthSamples(file_) : samples_;
        samples_.release();
        photo = image;
    }

  private:
    std::filesystem::path file_;
    DepthKind kind_;
    cv::Mat samples_; // from readImage()
};

class RgbdSource : public DepthSource {
  public:
    RgbdSource(const RgbdLayout& layout, DepthKind kind)
        : layout_(layout), halves_(layout.halves), kind_(kind) {}
    std::string description() const override { return "depth half of the image"; }
    DepthOrigin origin() const override { return DepthOrigin::Given; }
    DepthKind kind() const override { return kind_; }
    cv::Mat readImage(const std::filesystem::path& file, Notes* notes) override {
        layout_.halves = halvesOf(file, halves_);
        const auto readAndSplit = [this](const std::filesystem::path& path, Notes* own) {
            cv::Mat image = readRgbdImage(path, layout_.side, own);
            cv::Mat photo;
            cv::Mat raw;
            try {
                splitRgbd(image, layout_, photo, raw, own);
            } catch (const Error& error) {
                throw Error(error.code(), path.string(), error.what());
            }
            return image;
        };
        return withNotes(readAndSplit, file, notes);
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        splitRgbd(image, layout_, photo, raw);
    }

  private:
    RgbdLayout layout_;   // of the last image
    StereoHalves halves_; // as given
    DepthKind kind_;
};

} // namespace

DepthSource::~DepthSource() = default;

DepthOrigin DepthSource::origin() const {
    return DepthOrigin::Estimated;
}

std::filesystem::path DepthSource::separateFile() const {
    return {};
}

DepthEdges DepthSource::edges() const {
    return origin() == DepthOrigin::Matched ? DepthEdges::Matched : DepthEdges::Unknown;
}

const DepthNetwork* DepthSource::network() const {
    return nullptr;
}

void DepthSource::load() {}

cv::Mat DepthSource::readImage(const std::filesystem::path& file, Notes* notes) {
    return withNotes(readPhoto, file, notes);
}

void DepthSource::readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) {
    read(image, photo, raw);
}

void DepthSource::readScene(const cv::Mat& image, double flatDepth, Scene& scene) {
    DepthNormalization normalization;
    normalization.kind = kind();
    normalization.flatDepth = flatDepth;
    cv::Mat raw;
    read(image, scene.photo, raw);
    scene.hidden = {};
    scene.edges = edges();
    normalizeDepth(raw, scene.depth, normalization);
}

std::unique_ptr<DepthSource> depthFromNetwork(DepthNetwork network) {
    return std::make_unique<NetworkSource>(std::move(network));
}

std::unique_ptr<DepthSource> depthFromNetworkFile(std::filesystem::path file,
                                                  NetworkProfile profile, InferenceTarget target,
                                                  cv::Size inputSize, InferenceEngine engine) {
    const auto load = [file, profile, target, inputSize, engine] {
        return DepthNetwork(file, profile, target, inputSize, engine);
    };
    return std::make_unique<NetworkSource>(std::move(profile), std::move(file), load);
}

std::unique_ptr<DepthSource> estimatedDepth() {
    const std::optional<InstalledNetwork> network = standardNetwork();
    if (!network) return std::make_unique<MissingNetwork>();
    return depthFromNetworkFile(network->file, network->profile);
}

std::unique_ptr<DepthSource> depthFromFile(std::filesystem::path file, DepthKind kind) {
    return std::make_unique<FileSource>(std::move(file), kind);
}

std::unique_ptr<DepthSource> depthFromRgbd(const RgbdLayout& layout, DepthKind kind) {
    return std::make_unique<RgbdSource>(layout, kind);
}

} // namespace altiro3D
