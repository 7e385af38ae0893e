#include "cli/chosen_depth.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/quilt2native.hpp"
#include "cli/inputs.hpp"
#include "cli/network_trust.hpp"
#include "cli/outputs.hpp"
#include "cli/system.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

const NetworkProfile* firstLarge(const std::vector<NetworkProfile>& catalog) {
    for (const NetworkProfile& profile : catalog)
        if (profile.large) return &profile;
    return nullptr;
}

const NetworkProfile* named(const std::vector<NetworkProfile>& catalog, const std::string& name) {
    for (const NetworkProfile& profile : catalog) {
        if (profile.name == name) return &profile;
    }
    return nullptr;
}

// The network's input size with another longer side; its multiples are kept.
cv::Size scaledInput(const NetworkProfile& profile, double longerSide) {
    const double scale = longerSide / std::max(profile.inputWidth, profile.inputHeight);
    const auto side = [&](int own) {
        const auto steps = std::lround(own * scale / profile.multipleOf);
        return static_cast<int>(std::max(steps, 1L)) * profile.multipleOf;
    };
    return {side(profile.inputWidth), side(profile.inputHeight)};
}

const char* nameOf(StereoLayout layout) {
    constexpr const char* kNames[] = {"left-right", "right-left", "top-bottom", "bottom-top"};
    return entryOf(kNames, layout);
}

// Warns that a picture with two halves is read as one.
void warnOfHalves(const PhotoFile& photo, Messages& messages) {
    const std::string name = photo.path().string();
    if (const auto layout = readStereoLayout(photo)) {
        messages.warn(name +
                      ": holds the pictures of both eyes, which are read as one picture; "
                      "--stereo " +
                      nameOf(*layout) + " reads the left one");
    } else if (const auto stated = parseSceneName(photo.path())) {
        const bool isRgbd = stated->contents == SceneName::Contents::Rgbd;
        messages.warn(
            name + ": may hold " + (isRgbd ? "photo and depth" : "both eyes") + ", as its name (" +
            stated->tag + ") says, and is read as one picture; " +
            (isRgbd ? "--rgbd right" : std::string("--stereo ") + nameOf(stated->layout)) +
            " takes it apart");
    }
}

// The network that -n names: a file, or a name of the catalogue.
InstalledNetwork namedNetwork(const DepthOptions& options,
                              const std::vector<NetworkProfile>& catalog) {
    const std::string& wanted = options.network;
    std::optional<NetworkProfile> profile;
    if (!options.profile.empty()) profile = readNetworkProfile(options.profile);
    const NetworkProfile* known = named(catalog, wanted);
    const bool isFile = isThere(wanted) && !isDirectory(wanted);
    const fs::path file =
        isFile ? fs::path(wanted)
               : findModelFile(known != nullptr ? known->file : wanted, modelSearchPath());
    if (file.empty() && known != nullptr) {
        throw Error(ErrorCode::NotFound, wanted,
                    "its file " + known->file + " is missing, expected it to be downloaded (" +
                        howToDownload(*known) + ")");
    }
    if (file.empty()) {
        throw Error(ErrorCode::NotFound, wanted,
                    "does not exist, expected an ONNX file" +
                        (catalog.empty()
                             ? ""
                             : " or a network of the catalogue: " + joined(namesOf(catalog))));
    }
    if (profile) return {*profile, file};
    known = findProfile(catalog, file);
    if (known != nullptr && options.isLarge && !known->large) {
        throw UsageError("-l says that " + wanted +
                         " is a large network, but the catalogue knows it as " + known->name +
                         "; expected no -l");
    }
    if (known == nullptr && options.isLarge) known = firstLarge(catalog);
    if (known == nullptr) {
        throw Error(ErrorCode::NotFound, wanted,
                    "is not in the catalogue of networks, expected --net-profile FILE.json "
                    "that describes it");
    }
    return {*known, file};
}

// The usual network; nothing if none is installed.
std::optional<InstalledNetwork> usualNetwork(bool large,
                                             const std::vector<NetworkProfile>& catalog) {
    std::optional<InstalledNetwork> standard = standardNetwork(large);
    if (standard || !large) return standard;
    const NetworkProfile* const known = firstLarge(catalog);
    const std::string file = known != nullptr ? " (" + known->file + ")" : "";
    const std::string how = known != nullptr ? " (" + howToDownload(*known) + ")" : "";
    throw Error(ErrorCode::NotFound, "-l",
                "the large network" + file +
                    " was not found, expected it in the model search path" + how +
                    " or given with -n");
}

} // namespace

std::string engineName(InferenceEngine engine) {
    return engine == InferenceEngine::OnnxRuntime ? "ONNX Runtime" : "OpenCV";
}

std::vector<std::string> namesOf(const std::vector<NetworkProfile>& catalog) {
    std::vector<std::string> names;
    for (const NetworkProfile& profile : catalog)
        names.push_back(profile.name);
    return names;
}

ChosenDepth::ChosenDepth(const DepthOptions& options, Messages& messages)
    : options_(options), description_(options.given) {
    if (options_.fromFiles) return;
    if (options_.rgbd) {
        source_ = depthFromRgbd(*options_.rgbd, options_.kind);
        return;
    }
    std::shared_ptr<DepthSource> network = chooseNetwork(messages);
    if (options_.medium == Medium::Photo) {
        useEstimator(std::move(network));
    } else {
        source_ = std::move(network);
        description_ = source_->description();
    }
    tellEngine(messages);
}

void ChosenDepth::useEstimator(std::shared_ptr<DepthSource> estimator) {
    description_ = estimator->description();
    if (options_.stereo && !options_.isPair) {
        source_ = depthFromStereo(*options_.stereo, std::move(estimator));
    } else if (options_.stored.useDepth || options_.stored.unblurred) {
        source_ = storedDepthOr(std::move(estimator), options_.stored);
    } else {
        source_ = std::move(estimator);
    }
}

void ChosenDepth::release() {
    source_.reset();
    releaseMemory();
}

void ChosenDepth::tellEngine(const Messages& messages) {
    if (isEngineTold_ || network() == nullptr) return;
    isEngineTold_ = true;
    const bool isCuda = network()->target() == InferenceTarget::Cuda;
    messages.detail(std::string("depth network runs on ") + (isCuda ? "CUDA" : "the CPU") + " by " +
                    engineName(network()->engine()));
}

std::shared_ptr<DepthSource> ChosenDepth::chooseNetwork(Messages& messages) {
    const std::vector<NetworkProfile> catalog = modelCatalog();
    const std::optional<InstalledNetwork> chosen = options_.network.empty()
                                                       ? usualNetwork(options_.isLarge, catalog)
                                                       : namedNetwork(options_, catalog);
    if (chosen) return openNetwork(*chosen, catalog, messages);
    std::shared_ptr<DepthSource> missing = estimatedDepth(); // fails when it is needed
    if (options_.medium == Medium::Video) missing->load();   // now
    return missing;
}

std::shared_ptr<DepthSource> ChosenDepth::openNetwork(const InstalledNetwork& chosen,
                                                      const std::vector<NetworkProfile>& catalog,
                                                      Messages& messages) {
    networkFile_ = chosen.file;
    if (options_.engine == InferenceEngine::OnnxRuntime && !hasOnnxRuntime()) {
        throw Error(ErrorCode::Unsupported, "--engine",
                    "ONNX Runtime is not built in, expected opencv, or a build on a system that "
                    "has libonnxruntime-dev (Debian 13)");
    }
    const NetworkProfile& profile = chosen.profile;
    const std::optional<int>& wantedSize = options_.networkSize;
    const InferenceEngine engine =
        options_.engine == InferenceEngine::Best ? profile.engine : options_.engine;
    const InferenceTarget target = bestInferenceTarget(engine);
    if (wantedSize && *wantedSize % profile.multipleOf != 0) {
        throw UsageError("--network-size is " + std::to_string(*wantedSize) +
                         ", expected a multiple of " + std::to_string(profile.multipleOf) +
                         " for " + profile.name);
    }
    const cv::Size size = wantedSize ? scaledInput(profile, *wantedSize) : cv::Size();
    requireHarmless(chosen.file, profile, catalog, size, options_.engine, messages);
    std::shared_ptr<DepthSource> source =
        depthFromNetworkFile(chosen.file, profile, target, size, options_.engine);
    const bool isAskedFor = !options_.network.empty() || options_.isLarge;
    if (isAskedFor || options_.medium == Medium::Video) { // else a photo may bring depth of its own
        const QuietStandardError quiet; // some builds of ONNX Runtime print when they start
        source->load();
    }
    const cv::Size input = size.empty() ? cv::Size(profile.inputWidth, profile.inputHeight) : size;
    messages.say("depth: " + source->description() + ", " +
                 (profile.inputShape == InputShape::Photo
                      ? std::to_string(std::max(input.width, input.height)) + " px wide or high"
                      : sizeText(input)));
    return source;
}

PhotoScene ChosenDepth::read(const fs::path& photoFile, const fs::path& depthFile, double flatDepth,
                             Messages& messages, StageTimes& times) {
    PhotoFile file = pictureToRead(photoFile);
    static_cast<void>(file.bytes()); // once, also a pipe
    refuseNative(file, "a photo");
    if (!depthFile.empty()) refuseNative(depthFile, "a depth picture");
    if (options_.refusesVr) refuseVrName(photoFile);
    warnIfQuilt(photoFile, "quilt2native", messages);
    std::unique_ptr<DepthSource> ofFiles; // depth or a right eye of a file of its own
    if (options_.isPair) {
        if (depthFile.empty()) throw UsageError("--stereo files takes LEFT RIGHT, got one picture");
        StereoInput pair = *options_.stereo;
        pair.right = depthFile;
        ofFiles = depthFromStereo(pair, source_);
    } else if (!depthFile.empty() && options_.fromFiles) { // else the source finds and checks it
        ofFiles = depthFromFile(depthFile, options_.kind);
    }
    DepthSource& source = ofFiles ? *ofFiles : *source_; // of a plain photo: storedDepthOr(network)
    PhotoScene result;
    PhotoDepth found;
    Notes notes;
    {
        const QuietStandardError quiet;
        found = source.readPhoto(file, &notes);
    }
    if (options_.rgbd) {
        rgbdOf(photoFile, *options_.rgbd,
               static_cast<double>(found.whole.width) / found.whole.height, messages);
    }
    for (const Note& note : notes) {
        if (note.code == NoteCode::Chosen) {
            result.isUnblurred = true;
            messages.say(note.text);
        } else {
            messages.warn(note.text);
        }
    }
    if (options_.stored.unblurred && !result.isUnblurred)
        messages.say(file.path().string() + ": no sharp original in the file is used");
    result.origin = found.origin;
    result.source = options_.fromFiles ? description_ : found.text;
    result.file = ofFiles ? depthFile : found.separateFile;
    const bool isEstimated = result.origin == DepthOrigin::Estimated;
    const bool isGiven = !options_.given.empty(); // by an option
    if (!isEstimated && !isGiven && (depthFile.empty() || options_.isPair))
        messages.say((messages.hasSubject() ? "" : file.path().string() + ": ") + result.source);
    if (isEstimated && !options_.stored.useDepth && !options_.stereo) warnOfHalves(file, messages);
    file = PhotoFile(file.path()); // releases the bytes of a large file
    times.end("read");
    {
        const QuietStandardError quiet; // loading a network may print
        // estimates the depth by the network, unless it was found
        source.readScene(found, flatDepth, result); // the Scene in it
    }
    tellEngine(messages);
    const double photoAspect = static_cast<double>(result.photo.cols) / result.photo.rows;
    const double depthAspect = static_cast<double>(result.depth.cols) / result.depth.rows;
    if (ofFiles && !options_.isPair && !haveSameShape(photoAspect, depthAspect)) {
        messages.warn(depthFile.string() + ": its shape differs from the photo's (" +
                      pairText(result.depth.cols, result.depth.rows) + " and " +
                      sizeText(result.photo.size()) + "); it is stretched to fit");
    }
    if (result.origin == DepthOrigin::Given &&
        looksInverted(result.depth, [&] { return trustedEstimate(result.photo); })) {
        const fs::path& named = depthFile.empty() ? file.path() : depthFile;
        messages.warn(invertedText(named, options_.kind, isGiven));
    }
    times.end("depth");
    return result;
}

std::string ChosenDepth::estimateScene(const cv::Mat& photo, double flatDepth, Scene& scene) {
    source_->readScene(photo, flatDepth, scene);
    return source_->description();
}

} // namespace altiro3D::tools
