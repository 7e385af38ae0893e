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

constexpr std::pair<const char*, DepthSide> kSides[] = {{"right", DepthSide::Right},
                                                        {"left", DepthSide::Left},
                                                        {"top", DepthSide::Top},
                                                        {"bottom", DepthSide::Bottom}};
constexpr std::pair<const char*, StereoLayout> kLayouts[] = {
    {"left-right", StereoLayout::LeftRight},
    {"right-left", StereoLayout::RightLeft},
    {"top-bottom", StereoLayout::TopBottom},
    {"bottom-top", StereoLayout::BottomTop}};
constexpr std::pair<const char*, InferenceEngine> kEngines[] = {
    {"opencv", InferenceEngine::OpenCv}, {"onnxruntime", InferenceEngine::OnnxRuntime}};
constexpr std::pair<const char*, bool> kUses[] = {{"auto", true}, {"off", false}};

// near-white | far-white | metric[:SCALE]. SCALE states the unit, which relative depth does not
// need.
std::optional<DepthKind> readKind(const std::string& text) {
    if (text == "near-white") return DepthKind::NearWhite;
    if (text == "far-white") return DepthKind::FarWhite;
    if (text == "metric") return DepthKind::Metric;
    const std::string prefix = "metric:";
    double scale = 0;
    const char* end = text.data() + text.size();
    if (text.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
    const auto parsed = std::from_chars(text.data() + prefix.size(), end, scale);
    const bool isScale = parsed.ec == std::errc() && parsed.ptr == end && scale > 0 && scale < 1e12;
    return isScale ? std::optional(DepthKind::Metric) : std::nullopt;
}

// A place with the shape of the halves: "right", "left-right:full", "top:squeezed".
// @param others what else the option accepts, for the message
template <typename Place, std::size_t N>
std::optional<std::pair<Place, StereoHalves>>
placeOption(const CommandLine& commandLine, const char* option,
            const std::pair<const char*, Place> (&places)[N], const std::string& others = {}) {
    std::string text;
    commandLine.take({{option, text}});
    if (text.empty()) return std::nullopt;
    const std::size_t colon = std::min(text.find(':'), text.size());
    std::vector<std::string> words;
    for (const auto& [word, place] : places) {
        words.emplace_back(word);
        for (const auto& [end, halves] :
             {std::pair("", StereoHalves::Automatic), std::pair(":full", StereoHalves::Full),
              std::pair(":squeezed", StereoHalves::Squeezed)})
            if (text.substr(0, colon) == word && text.substr(colon) == end)
                return std::pair(place, halves);
    }
    commandLine.failValue(option, joined(words, ", ", " or ") +
                                      ", with :full or :squeezed if needed" + others);
}

// left-right | right-left | top-bottom | bottom-top | files | videos
void readStereoOption(const CommandLine& commandLine, const std::string& text,
                      DepthOptions& options) {
    options.isPair = text == "files";
    options.areVideos = text == "videos";
    if (options.isPair || options.areVideos) {
        options.stereo = {StereoLayout::LeftRight, StereoHalves::Full, {}};
    } else if (const auto layout = placeOption(commandLine, "stereo", kLayouts, ", or files")) {
        options.stereo = {layout->first, layout->second, {}};
    }
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
                        " and depth are one RGB-D image, with depth at this side: right, left, "
                        "top or bottom. Halves of a 16:9 picture count as squeezed, unless the "
                        "name says RGBD; :full or :squeezed after the side overrides this "
                        "(right:squeezed).",
                    "SIDE");
    if (video) {
        commandLine.addAdvanced(
            {"stereo"},
            "Frames hold the pictures of both eyes: left-right, right-left, top-bottom or "
            "bottom-top. Depth is found by matching them. Halves of 16:9 frames count as "
            "squeezed; :full or :squeezed after the order overrides this (left-right:full). Files "
            "that state the order, and names like film_LR.mp4 whose halves match, need no option. "
            "videos: the file has a video for each eye, although nothing says so; off: frames are "
            "flat.",
            "ORDER|videos|off");
    } else {
        commandLine.add(
            {"stereo"},
            "The photo holds the pictures of both eyes: left-right, right-left, top-bottom or "
            "bottom-top. Depth is found by matching them. Halves of a 16:9 picture count as "
            "squeezed; :full or :squeezed after the order overrides this (left-right:full). "
            "files: LEFT RIGHT instead of PHOTO. MPO, JPS, PNS, spatial HEIC and names like "
            "a_LR.jpg need no option. If both eyes do not match, the depth of the left picture is "
            "estimated, by -n if it is given.",
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
    const bool isVideo = medium == Medium::Video;
    std::string filesOption = "d";
    std::string rgbd;
    DepthOptions options;
    options.medium = medium;
    commandLine.take({{"d", options.fromFiles}, {"rgbd", rgbd}});
    if (isVideo) {
        commandLine.exclude("d", "depth");
        commandLine.take({{"depth", options.fromFiles}, {"depth", filesOption, "depth"}});
    }
    if (const auto side = placeOption(commandLine, "rgbd", kSides))
        options.rgbd = RgbdLayout(side->first, side->second);
    commandLine.take({{"depth-kind", options.kind, readKind,
                       "near-white, far-white, metric or metric:SCALE (units of a metre)"}});
    commandLine.exclude(filesOption, "rgbd");
    commandLine.exclude("l", "net-profile"); // the profile itself describes the network
    if (options.fromFiles) options.given = isVideo ? "given depth" : "depth image";
    if (options.rgbd) options.given = "depth half of the picture (" + rgbd + ")";
    options.isDefault = options.given.empty();
    for (const char* networkOption : {"n", "l", "net-profile", "network-size", "engine"}) {
        commandLine.exclude(filesOption, networkOption);
        commandLine.exclude("rgbd", networkOption);
        commandLine.take({{networkOption, options.isDefault, false}});
    }
    if (options.given.empty())
        commandLine.refuse({"depth-kind"}, " describes given depth, expected -d or --rgbd with it");
    std::string stereo;
    commandLine.take(
        {{"n", options.network}, {"l", options.isLarge}, {"net-profile", options.profile}});
    if (options.network == "cues")
        throw UsageError("-n cues: depth without a network no longer exists, expected -n altiro3d");
    if (options.network.empty())
        commandLine.refuse({"net-profile"}, " describes a network file, expected -n FILE with it");
    commandLine.take({{"network-size", options.networkSize, 16, 4096},
                      {"engine", options.engine, kEngines},
                      {"stereo", stereo}});
    if (isVideo) {
        commandLine.exclude("stereo", {"d", "depth", "rgbd"});
        options.isFlat = stereo == "off";
        if (options.isFlat) return options;
    }
    readStereoOption(commandLine, stereo, options);
    if (isVideo && options.isPair)
        commandLine.failValue("stereo", "an order of halves, videos, or off; files are for photos");
    if (isVideo) return options;
    if (options.areVideos)
        commandLine.failValue("stereo", "an order of halves, or files; videos are of a video");
    std::optional<bool> use;
    commandLine.take({{"embedded-depth", use, kUses}, {"unblurred", options.stored.unblurred}});
    commandLine.exclude("stereo", {"d", "rgbd", "embedded-depth", "unblurred"});
    for (const char* other : {"d", "rgbd"})
        commandLine.exclude(other, {"embedded-depth", "unblurred"});
    if (!options.given.empty() || options.stereo) return options;
    options.stored.useDepth = use.value_or(options.network.empty() && !options.isLarge);
    options.refusesVr = use.value_or(true);
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
