#include "altiro3D/depth_source.hpp"

#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"
#include "depth/network/network_estimate.hpp"
#include "depth/source/kind_notes.hpp"

#include <functional>
#include <future>
#include <opencv2/core/utility.hpp>
#include <optional>

namespace altiro3D {

namespace {

cv::Mat readWithNotes(const PhotoFile& file, Notes* notes) {
    return withNamedNotes(file.path(), notes, [&](Notes* own) { return readPhoto(file, own); });
}

// Stands for a network that is not installed. Photos with depth do not need it.
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
    DepthEdges edges() const override { return DepthEdges::Aligned; }
    DepthKind kind() const override { return DepthKind::NearWhite; }
    const DepthNetwork* network() const override { return network_ ? &*network_ : nullptr; }
    void load() override {
        if (!network_) network_ = load_();
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override try {
        load();
        raw = estimatePhoto(*network_, image);
        photo = image;
    } catch (const cv::Exception& exception) {
        leaveAsOurs(exception);
    }
    void readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override try {
        load();
        raw = estimateFrame(*network_, image);
        photo = image;
    } catch (const cv::Exception& exception) {
        leaveAsOurs(exception);
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
    DepthKind kind() const override { return kind_; }
    PhotoDepth readPhoto(const PhotoFile& file, Notes* notes) override {
        Notes depthNotes;
        // each decoder uses one thread
        std::launch when = std::launch::deferred;
        if (cv::getNumThreads() > 1) when |= std::launch::async;
        std::future<cv::Mat> samples = std::async(when, [&] {
            return withNamedNotes(file_, &depthNotes, [&](Notes* own) {
                const PhotoFile depth(file_);
                cv::Mat raw = readDepthSamples(depth, own);
                addKindNotes(depth, raw, kind_, own);
                return raw;
            });
        });
        PhotoDepth found;
        // if both are damaged, the error names the photo
        found.photo = readWithNotes(file, notes);
        found.rawDepth = samples.get();
        found.kind = kind_;
        found.origin = DepthOrigin::Given;
        found.text = description();
        addNotes(notes, depthNotes);
        return found;
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        checkType(image, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
        raw = readDepthSamples(file_);
        photo = image;
    }

  private:
    std::filesystem::path file_;
    DepthKind kind_;
};

class RgbdSource : public DepthSource {
  public:
    RgbdSource(const RgbdLayout& layout, DepthKind kind) : layout_(layout), kind_(kind) {}
    std::string description() const override { return "depth half of the image"; }
    DepthKind kind() const override { return kind_; }
    PhotoDepth readPhoto(const PhotoFile& file, Notes* notes) override try {
        RgbdLayout layout = layout_;
        layout.halves = halvesOf(file.path(), layout_.halves);
        PhotoDepth found;
        found.kind = kind_;
        found.origin = DepthOrigin::Given;
        found.text = description();
        return withNamedNotes(file.path(), notes, [&](Notes* own) {
            const cv::Mat image = readRgbdImage(file, layout.side, own);
            found.whole = image.size();
            try {
                splitRgbd(image, layout, found.photo, found.rawDepth, own);
            } catch (const Error& error) {
                throw Error(error.code(), file.path().string(), error.what());
            }
            if (image.depth() == CV_16U && kind_ == DepthKind::Metric) // 65535 may be unknown
                found.rawDepth.convertTo(found.rawDepth, CV_16U);
            addKindNotes(file, found.rawDepth, kind_, own);
            return found;
        });
    } catch (const cv::Exception& exception) {
        leaveAsOurs(exception);
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        splitRgbd(image, layout_, photo, raw);
    }

  private:
    RgbdLayout layout_;
    DepthKind kind_;
};

} // namespace

DepthSource::~DepthSource() = default;

DepthEdges DepthSource::edges() const {
    return DepthEdges::Unknown;
}

const DepthNetwork* DepthSource::network() const {
    return nullptr;
}

void DepthSource::load() {}

PhotoDepth DepthSource::readPhoto(const PhotoFile& file, Notes* notes) try {
    PhotoDepth found;
    found.photo = readWithNotes(file, notes);
    found.text = description();
    if (notes == nullptr) return found;
    const std::string mixed = mixedEyes(found.photo);
    if (!mixed.empty()) notes->push_back({NoteCode::Doubtful, file.path().string() + ": " + mixed});
    return found;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void DepthSource::readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) {
    read(image, photo, raw);
}

void DepthSource::readScene(const PhotoDepth& found, double flatDepth, Scene& scene) {
    if (found.rawDepth.empty()) return readScene(found.photo, flatDepth, scene);
    makeScene(found, flatDepth, scene);
}

void DepthSource::readScene(const cv::Mat& image, double flatDepth, Scene& scene) try {
    DepthNormalization normalization;
    normalization.kind = kind();
    normalization.flatDepth = flatDepth;
    cv::Mat raw;
    // storedDepthOr() passes read(), kind() and edges() on to its fallback
    read(image, scene.photo, raw);
    scene.hidden = {};
    scene.edges = edges();
    // networks: once more, as estimatePhoto() joins several runs
    normalizeDepth(raw, scene.depth, normalization);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
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
    return depthFromNetworkFile(network->file, network->profile,
                                bestInferenceTarget(network->profile.engine));
}

std::unique_ptr<DepthSource> depthFromFile(std::filesystem::path file, DepthKind kind) {
    return std::make_unique<FileSource>(std::move(file), kind);
}

std::unique_ptr<DepthSource> depthFromRgbd(const RgbdLayout& layout, DepthKind kind) {
    return std::make_unique<RgbdSource>(layout, kind);
}

} // namespace altiro3D
