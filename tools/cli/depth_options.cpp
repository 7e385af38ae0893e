#include "cli/depth_options.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/image_io.hpp"
#include "cli/chosen_depth.hpp"

#include <algorithm>
#include <charconv>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

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
        if (parsed.ec == std::errc() && parsed.ptr == end && scale > 0 && scale < 1e12)
            return DepthKind::Metric;
    }
    commandLine.failValue("depth-kind",
                          "near-white, far-white, metric or metric:SCALE (units of a metre)");
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

// left-right | right-left | top-bottom | bottom-top | files | videos
void readStereoOption(const CommandLine& commandLine, DepthOptions& options) {
    constexpr StereoLayout kLayouts[] = {StereoLayout::LeftRight, StereoLayout::RightLeft,
                                         StereoLayout::TopBottom, StereoLayout::BottomTop};
    options.isPair = commandLine.value("stereo") == "files";
    options.areVideos = commandLine.value("stereo") == "videos";
    if (options.isPair || options.areVideos) {
        options.stereo = {StereoLayout::LeftRight, StereoHalves::Full, {}};
        return;
    }
    const auto layout =
        layoutOption(commandLine, "stereo",
                     {"left-right", "right-left", "top-bottom", "bottom-top"}, ", or files");
    if (layout) options.stereo = {kLayouts[layout->place], layout->halves, {}};
}

} // namespace

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
            "and names as film_LR.mp4 whose halves match, need no option. videos: the file has a "
            "video for each eye, although nothing says so; off: frames are flat.",
            "ORDER|videos|off");
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
            "-d, --rgbd, -n and -l take precedence over it; with -n and auto together, -n is for "
            "photos without depth.",
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
        commandLine.failValue("stereo", "an order of halves, videos, or off; files are for photos");
    if (isVideo) return options;
    if (options.areVideos)
        commandLine.failValue("stereo", "an order of halves, or files; videos are of a video");
    const auto use = commandLine.choice("embedded-depth", {"auto", "off"});
    commandLine.exclude("stereo", {"d", "rgbd", "embedded-depth", "unblurred"});
    for (const char* other : {"d", "rgbd"})
        commandLine.exclude(other, {"embedded-depth", "unblurred"});
    options.stored.unblurred = has("unblurred");
    if (!options.given.empty() || options.stereo) return options;
    options.stored.useDepth = use ? *use == 0 : options.network.empty() && !options.isLarge;
    options.refusesVr = !use || *use == 0;
    return options;
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

} // namespace altiro3D::tools
