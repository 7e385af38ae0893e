#include "cli/depth_options.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/quilt2native.hpp"
#include "cli/network_trust.hpp"
#include "cli/outputs.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <malloc.h>
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

std::vector<std::string> namesOf(const std::vector<NetworkProfile>& catalog) {
    std::vector<std::string> names;
    for (const NetworkProfile& profile : catalog)
        names.push_back(profile.name);
    return names;
}

// near-white | far-white | metric[:SCALE]. SCALE states the unit, which relative depth does not
// need.
DepthKind kindOption(const CommandLine& commandLine) {
    const auto text = commandLine.value("depth-kind");
    if (!text || *text == "near-white") return DepthKind::NearWhite;
    if (*text == "far-white") return DepthKind::FarWhite;
    const std::string prefix = "metric:";
    if (*text == "metric") return DepthKind::Metric;
    if (text->compare(0, prefix.size(), prefix) == 0) {
        double scale = 0;
        const char* end = text->data() + text->size();
        const auto parsed = std::from_chars(text->data() + prefix.size(), end, scale);
        if (parsed.ec == std::errc() && parsed.ptr == end && scale > 0 && scale < 1e12) {
            return DepthKind::Metric;
        }
    }
    commandLine.failValue("depth-kind",
                          "near-white, far-white, metric or metric:SCALE (units of a metre)");
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

// A place with the shape of the halves: "right", "left-right:full", "top:squeezed".
struct LayoutChoice {
    std::size_t place = 0; // of the names
    StereoHalves halves = StereoHalves::Automatic;
};

// @param others what else the option accepts, for the message
std::optional<LayoutChoice> layoutOption(const CommandLine& commandLine, const std::string& option,
                                         const std::vector<std::string>& places,
                                         const std::string& others = {}) {
    const auto value = commandLine.value(option);
    if (!value) return std::nullopt;
    const std::size_t colon = value->find(':');
    const std::string halves = colon == std::string::npos ? "" : value->substr(colon + 1);
    const auto found = std::find(places.begin(), places.end(), value->substr(0, colon));
    LayoutChoice choice;
    choice.place = static_cast<std::size_t>(found - places.begin());
    if (halves == "full") choice.halves = StereoHalves::Full;
    if (halves == "squeezed") choice.halves = StereoHalves::Squeezed;
    const bool areHalves = colon == std::string::npos || choice.halves != StereoHalves::Automatic;
    if (found != places.end() && areHalves) return choice;
    commandLine.failValue(option, joined(places, ", ", " or ") +
                                      ", with :full or :squeezed if needed" + others);
}

std::optional<RgbdLayout> rgbdOption(const CommandLine& commandLine) {
    constexpr DepthSide kSides[] = {DepthSide::Right, DepthSide::Left, DepthSide::Top,
                                    DepthSide::Bottom};
    const auto choice = layoutOption(commandLine, "rgbd", {"right", "left", "top", "bottom"});
    if (!choice) return std::nullopt;
    return RgbdLayout(kSides[choice->place], choice->halves);
}

// left-right | right-left | top-bottom | bottom-top | files
void readStereoOption(const CommandLine& commandLine, DepthOptions& options) {
    constexpr StereoLayout kLayouts[] = {StereoLayout::LeftRight, StereoLayout::RightLeft,
                                         StereoLayout::TopBottom, StereoLayout::BottomTop};
    options.isPair = commandLine.value("stereo") == "files";
    if (options.isPair) {
        options.stereo = {StereoLayout::LeftRight, StereoHalves::Full, {}};
        return;
    }
    const auto layout =
        layoutOption(commandLine, "stereo",
                     {"left-right", "right-left", "top-bottom", "bottom-top"}, ", or files");
    if (layout) options.stereo = {kLayouts[layout->place], layout->halves, {}};
}

const char* nameOf(StereoLayout layout) {
    constexpr const char* kNames[] = {"left-right", "right-left", "top-bottom", "bottom-top"};
    return kNames[static_cast<int>(layout)];
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

} // namespace

std::string engineName(InferenceEngine engine) {
    return engine == InferenceEngine::OnnxRuntime ? "ONNX Runtime" : "OpenCV";
}

void addDepthOptions(CommandLine& commandLine, Medium medium) {
    const bool video = medium == Medium::Video;
    commandLine.addSection("Depth");
    commandLine.add(
        {"n", "network"},
        "Depth network: an ONNX file, or the name of one in the catalogue. Default: the first of "
        "depth-anything-v2-small (needs ONNX Runtime), midas-small and altiro3d whose file is "
        "found.",
        "NETWORK", [] { return namesOf(modelCatalog()); });
    commandLine.addAdvanced({"l", "large"},
                            "Use the large MiDaS network; with -n: the file is a large network.");
    commandLine.addAdvanced(
        {"net-profile"},
        "Input and output of a network that is not in the catalogue (JSON, the keys of "
        "models/catalog.json).",
        "FILE.json");
    commandLine.addAdvanced({"network-size"},
                            "Longer side of the network's input in px (default: its own, 256 for "
                            "midas-small). Smaller is quicker and less accurate.",
                            "PX");
    commandLine.addAdvanced(
        {"engine"},
        std::string("Program that runs the network: opencv or onnxruntime, which "
                    "is several times faster") +
            (hasOnnxRuntime() ? " (default: onnxruntime where it can be used)."
                              : " but is not built in here."),
        "opencv|onnxruntime");
    if (video) {
        commandLine.add({"depth"},
                        "Depth is given: a video, or a directory with one picture per frame.",
                        "FILE|DIR");
        commandLine.addAdvanced({"d", "depthmode"},
                                "Another way to give depth: IN DEPTH instead of IN.");
    } else {
        commandLine.add({"d", "depthmode"}, "Depth is given: PHOTO DEPTH instead of PHOTO.");
    }
    commandLine.add({"rgbd"},
                    std::string(video ? "Frame" : "Photo") +
                        " and depth are one RGB-D image, with depth at this side: right, left, top "
                        "or bottom. Halves of a 16:9 picture count as squeezed, unless the name "
                        "says RGBD; :full or :squeezed after the side says so (right:squeezed).",
                    "SIDE");
    if (video) {
        commandLine.addAdvanced(
            {"stereo"},
            "Frames hold the pictures of both eyes: left-right, right-left, top-bottom or "
            "bottom-top. Depth is found by matching them. Halves of 16:9 frames count as squeezed; "
            ":full or :squeezed after the order says so (left-right:full). Files that state it, "
            "and names as film_LR.mp4 whose halves match, need no option; off: frames are flat.",
            "ORDER|off");
    } else {
        commandLine.add(
            {"stereo"},
            "The photo holds the pictures of both eyes: left-right, right-left, top-bottom or "
            "bottom-top. Depth is found by matching them. Halves of a 16:9 picture count as "
            "squeezed; :full or :squeezed after the order says so (left-right:full). files: LEFT "
            "RIGHT instead of PHOTO. MPO, JPS, PNS, spatial HEIC and names as a_LR.jpg need no "
            "option. If both eyes do not match, the depth of the left picture is estimated, by -n "
            "if it is given.",
            "ORDER|files");
        commandLine.addAdvanced(
            {"embedded-depth"},
            "auto (default) uses the depth that comes with a photo, in its file (portraits of "
            "phones, MPO and spatial photos, halves that the name states: a_LR.jpg, a_RGBD.jpg) or "
            "beside it (a.jpg and a-depth.png, a_depth.png, a.disparity.png, ...); off ignores it. "
            "-d, --rgbd, -n and -l go before it; with -n and auto together, -n is for photos "
            "without depth.",
            "auto|off");
        commandLine.addAdvanced({"unblurred"},
                                "Use the sharp original of a portrait where the file has one.");
    }
    commandLine.addAdvanced(
        {"depth-kind"},
        "Meaning of given depth: near-white (default), far-white, or metric[:SCALE] "
        "(distances, 0 = unknown). In depth that is drawn in colours, the warm or bright end or "
        "the largest hue counts as white.",
        "KIND");
    using Chapter = CommandLine::Chapter;
    commandLine.addTerm(Chapter::Files, "~/.local/share/altiro3D/models/",
                        "Depth networks; get-models.sh puts them here.");
    commandLine.addTerm(
        Chapter::Files, "PREFIX/share/altiro3D/models/catalog.json",
        "The catalogue: the networks that -n accepts by name, and their input and output. "
        "PREFIX is where the tools are installed, such as /usr.");
    commandLine.addTerm(Chapter::Environment, "ALTIRO3D_MODELS",
                        "Directories that are searched first for networks and the catalogue, "
                        "separated by colons.");
    commandLine.addTerm(Chapter::Environment, "XDG_DATA_HOME",
                        "Directory that is used instead of ~/.local/share.");
}

DepthOptions depthOptions(const CommandLine& commandLine, Medium medium) {
    constexpr const char* kNetworkOptions[] = {"n", "l", "net-profile", "network-size", "engine"};
    const auto has = [&](const char* option) { return commandLine.has(option); };
    const bool isVideo = medium == Medium::Video;
    const char* const filesOption = isVideo && has("depth") ? "depth" : "d";
    if (isVideo) commandLine.exclude("d", "depth");
    DepthOptions options;
    options.medium = medium;
    options.fromFiles = has(filesOption);
    options.rgbd = rgbdOption(commandLine);
    options.kind = kindOption(commandLine);
    commandLine.exclude(filesOption, "rgbd");
    commandLine.exclude("l", "net-profile"); // the profile itself describes the network
    for (const char* networkOption : kNetworkOptions) {
        commandLine.exclude(filesOption, networkOption);
        commandLine.exclude("rgbd", networkOption);
    }
    if (options.fromFiles) options.given = isVideo ? "given depth" : "depth image";
    if (options.rgbd)
        options.given = "depth half of the picture (" + *commandLine.value("rgbd") + ")";
    if (options.given.empty())
        commandLine.refuse({"depth-kind"}, " describes given depth, expected -d or --rgbd with it");
    options.network = commandLine.value("n").value_or("");
    if (options.network == "cues")
        throw UsageError("-n cues: depth without a network no longer exists, expected -n altiro3d");
    options.isLarge = has("l");
    options.profile = commandLine.value("net-profile").value_or("");
    if (options.network.empty())
        commandLine.refuse({"net-profile"}, " describes a network file, expected -n FILE with it");
    options.networkSize = commandLine.wholeNumber("network-size", 16, 4096);
    options.engine =
        commandLine
            .oneOf<InferenceEngine>("engine", {{"opencv", InferenceEngine::OpenCv},
                                               {"onnxruntime", InferenceEngine::OnnxRuntime}})
            .value_or(InferenceEngine::Best);
    options.isDefault = options.given.empty() &&
                        std::none_of(std::begin(kNetworkOptions), std::end(kNetworkOptions), has);
    if (isVideo) {
        commandLine.exclude("stereo", {"d", "depth", "rgbd"});
        options.isFlat = commandLine.value("stereo") == "off";
        if (options.isFlat) return options;
    }
    readStereoOption(commandLine, options);
    if (isVideo && options.isPair)
        commandLine.failValue("stereo", "an order of halves, or off; files are for photos");
    if (isVideo) return options;
    const auto use = commandLine.choice("embedded-depth", {"auto", "off"});
    commandLine.exclude("stereo", {"d", "rgbd", "embedded-depth", "unblurred"});
    for (const char* other : {"d", "rgbd"})
        commandLine.exclude(other, {"embedded-depth", "unblurred"});
    options.photo.unblurred = has("unblurred");
    if (!options.given.empty() || options.stereo) return options;
    options.photo.useDepth = use ? *use == 0 : options.network.empty() && !options.isLarge;
    options.refusesVr = !use || *use == 0;
    return options;
}

ChosenDepth::ChosenDepth(const DepthOptions& options, Messages& messages)
    : options_(options), description_(options.given) {
    if (options_.fromFiles) return;
    if (options_.rgbd) {
        source_ = depthFromRgbd(*options_.rgbd, options_.kind);
        return;
    }
    chooseNetwork(messages);
    if (options_.medium == Medium::Photo) setEstimator(source_); // stored depth goes before it
}

void ChosenDepth::setEstimator(std::shared_ptr<DepthSource> estimator) {
    source_ = std::move(estimator);
    description_ = source_->description();
    if (options_.stereo && !options_.isPair) {
        source_ = depthFromStereo(*options_.stereo, source_);
    } else if (options_.photo.useDepth || options_.photo.unblurred) {
        source_ = storedDepthOr(source_, options_.photo);
    }
}

void ChosenDepth::release() {
    source_.reset();
    malloc_trim(0);
}

void ChosenDepth::tellEngine(const Messages& messages) {
    if (isEngineTold_ || network() == nullptr) return;
    isEngineTold_ = true;
    const bool isCuda = network()->target() == InferenceTarget::Cuda;
    messages.detail(std::string("depth network runs on ") + (isCuda ? "CUDA" : "the CPU") + " by " +
                    engineName(network()->engine()));
}

void ChosenDepth::chooseNetwork(Messages& messages) {
    const std::vector<fs::path> searchPath = modelSearchPath();
    const std::vector<NetworkProfile> catalog = modelCatalog(searchPath);
    const std::string& wanted = options_.network;
    const bool large = options_.isLarge;
    std::optional<NetworkProfile> profile;
    if (!options_.profile.empty()) profile = readNetworkProfile(options_.profile);
    fs::path& networkFile = networkFile_;
    if (!wanted.empty()) {
        const NetworkProfile* known = named(catalog, wanted);
        const bool isFile = isThere(wanted) && !isDirectory(wanted);
        networkFile = isFile ? fs::path(wanted)
                             : findModelFile(known != nullptr ? known->file : wanted, searchPath);
        if (networkFile.empty() && known != nullptr) {
            throw Error(ErrorCode::NotFound, wanted,
                        "its file " + known->file + " is missing, expected it to be downloaded (" +
                            downloadCommand(known->name) + ")");
        }
        if (networkFile.empty()) {
            throw Error(ErrorCode::NotFound, wanted,
                        "does not exist, expected an ONNX file" +
                            (catalog.empty()
                                 ? ""
                                 : " or a network of the catalogue: " + joined(namesOf(catalog))));
        }
        if (!profile) {
            known = findProfile(catalog, networkFile);
            if (known != nullptr && large && !known->large) {
                throw UsageError("-l says that " + wanted +
                                 " is a large network, but the catalogue knows it as " +
                                 known->name + "; expected no -l");
            }
            if (known == nullptr && large) known = firstLarge(catalog);
            if (known == nullptr) {
                throw Error(ErrorCode::NotFound, wanted,
                            "is not in the catalogue of networks, expected --net-profile FILE.json "
                            "that describes it");
            }
            profile = *known;
        }
    } else if (const auto standard = standardNetwork(large, searchPath)) {
        networkFile = standard->file;
        profile = standard->profile;
    } else if (large) {
        const NetworkProfile* const known = firstLarge(catalog);
        const std::string file = known != nullptr ? " (" + known->file + ")" : "";
        throw Error(ErrorCode::NotFound, "-l",
                    "the large network" + file +
                        " was not found, expected it in the model search path (" +
                        downloadCommand(known != nullptr ? known->name : "midas-large") +
                        ") or given with -n");
    }
    if (networkFile.empty()) {
        source_ = estimatedDepth();
        description_ = source_->description();
        if (options_.medium == Medium::Video) source_->load(); // fails
        return;
    }
    if (options_.engine == InferenceEngine::OnnxRuntime && !hasOnnxRuntime()) {
        throw Error(ErrorCode::Unsupported, "--engine",
                    "ONNX Runtime is not built in, expected opencv, or a build on a system that "
                    "has libonnxruntime-dev (Debian 13)");
    }
    const std::optional<int>& wantedSize = options_.networkSize;
    const InferenceTarget target = bestInferenceTarget();
    if (wantedSize && *wantedSize % profile->multipleOf != 0) {
        throw UsageError("--network-size is " + std::to_string(*wantedSize) +
                         ", expected a multiple of " + std::to_string(profile->multipleOf) +
                         " for " + profile->name);
    }
    const cv::Size size = wantedSize ? scaledInput(*profile, *wantedSize) : cv::Size();
    requireHarmless(networkFile, *profile, catalog, size, options_.engine, messages);
    source_ = depthFromNetworkFile(networkFile, *profile, target, size, options_.engine);
    const bool isNamed = !wanted.empty() || large;
    if (isNamed || options_.medium == Medium::Video) { // else a photo may bring depth of its own
        const QuietStandardError quiet; // some builds of ONNX Runtime print when they start
        source_->load();
    }
    description_ = source_->description();
    const cv::Size input =
        size.empty() ? cv::Size(profile->inputWidth, profile->inputHeight) : size;
    messages.say("depth: " + description_ + ", " +
                 (profile->inputShape == InputShape::Photo
                      ? std::to_string(std::max(input.width, input.height)) + " px wide or high"
                      : sizeText(input)));
    tellEngine(messages);
}

RgbdLayout rgbdOf(const fs::path& file, const RgbdLayout& stated, double aspect,
                  Messages& messages) {
    const RgbdLayout layout(stated.side, halvesOf(file, stated.halves, aspect));
    if (layout.halves == StereoHalves::Squeezed &&
        halvesOf(file, stated.halves) == StereoHalves::Automatic) {
        messages.say(
            (messages.hasSubject() ? "" : file.string() + ": ") +
            "halves of a 16:9 picture count as squeezed and are stretched; :full after the "
            "side of --rgbd keeps them");
    }
    return layout;
}

RgbdLayout savedRgbdLayout(const std::filesystem::path& file) {
    const auto name = parseSceneName(file);
    const bool isSqueezed = name && name->contents == SceneName::Contents::Rgbd &&
                            name->halves == StereoHalves::Squeezed;
    return {DepthSide::Right, isSqueezed ? StereoHalves::Squeezed : StereoHalves::Full};
}

std::string invertedText(const fs::path& file, DepthKind kind, bool isNamed) {
    const std::string other = kind == DepthKind::NearWhite ? "far-white" : "near-white";
    return file.string() + ": near and far look exchanged; if near things look far, photo2native " +
           (isNamed ? "" : "-d with ") + "--depth-kind " + other + " turns it round" +
           (isNamed ? "" : ", and --embedded-depth off leaves it out");
}

ReadPhoto ChosenDepth::read(const fs::path& photoFile, const fs::path& depthFile, double flatDepth,
                            Messages& messages, StageTimes& times) {
    PhotoFile photo = pictureToRead(photoFile);
    static_cast<void>(photo.bytes()); // once, also a pipe
    refuseNative(photo, "a photo");
    if (!depthFile.empty()) refuseNative(depthFile, "a depth picture");
    if (options_.refusesVr) refuseVrName(photoFile);
    warnIfQuilt(photoFile, "quilt2native", messages);
    std::unique_ptr<DepthSource> given;
    if (options_.isPair) {
        if (depthFile.empty()) throw UsageError("--stereo files takes LEFT RIGHT, got one picture");
        StereoInput pair = *options_.stereo;
        pair.right = depthFile;
        given = depthFromStereo(pair, source_);
    } else if (!depthFile.empty() && options_.fromFiles) { // else the source finds and checks it
        given = depthFromFile(depthFile, options_.kind);
    }
    DepthSource& source = given ? *given : *source_;
    ReadPhoto result;
    PhotoDepth found;
    Notes notes;
    {
        const QuietStandardError quiet;
        found = source.readPhoto(photo, &notes);
        result.focalLength35mm = readFocalLength35mm(photo);
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
    if (options_.photo.unblurred && !result.isUnblurred)
        messages.say(photo.path().string() + ": no sharp original in the file is used");
    result.origin = found.origin;
    result.source = options_.fromFiles ? description_ : found.text;
    result.file = given ? depthFile : found.separateFile;
    const bool isEstimated = result.origin == DepthOrigin::Estimated;
    const bool isNamed = !options_.given.empty(); // by an option
    if (!isEstimated && !isNamed && (depthFile.empty() || options_.isPair))
        messages.say((messages.hasSubject() ? "" : photo.path().string() + ": ") + result.source);
    if (isEstimated && !options_.photo.useDepth && !options_.stereo) warnOfHalves(photo, messages);
    photo = PhotoFile(photo.path()); // releases the bytes of a large file
    times.end("read");
    {
        const QuietStandardError quiet; // it may load the network
        source.readScene(found, flatDepth, result);
    }
    tellEngine(messages);
    const double photoAspect = static_cast<double>(result.photo.cols) / result.photo.rows;
    const double depthAspect = static_cast<double>(result.depth.cols) / result.depth.rows;
    if (given && !options_.isPair && !haveSameShape(photoAspect, depthAspect)) {
        messages.warn(depthFile.string() + ": its shape differs from the photo's (" +
                      std::to_string(result.depth.cols) + " x " +
                      std::to_string(result.depth.rows) + " and " + sizeText(result.photo.size()) +
                      "); it is stretched to fit");
    }
    if (result.origin == DepthOrigin::Given &&
        looksInverted(result.depth, [&] { return trustedEstimate(result.photo); })) {
        const fs::path& file = depthFile.empty() ? photo.path() : depthFile;
        messages.warn(invertedText(file, options_.kind, isNamed));
    }
    times.end("depth");
    return result;
}

std::string ChosenDepth::estimateScene(const cv::Mat& photo, double flatDepth, Scene& scene) {
    source_->readScene(photo, flatDepth, scene);
    return source_->description();
}

} // namespace altiro3D::tools
